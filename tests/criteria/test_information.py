"""The algebra of information against the dense formulas of theory.md 4.2 and 5.3, and against the assessment."""

from dataclasses import replace
from functools import reduce

import numpy as np
import pytest

from expdesign.assurance.acceptance.planned import acting_loads
from expdesign.estimation.gaussian import Gaussian
from expdesign.estimation.load_errors import Estimator
from expdesign.planning.criteria.accuracy import expected_total
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.information import Information
from expdesign.planning.optimality.exchange import Exchange
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import starting_designs
from expdesign.planning.scalarisation import Aims
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array


def covariance_of(errors: Array, shared: Array) -> Array:
    """Of the load errors alone, in the whitened readings (m·k, m·k), of errors (m, k, d)."""
    m, k, _ = errors.shape
    common = errors[..., shared].reshape(m * k, -1)
    covariance = common @ common.T
    for place, block in enumerate(errors[..., ~shared]):
        part = slice(place * k, (place + 1) * k)
        covariance[part, part] += block @ block.T
    return covariance


def dense(
    rows: Array, errors: Array, shared: Array, targets: Array, estimator: str, noise: Array | None = None
) -> tuple[Array, Array]:
    """U_ii and (Z·Σ_F·Zᵀ)_ii from whole matrices: rows (m, k, p), errors (m, k, d), targets (t, r, p)."""
    m, k, p = rows.shape
    flat, force = rows.reshape(m * k, p), covariance_of(errors, shared)
    noise = np.eye(m * k) if noise is None else noise
    inverse = np.linalg.inv(noise + force if estimator == "generalised" else noise)
    gain = np.linalg.solve(flat.T @ inverse @ flat, flat.T @ inverse)
    first, second = (np.einsum("trp,pq,trq->tr", targets, gain @ each @ gain.T, targets) for each in (noise, force))
    return first, second


def drawn(here: DesignProblem, count: int) -> Array:
    designs = starting_designs(here, count, np.random.default_rng(2))
    return designs.reshape(-1, here.space.decisions)[:count]


def told(here: DesignProblem, measurements: Array) -> Information:
    """Of all measurements (c, g), one added to the other."""
    each = here.informed(measurements)
    return reduce(Information.plus, (each.part(index) for index in range(len(measurements))))


ERRORS = [
    {"source": "com", "std": [0.001, 0.001, 0.001], "shared": True},
    {"source": "wrench", "std": [0.5, 0.5, 0.5, 0.05, 0.05, 0.05], "shared": False},
]
ESTIMATORS: list[Estimator] = ["weighted", "generalised"]
BASES = [(BIPOD, {}), (HEXAPOD, {}), (HEXAPOD, {"experiment.load_error": ERRORS})]


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize(("base", "changes"), BASES)
def test_all_forms_have_the_variances_of_the_dense_formulas(
    base: dict[str, object], changes: dict[str, object], estimator: Estimator
) -> None:
    here = problem(base, {**changes, "experiment.estimator": estimator})
    measurements = drawn(here, 5)
    rows, errors = here.whitened(*here.space.decode(measurements))
    targets, scale = here.targets.observation, here.loaded.scale
    noise, force = dense(rows * scale, errors, here.shared_errors, targets * scale, estimator)
    total = told(here, measurements)
    configurations, loads = here.space.decode(measurements)
    assessment = here.assess(configurations[None], loads[None])
    of_assessment = assessment.noise_variance[0], assessment.force_variance[0]
    for found in (total.variances(targets), of_assessment):
        np.testing.assert_allclose(found[0], noise, rtol=1e-8)
        np.testing.assert_allclose(found[1], force, rtol=1e-8)
    for root, part in ((assessment.noise_root, noise), (assessment.force_root, force)):
        np.testing.assert_allclose((root[0] ** 2).sum(axis=-1), part, rtol=1e-8)
    expected = known_criteria()["total"].values(assessment)[0]
    assert expected_total(total, here.targets) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_what_is_known_before_counts_as_if_it_were_measured(estimator: Estimator) -> None:
    here = problem(HEXAPOD, {"experiment.load_error": ERRORS, "experiment.estimator": estimator})
    measurements = drawn(here, 6)
    beside = replace(here, known=told(here, measurements[:3]))
    assessed = beside.assessed(measurements[None, 3:])
    configurations, loads = here.space.decode(measurements)
    together = here.assess(configurations[None], loads[None])
    np.testing.assert_allclose(assessed.noise_variance, together.noise_variance, rtol=1e-9)
    np.testing.assert_allclose(assessed.force_variance, together.force_variance, rtol=1e-9)
    for name in ("duir", "feir"):
        by_sums = Exchange(beside, (name,)).scores(measurements[None, 3:], Aims.of_one(1))
        assert by_sums == pytest.approx(known_criteria()[name].values(together), rel=1e-8)


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("sources", [[], ERRORS])
def test_series_that_share_a_reference_are_those_of_dense_formulas(
    sources: list[dict[str, object]], estimator: Estimator
) -> None:
    """Cov = ½(I + 11ᵀ)⊗V within a series, and what load errors add (theory.md 10.4, 10.6)."""
    changes = {"experiment.deflection_noise.shared_reference": True, "experiment.load_error": sources}
    here = problem(HEXAPOD, {**changes, "experiment.measurements": 6, "experiment.estimator": estimator})
    design = drawn(here, 6)
    design[:3, here.space.of_pose] = design[0, here.space.of_pose]
    rows, errors = here.whitened(*here.space.decode(design))
    series = np.unique(design[:, here.space.of_pose], axis=0, return_inverse=True)[1].ravel()
    noise = np.kron(0.5 * (np.eye(6) + (series[:, None] == series)), np.eye(rows.shape[1]))
    targets, scale = here.targets.observation * here.loaded.scale, here.loaded.scale
    expected = dense(rows * scale, errors, here.shared_errors, targets, estimator, noise)
    configurations, loads = here.space.decode(design)
    assessment = here.assess(configurations[None], loads[None], series[None] + 1)
    for part, found in zip(expected, (assessment.noise_variance[0], assessment.force_variance[0]), strict=True):
        np.testing.assert_allclose(found, part, rtol=1e-8, atol=1e-30)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_gain_and_sensitivity_are_those_of_the_estimator(estimator: Estimator) -> None:
    """Load errors and noise through `gain` leave what FEIR and DUIR say; Z is −A_D·P·D (theory.md 5.1)."""
    here = problem(HEXAPOD, {"experiment.load_error": ERRORS, "experiment.estimator": estimator})
    design = drawn(here, 4)
    assessment = here.assessed(design[None])
    gain, measured = assessment.gain[0], assessment.measurements
    np.testing.assert_allclose(np.einsum("mpn,mnq->pq", gain, measured.observation[0]), np.eye(6), atol=1e-9)
    covariance = covariance_of(measured.compliance[0] @ measured.load_errors[0], here.shared_errors)
    through = here.targets.observation @ gain.swapaxes(0, 1).reshape(6, -1)
    found = np.einsum("tij,jk,tik->ti", through, covariance, through)
    np.testing.assert_allclose(found, assessment.force_variance[0], rtol=1e-8)
    by_load = -np.einsum("tip,mpn,mnf->timf", here.targets.observation, gain, measured.compliance[0])
    sensitivity = assessment.force_sensitivity()[0].reshape(by_load.shape)
    np.testing.assert_allclose(sensitivity, by_load, atol=1e-9 * np.abs(by_load).max())


