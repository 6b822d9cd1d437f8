"""The one Gaussian model: published test vectors, two derivations of every quantity, and draws."""

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.estimation.gaussian import Gaussian

A = np.array([[1.0, 0.2], [0.4, 1.0], [1.2, -0.5], [-0.3, 0.9]])
LOADS = np.array([[0.8, 0.5, 0.0], [0.5, 0.1, 0.0], [-0.2, 0.0, 0.3], [0.6, 0.0, 0.7]])
"""Per standard deviation: one that the readings share, and two of single rows."""
T = np.array([[1.0, 1.0], [0.5, -2.0]])
C, AT = np.array([[0.1], [0.9], [0.4], [-0.7]]), np.array([[0.3], [0.2]])
"""Physics, of size 0.6."""
READINGS = np.array([1.3, 0.4, 0.9, 0.2])
EXACT = 1e-10


def model(
    *further: tuple[FloatArray, FloatArray, float], base: FloatArray = A, readings: FloatArray = READINGS
) -> Gaussian:
    """Two stiffnesses of which nothing is known, and further parameters: columns, those at the targets, deviations."""
    columns = np.hstack([base, *(each for each, _, _ in further)])
    deviations = np.concatenate([np.full(2, np.inf), *(np.full(each.shape[1], size) for each, _, size in further)])
    targets = np.hstack([T, *(at for _, at, _ in further)])
    return Gaussian(columns, readings, deviations, at_targets=targets)


def error(of: Gaussian) -> FloatArray:
    """T·P·Tᵀ."""
    through = of.at_targets @ of.root
    return np.asarray(through @ through.T)


NOWHERE = np.zeros((2, 3))
PHYSICS = (C, AT, 0.6)
BASE = model()
GENERALISED = model((LOADS, NOWHERE, 1.0))
WITH_PHYSICS = model((LOADS, NOWHERE, 1.0), PHYSICS)
COVARIANCE = np.eye(4) + LOADS @ LOADS.T


def parts(of: Gaussian) -> tuple[FloatArray, FloatArray]:
    """What noise and parameters with a prior do at the targets (Joseph's form): T·K·Kᵀ·Tᵀ and (T·K·B − T)·S·(…)ᵀ."""
    through = of.at_targets @ of.gain
    own = of.unexplained(of.columns[:, of.proper], of.at_targets[:, of.proper]) * of.deviation[of.proper]
    return np.asarray(through @ through.T), np.asarray(own @ own.T)


def test_weighted_noise_and_load_errors() -> None:
    load = BASE.unexplained(LOADS, NOWHERE)
    assert np.diag(error(BASE)) == pytest.approx([0.9558652105, 1.92697405], abs=EXACT)
    assert (load**2).sum(axis=1) == pytest.approx([1.0913886219, 1.5792369107], abs=EXACT)
    assert np.sqrt(np.trace(error(BASE)) + (load**2).sum()) == pytest.approx(2.356579044523, abs=1e-12)


def test_generalised_noise_and_load_errors() -> None:
    noise, load = parts(GENERALISED)
    assert np.diag(noise) == pytest.approx([1.1649976588, 2.2028261782], abs=EXACT)
    assert np.diag(load) == pytest.approx([0.5972658511, 0.9275532465], abs=EXACT)
    assert np.diag(error(GENERALISED)) == pytest.approx([1.7622635099, 3.1303794247], abs=EXACT)
    assert np.sqrt(np.trace(error(GENERALISED))) == pytest.approx(2.211931946203, abs=1e-12)


def test_covariance_by_readings_and_by_nuisance_parameters() -> None:
    stated = np.array([[0.4730293774, 0.214481445], [0.214481445, 0.8602712426]])
    found, inverse = GENERALISED.estimable.generalised[:2, :2], np.linalg.inv(COVARIANCE)
    assert found == pytest.approx(stated, abs=EXACT)
    assert found == pytest.approx(np.linalg.inv(A.T @ inverse @ A), abs=1e-14)
    assert GENERALISED.gain[:2] == pytest.approx(np.linalg.solve(A.T @ inverse @ A, A.T @ inverse), abs=1e-14)


def test_physics_left_out_and_in_the_model() -> None:
    left_out, within = 0.6 * GENERALISED.unexplained(C, AT)[:, 0], np.diag(error(WITH_PHYSICS))
    assert left_out**2 == pytest.approx([0.1391819184, 0.1513383621], abs=EXACT)
    assert within == pytest.approx([1.8737097075, 3.2515595693], abs=EXACT)
    assert (within < np.diag(error(GENERALISED)) + left_out**2).all()


def test_evidence() -> None:
    assert BASE.log_evidence == pytest.approx(-0.9675815443829, abs=1e-12)
    assert GENERALISED.log_evidence == pytest.approx(-1.2915771844663, abs=1e-12)
    assert WITH_PHYSICS.log_evidence == pytest.approx(-1.3894518130475, abs=1e-12)
    assert WITH_PHYSICS.estimate[-1] == pytest.approx(-0.0873853702, abs=EXACT)
    assert WITH_PHYSICS.estimate[:2] == pytest.approx([0.9299996222, 0.1998666917], abs=EXACT)


