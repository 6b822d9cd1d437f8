"""What follows the temperature slowly, and what stops short of where it is sent, by the way it came."""

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.arrays import FloatArray
from expdesign.chain.row import LAGS, row_data, row_symbols
from expdesign.diagnosis.result import Diagnosis
from tests.chain.laboratory import FOLDER, measured
from tests.plant import JOINTS, PLACES, PLAIN, READ, ROBOT, Arm, recordings


def slow(temperature: FloatArray, time: FloatArray, constant: float) -> FloatArray:
    """A temperature that follows with a time constant (s), in steps of a second."""
    every = np.arange(time[0], time[-1] + 1.0)
    recorded_then = np.interp(every, time, temperature)
    found = recorded_then.copy()
    for second in range(1, len(every)):
        found[second] += (1.0 - 1.0 / constant) * (found[second - 1] - recorded_then[second])
    return np.interp(time, every, found)


def approached(frame: pd.DataFrame, band: float) -> pd.DataFrame:
    """Positions with joint 3 short of its command by half of a band (rad), by the way it came."""
    arm, moved = Arm(PLAIN), frame.copy()
    commands = frame[JOINTS].to_numpy()
    came = pd.Series(np.sign(np.diff(commands[:, 2], prepend=commands[0, 2]))).replace(0.0, np.nan).ffill().fillna(0.0)
    for row, (command, marker) in enumerate(zip(commands, frame["marker"], strict=True)):
        short = command - 0.5 * band * came[row] * (np.arange(6) == 2)
        change = arm.position(short, PLACES[marker]) - arm.position(command, PLACES[marker])
        moved.loc[row, READ] = frame.loc[row, READ].to_numpy(dtype=float) + change
    return moved


@pytest.mark.slow
def test_a_joint_that_stops_short_by_the_way_it_came_is_found_and_predicted() -> None:
    """A row alone, of which nobody knows how it was reached, is predicted less surely than among those before it."""
    frame = approached(recordings(PLAIN, 240, 5, loads=False), 6e-4)
    found = xd.diagnose(ROBOT, frame)
    result: Diagnosis = found.result
    assert {finding.component for finding in result.findings} == {"joint 3"}
    assert "last move of joint 3" in result.findings[0].sentence
    assert result.errors.test_after < 1.15
    assert result.errors.test_before > 2.0
    among, alone = (xd.predict(found, rows).frame for rows in (frame, frame[99:100]))
    assert alone["spx_m"].iloc[0] > 2.0 * among["spx_m"].iloc[99]


@pytest.mark.slow
def test_an_instrument_that_follows_the_temperature_slowly_is_found_and_predicted() -> None:
    frame = measured("hexapod-h1", noise=True)
    frame["time_s"] *= 10.0
    time = frame["time_s"].to_numpy()
    room = 20.0 + 3.0 * np.sin(time / 4000.0)
    late = slow(room, time, 1500.0)
    first = frame.groupby("series")["time_s"].transform("idxmin").to_numpy()
    frame = frame.assign(temperature_degC=room, dx_m=frame["dx_m"] + 5e-6 * (late - late[first]))
    frame["split"] = np.where(frame["series"] % 5 == 0, "test", "train")
    result: Diagnosis = xd.diagnose(FOLDER / "hexapod-h1.yaml", frame).result
    assert {finding.component for finding in result.findings} == {"environment"}
    assert "followed with a time constant" in result.findings[0].sentence
    assert result.errors.test_after < 1.2
    assert result.errors.test_before > 2.0


def test_rows_follow_the_temperature_and_remember_the_last_move() -> None:
    """First-order lags are those of steps of a second; where a row is missing nobody knows what moved."""
    frame = recordings(PLAIN, 60, 5, markers=1).assign(time_s=lambda rows: 400.0 * rows["sequence"])
    frame["temperature_degC"] = 20.0 + 2.0 * np.sin(frame["time_s"] / 3000.0)
    robot = xd.load_robot(ROBOT).robot
    points = xd.read_recordings(frame.drop(index=30), ROBOT)
    rows, symbols = row_data(points, robot), row_symbols(robot, 1)
    for constant, found in zip(LAGS, rows.values[:30, symbols.columns("lagged")].T, strict=True):
        wanted = slow(frame["temperature_degC"].to_numpy()[:30], frame["time_s"].to_numpy()[:30], constant)
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=5e-3)
    came = rows.values[:, symbols.columns("approach")]
    commands = frame.drop(index=30)[JOINTS].to_numpy()
    wanted = np.sign(np.diff(commands, axis=0, prepend=commands[:1]))
    wanted[30] = 0.0
    np.testing.assert_array_equal(came, wanted)
    np.testing.assert_array_equal(np.flatnonzero(rows.values[:, symbols.columns("unseen")]), [30])
