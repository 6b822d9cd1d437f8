"""Lower bounds: closed forms, the equivalence theorem, and that nothing beats them, neither chance nor optimisation."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.deflection_noise import series_by_pose
from expdesign.planning.optimality.certificate import Certificate, LowerBound
from expdesign.planning.optimality.measurement_maps import MeasurementMaps
from expdesign.planning.optimality.pool import Pool
from expdesign.planning.optimality.weights import Relaxation, dual_of, optimal_weights
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.sampling import starting_designs
from expdesign.planning.search import search
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.design.refined import refined
from tests.oracle import Array
from tests.sweeps.small import SMALL

FACTORS = {"duir": 0.0, "total": 1.0}


SPREAD_TARGETS = [
    {"pose": [0.1, 0.6], "wrench": [0.0, -1000.0], "tolerance": {"dx_m": 1.0e-6}},
    {"pose": [-0.2, 0.4], "wrench": [300.0, -1000.0], "tolerance": {"dy_m": 2.0e-6}},
    {"pose": [0.2, 0.9], "wrench": [0.0, 500.0], "tolerance": {"dx_m": 3.0e-6, "dy_m": 1.0e-6}, "weight": 3.0},
]


OWN = [{"source": "com", "std": [0.001, 0.001, 0.001], "shared": False}, {"source": "mass", "std": 0.1}]


CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "bipod": (BIPOD, {}),
    "bipod-one": (BIPOD, {"experiment.measurements": 1}),
    "bipod-max": (BIPOD, {"aggregate": "max", "targets": SPREAD_TARGETS}),
    "bipod-mean": (BIPOD, {"targets": SPREAD_TARGETS}),
    "bipod-one-axis": (BIPOD, {"experiment.deflection_noise": {"std": {"dx_m": 1.0e-6}}, "experiment.measurements": 4}),
    "bipod-shared-error": (BIPOD, {"experiment.load_error": [{"source": "wrench", "std": [5.0, 8.0]}]}),
    "bipod-shared-reference": (
        BIPOD,
        {
            "experiment.deflection_noise.shared_reference": True,
            "experiment.load": {"kind": "wrench", "fx_N": [-500.0, 500.0], "fy_N": [-500.0, 500.0]},
        },
    ),
    "bipod-grid": (BIPOD, {"experiment.poses": {"grid": {"x_m": [-0.3, 0.3, 5], "y_m": [0.4, 0.8, 4]}}}),
    "hexapod": (HEXAPOD, {}),
    "hexapod-max": (HEXAPOD, {"aggregate": "max"}),
    "hexapod-own-errors": (HEXAPOD, {"experiment.load_error": OWN}),
    "hexapod-geometric": (HEXAPOD, {"experiment.geometric_stiffness": True}),
}


def random_designs(here: DesignProblem, count: int, seed: int) -> Array:
    space = here.space
    designs = starting_designs(here, count, np.random.default_rng(seed))
    # A third of them with extreme loads, some with measurements repeated at the same pose: where the best designs are.
    loads = [i for i, v in enumerate(space.variables) if v.columns[0] >= space.n_pose and not v.discrete]
    third = count // 3
    middle = 0.5 * (space.lower + space.upper)
    designs[:third, :, loads] = np.where(designs[:third] > middle, space.upper, space.lower)[..., loads]
    poses = [i for i, v in enumerate(space.variables) if v.columns[0] < space.n_pose]
    designs[: third // 2, 1:, poses] = designs[: third // 2, :1, poses]
    return designs


def values(here: DesignProblem, decisions: Array, name: str) -> Array:
    found = known_criteria()[name].values(here.assess(*here.space.decode(decisions)))
    return np.where(np.isfinite(found), found, np.inf)


def beaten(bound: float, found: Array) -> bool:
    """Whether any design is better than a bound says is possible."""
    return bool((found < bound * (1.0 - 1e-9)).any())


@pytest.mark.parametrize("name", CASES)
def test_no_design_beats_a_bound_and_a_bound_that_is_too_high_is_beaten(name: str) -> None:
    here = problem(*CASES[name])
    chance = random_designs(here, 3000, 11)
    polished = refined(here, chance[:20], 12)
    for criterion, factor in FACTORS.items():
        bound = Certificate(here, factor).bound()
        assert bound.value is not None
        found = np.concatenate([values(here, chance, criterion), values(here, polished, criterion)])
        assert not beaten(bound.value, found)
        # Had the bound been a third too high, the same designs would have shown it.
        slack = 1.6 if name in ("bipod-shared-reference", "hexapod-own-errors", "bipod-one-axis") else 1.34
        assert beaten(slack * bound.value, found)


def orthogonal_bipod(measurements: int) -> DesignProblem:
    """At (0, 0.5) the legs are perpendicular, and the corners of the box of loads each load one leg alone."""
    return problem(
        BIPOD,
        {
            "experiment.measurements": measurements,
            "experiment.poses": {"bounds": {"x_m": 0.0, "y_m": 0.5}},
            "experiment.load": {"kind": "wrench", "fx_N": [-300.0, 300.0], "fy_N": [-300.0, 300.0]},
            "experiment.deflection_noise": {"std": {"dx_m": 1.0e-6, "dy_m": 1.0e-6}},
            "experiment.load_error": [],
        },
    )


@pytest.mark.parametrize("measurements", [1, 2, 7])
def test_closed_form(measurements: int) -> None:
    # M = w·diag(a, 0) + (1 − w)·diag(0, a) with a = τ²/σ²: min C_11/(w·a) + C_22/((1 − w)·a) = (√C_11 + √C_22)²/a.
    here = orthogonal_bipod(measurements)
    rows = here.targets.observation[0] * np.sqrt(here.targets.importance[0])[:, None]
    diagonal = np.sqrt((rows**2).sum(axis=0))
    information = 2.0 * 300.0**2 / 1e-6**2
    bound = Certificate(here, 0.0).bound().value
    assert bound == pytest.approx(diagonal.sum() / np.sqrt(information * measurements), rel=1e-4)
    assert bound is not None
    assert bound <= diagonal.sum() / np.sqrt(information * measurements)


def relaxation_of(here: DesignProblem, factor: float, count: int) -> tuple[Relaxation, Array]:
    information = MeasurementMaps(here, factor)
    decisions = random_designs(here, count, 5)[:, 0]
    return information.relaxation(), information.rows(decisions)


@pytest.mark.parametrize("name", ["bipod-mean", "bipod-max", "hexapod", "hexapod-max"])
@pytest.mark.parametrize("factor", [0.0, 1.0])
def test_equivalence_theorem(name: str, factor: float) -> None:
    relaxation, rows = relaxation_of(problem(*CASES[name]), factor, 400)
    weights, dual = optimal_weights(relaxation, rows, 1e-5)
    sensitivities = dual.sensitivities(rows)
    largest = sensitivities.max()
    assert weights.sum() == pytest.approx(1.0)
    assert (weights >= 0.0).all()
    # On the support d is largest, and the bound meets the value.
    assert sensitivities[weights > 1e-3].min() > (1.0 - 1e-3) * largest
    assert dual.bound(float(largest)) == pytest.approx(dual.value, rel=1e-5)


@pytest.mark.parametrize("measurements", [24, pytest.param(60, marks=pytest.mark.slow)])
def test_the_bound_of_a_finite_space_is_what_the_relaxation_over_all_of_it_gives(measurements: int) -> None:
    here = problem(*CASES["bipod-grid"])
    bound = Certificate(here, 0.0).bound()
    assert "all 80 measurements" in bound.certified_on
    assert bound.value is not None
    many = problem(BIPOD, {**CASES["bipod-grid"][1], "experiment.measurements": measurements})
    scaled = Certificate(many, 0.0).bound().value
    assert scaled == pytest.approx(bound.value * np.sqrt(2 / measurements), rel=1e-3)
    # So many measurements can follow the optimal weights closely.
    designs = refined(many, random_designs(many, 10, 3), 12)
    assert values(many, designs, "duir").min() < 1.01 * Certificate(many, 0.0).bound().value


def test_opposite_loads_on_a_shared_reference_beat_separate_references() -> None:
    # Sharing a reference can tell more: the difference of two opposite loads does not contain the reference's noise.
    # A bound for separate references is therefore none for shared ones.
    name = "bipod-shared-reference"
    here = problem(*CASES[name])
    separate = problem(BIPOD, {**CASES[name][1], "experiment.deflection_noise.shared_reference": False})
    designs = random_designs(here, 4000, 1)
    designs[:, 1] = designs[:, 0]
    space = here.space
    of_load = range(space.n_pose, space.n_pose + space.n_load)
    designs[:, 1, [i for i, v in enumerate(space.variables) if v.columns[0] in of_load]] *= -1.0
    assert (series_by_pose(here.space.decode(designs)[0]) == 1).all()
    without_settings = [i for i, v in enumerate(space.variables) if v.columns[0] < space.n_pose + space.n_load]
    shared, apart = values(here, designs, "duir"), values(separate, designs[..., without_settings], "duir")
    np.testing.assert_allclose(shared * np.sqrt(2.0), apart, rtol=1e-9)
    assert not beaten(bound_value(Certificate(here, 0.0).bound()), shared)


def bound_value(bound: LowerBound) -> float:
    assert bound.value is not None
    return bound.value


def test_gradients_of_the_sensitivity() -> None:
    for name in ("hexapod", "hexapod-own-errors"):
        here = problem(*CASES[name])
        information = MeasurementMaps(here, 1.3)
        decisions = random_designs(here, 30, 8)[:, 0]
        rows = information.rows(decisions)
        dual = dual_of(information.relaxation(), rows, np.full(30, 1.0 / 30.0), np.ones(1))
        found, gradient = Pool(information, 10).sensitivity(dual, decisions[:5, None])
        np.testing.assert_allclose(found, dual.sensitivities(rows[:5]), rtol=1e-12)
        span = here.space.upper - here.space.lower
        moved_by_ascents = ~here.space.discrete
        if information.convex_in_load:  # loads matter at their extremes alone
            moved_by_ascents[information.load_variables().index] = False
        for decision in np.flatnonzero(moved_by_ascents):
            step = 1e-5 * span[decision]
            moved = np.stack([decisions[:5], decisions[:5]])
            moved[:, :, decision] += np.array([[-step], [step]])
            low, high = dual.sensitivities(information.rows(moved.reshape(10, -1))).reshape(2, 5)
            assert (
                np.abs((high - low) / (2.0 * step) - gradient[:, decision]).max() * span[decision] < 1e-6 * found.max()
            )


def test_extreme_loads_are_where_the_sensitivity_is_largest() -> None:
    here = problem(*CASES["hexapod"])
    information = MeasurementMaps(here, 1.0)
    assert information.convex_in_load
    decisions = random_designs(here, 60, 4)[:, 0]
    dual = dual_of(information.relaxation(), information.rows(decisions), np.full(60, 1.0 / 60.0), np.ones(1))
    loads = information.load_variables()
    corners = np.repeat(decisions[:, None], len(loads.vertices), axis=1)
    corners[..., loads.index] = loads.vertices
    at_corners = dual.sensitivities(information.rows(corners.reshape(-1, decisions.shape[1]))).reshape(60, -1)
    assert (dual.sensitivities(information.rows(decisions)) <= at_corners.max(axis=1) * (1.0 + 1e-9)).all()


def test_where_nothing_matters_there_is_no_bound() -> None:
    here = problem(BIPOD)
    empty = type(here)(
        **{**vars(here), "targets": type(here.targets)(**{**vars(here.targets), "importance": np.zeros((1, 2))})}
    )
    bound = Certificate(empty, 0.0).bound()
    assert bound.value is None
    assert bound.certified_on


def test_a_fixed_load_has_a_bound(tmp_path: Path) -> None:
    """One corner of the range of loads, with no coordinate: it once could not be laid out."""
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(SMALL), encoding="utf-8")
    problem = read_problem(tmp_path / "config.yaml")
    front = search(problem)
    bound = Certificate(problem, 0.0).bound(front.decisions).value
    assert bound is not None
    assert 0.0 < bound <= float(front.criteria["duir"].min()) * (1.0 + 1e-9)
