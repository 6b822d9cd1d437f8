"""Rows that do not count: no weight in a fit, and still part of the history of their series."""

import numpy as np
import pytest

from expdesign.arrays import rms
from expdesign.chain.chain import Chain
from expdesign.estimation.fit import fit
from tests.cases import robot
from tests.diagnosis.samples import base_fit, effect, sample_of, simulated

COUNTS = np.random.default_rng(0).random(24) < 0.7


@pytest.mark.parametrize("name", ["irregular", "bipod-unequal"])
def test_rows_that_do_not_count_might_as_well_not_be_there(name: str) -> None:
    recordings = simulated(name)
    masked = base_fit(name, sample_of(name, recordings, COUNTS))
    shorter = base_fit(name, sample_of(name, recordings.rows(COUNTS)))
    np.testing.assert_allclose(masked.values, shorter.values, rtol=1e-12)
    np.testing.assert_allclose(masked.covariance, shorter.covariance, rtol=1e-9)
    assert masked.chi2 == pytest.approx(shorter.chi2, rel=1e-12)
    np.testing.assert_array_equal(masked.residuals[~COUNTS], 0.0)


def test_readings_and_restrictions() -> None:
    sample = sample_of("irregular", simulated("irregular"), COUNTS)
    assert sample.readings == 6 * int(COUNTS.sum())
    other = np.arange(24) % 2 == 0
    np.testing.assert_array_equal(sample.restricted(other).counts, COUNTS & other)
    whitened = sample.whiten(np.ones((24, 6, 3)))
    np.testing.assert_array_equal(whitened[~COUNTS], 0.0)
    expected = 1.0 / np.array(sample.recordings.deviations)[COUNTS]
    np.testing.assert_allclose(whitened[COUNTS], np.repeat(expected[..., None], 3, axis=2))


def test_a_row_set_aside_stays_in_the_history_of_its_series() -> None:
    """Friction: what a row reads depends on the load of the row before, whether or not that one counts."""
    friction = effect("irregular", "friction_hysteresis", "all legs", "rigid")
    recordings = simulated("irregular", friction, parameters=[30.0], noise=0.0)
    chain = Chain(robot("irregular"), (friction,))
    counts = np.arange(24) % 4 != 1
    sample = sample_of("irregular", recordings, counts)
    truth = np.append(np.ones(6), 30.0)
    assert np.abs(sample.residuals(chain, truth)).max() < 1e-6
    without = sample_of("irregular", recordings.rows(counts))
    assert np.abs(without.residuals(chain, truth)).max() > 1.0
    found = fit(chain, sample, np.append(np.ones(6), 10.0))
    assert found.values[-1] == pytest.approx(30.0, rel=1e-6)


def test_rms_is_over_the_rows_that_count() -> None:
    residuals = np.array([[3.0, 4.0], [100.0, 100.0]])
    assert rms(residuals, np.array([True, False])) == pytest.approx(np.sqrt(12.5))
    assert np.isnan(rms(residuals, np.array([False, False])))
