"""Rows that stand out, and whether they stand out alone."""

import numpy as np
import pytest
from tests.diagnosis.samples import base_fit, sample_of, simulated

from expdesign.diagnosis.outliers import isolated, row_distances
from expdesign.identification.fit import Fit

SERIES = np.repeat(np.arange(30), 6)


@pytest.mark.parametrize("name", ["irregular", "bipod-unequal"])
def test_the_distance_of_a_row_is_what_chi_squared_falls_by_without_it(name: str) -> None:
    recordings = simulated(name, seed=3)
    sample = sample_of(name, recordings)
    base = base_fit(name, sample)
    distances = row_distances(base)
    for row in range(len(recordings)):
        left = base_fit(name, sample.restricted(np.arange(len(recordings)) != row))
        assert distances[row] == pytest.approx(base.chi2 - left.chi2, rel=1e-6, abs=1e-6)


def test_a_row_that_alone_determines_a_leg_has_no_finite_evidence_against_it() -> None:
    """Full leverage: the residual is zero, and so is the distance."""
    sensitivities = np.zeros((3, 2, 1))
    sensitivities[0, 0, 0] = 1.0
    residuals = np.array([[0.0, 0.3], [1.0, 1.0], [0.5, 0.5]])
    result = Fit(
        None,
        np.zeros(1),
        np.eye(1),
        np.ones(1, bool),
        residuals,
        sensitivities,
        0.0,
        5,
        1,  # type: ignore[arg-type]
    )
    np.testing.assert_allclose(row_distances(result), [0.09, 2.0, 0.5], rtol=1e-6)


def mistakes(seed: int, rows: int = 6) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    """Residuals of noise, and rows with large errors in random directions at random places."""
    generator = np.random.default_rng(seed)
    residuals = generator.standard_normal((len(SERIES), 6))
    chosen = generator.permutation(len(SERIES))[:rows]
    residuals[chosen] += 20.0 * generator.standard_normal((rows, 6))
    outliers = np.zeros(len(SERIES), dtype=bool)
    outliers[chosen] = True
    return residuals, outliers


def test_random_mistakes_stand_alone() -> None:
    """Two tests at the level of 0.005 each: of 40 sets no more than 3 (mean 0.4, standard deviation 0.6)."""
    accepted = [isolated(*mistakes(seed), SERIES) for seed in range(40)]
    assert sum(accepted) >= 37


def test_mistakes_of_one_direction_do_not() -> None:
    residuals, outliers = mistakes(0)
    residuals[outliers] = np.array([1.0, 2.0, -1.0, 0.5, 0.0, 1.0]) + 0.2 * residuals[outliers] / 20.0
    assert not isolated(residuals, outliers, SERIES)


def test_mistakes_of_one_series_do_not() -> None:
    residuals, _ = mistakes(0)
    outliers = (SERIES == 7) & (np.arange(len(SERIES)) % 6 < 4)
    residuals[outliers] *= 20.0
    assert isolated(residuals, mistakes(0)[1], SERIES)
    assert not isolated(residuals, outliers, SERIES)


@pytest.mark.parametrize("rows", [0, 1, 2])
def test_one_or_two_rows_say_nothing_of_each_other(rows: int) -> None:
    residuals, outliers = mistakes(1, rows)
    residuals[outliers] = 10.0
    assert isolated(residuals, outliers, SERIES)
