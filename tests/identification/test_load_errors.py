"""Declared errors of the recorded loads are weighed by the fit, and are in all that is said of it (theory.md 5.6)."""

from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import expdesign as xd
from expdesign.arrays import FloatArray, as_matrix
from expdesign.assurance.acceptance.fitted import attained_at_targets, fitted_budget
from expdesign.assurance.acceptance.planned import planned_budgets
from expdesign.chain.chain import Chain
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.estimation.fit import Fit, linear_fit
from expdesign.estimation.gaussian import Gaussian
from expdesign.estimation.identify import Identification, identify
from expdesign.estimation.load_errors import Estimator, load_columns
from expdesign.estimation.weighed import Fittable, weighed
from expdesign.estimation.whitening import Whitening
from expdesign.report.at_targets import AtTargets
from tests.design.problems import BIPOD, HEXAPOD, problem, recorded

LARGE = [
    {"source": "mass", "std": 0.5, "shared": True},
    {"source": "com", "std": [0.02, 0.02, 0.02], "shared": False},
]
"""Errors that move the readings by many times their noise."""
SHARED = [
    {"source": "mass", "std": 0.5, "shared": True},
    {"source": "com", "std": [0.004, 0.003, 0.005], "shared": True},
]
UNDECLARED = {"experiment.measurements": 6, "experiment.load_error": []}
CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "bipod-wrench": (BIPOD, {"experiment.measurements": 6}),
    "hexapod-payload": (HEXAPOD, {"experiment.measurements": 6, "experiment.load_error": LARGE}),
}


def simulated(load_error: list[dict[str, Any]], **options: Any) -> tuple[Any, Any]:
    """A problem, and recordings of a plan for it."""
    case = problem(HEXAPOD, {"experiment.measurements": 6, "experiment.load_error": load_error})
    return case, recorded(case, **options)


def written_out(result: Identification, train: Any, scales: FloatArray) -> FloatArray:
    """C = V + Σ λ²·G·Gᵀ of all readings."""
    loads = result.loads
    assert loads is not None
    count, readings = train.deflections.shape
    size = count * readings
    plain = Whitening(result.noise.deviations, references=train.references)
    root = plain.apply(np.eye(size).reshape(count, readings, size)).reshape(size, size)
    columns = load_columns(loads.effects, scales).as_shared.shared.reshape(size, -1)
    return np.asarray(np.linalg.inv(root.T @ root) + columns @ columns.T)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("shared_reference", [False, True])
def test_estimate_covariance_and_chi2_are_those_of_one_model(name: str, shared_reference: bool) -> None:
    base, changes = CASES[name]
    case = problem(base, changes)
    plain = xd.identify(base["robot"], recorded(case, seed=3), shared_reference=shared_reference).result
    result = identify(case.loaded.robot, plain.recordings, load_errors=case.load_errors)
    train = result.recordings.rows(result.fitted)
    loads = result.loads
    assert loads is not None
    inverse, sized = (np.linalg.inv(written_out(result, train, scales)) for scales in (loads.weights, loads.sizes))
    sensitivities = result.fit.chain.predict_with_sensitivities(row_data(train, result.robot), result.fit.values)[1]
    matrix = sensitivities[:, train.axes].reshape(train.deflections.size, -1)
    gain = np.linalg.solve(matrix.T @ inverse @ matrix, matrix.T @ inverse)
    covariance = gain @ np.linalg.solve(sized, gain.T)
    values = gain @ train.deflections.ravel()
    np.testing.assert_allclose(result.fit.values, values, rtol=1e-6)
    np.testing.assert_allclose(result.fit.covariance, result.fit.inflation * covariance, rtol=1e-5, atol=1e-9)
    left = train.deflections.ravel()
    left = left - matrix @ np.linalg.solve(matrix.T @ sized @ matrix, matrix.T @ sized @ left)
    assert result.goodness.chi2 == pytest.approx(left @ sized @ left, rel=1e-6)
    assert (loads.weights < loads.sizes).all()
    assert np.abs(plain.fit.values - values).max() > 1e-4


def test_the_weighted_estimate_is_that_of_exact_loads_and_its_covariance_has_their_errors() -> None:
    case, frame = simulated(SHARED, seed=4)
    exact = xd.identify(HEXAPOD["robot"], frame).result
    found = identify(case.loaded.robot, exact.recordings, load_errors=case.load_errors, estimator="weighted")
    np.testing.assert_allclose(found.fit.values, exact.fit.values, rtol=1e-12)
    train = found.recordings.rows(found.fitted)
    covariance = written_out(found, train, np.ones(2))
    sensitivities = found.fit.chain.predict_with_sensitivities(row_data(train, found.robot), found.fit.values)[1]
    matrix = sensitivities[:, train.axes].reshape(train.deflections.size, -1) / train.deviations.reshape(-1, 1)
    gain = np.linalg.solve(matrix.T @ matrix, matrix.T) / train.deviations.ravel()
    np.testing.assert_allclose(
        found.fit.covariance, found.fit.inflation * gain @ covariance @ gain.T, rtol=1e-6, atol=1e-12
    )


