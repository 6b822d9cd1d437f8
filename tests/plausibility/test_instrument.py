"""Places that jump between rows, and a scale of the instrument, as the fit of an arm's positions shows them."""

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.instrument import change_points, instrument_findings
from tests.identification.test_stations import seated_anew
from tests.plant import PLAIN, READ, ROBOT, STATED, recordings


@pytest.fixture(scope="module")
def standing() -> pd.DataFrame:
    """Sixty poses at two markers, without stated noise."""
    return recordings(PLAIN, 120, 7, held_out=0.0, markers=2, loads=False).drop(columns=STATED)


def found(frame: pd.DataFrame) -> list[Implausibility]:
    result = xd.identify(ROBOT, frame).result
    assert result.arm is not None
    return instrument_findings(result.arm, result.recordings)


def plus(frame: pd.DataFrame, shifts: np.ndarray) -> pd.DataFrame:
    return frame.assign(**{name: frame[name] + shifts[:, i] for i, name in enumerate(READ)})


def test_what_stands_still_and_has_its_scale_is_not_asked_about(standing: pd.DataFrame) -> None:
    assert found(standing) == []


def test_a_marker_that_was_seated_anew_is_named_with_the_column_to_add(standing: pd.DataFrame) -> None:
    frame = seated_anew(standing, 60).drop(columns="session")
    (finding,) = found(frame)
    row = int(frame.index[(np.arange(len(frame)) >= 60) & (frame["marker"] == "two")][0]) + 2
    assert "marker `two` jumps in the axes of the tip" in finding.what
    assert f"before row {row}" in finding.what
    assert "Add a column `session`" in finding.likely
    assert found(seated_anew(standing, 60)) == []


def test_an_instrument_that_was_pushed_is_named_with_the_column_to_add(standing: pd.DataFrame) -> None:
    late = (np.arange(len(standing)) >= 50)[:, None]
    (finding,) = found(plus(standing, late * np.array([1e-3, -5e-4, 8e-4])))
    assert "in the axes of the instrument" in finding.what
    assert "before row 52" in finding.what
    assert "Add a column `station`" in finding.likely


def test_a_drift_is_no_jump(standing: pd.DataFrame) -> None:
    assert found(plus(standing, np.linspace(0.0, 1.0, len(standing))[:, None] * np.array([1e-3, 0.0, -5e-4]))) == []


def test_four_seats_are_three_changes_and_noise_is_none() -> None:
    """By 7, 5, 1 and 0 mm, as a reflector in its nest; of 2,000 series of noise none has a change."""
    generator = np.random.default_rng(1)
    seats = np.repeat([7e-3, 5e-3, 1e-3, 0.0], [12, 9, 20, 60])[:, None] * np.array([0.6, 0.0, 0.8])
    assert change_points(seats + 3e-4 * generator.standard_normal(seats.shape)) == [12, 21, 41]
    assert all(change_points(generator.standard_normal((60, 3))) == [] for _ in range(2000))


@pytest.mark.parametrize("scale", [1.008, 0.992])
def test_a_scale_of_the_instrument_is_named_and_lengths_are_not_blamed(scale: float, standing: pd.DataFrame) -> None:
    (finding,) = found(standing.assign(**{name: scale * standing[name] for name in READ}))
    factor = float(finding.likely.split("Multiply positions by ")[1].split()[0].rstrip("."))
    assert factor * scale == pytest.approx(1.0, abs=6e-4)
    assert "e^" in finding.what
