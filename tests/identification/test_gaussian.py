"""The one Gaussian model: published test vectors, two derivations of every quantity, and draws."""

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.estimation.gaussian import NOISE, Gaussian, Mixture, Term

A = np.array([[1.0, 0.2], [0.4, 1.0], [1.2, -0.5], [-0.3, 0.9]])
SHARED = np.array([[0.8], [0.5], [-0.2], [0.6]])
OWN = np.array([[0.5, 0.0], [0.1, 0.0], [0.0, 0.3], [0.0, 0.7]])
T = np.array([[1.0, 1.0], [0.5, -2.0]])
C = np.array([[0.1], [0.9], [0.4], [-0.7]])
READINGS = np.array([1.3, 0.4, 0.9, 0.2])
EXACT = 1e-10

STIFFNESS = Term("stiffness", A, T)
LOADS = (
    Term("shared", SHARED, root=np.ones(1), source="load", scope="campaign"),
    Term("own", OWN, root=np.ones(2), source="load", scope="campaign"),
)
PHYSICS = Term("physics", C, np.array([[0.3], [0.2]]), root=np.array([0.6]))

BASE = Gaussian((STIFFNESS,), READINGS)
GENERALISED = Gaussian((STIFFNESS, *LOADS), READINGS)
WITH_PHYSICS = GENERALISED.beside(PHYSICS)


def covariance_of(terms: tuple[Term, ...]) -> FloatArray:
    """C = I + Σ B·S·Bᵀ of terms with a proper prior."""
    return np.eye(4) + sum((t.columns @ t.prior_root @ t.prior_root.T @ t.columns.T for t in terms), np.zeros((4, 4)))


def projector(terms: tuple[Term, ...], flat: FloatArray = A) -> FloatArray:
    """Q = C⁻¹ − C⁻¹A(AᵀC⁻¹A)⁻¹AᵀC⁻¹."""
    inverse = np.linalg.inv(covariance_of(terms))
    return inverse - inverse @ flat @ np.linalg.solve(flat.T @ inverse @ flat, flat.T @ inverse)


def test_weighted_noise_and_load_errors() -> None:
    load = sum((BASE.mean_square(term) for term in LOADS), np.zeros((2, 2)))
    assert np.diag(BASE.error) == pytest.approx([0.9558652105, 1.92697405], abs=EXACT)
    assert np.diag(load) == pytest.approx([1.0913886219, 1.5792369107], abs=EXACT)
    assert np.sqrt(np.trace(BASE.error + load)) == pytest.approx(2.356579044523, abs=1e-12)


def test_generalised_noise_and_load_errors() -> None:
    budget = GENERALISED.budget
    assert np.diag(budget[NOISE]) == pytest.approx([1.1649976588, 2.2028261782], abs=EXACT)
    assert np.diag(budget["load"]) == pytest.approx([0.5972658511, 0.9275532465], abs=EXACT)
    assert np.diag(GENERALISED.error) == pytest.approx([1.7622635099, 3.1303794247], abs=EXACT)
    assert np.sqrt(np.trace(GENERALISED.error)) == pytest.approx(2.211931946203, abs=1e-12)


def test_covariance_by_readings_and_by_nuisance_terms() -> None:
    stated = np.array([[0.4730293774, 0.214481445], [0.214481445, 0.8602712426]])
    assert GENERALISED.of("stiffness")[1] == pytest.approx(stated, abs=EXACT)
    inverse = np.linalg.inv(covariance_of(LOADS))
    assert GENERALISED.of("stiffness")[1] == pytest.approx(np.linalg.inv(A.T @ inverse @ A), abs=1e-14)
    assert GENERALISED.gain[:2] == pytest.approx(np.linalg.solve(A.T @ inverse @ A, A.T @ inverse), abs=1e-14)


def test_physics_left_out_and_as_a_term() -> None:
    left_out, term = np.diag(GENERALISED.mean_square(PHYSICS)), np.diag(WITH_PHYSICS.error)
    assert left_out == pytest.approx([0.1391819184, 0.1513383621], abs=EXACT)
    assert term == pytest.approx([1.8737097075, 3.2515595693], abs=EXACT)
    assert (term < np.diag(GENERALISED.error) + left_out).all()
    bias = GENERALISED.bias(PHYSICS, np.array([0.6]))
    assert bias**2 == pytest.approx(left_out, abs=1e-14)


