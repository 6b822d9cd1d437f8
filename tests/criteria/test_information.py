"""The algebra of information against the dense formulas of theory.md 4.2 and 5.3, and against the assessment."""

from dataclasses import replace
from functools import reduce

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.planning.criteria.accuracy import expected_total
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.information import Information, Sums
from expdesign.planning.optimality.bounds import best_linear_total
from expdesign.planning.optimality.gradient_check import criterion_gradients
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import starting_designs


def dense(rows: Array, errors: Array, shared: Array, targets: Array) -> tuple[Array, Array]:
    """U_ii and (Z·Σ_F·Zᵀ)_ii from whole matrices: rows (m, k, p), errors (m, k, d), targets (t, r, p)."""
    m, k, p = rows.shape
    gain = np.linalg.pinv(rows.reshape(m * k, p))
    common = errors[..., shared].reshape(m * k, -1)
    covariance = common @ common.T
    for place, block in enumerate(errors[..., ~shared]):
        part = slice(place * k, (place + 1) * k)
        covariance[part, part] += block @ block.T
    noise, force = gain @ gain.T, gain @ covariance @ gain.T
    first, second = (np.einsum("trp,pq,trq->tr", targets, each, targets) for each in (noise, force))
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
BASES = [(BIPOD, {}), (HEXAPOD, {}), (HEXAPOD, {"experiment.load_error": ERRORS})]


@pytest.mark.parametrize(("base", "changes"), BASES)
def test_both_forms_have_the_variances_of_the_dense_formulas(
    base: dict[str, object], changes: dict[str, object]
) -> None:
    here = problem(base, changes)
    measurements = drawn(here, 5)
    rows, errors = here.whitened(*here.space.decode(measurements))
    targets, scale = here.targets.observation, here.loaded.scale
    noise, force = dense(rows * scale, errors, here.shared_errors, targets * scale)
    total = told(here, measurements)
    of_sums = Sums.of_information(total.in_units(scale))
    sums = Sums.of_measurements(rows * scale, errors, here.shared_errors)
    summed = Sums(sums.matrix.sum(axis=0), sums.own.sum(axis=0), sums.shared.sum(axis=0))
    configurations, loads = here.space.decode(measurements)
    assessment = here.assess(configurations[None], loads[None])
    of_assessment = assessment.noise_variance[0], assessment.force_variance[0]
    forms = (total.variances(targets), of_sums.variances(targets * scale), summed.variances(targets * scale))
    for found in (*forms, of_assessment):
        np.testing.assert_allclose(found[0], noise, rtol=1e-8)
        np.testing.assert_allclose(found[1], force, rtol=1e-8)
    expected = known_criteria()["total"].values(assessment)[0]
    assert expected_total(total, here.targets) == pytest.approx(expected, rel=1e-8)


def test_what_is_known_before_counts_as_if_it_were_measured() -> None:
    here = problem(HEXAPOD, {"experiment.load_error": ERRORS})
    measurements = drawn(here, 6)
    beside = replace(here, known=told(here, measurements[:3])).assessed(measurements[None, 3:])
    configurations, loads = here.space.decode(measurements)
    together = here.assess(configurations[None], loads[None])
    np.testing.assert_allclose(beside.noise_variance, together.noise_variance, rtol=1e-9)
    np.testing.assert_allclose(beside.force_variance, together.force_variance, rtol=1e-9)


def test_a_shared_reference_is_a_nuisance_parameter_of_its_series() -> None:
    """Rows [a_i, I] with a parameter ρ of prior information 2·I and readings of half the covariance, eliminated as
    roots and as sums, against what the assessment makes of series.
    """
    here = problem(HEXAPOD, {"experiment.deflection_noise.shared_reference": True, "experiment.load_error": ERRORS})
    measurements = drawn(here, 5)
    rows, errors = here.whitened(*here.space.decode(measurements))
    rows, errors, k = np.sqrt(2.0) * rows * here.loaded.scale, np.sqrt(2.0) * errors, rows.shape[1]
    targets = here.targets.observation * here.loaded.scale
    series = np.array([0, 0, 0, 1, 1])
    reference = np.zeros((5, k, 2 * k))
    for row, number in enumerate(series):
        reference[row, :, number * k : (number + 1) * k] = np.sqrt(2.0) * np.eye(k)
    configurations, loads = here.space.decode(measurements)
    assessment = here.assess(configurations[None], loads[None], series[None] + 1)
    nuisance, prior = reference.reshape(5 * k, -1), np.full(2 * k, np.sqrt(2.0))
    found = Information.beside(rows.reshape(5 * k, -1), nuisance, prior).variances(targets)[0]
    np.testing.assert_allclose(found, assessment.noise_variance[0], rtol=1e-8)
    each = Sums.of_measurements(np.concatenate([rows, reference], axis=2), errors, here.shared_errors)
    sums = Sums(each.matrix.sum(axis=0), each.own.sum(axis=0), each.shared.sum(axis=0)).eliminated(2 * k, 2.0)
    for mine, theirs in zip(
        sums.variances(targets), (assessment.noise_variance[0], assessment.force_variance[0]), strict=True
    ):
        np.testing.assert_allclose(mine, theirs, rtol=1e-8)


