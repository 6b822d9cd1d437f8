"""The least-squares core: against closed forms, where normal equations fail, and with parameters nobody can know."""

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.estimation.fit import fit, linear_fit
from tests.cases import robot
from tests.fitting import data_of
from tests.identification.experiments import experiment


def two_parameters(matrix: np.ndarray, readings: np.ndarray, **options: object):  # type: ignore[no-untyped-def]
    """A bipod's two compliances fitted to an arbitrary matrix of sensitivities."""
    chain = Chain(robot("bipod"))
    return linear_fit(chain, np.zeros(2), readings[:, None], matrix[:, None, :], **options)  # type: ignore[arg-type]


def test_a_nearly_dependent_problem_keeps_the_digits_that_normal_equations_lose() -> None:
    small = 2.0**-26
    matrix = np.array([[1.0, 1.0], [small, 0.0], [0.0, small]])
    truth = np.array([1.0, -2.0])
    assert np.linalg.matrix_rank(matrix.T @ matrix) == 1
    found = two_parameters(matrix, matrix @ truth)
    np.testing.assert_allclose(found.values, truth, atol=1e-6)
    assert found.rank == 2


def test_estimate_and_covariance_are_those_of_the_closed_form() -> None:
    generator = np.random.default_rng(3)
    matrix, readings = generator.standard_normal((9, 2)), generator.standard_normal(9)
    found = two_parameters(matrix, readings)
    information = matrix.T @ matrix
    np.testing.assert_allclose(found.values, np.linalg.solve(information, matrix.T @ readings), rtol=1e-12)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(information), rtol=1e-12)
    np.testing.assert_allclose(found.chi2, ((readings - matrix @ found.values) ** 2).sum(), rtol=1e-12)
    assert found.dof == 7


def test_a_prior_is_worth_as_much_as_a_reading_of_the_parameter() -> None:
    generator = np.random.default_rng(4)
    matrix, readings = generator.standard_normal((5, 2)), generator.standard_normal(5)
    mean, deviation = np.array([1.0, 2.0]), np.array([0.5, 0.1])
    with_prior = two_parameters(matrix, readings, prior=(mean, deviation))
    with_readings = two_parameters(
        np.vstack([matrix, np.diag(1.0 / deviation)]), np.concatenate([readings, mean / deviation])
    )
    np.testing.assert_allclose(with_prior.values, with_readings.values, rtol=1e-12)
    np.testing.assert_allclose(with_prior.covariance, with_readings.covariance, rtol=1e-12)
    np.testing.assert_allclose(with_prior.chi2, with_readings.chi2, rtol=1e-12)
    assert with_prior.dof == with_readings.dof


@pytest.mark.parametrize("rows", [1, 2, 7])
def test_what_the_data_do_not_determine_is_infinitely_uncertain(rows: int) -> None:
    matrix = np.zeros((rows, 2))
    matrix[:, 0] = np.arange(1, rows + 1)
    found = two_parameters(matrix, matrix @ [3.0, 0.0])
    assert found.rank == 1
    np.testing.assert_array_equal(found.determined, [True, False])
    assert np.isinf(found.covariance[1]).all()
    np.testing.assert_allclose(found.values[0], 3.0)
    np.testing.assert_allclose(found.covariance[0, 0], 1.0 / (matrix[:, 0] ** 2).sum())


def test_two_parameters_that_only_appear_together_are_both_undetermined() -> None:
    matrix = np.array([[1.0, 2.0], [2.0, 4.0], [-1.0, -2.0]])
    found = two_parameters(matrix, matrix @ [1.0, 1.0])
    assert found.rank == 1
    assert not found.determined.any()
    np.testing.assert_allclose(matrix @ found.values, matrix @ [1.0, 1.0])


@pytest.mark.parametrize("name", ["bipod", "H1", "moving-xyz"])
def test_the_chain_without_effects_is_the_base_model(name: str) -> None:
    made = experiment(name, 8)
    recordings = made.recordings(made.noisy(np.random.default_rng(2)))
    data = data_of(recordings, made.robot)
    found = fit(Chain(made.robot), data)
    direct = linear_fit(
        Chain(made.robot),
        np.zeros(len(made.compliance)),
        data.whitening.apply(recordings.deflections),
        data.whitening.apply(made.observation * made.robot.compliance),
    )
    np.testing.assert_allclose(found.values, direct.values, rtol=1e-9)
    np.testing.assert_allclose(found.covariance, direct.covariance, rtol=1e-9)
    np.testing.assert_allclose(found.chi2, direct.chi2, rtol=1e-9)
