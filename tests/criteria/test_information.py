"""The algebra of information against the dense formulas of theory.md 4.2 and 5.3, and against the assessment."""

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.information import Information, propagated
from expdesign.planning.optimality.bounds import best_linear_total
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sequential import expected_total, information_of
from expdesign.planning.start import starting_designs


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


@pytest.mark.parametrize("base", [BIPOD, HEXAPOD])
def test_sums_have_the_variances_of_the_dense_formulas(base: dict[str, object]) -> None:
    here = problem(base)
    measurements = drawn(here, 5)
    rows, errors = here.whitened(*here.space.decode(measurements))
    rows = rows * here.loaded.scale
    targets = here.targets.observation * here.loaded.scale
    noise, force = dense(rows, errors, here.shared_errors, targets)
    total = information_of(here, measurements).part(0)
    for index in range(1, 5):
        total = total.plus(information_of(here, measurements).part(index))
    found = total.variances(targets)
    np.testing.assert_allclose(found[0], noise, rtol=1e-8)
    np.testing.assert_allclose(found[1], force, rtol=1e-8)
    assert found[2].all()
    configurations, loads = here.space.decode(measurements)
    assessment = here.assess(configurations[None], loads[None])
    np.testing.assert_allclose(assessment.noise_variance[0], noise, rtol=1e-8)
    np.testing.assert_allclose(assessment.force_variance[0], force, rtol=1e-8)
    expected = known_criteria()["total"].values(assessment)[0]
    assert expected_total(total, here.targets, here.loaded.scale) == pytest.approx(expected, rel=1e-8)


def test_what_was_added_can_be_taken_away() -> None:
    here = problem(HEXAPOD)
    each = information_of(here, drawn(here, 4))
    targets = here.targets.observation * here.loaded.scale
    three = each.part(0).plus(each.part(1)).plus(each.part(2))
    back = three.plus(each.part(3)).minus(each.part(3))
    for mine, theirs in zip(back.variances(targets)[:2], three.variances(targets)[:2], strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-6)


def test_a_shared_reference_is_a_nuisance_parameter_of_its_series() -> None:
    """Rows [a_i, I] with a parameter ρ of prior information 2·I and readings of half the covariance, against what the
    assessment makes of series.
    """
    here = problem(HEXAPOD, {"experiment.deflection_noise.shared_reference": True, "experiment.load_error": []})
    measurements = drawn(here, 5)
    rows, _ = here.whitened(*here.space.decode(measurements))
    rows, k = np.sqrt(2.0) * rows * here.loaded.scale, rows.shape[1]
    series = np.array([0, 0, 0, 1, 1])
    reference = np.zeros((5, k, 2 * k))
    for row, number in enumerate(series):
        reference[row, :, number * k : (number + 1) * k] = np.eye(k)
    wide = np.concatenate([rows, reference], axis=2).reshape(5 * k, -1)
    p = rows.shape[2]
    prior = np.concatenate([np.zeros((2 * k, p)), np.eye(2 * k)], axis=1)
    targets = here.targets.observation * here.loaded.scale
    padded = np.concatenate([targets, np.zeros((*targets.shape[:2], 2 * k))], axis=2)
    none = np.zeros((p + 2 * k, 0)), np.zeros((p + 2 * k,) * 2)
    found = Information(np.concatenate([wide, prior]), *none).variances(padded)[0]
    configurations, loads = here.space.decode(measurements)
    assessment = here.assess(configurations[None], loads[None], series[None] + 1)
    np.testing.assert_allclose(found, assessment.noise_variance[0], rtol=1e-8)


def test_what_is_not_determined_is_said() -> None:
    here = problem(HEXAPOD, {"experiment.deflection_noise": {"std": {"dx_m": 1e-6}}})
    one = information_of(here, drawn(here, 1)).part(0)
    _, _, known = one.variances(here.targets.observation * here.loaded.scale)
    assert not known.all()
    assert not np.isfinite(expected_total(one, here.targets, here.loaded.scale))


def test_known_numbers_of_the_bipod() -> None:
    """The test vectors of the theory: U and Z of one measurement."""
    observation = np.array([[-371.0909090909, 547.5454545455], [-472.2975206612, -298.6611570248]])
    target = np.array([[[-480.0, 520.0], [-320.0, -520.0]]])
    inverse = np.linalg.inv(observation.T @ observation)
    noise, _ = propagated(target, inverse, np.zeros((2, 0)), np.zeros((2, 2)))
    np.testing.assert_allclose(noise[0], [1.1442042521, 1.1581359476], rtol=1e-9)


ERRORS = [
    {"source": "com", "std": [0.001, 0.001, 0.001], "shared": True},
    {"source": "wrench", "std": [0.5, 0.5, 0.5, 0.05, 0.05, 0.05], "shared": False},
]


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
    series = np.array([0, 0, 0, 1, 2, 3])
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