def test_evidence() -> None:
    assert BASE.log_evidence == pytest.approx(-0.9675815443829, abs=1e-12)
    assert GENERALISED.log_evidence == pytest.approx(-1.2915771844663, abs=1e-12)
    assert WITH_PHYSICS.log_evidence == pytest.approx(-1.3894518130475, abs=1e-12)
    assert WITH_PHYSICS.mean_of("physics") == pytest.approx([-0.0873853702], abs=EXACT)
    assert WITH_PHYSICS.mean_of("stiffness") == pytest.approx([0.9299996222, 0.1998666917], abs=EXACT)


@pytest.mark.parametrize("model", [BASE, GENERALISED, WITH_PHYSICS])
def test_parts_of_the_budget_add_up(model: Gaussian) -> None:
    assert sum(model.budget.values(), np.zeros((2, 2))) == pytest.approx(model.error, abs=1e-14)


def test_weighted_squares_are_the_same_model_without_priors_on_the_loads() -> None:
    # A prior of no width is none at all, and one far too wide takes its columns away as a flat one does.
    exact = Gaussian((STIFFNESS, *(term.scaled(0.0) for term in LOADS)), READINGS)
    assert exact.error == pytest.approx(BASE.error, abs=1e-14)
    assert exact.mean_of("stiffness") == pytest.approx(BASE.estimate, abs=1e-14)
    wide = Gaussian((STIFFNESS, LOADS[0].scaled(1e7)), READINGS)
    flat = Gaussian((STIFFNESS, Term("shared", SHARED)), READINGS)
    assert wide.of("stiffness")[1] == pytest.approx(flat.of("stiffness")[1], rel=1e-9)


def test_residuals_left_out_match_refits() -> None:
    blocks = np.array([0, 1, 1, 2])
    by_formula, variances = WITH_PHYSICS.left_out(blocks), WITH_PHYSICS.left_out_variances(blocks)
    assert np.isnan(BASE.left_out(np.array([0, 1, 1, 1]))[1:]).all()  # one reading is left for two stiffnesses
    for block in range(3):
        inside, rest = blocks == block, blocks != block
        terms = tuple(
            Term(t.name, t.columns[rest], t.columns[inside], t.root, source=t.source) for t in WITH_PHYSICS.terms
        )
        others = Gaussian(terms, READINGS[rest])
        refitted = READINGS[inside] - others.at_targets @ others.estimate
        known = np.diag(others.error) + 1.0
        assert by_formula[inside] == pytest.approx(refitted, abs=1e-12)
        assert variances[inside] == pytest.approx(known, abs=1e-12)


def test_shares_add_up_and_may_compensate() -> None:
    twin = Term("twin", -1.3 * C + 0.05 * SHARED, root=np.array([0.5]))
    model = GENERALISED.beside(PHYSICS, twin)
    shares = model.shares(["physics", "twin"])
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-14)
    left = projector(LOADS) @ READINGS
    moved = {name: left @ model.columns[:, model.slices[name]] @ model.mean_of(name) for name in shares}
    assert shares["physics"] == pytest.approx(moved["physics"] / sum(moved.values()), abs=1e-12)


def test_prior_means_and_roots() -> None:
    root = np.array([[0.3, 0.0], [0.2, 0.4]])
    term = Term("frame", OWN, root=root, mean=np.array([0.2, -0.1]))
    model = Gaussian((STIFFNESS, term), READINGS)
    precision = np.linalg.inv(root @ root.T)
    design = np.hstack([A, OWN])
    normal = design.T @ design
    normal[2:, 2:] += precision
    right = design.T @ READINGS
    right[2:] += precision @ [0.2, -0.1]
    assert model.estimate == pytest.approx(np.linalg.solve(normal, right), abs=1e-13)
    assert model.covariance == pytest.approx(np.linalg.inv(normal), abs=1e-13)
    away = model.estimate[2:] - [0.2, -0.1]
    left = READINGS - design @ model.estimate
    assert model.chi2 == pytest.approx(left @ left + away @ precision @ away, abs=1e-13)
    assert model.determined("frame") == pytest.approx(2.0 - np.trace(precision @ model.covariance[2:, 2:]), abs=1e-13)


def test_a_targets_own_payload_stays_as_it_is_declared() -> None:
    own = Term("payload", np.zeros((4, 1)), np.array([[0.7], [0.1]]), root=np.array([0.5]), scope="target")
    with_own = GENERALISED.beside(own)
    assert with_own.budget["payload"] == pytest.approx(0.25 * np.outer([0.7, 0.1], [0.7, 0.1]), abs=1e-15)
    assert with_own.error - with_own.budget["payload"] == pytest.approx(GENERALISED.error, abs=1e-14)
    # The weights of the campaign at the target: what the readings say of them counts.
    carried = Gaussian((STIFFNESS, Term("shared", SHARED, np.array([[0.7], [0.1]]), root=np.ones(1))), READINGS)
    assert sum(carried.budget.values(), np.zeros((2, 2))) == pytest.approx(carried.error, abs=1e-14)


