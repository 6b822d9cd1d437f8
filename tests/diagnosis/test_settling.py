"""Motion of the machine between series is noise that a series shares: as cheap as one series, and there where it is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.row import row_data
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.settling import Settling, settling
from expdesign.estimation.fit import Data, Fit, fit
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.serial import SerialRobot
from tests.chain.arms import DEVIATION, READING, configurations, read_arm, recordings_of
from tests.oracle import Array

_ROWS = 60


def _case(tmp_path: Path, series: Array, moved: float = 0.0) -> tuple[Data, Fit]:
    """Positions by an arm as modelled whose base shifts by `moved` (m) from series to series, and the base fit."""
    here: SerialRobot = read_arm(tmp_path)
    generator = np.random.default_rng(2)
    blank = replace(recordings_of(here, configurations(_ROWS, 1), np.zeros((_ROWS, 3))), series=series)
    exact = Chain(here, reading=READING).predict(row_data(blank, here), Chain(here, reading=READING).start())
    exact = exact + generator.normal(0.0, DEVIATION, exact.shape)
    shifts = moved * generator.standard_normal((int(series.max()) + 1, 3))
    recordings = replace(blank, deflections=exact + shifts[series])
    whitening = Whitening(np.full((_ROWS, 3), DEVIATION))
    reading = reading_of(here, recordings)
    chain = Chain(here, reading=reading)
    data = Data(recordings, row_data(recordings, here), whitening, reading=reading)
    sample = data.counting(np.ones(_ROWS, dtype=bool))
    return sample, fit(chain, sample)


def _present(base: Fit) -> Present:
    slopes = base.sensitivities.reshape(-1, len(base.values))
    precision = 1e-12 * np.maximum((slopes**2).sum(axis=0), 1.0)
    return Present(slopes, precision, base.residuals.ravel(), known_noise=False)


def _settled(sample: Data, base: Fit) -> Settling:
    return settling(base.chain, sample, _present(base)).most_evident(_present(base))


def test_series_at_one_pose_have_none(tmp_path: Path) -> None:
    """One series per pose, or per row with joints as they were logged, costs what one series for all does."""
    sample, base = _case(tmp_path, np.arange(_ROWS))
    assert _settled(sample, base) == Settling()
    logged = sample.recordings.configurations.copy()
    logged[1::2] = logged[::2] + 1e-6
    pairs = np.arange(_ROWS) // 2
    recordings = replace(sample.recordings, configurations=logged, series=pairs)
    rows = replace(sample.rows, series=pairs)
    assert not settling(base.chain, replace(sample, recordings=recordings, rows=rows), _present(base)).groups


@pytest.mark.parametrize(("moved", "there"), [(0.0, False), (10.0 * DEVIATION, True)])
def test_evidence_says_whether_the_machine_moved(moved: float, there: bool, tmp_path: Path) -> None:
    found = _settled(*_case(tmp_path, np.arange(_ROWS) // 6, moved))
    assert len(found.groups) == 10
    assert (found.ratio > 1e-3) == there


def test_whitening_is_the_inverse_root_of_the_covariance(tmp_path: Path) -> None:
    sample, base = _case(tmp_path, np.arange(_ROWS) // 6, 10.0 * DEVIATION)
    found = _settled(sample, base)
    covariance = np.eye(3 * _ROWS)
    for rows, turned, squares in zip(found.groups, found.turned, found.squares, strict=True):
        covariance[np.ix_(rows, rows)] += found.ratio * (turned * squares) @ turned.T
    root = found.whitened(np.eye(3 * _ROWS))
    np.testing.assert_allclose(root @ covariance @ root.T, np.eye(3 * _ROWS), atol=1e-9)
    readings = base.residuals.ravel()
    np.testing.assert_allclose(found.unwhitened(found.whitened(readings)), readings, rtol=1e-9, atol=1e-9)


def test_a_sample_with_this_noise_is_whitened_as_its_readings_are(tmp_path: Path) -> None:
    """Rows that do not count stay at zero, and residuals and derivatives are taken through the same root."""
    sample, base = _case(tmp_path, np.arange(_ROWS) // 6, 10.0 * DEVIATION)
    found = replace(_settled(sample, base), ratio=0.5)
    plain, slopes = sample.residuals_with_sensitivities(base.chain, base.values)
    whitened, turned = replace(sample, shared=found).residuals_with_sensitivities(base.chain, base.values)
    np.testing.assert_allclose(whitened.ravel(), found.whitened(plain.ravel()))
    np.testing.assert_allclose(
        turned.reshape(-1, turned.shape[-1]), found.whitened(slopes.reshape(-1, len(base.values)))
    )
    np.testing.assert_allclose(replace(sample, shared=found).residuals(base.chain, base.values), whitened)
