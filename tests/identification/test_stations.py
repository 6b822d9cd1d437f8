"""An instrument that is moved, and a marker that is seated anew, between rows of one file."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import expdesign as xd
from expdesign.errors import InputError
from tests.plant import JOINTS, NOISE, PLACES, PLAIN, READ, ROBOT, Arm, recordings


@pytest.fixture(scope="module")
def standing() -> pd.DataFrame:
    """Eighty poses at three markers; the instrument stands still, and every fourth pose is held out."""
    frame = recordings(PLAIN, 240, 7, loads=False)
    return frame.assign(split=np.where(np.arange(len(frame)) // 3 % 4 == 3, "test", "train"))


def moved(frame: pd.DataFrame, first: int) -> pd.DataFrame:
    """From a row on the instrument stands elsewhere; a column says so."""
    turned = frame[READ].to_numpy() @ Rotation.from_euler("xyz", [0.1, -0.2, 1.4]).as_matrix() + [1.2, -0.4, 0.3]
    late = (np.arange(len(frame)) >= first)[:, None]
    there = pd.DataFrame(np.where(late, turned, frame[READ]), columns=READ, index=frame.index)
    return frame.assign(**there, station=np.where(late[:, 0], "window", "door"))


def held_out(frame: pd.DataFrame) -> float:
    return xd.identify(ROBOT, frame).result.arm.accuracy["held out", "position"].after.rms


def test_every_station_has_a_pose_of_the_instrument(standing: pd.DataFrame, tmp_path: Path) -> None:
    frame = moved(standing, 130)
    found = xd.identify(ROBOT, frame)
    assert found.result.arm.accuracy["held out", "position"].after.rms < 1.25 * NOISE * np.sqrt(3.0)
    names = [parameter.name for parameter in found.model.chain.reading.parameters]
    assert "instrument door x_m" in names
    assert "instrument window rz_rad" in names
    assert "identified_instrument_window" in str(found.urdf)
    found.save(tmp_path / "out")
    predicted = xd.predict(tmp_path / "out/model.yaml", frame.drop(columns=READ)).frame
    error = (predicted[READ] - frame[READ]).to_numpy()
    assert np.sqrt((error**2).mean()) < 1.2 * NOISE


def test_one_pose_of_the_instrument_does_not_serve_two_stations(standing: pd.DataFrame) -> None:
    assert held_out(moved(standing, 130).drop(columns="station")) > 100.0 * NOISE


def seated_anew(frame: pd.DataFrame, first: int) -> pd.DataFrame:
    """From a row on marker `two` sits 4 mm from where it sat; a column says so."""
    arm, joints = Arm(PLAIN), frame[JOINTS].to_numpy()
    late, read = np.arange(len(frame)) >= first, frame[READ].to_numpy().copy()
    for row in np.flatnonzero(late & (frame["marker"] == "two").to_numpy()):
        there = arm.position(joints[row], PLACES["two"] + [3e-3, -2e-3, 2e-3])
        read[row] += there - arm.position(joints[row], PLACES["two"])
    return frame.assign(**{name: read[:, i] for i, name in enumerate(READ)}, session=np.where(late, 2, 1))


def test_every_session_has_places_of_the_markers(standing: pd.DataFrame) -> None:
    frame = seated_anew(standing, 100)
    found = xd.identify(ROBOT, frame)
    assert found.result.arm.accuracy["held out", "position"].after.rms < 1.25 * NOISE * np.sqrt(3.0)
    names = [parameter.name for parameter in found.model.chain.reading.parameters]
    assert "marker two in session 1 x_m" in names
    assert "marker two in session 2 x_m" in names
    assert held_out(frame.drop(columns="session")) > 10.0 * NOISE


def test_a_column_of_one_station_changes_nothing(standing: pd.DataFrame) -> None:
    names = [p.name for p in xd.identify(ROBOT, standing.assign(station="door")).model.chain.reading.parameters]
    assert "instrument x_m" in names


def test_a_given_instrument_has_no_two_stations(standing: pd.DataFrame, tmp_path: Path) -> None:
    text = ROBOT.read_text(encoding="utf-8").replace("urdf: ", f"urdf: {ROBOT.parent}/")
    (tmp_path / "arm.yaml").write_text(f"{text}\ninstrument: [1, 0, 0, 0, 0, 0]\n", encoding="utf-8")
    with pytest.raises(InputError, match="2 stations, and the robot file gives one pose"):
        xd.identify(tmp_path / "arm.yaml", moved(standing, 130))