def test_what_is_not_determined_is_said() -> None:
    here = problem(HEXAPOD, {"experiment.deflection_noise": {"std": {"dx_m": 1e-6}}})
    one = told(here, drawn(here, 1))
    noise, force = one.variances(here.targets.observation)
    assert np.isnan(noise).any()
    np.testing.assert_array_equal(np.isnan(noise), np.isnan(force))
    assert not np.isfinite(expected_total(one, here.targets))


@pytest.mark.parametrize("sources", [[], ERRORS])
@pytest.mark.parametrize("shared_reference", [False, True])
def test_the_best_linear_estimator_is_the_dense_one_of_aitken(
    shared_reference: bool, sources: list[dict[str, object]]
) -> None:
    """Cov = (Aᵀ·C⁻¹·A)⁻¹ with C = S⊗V + Σ_own + D·Σ_shared·Dᵀ (theory.md 10.4), S = ½(I + 11ᵀ) within a series."""
    changes = {"experiment.deflection_noise.shared_reference": shared_reference, "experiment.load_error": sources}
    here = problem(HEXAPOD, changes)
    design = drawn(here, 6)
    design[:3, here.space.of_pose] = design[0, here.space.of_pose]
    rows, errors = here.whitened(*here.space.decode(design))
    (m, k, p), own = rows.shape, ~here.shared_errors
    rows = rows.reshape(m * k, p) * here.loaded.scale
    series = np.unique(design[:, here.space.of_pose], axis=0, return_inverse=True)[1].ravel()
    same = 0.5 * (np.eye(m) + (series[:, None] == series)) if shared_reference else np.eye(m)
    common = errors[..., ~own].reshape(m * k, -1)
    covariance = np.kron(same, np.eye(k)) + common @ common.T
    for place, block in enumerate(errors[..., own]):
        part = slice(place * k, (place + 1) * k)
        covariance[part, part] += block @ block.T
    inverse = np.linalg.inv(rows.T @ np.linalg.inv(covariance) @ rows)
    targets = here.targets.observation * here.loaded.scale
    variances = np.einsum("trp,pq,trq->tr", targets, inverse, targets) * here.targets.importance
    weights = here.targets.weights / here.targets.weights.sum()
    assert best_linear_total(here, design) == pytest.approx(np.sqrt(weights @ variances.sum(axis=1)), rel=1e-9)


def test_what_each_source_adds_is_the_dense_sum_over_it() -> None:
    """Z·Σ_F·Zᵀ of one source after the other (theory.md 5.3): the budget of errors adds up to FEIR."""
    here = problem(HEXAPOD, {"experiment.load_error": ERRORS})
    design = drawn(here, 6)
    rows, errors = here.whitened(*here.space.decode(design))
    targets = here.targets.observation * here.loaded.scale
    assessment = here.assessed(design[None])
    for index, some in enumerate((here.shared_errors, ~here.shared_errors)):
        _, force = dense(rows * here.loaded.scale, errors * some, here.shared_errors, targets)
        np.testing.assert_allclose(assessment.source_variances[0, ..., index], force, rtol=1e-9)
    np.testing.assert_allclose(assessment.source_variances.sum(axis=-1), assessment.force_variance, rtol=1e-12)


def by_dense_formulas(here: DesignProblem, design: Array) -> dict[str, float]:
    """DUIR, FEIR and their sum of a design (m, g) as the interfaces define them, from whole matrices."""
    rows, errors = here.whitened(*here.space.decode(design))
    parts = dense(rows * here.loaded.scale, errors, here.shared_errors, here.targets.observation * here.loaded.scale)
    weights = here.targets.weights / here.targets.weights.sum()
    noise, force = (float(weights @ (part * here.targets.importance).sum(axis=1)) for part in parts)
    return {"duir": noise**0.5, "feir": force**0.5, "total": (noise + force) ** 0.5}


@pytest.mark.parametrize(("base", "changes"), BASES)
def test_gradients_are_those_of_the_dense_formulas(base: dict[str, object], changes: dict[str, object]) -> None:
    here = problem(base, changes)
    design, space = drawn(here, here.space.measurements), here.space
    expected = by_dense_formulas(here, design)
    exact = criterion_gradients(here, design[None], list(expected))
    span = (space.upper - space.lower) * ~space.discrete
    for name, value in expected.items():
        assert exact[name][0][0] == pytest.approx(value, rel=1e-8)
    differences = {name: np.zeros(design.shape) for name in expected}
    for place in np.ndindex(design.shape):
        step = np.zeros(design.shape)
        step[place] = 1e-5 * span[place[1]]
        if step[place] > 0.0:
            high, low = (by_dense_formulas(here, design + sign * step) for sign in (1.0, -1.0))
            for name, found in differences.items():
                found[place] = (high[name] - low[name]) / 2e-5
    for name, found in differences.items():
        np.testing.assert_allclose(exact[name][1][0] * span, found, atol=1e-6 * np.abs(found).max())