def test_what_is_not_determined_is_said() -> None:
    here = problem(HEXAPOD, {"experiment.deflection_noise": {"std": {"dx_m": 1e-6}}})
    one = told(here, drawn(here, 1))
    noise, force = one.variances(here.targets.observation)
    assert np.isnan(noise).any()
    np.testing.assert_array_equal(np.isnan(noise), np.isnan(force))
    assert not np.isfinite(expected_total(one, here.targets))


@pytest.mark.parametrize("shared_reference", [False, True])
def test_errors_that_act_at_targets_as_well_are_those_of_the_joint_model(shared_reference: bool) -> None:
    """(T·K·B_s − T_s)·S_s·(…)ᵀ of every source, and the noise's part (`estimation/gaussian.py`)."""
    sources = [*ERRORS, {"source": "direction", "std": [0.01, 0.02], "shared": True}]
    changes = {"experiment.load_error": sources, "experiment.deflection_noise.shared_reference": shared_reference}
    here = problem(HEXAPOD, changes)
    assessment, acting = here.assessed(drawn(here, 6)[None]), acting_loads(here)
    assert [bool(each.any()) for each in acting] == [False, False, True]
    targets = here.targets.observation.reshape(-1, 6)
    errors = assessment.measurements.compliance @ assessment.measurements.load_errors
    base = assessment.white(assessment.measurements.observation)[0]
    columns, at_targets = [base], [targets]
    for source, part, at in zip(here.loaded.sources, assessment.measurements.sources, acting, strict=True):
        if source.shared:
            columns.append(assessment.white(errors[..., part])[0])
            at_targets.append(at.reshape(len(targets), -1))
        else:
            each = np.eye(assessment.count)[:, None, :, None] * errors[0, ..., part][:, :, None]
            columns.append(assessment.white(each.reshape(1, *each.shape[:2], -1))[0])
            at_targets.append(np.zeros((len(targets), columns[-1].shape[1])))
    whole = np.hstack(columns)
    deviation = np.append(np.full(base.shape[1], np.inf), np.ones(whole.shape[1] - base.shape[1]))
    expected = Gaussian(whole, np.zeros(len(whole)), deviation, at_targets=np.hstack(at_targets))
    noise, parts = assessment.information.budget(here.targets.observation, acting)
    through = np.hstack(at_targets) @ expected.gain
    np.testing.assert_allclose(noise[0].ravel(), (through**2).sum(axis=1), rtol=1e-8)
    for index, pair in enumerate(zip(columns[1:], at_targets[1:], strict=True)):
        squares = (expected.unexplained(*pair) ** 2).sum(axis=1)
        np.testing.assert_allclose(parts[0, ..., index].ravel(), squares, rtol=1e-8)