def test_a_diagnosis_reads_the_errors_that_the_recordings_declare() -> None:
    case, frame = simulated(SHARED, seed=3)
    diagnosed = xd.diagnose(HEXAPOD["robot"], columns_of(frame, **WHOLE), targets=problem(HEXAPOD, UNDECLARED))
    named, found = diagnosed.result.before, diagnosed.acceptance
    configured = xd.identify(HEXAPOD["robot"], frame, targets=case).result.goodness
    assert named.chi2 == pytest.approx(configured.chi2, rel=1e-6)
    assert named.without_load_errors == pytest.approx(configured.without_load_errors, rel=1e-6)
    assert found is not None
    assert [one.name for one in found.budget.contributions][1:] == ["mass", "com"]


@pytest.mark.parametrize("estimator", ["generalised", pytest.param("weighted", marks=pytest.mark.slow)])
def test_a_diagnosis_that_misses_nothing_is_the_identification(estimator: str) -> None:
    """One model has one estimate, one covariance, one statement of fit and one U."""
    _, frame = simulated(LARGE, seed=4)
    case = problem(
        HEXAPOD,
        {"experiment.measurements": 6, "experiment.load_error": LARGE, "experiment.estimator": estimator},
    )
    diagnosed, identified = (way(HEXAPOD["robot"], frame, targets=case) for way in (xd.diagnose, xd.identify))
    assert diagnosed.record["verdict"] == "consistent"
    assert diagnosed.result.before.without_load_errors is not None
    known, fit = diagnosed.result.known, identified.result.fit
    np.testing.assert_allclose(known.values, fit.values, rtol=1e-7)
    np.testing.assert_allclose(known.covariance, fit.covariance, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(diagnosed.model.covariance, known.covariance, rtol=1e-9, atol=1e-12)
    assert diagnosed.record["load_errors"]["estimator"] == estimator
    assert diagnosed.result.after.chi2 == pytest.approx(identified.result.goodness.chi2, rel=1e-6)
    np.testing.assert_allclose(diagnosed.acceptance.budget.expanded, identified.acceptance.budget.expanded, rtol=1e-6)


def test_the_next_measurement_follows_a_fit_that_weighs_the_load_errors() -> None:
    case, frame = simulated(LARGE, seed=3)
    fit = xd.plan_next(case, frame).fit
    assert fit is not None
    assert not fit.refuted
    assert fit.without_load_errors is not None


class Experiments:
    """Repetitions of one experiment that is linear in noise and load errors, about the readings without either."""

    def __init__(self, load_error: list[dict[str, Any]], *, stated: bool = True) -> None:
        self.case, frame = simulated(load_error, noise=False, load_errors=False)
        recordings = xd.identify(HEXAPOD["robot"], frame).result.recordings
        self.deviations = recordings.deviations
        self.recordings = recordings if stated else replace(recordings, deviations=None)
        base = identify(self.case.loaded.robot, recordings, load_errors=self.case.load_errors)
        assert base.loads is not None
        self.columns = load_columns(base.loads.effects, np.ones(len(base.loads.effects))).as_shared.shared

    def identified(self, random: np.random.Generator, actual: float, estimator: Estimator) -> Identification:
        """One repetition with load errors `actual` times as large as they are declared."""
        self.drawn = actual * random.standard_normal(self.columns.shape[-1])
        moved = self.columns @ self.drawn
        noise = self.deviations * random.standard_normal(self.deviations.shape)
        recorded = replace(self.recordings, deflections=self.recordings.deflections + moved + noise)
        return identify(self.case.loaded.robot, recorded, load_errors=self.case.load_errors, estimator=estimator)

    def coverage(self, count: int, estimator: Estimator, actual: float = 1.0) -> tuple[float, float]:
        """Share of 95 % intervals of compliance that hold the truth, and RMS of the relative errors."""
        random = np.random.default_rng(7)
        truth, inside, errors = self.case.loaded.robot.compliance, [], []
        for _ in range(count):
            own = self.identified(random, actual, estimator).compliance
            inside.append((own.low <= truth) & (truth <= own.high))
            errors.append(own.estimate / truth - 1.0)
        return float(np.mean(inside)), float(np.sqrt(np.mean(np.square(errors))))


def test_what_acts_at_targets_is_the_posterior_of_the_joint_model() -> None:
    """Mean and covariance of the load errors and with the parameters, where the fit weighs them as they are drawn."""
    experiments = Experiments([*SHARED, LARGE[1]])
    case, random = experiments.case, np.random.default_rng(4)
    recorded = experiments.identified(random, 1.0, "generalised").recordings
    chain, robot = Chain(case.loaded.robot), case.loaded.robot
    rows = row_data(recorded, robot)

    def linearised(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        predicted, sensitivities = chain.predict_with_sensitivities(rows, values)
        return recorded.deflections - predicted, sensitivities

    def solve(whitening: Whitening) -> Fit:
        residuals, sensitivities = linearised(np.zeros(6))
        return linear_fit(chain, np.zeros(6), whitening.apply(residuals), whitening.apply(sensitivities))

    noise = Whitening(np.asarray(recorded.deviations))
    fit, loads = weighed(
        Fittable(chain, recorded, solve, linearised), noise, case.load_errors, "generalised", np.ones(1)
    )
    residuals, sensitivities = linearised(fit.values)
    columns = load_columns(loads.effects, np.ones(len(loads.effects)))
    alone = noise.weighing(replace(columns, shared=columns.shared[..., :0]))
    flat = [as_matrix(alone.apply(each)) for each in (sensitivities, columns.shared)]
    known = np.append(np.full(6, np.inf), np.ones(flat[1].shape[1]))
    expected = Gaussian(np.hstack(flat), alone.apply(residuals).ravel(), known)
    np.testing.assert_allclose(loads.estimated.mean, expected.estimate[6:], rtol=1e-7, atol=1e-9)
    acting = loads.at_targets(fit)
    assert acting is not None
    units = np.concatenate([np.ones(6), loads.acting.units])
    kept = np.concatenate([np.arange(6), 6 + loads.acting.columns])
    joint = expected.estimable.covariance[np.ix_(kept, kept)] * np.outer(units, units)
    np.testing.assert_allclose(acting.covariance, joint[6:], rtol=1e-6, atol=1e-9 * np.abs(joint).max())


@pytest.mark.parametrize("estimator", ["generalised", "weighted"])
def test_coverage_of_targets_at_which_load_errors_act(estimator: Estimator) -> None:
    """The direction of gravity at all, the weights' errors where these are carried: what is left of them is in U."""
    experiments = Experiments([*SHARED, {"source": "direction", "std": [0.02, 0.02], "shared": True}])
    case = deepcopy(experiments.case.config)
    case["targets"].append(deepcopy(case["targets"][0]))
    case["targets"][0]["payload"]["same_as"] = "experiment"
    here, random, ratios = problem(case, {"experiment.estimator": estimator}), np.random.default_rng(3), []
    for _ in range(100):
        found = experiments.identified(random, 1.0, estimator)
        assert found.loads is not None
        acting, units = found.loads.at_targets(found.fit), found.loads.acting.units
        assert acting is not None
        sensitivities = attained_at_targets(here, found.fit, experiments.recordings, acting).sensitivities
        wrong = np.concatenate([found.fit.values - 1.0, acting.values - units * experiments.drawn])
        budget = fitted_budget(here, AtTargets.identified(here, found).model)
        ratios.append((sensitivities @ wrong) / budget.standard)
    spread = np.sqrt(np.mean(np.square(ratios), axis=0))
    np.testing.assert_allclose(spread, 1.0, atol=0.21)  # three standard errors of a root mean square of 100
    expected = planned_budgets(here, here.assess(*plan_of(experiments.recordings)))[0]
    np.testing.assert_allclose(expected.standard, budget.standard, rtol=0.35)
    for each in (expected, budget):
        assert each.repetition is not None
        once = each.repetition.variances(1.0)
        if each is expected or estimator == "weighted":  # a fit weighs less than its intervals contain
            np.testing.assert_allclose(once, each.standard**2, rtol=1e-6)
    configurations, loads = (np.repeat(each, 5, axis=1) for each in plan_of(experiments.recordings))
    several = planned_budgets(here, here.assess(configurations, loads))[0]
    np.testing.assert_allclose(expected.repeated(5.0), several.expanded, rtol=1e-6)
    names = [one.name for one in budget.contributions]
    for name in ("mass", "com"):  # carried or not, U differs
        both = budget.contributions[names.index(name)].deviation
        assert np.abs(both[0] / both[1] - 1.0).max() > 0.05


def plan_of(recorded: Recordings) -> tuple[FloatArray, FloatArray]:
    """Configurations and loads of one design."""
    assert recorded.payload is not None
    loads = np.concatenate([recorded.payload, recorded.gravity], axis=1)
    return recorded.configurations[None], loads[None]


@pytest.mark.parametrize("estimator", ["generalised", "weighted"])
@pytest.mark.parametrize("stated", [True, False])
def test_coverage_of_400_experiments(estimator: Estimator, stated: bool) -> None:
    if estimator == "weighted" and not stated:
        pytest.skip("levels of the noise take up the load errors there")
    share, _ = Experiments(SHARED, stated=stated).coverage(400, estimator)
    assert share == pytest.approx(0.95, abs=0.02)


def test_a_declaration_twice_too_large_costs_nothing_that_matters() -> None:
    """Against least squares that weigh no load error: better where the declaration is right, not worse where half."""
    experiments = Experiments(SHARED)
    for actual, most in ((1.0, 0.95), (0.5, 1.05)):
        weighing = experiments.coverage(60, "generalised", actual)[1]
        assert weighing <= most * experiments.coverage(60, "weighted", actual)[1]


def test_the_scale_that_was_taken_follows_the_recordings() -> None:
    """Errors that every row has for itself tell their size: a fifth and twice what is declared are seen."""
    experiments = Experiments([{"source": "com", "std": [0.02, 0.02, 0.02], "shared": False}])
    random = np.random.default_rng(2)
    taken = []
    for actual in (0.2, 2.0):
        found = [experiments.identified(random, actual, "generalised").loads for _ in range(5)]
        taken.append(float(np.mean([np.log(loads.sizes[0]) for loads in found if loads is not None])))
    assert taken[0] < np.log(0.4)
    assert taken[1] > np.log(1.5)


def columns_of(frame: Any, **errors: Any) -> Any:
    return frame.assign(**{f"error_{name}": value for name, value in errors.items()})


WHOLE = {"mass_kg": 0.5, "com_x_m": 0.004, "com_y_m": 0.003, "com_z_m": 0.005}


def test_columns_of_the_recordings_declare_what_a_configuration_does() -> None:
    case, frame = simulated(SHARED, seed=5)
    by_columns = xd.identify(HEXAPOD["robot"], columns_of(frame, **WHOLE)).result
    recorded = xd.identify(HEXAPOD["robot"], frame).result.recordings
    by_configuration = identify(case.loaded.robot, recorded, load_errors=case.load_errors)
    np.testing.assert_allclose(by_columns.fit.values, by_configuration.fit.values, rtol=1e-9)
    # The same in both places counts once.
    both = xd.identify(HEXAPOD["robot"], columns_of(frame, **WHOLE), targets=case).result
    np.testing.assert_allclose(both.fit.values, by_configuration.fit.values, rtol=1e-9)
    assert both.loads is not None
    assert [effect.source for effect in both.loads.effects] == ["mass", "com"]


def test_every_weight_has_an_error_of_its_own() -> None:
    _, frame = simulated(SHARED, seed=5)
    names = ["large" if row % 2 else "small" for row in range(len(frame))]
    frame = columns_of(frame, mass_kg=0.5).assign(weight=names)
    frame["error_mass_kg"] = [0.5 if name == "large" else 0.2 for name in names]
    loads = xd.identify(HEXAPOD["robot"], frame).result.loads
    assert loads is not None
    assert [(effect.name, effect.deviation.tolist()) for effect in loads.effects] == [
        ("mass of large", [0.5]), ("mass of small", [0.2]),
    ]  # fmt: skip
    rows = np.array(names) == "large"
    assert not loads.effects[0].moved[~rows].any()
    assert loads.effects[0].moved[rows].any()
    assert len(loads.record["sources"]) == 2


@pytest.mark.parametrize(
    ("errors", "said"),
    [
        ({"mass_kg": 0.0}, "0 is not a standard deviation"),
        ({"mass_kg": 1e4}, "larger than the load itself"),
        ({"fx_N": -1.0}, "-1 is not a standard deviation"),
        ({"mass_kg": [0.5] * 5 + [0.4]}, "all rows share it"),
        ({"mass_kg": 0.4}, "experiment.load_error"),  # which declares another one
    ],
)
def test_errors_that_are_none_are_refused(errors: dict[str, Any], said: str) -> None:
    case, frame = simulated(SHARED, seed=5)
    with pytest.raises(InputError, match=said) as refused:
        xd.identify(HEXAPOD["robot"], columns_of(frame, **errors), targets=case)
    assert f"column error_{next(iter(errors))}" in str(refused.value)