def test_flat_terms_that_do_alike_are_estimable_in_sum_alone() -> None:
    double = Term("stiffness", np.hstack([A, A[:, :1]]), np.array([[1.0, 1.0, 1.0], [0.5, -2.0, 0.0]]))
    model = Gaussian((double, *LOADS), READINGS)
    assert model.rank == 2
    assert model.error[0, 0] == pytest.approx(1.7622635099, abs=EXACT)
    assert np.isinf(model.error[1]).all()
    assert np.isinf(model.budget[NOISE][1, 1])
    assert list(model.estimable.determined) == [False, True, False, True, True, True]
    assert model.projected == pytest.approx(GENERALISED.projected, abs=1e-14)
    assert model.chi2 == pytest.approx(GENERALISED.chi2, abs=1e-13)
    # What the kernel costs in evidence is the same for every model with these flat terms.
    difference = Gaussian((double,), READINGS).log_evidence - model.log_evidence
    assert difference == pytest.approx(BASE.log_evidence - GENERALISED.log_evidence, abs=1e-12)


def test_ill_conditioned_terms_keep_digits_that_normal_equations_lose() -> None:
    steep = Term("steep", np.column_stack([A[:, 0], A[:, 0] + 1e-7 * A[:, 1]]))
    model = Gaussian((steep,), READINGS)
    transform = np.array([[1.0, 1.0], [0.0, 1e-7]])
    expected = np.linalg.solve(transform, BASE.estimate)
    assert model.estimate == pytest.approx(expected, rel=1e-7)


def test_draws_have_the_stated_errors() -> None:
    random, count = np.random.default_rng(5), 40_000
    truth = random.standard_normal((2, count))
    loads = random.standard_normal((3, count))
    readings = A @ truth + np.hstack([SHARED, OWN]) @ loads + random.standard_normal((4, count))
    errors = T @ (GENERALISED.gain[:2] @ readings - truth)
    squares = errors**2
    standard = squares.std(axis=1) / np.sqrt(count)
    assert (np.abs(squares.mean(axis=1) - np.diag(GENERALISED.error)) < 4.0 * standard).all()
    assert (np.abs(squares.mean(axis=1) - np.diag(BASE.error)) > 4.0 * standard).all()


def test_slope_of_the_evidence_by_a_size_is_its_squares_less_what_is_determined() -> None:
    readings = READINGS + 3.0 * C[:, 0]
    low, middle, high = (
        Gaussian((STIFFNESS, Term("physics", C, root=np.array([0.7 * np.exp(step)]))), readings)
        for step in (-1e-4, 0.0, 1e-4)
    )
    slope = float((middle.standardised("physics") ** 2).sum()) - middle.determined("physics")
    assert slope == pytest.approx((high.log_evidence - low.log_evidence) / 2e-4, rel=1e-6)


def test_unknown_noise_is_the_mean_square_that_is_left() -> None:
    assert BASE.noise_variance == pytest.approx(READINGS @ projector(()) @ READINGS / 2.0, abs=1e-14)
    twice = Gaussian((STIFFNESS,), 2.0 * READINGS)
    fall = BASE.log_evidence_of_unknown_noise - twice.log_evidence_of_unknown_noise
    assert fall == pytest.approx(BASE.freedom * np.log(2.0), abs=1e-12)


def test_mixture_of_models() -> None:
    mixture = Mixture.of([GENERALISED, WITH_PHYSICS])
    odds = np.exp(GENERALISED.log_evidence - WITH_PHYSICS.log_evidence)
    assert mixture.weights[0] / mixture.weights[1] == pytest.approx(odds, rel=1e-12)
    assert Mixture.of([GENERALISED, WITH_PHYSICS], temperature=1e9).weights == pytest.approx([0.5, 0.5], abs=1e-6)
    random, count = np.random.default_rng(3), 200_000
    which = random.random(count) < mixture.weights[0]
    draws = np.where(
        which[:, None],
        random.multivariate_normal(mixture.means[0], mixture.covariances[0], count),
        random.multivariate_normal(mixture.means[1], mixture.covariances[1], count),
    )
    limits = np.array([1.5, 2.0])
    outside = np.abs(draws - mixture.mean) > limits
    assert outside.mean(axis=0) == pytest.approx(mixture.beyond(limits), abs=4.0 * 0.5 / np.sqrt(count))
    assert np.cov(draws.T) == pytest.approx(mixture.covariance, rel=0.03)