def test_parameters_that_join_say_what_the_larger_model_says() -> None:
    rise, mean, root = GENERALISED.joined(C, AT, 0.6)
    assert rise == pytest.approx(WITH_PHYSICS.log_evidence - GENERALISED.log_evidence, abs=1e-13)
    moved = WITH_PHYSICS.at_targets @ WITH_PHYSICS.estimate - GENERALISED.at_targets @ GENERALISED.estimate
    assert mean == pytest.approx(moved, abs=1e-13)
    assert root @ root.T == pytest.approx(error(WITH_PHYSICS) - error(GENERALISED), abs=1e-13)


@pytest.mark.parametrize("of", [BASE, GENERALISED, WITH_PHYSICS, model((LOADS[:, :1], np.array([[0.7], [0.1]]), 1.0))])
def test_parts_of_the_error_add_up(of: Gaussian) -> None:
    assert sum(parts(of)) == pytest.approx(error(of), abs=1e-14)


def test_weighted_squares_are_the_same_model_without_priors_on_the_loads() -> None:
    # A prior of no width is none at all, and one far too wide takes its columns away as a flat one does.
    exact = model((LOADS, NOWHERE, 0.0))
    assert error(exact) == pytest.approx(error(BASE), abs=1e-14)
    assert exact.estimate[:2] == pytest.approx(BASE.estimate, abs=1e-14)
    wide, flat = (model((LOADS[:, :1], NOWHERE[:, :1], size)).estimable.generalised for size in (1e7, np.inf))
    assert wide[:2, :2] == pytest.approx(flat[:2, :2], rel=1e-9)


def test_residuals_left_out_match_refits() -> None:
    blocks = np.array([0, 1, 1, 2])
    by_formula = WITH_PHYSICS.left_out(blocks)
    assert np.isnan(BASE.left_out(np.array([0, 1, 1, 1]))[1:]).all()  # one reading is left for two stiffnesses
    for block in range(3):
        inside, rest = blocks == block, blocks != block
        others = Gaussian(WITH_PHYSICS.columns[rest], READINGS[rest], WITH_PHYSICS.deviation)
        refitted = READINGS[inside] - WITH_PHYSICS.columns[inside] @ others.estimate
        assert by_formula[inside] == pytest.approx(refitted, abs=1e-12)


def test_prior_means() -> None:
    own, size, mean = LOADS[:, 1:], np.array([0.3, 0.4]), np.array([0.2, -0.1])
    columns, deviation = np.hstack([own, A]), np.append(size, np.full(2, np.inf))
    found = Gaussian(columns, READINGS, deviation, np.append(mean, np.zeros(2)))
    normal, right = columns.T @ columns, columns.T @ READINGS
    normal[:2, :2] += np.diag(size**-2.0)
    right[:2] += mean / size**2
    assert found.estimate == pytest.approx(np.linalg.solve(normal, right), abs=1e-13)
    assert found.estimable.covariance == pytest.approx(np.linalg.inv(normal), abs=1e-13)
    away, left = (found.estimate[:2] - mean) / size, READINGS - columns @ found.estimate
    assert found.chi2 == pytest.approx(left @ left + away @ away, abs=1e-13)
    assert found.standardised == pytest.approx(away, abs=1e-13)
    assert found.determined == pytest.approx(1.0 - np.linalg.inv(normal).diagonal()[:2] / size**2, abs=1e-13)


def test_what_flat_parameters_do_alike_is_not_determined() -> None:
    combined = A @ np.array([[1.0], [0.5]])
    double = Gaussian(np.hstack([A, combined, LOADS]), READINGS, np.append(np.full(3, np.inf), np.ones(3)))
    assert double.rank == 2
    assert list(double.estimable.determined) == [False, False, False, True, True, True]
    assert double.projected == pytest.approx(GENERALISED.projected, abs=1e-14)
    assert double.chi2 == pytest.approx(GENERALISED.chi2, abs=1e-13)
    # Evidence is comparable between models with these flat parameters.
    without = Gaussian(np.hstack([A, combined]), READINGS, np.full(3, np.inf))
    difference = without.log_evidence - double.log_evidence
    assert difference == pytest.approx(BASE.log_evidence - GENERALISED.log_evidence, abs=1e-12)


def test_ill_conditioned_columns_keep_digits_that_normal_equations_lose() -> None:
    steep = model(base=np.column_stack([A[:, 0], A[:, 0] + 1e-7 * A[:, 1]]))
    expected = np.linalg.solve(np.array([[1.0, 1.0], [0.0, 1e-7]]), BASE.estimate)
    assert steep.estimate == pytest.approx(expected, rel=1e-7)


def test_draws_have_the_stated_errors() -> None:
    random, count = np.random.default_rng(5), 40_000
    truth = random.standard_normal((2, count))
    readings = A @ truth + LOADS @ random.standard_normal((3, count)) + random.standard_normal((4, count))
    squares = (T @ (GENERALISED.gain[:2] @ readings - truth)) ** 2
    standard = squares.std(axis=1) / np.sqrt(count)
    assert (np.abs(squares.mean(axis=1) - np.diag(error(GENERALISED))) < 4.0 * standard).all()
    assert (np.abs(squares.mean(axis=1) - np.diag(error(BASE))) > 4.0 * standard).all()


def test_slope_of_the_evidence_by_a_size_is_its_squares_less_what_is_determined() -> None:
    readings = READINGS + 3.0 * C[:, 0]
    low, middle, high = (model((C, AT, 0.7 * np.exp(step)), readings=readings) for step in (-1e-4, 0.0, 1e-4))
    slope = float((middle.standardised**2 - middle.determined).sum())
    assert slope == pytest.approx((high.log_evidence - low.log_evidence) / 2e-4, rel=1e-6)
