"""Identification of the base model against dense formulas, invariances, and what must be refused."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm, t

from expdesign.app.api.identify import with_doubts
from expdesign.errors import InputError, NotIdentifiableError, SingularConfigurationError
from expdesign.estimation.identify import Identification, identify
from expdesign.mechanics.robots.bipod import Bipod
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.report.identification_tables import identification_record
from expdesign.report.remark_texts import sentences
from tests.cases import ROBOTS, robot
from tests.identification.experiments import Experiment, by_series, experiment, read

NAMES = sorted(ROBOTS)


def dense(made: Experiment, deflections: np.ndarray, shared: bool) -> tuple[np.ndarray, np.ndarray]:
    """ĉ and its covariance from the full covariance matrix of all readings (theory.md 3)."""
    count, n = deflections.shape
    same = made.series[:, None] == made.series[None, :]
    across = 0.5 * (np.eye(count) + same) if shared else np.eye(count)
    covariance = np.kron(across, np.diag(made.deviation**2))
    matrix = made.observation.reshape(count * n, -1)
    weighted = np.linalg.solve(covariance, matrix)
    information = matrix.T @ weighted
    return np.linalg.solve(information, weighted.T @ deflections.ravel()), np.linalg.inv(information)


@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_estimate_and_covariance_are_those_of_the_theory(name: str, shared: bool) -> None:
    made = experiment(name, 9, seed=3, loads_per_pose=3)
    deflections = made.noisy(np.random.default_rng(5), shared_reference=shared)
    found = identify(made.robot, by_series(made.recordings(deflections), shared))
    estimate, covariance = dense(made, deflections, shared)
    deviation = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(found.compliance.estimate, estimate, rtol=1e-9)
    np.testing.assert_allclose(
        found.covariance / np.outer(deviation, deviation), covariance / np.outer(deviation, deviation), atol=1e-9
    )
    np.testing.assert_allclose(found.compliance.high, estimate + norm.ppf(0.975) * deviation, rtol=1e-9)
    np.testing.assert_allclose(found.stiffness.low, 1.0 / found.compliance.high, rtol=1e-12)
    np.testing.assert_allclose(found.stiffness.high, 1.0 / found.compliance.low, rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "rows", "stated", "shared"),
    [
        ("bipod", 3, True, False),
        ("bipod", 3, False, False),
        pytest.param("H1", 3, True, False, marks=pytest.mark.slow),
        pytest.param("H1", 6, False, False, marks=pytest.mark.slow),
        pytest.param("H1", 4, True, True, marks=pytest.mark.slow),
        pytest.param("camera", 6, False, False, marks=pytest.mark.slow),
    ],
)
def test_intervals_cover_the_truth_in_95_of_100_experiments(name: str, rows: int, stated: bool, shared: bool) -> None:
    made = experiment(name, rows, seed=4)
    if not stated:
        # What is estimated is one level for translations and one for rotations.
        made = replace(made, deviation=np.where(np.arange(len(made.deviation)) < 3, 5e-7, 2e-6))
    generator = np.random.default_rng(11)
    count = 2000
    covered = np.zeros(len(made.compliance))
    exact = by_series(made.recordings(made.exact, stated=stated), shared)
    for _ in range(count):
        recordings = replace(exact, deflections=made.noisy(generator, shared_reference=shared))
        interval = identify(made.robot, recordings).stiffness
        low, high = np.nan_to_num(interval.low, nan=-np.inf), np.nan_to_num(interval.high, nan=np.inf)
        covered += (low <= 1.0 / made.compliance) & (1.0 / made.compliance <= high)
    np.testing.assert_allclose(covered / count, 0.95, atol=0.015)


def test_without_standard_deviations_a_bipod_is_ordinary_least_squares_with_students_t() -> None:
    made = experiment("bipod", 5, seed=1)
    deflections = made.noisy(np.random.default_rng(1))
    found = identify(made.robot, made.recordings(deflections, stated=False))
    matrix = made.observation.reshape(10, 2)
    estimate, squares, *_ = np.linalg.lstsq(matrix, deflections.ravel())
    sigma = np.sqrt(squares[0] / 8)
    half = t.ppf(0.975, 8) * sigma * np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix)))
    np.testing.assert_allclose(found.compliance.estimate, estimate, rtol=1e-9)
    np.testing.assert_allclose(found.compliance.high - found.compliance.estimate, half, rtol=1e-6)
    np.testing.assert_allclose(found.noise.groups[0].deviation, sigma, rtol=1e-6)
    record = identification_record(found)
    assert record["chi2"] is None
    assert record["p_value"] is None


def test_translations_and_rotations_get_a_noise_level_each() -> None:
    made = experiment("H1", 400, seed=6)
    made = replace(made, deviation=np.array([3e-7, 3e-7, 3e-7, 5e-6, 5e-6, 5e-6]))
    found = identify(made.robot, made.recordings(made.noisy(np.random.default_rng(0)), stated=False))
    levels = [group.deviation for group in found.noise.groups]
    np.testing.assert_allclose(levels, [3e-7, 5e-6], rtol=4.0 / np.sqrt(2 * 1200))
    assert found.noise.origin == "residuals"


def replicated(made: Experiment, times: int) -> Experiment:
    return replace(
        made,
        poses=np.repeat(made.poses, times, axis=0),
        wrenches=np.repeat(made.wrenches, times, axis=0),
        series=np.repeat(made.series, times),
    )


@pytest.mark.parametrize("shared", [False, True])
def test_replicates_show_the_noise_whatever_the_model(shared: bool) -> None:
    made = replicated(experiment("H1", 40, seed=7), 6)
    wrong = made.noisy(np.random.default_rng(1), shared_reference=shared)
    wrong += 1e-5 * np.sin(1e3 * made.poses)
    found = identify(made.robot, by_series(made.recordings(wrong, stated=False), shared))
    assert found.noise.origin == "replicates"
    expected = [np.sqrt((made.deviation[part] ** 2).mean()) for part in (slice(0, 3), slice(3, 6))]
    levels = [group.deviation for group in found.noise.groups]
    np.testing.assert_allclose(levels, expected, rtol=4.0 * 1.3 / np.sqrt(2 * 600))
    assert found.goodness.lack_of_fit.p_value < 1e-6


@pytest.mark.parametrize("shared", [False, True])
def test_the_tests_have_the_level_that_they_state(shared: bool) -> None:
    made = replicated(experiment("bipod", 6, seed=8), 3)
    generator = np.random.default_rng(21)
    chance, lack = [], []
    exact = by_series(made.recordings(made.exact), shared)
    for _ in range(600):
        recordings = replace(exact, deflections=made.noisy(generator, shared_reference=shared))
        goodness = identify(made.robot, recordings).goodness
        chance.append(goodness.p_value)
        lack.append(goodness.lack_of_fit.p_value)
    for values in (chance, lack):
        ordered = np.sort(np.array(values, dtype=float))
        # Kolmogorov-Smirnov distance from the uniform distribution; 1.95/√N is exceeded once in 1000.
        distance = np.abs(ordered - (np.arange(600) + 0.5) / 600).max()
        assert distance < 1.95 / np.sqrt(600)


def same(first: Identification, second: Identification, **tolerance: float) -> None:
    np.testing.assert_allclose(second.compliance.estimate, first.compliance.estimate, rtol=1e-9)
    np.testing.assert_allclose(
        second.covariance, first.covariance, rtol=1e-8, atol=1e-9 * np.abs(first.covariance).max()
    )
    np.testing.assert_allclose(second.fit.chi2, first.fit.chi2, rtol=1e-9)
    assert second.fit.dof == first.fit.dof


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("shared", [True, False])
def test_the_order_of_the_rows_changes_nothing(shared: bool, stated: bool) -> None:
    made = experiment("irregular", 12, seed=9)
    frame = made.frame(made.noisy(np.random.default_rng(2)), stated=stated)
    first = identify(made.robot, by_series(read(frame, made.robot), shared))
    shuffled = frame.sample(frac=1.0, random_state=4)
    same(first, identify(made.robot, by_series(read(shuffled, made.robot), shared)))
    renumbered = shuffled.assign(sequence=np.arange(1, 13))
    same(first, identify(made.robot, by_series(read(renumbered, made.robot), shared)))


@pytest.mark.parametrize(("length", "force"), [(2.5, 1.0), (1.0, 4.0), (0.4, 0.3)])
def test_other_units_of_length_and_force_change_nothing(length: float, force: float) -> None:
    """The same experiment in units `length` and `force` times smaller: compliances are in their ratio."""
    made = experiment("irregular", 8, seed=12)
    here = made.robot
    assert isinstance(here, Hexapod)
    scaled = Hexapod(
        base_joints=here.base_joints * length,
        platform_joints=here.platform_joints * length,
        home=here.home * length,
        stiffness=here.stiffness * force / length,
        orientation=here.orientation,
        gravity=here.gravity,
    )
    pose = np.array([length] * 3 + [1.0] * 3)
    wrench = np.array([force] * 3 + [force * length] * 3)
    deflections = made.noisy(np.random.default_rng(4))
    other = replace(
        made, robot=scaled, poses=made.poses * pose, wrenches=made.wrenches * wrench, deviation=made.deviation * pose
    )
    first = identify(here, made.recordings(deflections))
    second = identify(scaled, other.recordings(deflections * pose))
    np.testing.assert_allclose(second.stiffness.low, first.stiffness.low * force / length, rtol=1e-9)
    np.testing.assert_allclose(second.stiffness.high, first.stiffness.high * force / length, rtol=1e-9)
    np.testing.assert_allclose(second.fit.chi2, first.fit.chi2, rtol=1e-8)


def test_test_rows_are_predicted_but_never_fitted() -> None:
    made = experiment("H1", 12, seed=13)
    deflections = made.noisy(np.random.default_rng(5))
    frame = made.frame(deflections).assign(split=["train"] * 8 + ["test"] * 4)
    found = identify(made.robot, read(frame, made.robot))
    alone = identify(made.robot, read(frame.iloc[:8], made.robot))
    np.testing.assert_array_equal(found.compliance.estimate, alone.compliance.estimate)
    residuals = (deflections[8:] - made.observation[8:] @ found.compliance.estimate) / made.deviation
    np.testing.assert_allclose(found.test_residuals, residuals, rtol=1e-6, atol=1e-9)
    record = identification_record(found)
    np.testing.assert_allclose(record["fit"]["test_rms"], np.sqrt((residuals**2).mean()), rtol=1e-6)


def test_the_first_row_of_a_series_without_load_is_its_reference_and_measures_nothing() -> None:
    made = experiment("H1", 8, seed=14)
    frame = made.frame(made.noisy(np.random.default_rng(6)))
    reference = frame.iloc[[0]].copy()
    reference.loc[:, [name for name in map(str, frame) if name[0] in "fm" or name.startswith("d")]] = 0.0
    reference["sequence"] = 0
    found = identify(made.robot, read(pd.concat([reference, frame]), made.robot))
    assert found.fit.dof == 8 * 6 - 6
    assert not found.fitted[0]


def test_leverage_adds_up_to_the_parameters_and_information_to_one() -> None:
    made = experiment("H1", 10, seed=15)
    found = identify(made.robot, made.recordings(made.noisy(np.random.default_rng(7))))
    np.testing.assert_allclose(found.influence.leverage.sum(), 6.0)
    np.testing.assert_allclose(found.influence.share.sum(axis=0), np.ones(6))


@pytest.mark.parametrize("stated", [True, False])
def test_an_outlier_is_flagged_and_nothing_else(stated: bool) -> None:
    made = experiment("H1", 30, seed=16)
    deflections = made.noisy(np.random.default_rng(8))
    deflections[17, 2] += 20.0 * made.deviation[2]
    found = identify(made.robot, made.recordings(deflections, stated=stated))
    np.testing.assert_array_equal(np.flatnonzero(found.influence.outlier), [17])


def test_a_prior_makes_a_leg_without_load_known_as_well_as_before() -> None:
    made = idle_leg(experiment("H1", 6, seed=17))
    found = identify(made.robot, made.recordings(made.noisy(np.random.default_rng(9))), prior=0.3)
    relative = np.sqrt(np.diag(found.covariance)) * made.robot.stiffness
    np.testing.assert_allclose(relative[2], 0.3, rtol=1e-6)
    np.testing.assert_allclose(found.compliance.estimate[2], made.robot.compliance[2], rtol=1e-6)
    assert (np.delete(relative, 2) < 0.1).all()


def idle_leg(made: Experiment) -> Experiment:
    """The same experiment with loads that leave leg 3 without force."""
    jacobians = made.robot.jacobians(made.poses)
    forces = np.random.default_rng(1).uniform(-200.0, 200.0, (len(made.poses), 6))
    forces[:, 2] = 0.0
    inverse = np.linalg.inv(jacobians.forward)
    return replace(made, wrenches=(forces[:, None, :] @ inverse)[:, 0])


def one_axis_alone() -> Experiment:
    """Leg 1 pushes along the diagonal; leg 2 stands upright, so that leg 1 moves the tool point along x alone."""
    here = Bipod(
        base_joints=np.array([[-0.5, 0.0], [0.0, 0.0]]), home=np.array([0.0, 0.5]), stiffness=np.array([1e7, 1e7])
    )
    wrenches = np.array([[100.0, -50.0], [0.0, -200.0], [50.0, 10.0]])
    whole = replace(experiment("bipod", 3), robot=here, poses=np.zeros((3, 2)), wrenches=wrenches)
    return replace(whole, series=np.array([1, 1, 1]), compliance=here.compliance)


def straight_down() -> Experiment:
    made = experiment("H1", 9, loads_per_pose=9)
    wrenches = np.outer(np.resize([1.0, 2.0, 3.0], 9), [0.0, 0.0, -100.0, 0.0, 0.0, 0.0])
    return replace(made, poses=np.zeros((9, 6)), wrenches=wrenches)


def singular() -> Experiment:
    made = experiment("bipod", 4)
    return replace(made, poses=np.where(np.arange(8).reshape(4, 2) >= 4, [1.0, 0.0], 1.0) * made.poses)


REFUSED: dict[str, tuple[Experiment, set[str], float, type[Exception], str]] = {
    "no load": (replace(experiment("H1", 4), wrenches=np.zeros((4, 6))), set(), 1.0, NotIdentifiableError,
                "no row has a load"),
    "idle leg": (idle_leg(experiment("H1", 6, seed=17)), set(), 1.0, NotIdentifiableError, "leg 3 carries no load"),
    "one axis": (one_axis_alone(), {"dy_m", "sy_m"}, 1.0, NotIdentifiableError,
                 "leg 1 moves none of the measured axes"),
    "one load": (straight_down(), {"dz_m"}, 1.0, NotIdentifiableError,
                 r"do not tell leg 1, leg 2.* apart \(rank 1 of 6\)"),
    "few readings": (experiment("H1", 2), {"dx_m", "dy_m"}, 1.0, NotIdentifiableError,
                     "4 readings cannot determine 6 compliances"),
    "wrong sign": (experiment("H1", 8, seed=18), set(), -1.0, InputError,
                   r"recordings\.csv, row 2, columns dx_m.*wrong sign"),
    "singular row": (singular(), set(), 1.0, SingularConfigurationError, r"recordings\.csv, row 4"),
}  # fmt: skip
"""What was measured, the columns of readings that are left (all if none is named), factor on deflections, and what is
said.
"""


@pytest.mark.parametrize("name", REFUSED)
def test_what_does_not_determine_the_stiffness_is_refused_with_its_place(name: str) -> None:
    made, left, factor, error, words = REFUSED[name]
    if name == "singular row":
        deflections = np.zeros((4, 2)) + 1e-6
    else:
        deflections = factor * (made.exact if left or name == "idle leg" else made.noisy(np.random.default_rng(1)))
    frame = made.frame(deflections)
    known = {*made.robot.coordinates.deflection, *made.robot.coordinates.deviation}
    recordings = read(frame.drop(columns=[each for each in frame if each in known - left and left]), made.robot)
    with pytest.raises(error, match=words):
        identify(made.robot, recordings)


def test_as_many_readings_as_stiffnesses_leave_nothing_to_estimate_the_noise_from() -> None:
    made = experiment("H1", 1)
    with pytest.raises(NotIdentifiableError, match="no reading over"):
        identify(made.robot, made.recordings(made.exact, stated=False))
    assert identify(made.robot, made.recordings(made.exact)).goodness.p_value is None


@pytest.mark.parametrize("stated", [True, False])
def test_one_column_of_the_wrong_sign_is_named_in_the_record(stated: bool) -> None:
    made = experiment("H1", 12, seed=19)
    deflections = made.noisy(np.random.default_rng(1))
    assert with_doubts(identify(made.robot, made.recordings(deflections, stated=stated))).suspicions == []
    deflections[:, 4] *= -1.0
    found = with_doubts(identify(made.robot, made.recordings(deflections, stated=stated)))
    assert [text for text in sentences(found.suspicions) if "Does dry_rad have the wrong sign?" in text]


def test_a_hardly_loaded_leg_has_an_interval_without_an_upper_end() -> None:
    made = idle_leg(experiment("H1", 6, seed=17))
    here = robot("H1")
    tiny = np.zeros((6, 6))
    tiny[:, 2] = 0.05
    made = replace(
        made, wrenches=made.wrenches + (tiny[:, None, :] @ np.linalg.inv(here.jacobians(made.poses).forward))[:, 0]
    )
    record = identification_record(identify(here, made.recordings(made.noisy(np.random.default_rng(3)))))
    estimate, low, high = record["stiffness"]["leg 3"]
    assert high is None
    assert low is not None or estimate is not None
