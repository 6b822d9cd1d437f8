"""Residuals that are alike say less than their number; intervals and probabilities allow for it."""

import numpy as np
import pytest

from expdesign.diagnosis.dispersion import dispersion
from expdesign.estimation.fit import Data
from tests.chain.bodies import BODY, recordings
from tests.fitting import data_of


def sample(count: int) -> Data:
    points = recordings(count=count, axes=(3, 4))
    return data_of(points, BODY).counting(np.ones(count, dtype=bool))


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8])
def test_effective_rows_are_those_that_give_the_mean_its_variance(correlation: float) -> None:
    """Oracle: the variance of the mean of a first-order autoregression, over 4000 draws (standard error 2 %)."""
    count, draws = 400, 4000
    generator = np.random.default_rng(0)
    own = generator.standard_normal((draws, count, 2)) * np.sqrt(1.0 - correlation**2)
    series = np.empty_like(own)
    series[:, 0] = generator.standard_normal((draws, 2))
    for row in range(1, count):
        series[:, row] = correlation * series[:, row - 1] + own[:, row]
    independent = 1.0 / series.mean(axis=1).var()
    found = dispersion(series[0], sample(count))
    assert found.mean_square == pytest.approx(1.0, abs=0.25)
    assert found.correlation == pytest.approx(correlation, abs=0.12)
    exact = count * (1.0 - correlation) / (1.0 + correlation)
    assert independent == pytest.approx(exact, rel=0.1)


def test_rows_that_do_not_count_and_ends_of_series_join_nothing() -> None:
    chosen = sample(60)
    counts = np.arange(60) % 2 == 0
    alternating = np.ones((60, 2)) * counts[:, None]
    assert dispersion(alternating, chosen.restricted(counts)).correlation == 0.0
