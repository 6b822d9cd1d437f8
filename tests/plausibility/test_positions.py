"""Positions of markers in other units and frames than the commands are named with place and remedy."""

from collections.abc import Callable
from copy import copy
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from expdesign.assurance.plausibility.finding import Implausibility, say
from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.errors import InputError
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import read_robot
from tests.identification.experiments import table_of
from tests.identification.test_arm_calibration import mixed, recordings_of
from tests.plant import INSTRUMENT, JOINTS, LOADS, READ, recordings, usual_faults
from tests.plant import ROBOT as ARM
from tests.plausibility.mistaken_recordings import cell, shifted
from tests.plausibility.mistakes import Frame, swapped, times
from tests.robots.torso import FILE, LIFTED, STIFFNESS, Torso, read_torso


@pytest.fixture(scope="module")
def arm() -> Robot:
    return read_robot(ARM)


@pytest.fixture(scope="module")
def positions() -> pd.DataFrame:
    """Forty poses of an arm with usual errors, at three markers."""
    return recordings(usual_faults(3), 120, 5)


def copied(first: int, rows: int) -> Frame:
    """Rows once more at the end, under new numbers."""

    def change(frame: pd.DataFrame) -> pd.DataFrame:
        again = frame.iloc[first : first + rows].copy()
        for name in ("sequence", "series"):
            again[name] += frame[name].max()
        return pd.concat([frame, again])

    return change


def test_sound_positions_are_not_warned_of(arm: Robot, positions: pd.DataFrame, tmp_path: Path) -> None:
    assert recordings_findings(recordings_from_table(table_of(positions), arm), arm) == []
    torso = read_torso(tmp_path)
    sound = recordings_from_table(table_of(Torso().recordings(40, 2, 2e-5)), torso)
    assert recordings_findings(sound, torso) == []


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (times(180.0 / np.pi, *JOINTS), "joint coordinates in degrees"),
        (times(180.0 / np.pi, "q3_rad"), "q3_rad in degrees"),
        (times(-1.0, "q3_rad"), "q3_rad have the wrong sign"),
        (times(-1.0, "py_m"), "left-handed"),
        (swapped("q2_rad", "q3_rad"), "q2_rad and q3_rad swapped"),
        (swapped("q2_rad", "q5_rad"), "q2_rad and q5_rad swapped"),
        (shifted(READ, 1), "readings stand one row too late"),
        (cell(30, "px_m", lambda v: 10.0 * v), "in row 32 10 times too large"),
        (cell(31, "py_m", lambda v: -v), "in row 33 of the wrong sign"),
        (lambda frame: frame.assign(q3_rad=frame["q3_rad"] - frame["q2_rad"]), "q3_rad + q2_rad"),
        (lambda frame: frame.assign(q5_rad=frame["q5_rad"] + frame["q4_rad"]), "q5_rad − q4_rad"),
        (lambda frame: seen_from(frame, np.arange(len(frame)) >= 70), "moved before row 72?"),
    ],
)
def test_commands_and_positions_of_different_frames_are_said(
    arm: Robot, positions: pd.DataFrame, change: Frame, says: str
) -> None:
    (finding,) = recordings_findings(recordings_from_table(table_of(change(positions)), arm), arm)
    assert says in finding.likely
    assert "after registration" in finding.what


def pose_of(frame: pin.SE3) -> np.ndarray:
    return np.append(frame.translation, pin.rpy.matrixToRpy(frame.rotation))


STOOD = pose_of(INSTRUMENT)


@pytest.mark.parametrize(
    ("stated", "says"),
    [
        (
            STOOD * np.repeat([1.0, 180.0 / np.pi], 3),
            "angles in degrees? They have to be in rad. Write `instrument: [2.3, ",
        ),
        (STOOD * np.repeat([1e3, 1.0], 3), "Is its place in mm? Write `instrument: [2.3, 1.6, 0.4, 0.01, -0.02, 2.4]`"),
        (
            pose_of(INSTRUMENT.inverse()),
            "in the instrument's axes? Write `instrument: [2.3, 1.6, 0.4, 0.01, -0.02, 2.4]`",
        ),
        (STOOD + 0.4 * np.eye(6)[0], "they fit. Without the key the pose is estimated."),
    ],
)
def test_another_pose_of_the_instrument_is_said(
    arm: Robot, positions: pd.DataFrame, stated: np.ndarray, says: str
) -> None:
    robot = copy(arm)
    robot.instrument = stated
    (finding,) = recordings_findings(recordings_from_table(table_of(positions), robot), robot)
    assert says in finding.likely
    robot.instrument = STOOD
    assert recordings_findings(recordings_from_table(table_of(positions), robot), robot) == []
    (finding,) = recordings_findings(recordings_from_table(table_of(times(-1.0, "py_m")(positions)), robot), robot)
    assert "left-handed" in finding.likely
    based = [INSTRUMENT.act(place) for place in positions[READ].to_numpy()]
    frame = positions.assign(**dict(zip(READ, np.transpose(based), strict=True)))
    (finding,) = recordings_findings(recordings_from_table(table_of(frame), robot), robot)
    assert "in the base's frame? Write `instrument: [0, 0, 0, 0, 0, 0]`" in finding.likely


def seen_from(frame: pd.DataFrame, late: np.ndarray) -> pd.DataFrame:
    """Rows that are late are seen by an instrument that stands elsewhere."""
    turned = frame[READ].to_numpy() @ Rotation.from_euler("xyz", [0.1, -0.2, 1.4]).as_matrix() + [1.2, -0.4, 0.3]
    return frame.assign(**dict(zip(READ, np.where(late[:, None], turned, frame[READ]).T, strict=True)))


def test_a_station_for_each_arm_is_named_and_no_columns_are_called_swapped(tmp_path: Path) -> None:
    """One rigid motion for two arms at two stations leaves anything; no exchange of columns explains it."""
    (finding,) = of_torso(tmp_path, lambda frame: seen_from(frame, (frame["tip"] == "left_hand").to_numpy()))
    assert "station" in finding.likely
    assert "`right_hand`, `left_hand`" in finding.likely
    assert "swapped" not in finding.likely
    assert finding.otherwise


def test_the_lines_that_accept_a_coupling_are_read_and_fit(arm: Robot, positions: pd.DataFrame, tmp_path: Path) -> None:
    """They are those of the sentence: one joint more in the URDF, one line more in the robot file."""
    wrong = positions.assign(q3_rad=positions["q3_rad"] - positions["q2_rad"])
    (finding,) = recordings_findings(recordings_from_table(table_of(wrong), arm), arm)
    line = finding.likely.split("`")[1]
    joint = line.split("{")[1].split(":")[0]
    urdf = (ARM.parent / "ur5.urdf").read_text(encoding="utf-8")
    motor = f"""<link name="motor"/><joint name="{joint}_motor" type="revolute"><parent link="base"/>
        <child link="motor"/><axis xyz="0 0 1"/><limit lower="-7" upper="7" effort="1" velocity="1"/></joint>"""
    (tmp_path / "ur5.urdf").write_text(urdf.replace("</robot>", f"{motor}</robot>"), encoding="utf-8")
    (tmp_path / "ur5.yaml").write_text(f"{ARM.read_text(encoding='utf-8')}\n{line}\n", encoding="utf-8")
    coupled = read_robot(tmp_path / "ur5.yaml")
    assert recordings_findings(recordings_from_table(table_of(wrong), coupled), coupled) == []


def test_copied_positions_are_said(arm: Robot, positions: pd.DataFrame) -> None:
    (finding,) = recordings_findings(recordings_from_table(table_of(copied(12, 3)(positions)), arm), arm)
    assert "agree with those of rows 14 to 16 far closer" in finding.what


@pytest.mark.parametrize("column", ["com_z_m", "left_hand_com_z_m"])
def test_payloads_that_no_robot_could_hold_are_refused(tmp_path: Path, column: str) -> None:
    """A centre of mass of 150 mm, entered as 150 m, of what the tip or another hand carries."""
    torso = read_torso(tmp_path)
    frame = Torso().recordings(8, 2, 2e-5).assign(mass_kg=1.0, com_x_m=0.0, com_y_m=0.0, com_z_m=0.0)
    frame = frame.drop(columns=["fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"]).assign(**{column: 150.0})
    wrong = recordings_from_table(table_of(frame), torso)
    with pytest.raises(InputError, match=rf"column {column.replace('_z_', '_x_')}: .* lies 150 m away.*look like mm"):
        say(recordings_findings(wrong, torso), wrong.source)


def test_payloads_in_grams_are_named(arm: Robot, positions: pd.DataFrame) -> None:
    """Of 2 kg, in the first of many rows; 10 kg are not asked about."""
    for mass, said in ((10.0, []), (2000.0, ["row 2"])):
        own = np.where(np.arange(len(positions)) == 0, mass, 0.0)
        frame = positions.drop(columns=LOADS).assign(mass_kg=own, com_x_m=0.0, com_y_m=0.0, com_z_m=0.1)
        findings = recordings_findings(recordings_from_table(table_of(frame), arm), arm)
        assert [finding.where for finding in findings] == said
        assert all("Is a mass in grams" in finding.likely for finding in findings)


def test_positions_in_mm_are_refused(arm: Robot, positions: pd.DataFrame) -> None:
    wrong = recordings_from_table(table_of(times(1e3, *READ)(positions)), arm)
    with pytest.raises(InputError, match=r"column px_m: the positions spread over .* look like mm"):
        say(recordings_findings(wrong, arm), wrong.source)


def of_torso(folder: Path, change: Frame) -> list[Implausibility]:
    torso = read_torso(folder)
    recorded = recordings_from_table(table_of(change(Torso().recordings(60, 2, 2e-5))), torso)
    return recordings_findings(recorded, torso)


def test_markers_on_the_other_tip_are_said(tmp_path: Path) -> None:
    other = {"right_hand": "left_hand", "left_hand": "right_hand"}
    (finding,) = of_torso(tmp_path, lambda frame: frame.assign(tip=frame["tip"].map(other)))
    assert finding.likely == "Are `right_hand` and `left_hand` swapped in the column tip?"
    (finding,) = of_torso(tmp_path, lambda frame: frame.assign(tip="right_hand"))
    assert finding.likely == "Does marker `left` sit on `left_hand`?"


def test_joints_that_move_weight_and_have_no_column_are_named(tmp_path: Path) -> None:
    one = FILE.replace("[right_hand, left_hand]", "right_hand").replace("payload_links: [left_hand]\n", "")
    one = one.replace(str(STIFFNESS.tolist()), str(STIFFNESS[:5].tolist()))
    frame = Torso().recordings(60, 2, 2e-5)
    frame = frame[frame["tip"] == "right_hand"].drop(columns=["tip", *LIFTED])
    left = [f"left_{name}_rad" for name in ("shoulder", "elbow", "wrist")]
    torso = read_torso(tmp_path, one)
    (finding,) = recordings_findings(recordings_from_table(table_of(frame.drop(columns=left)), torso), torso)
    assert "`left_shoulder`, `left_elbow`, `left_wrist`" in finding.what
    assert "branch_joints: [left_shoulder, left_elbow, left_wrist]" in finding.likely
    torso = read_torso(tmp_path, one + "branch_joints: [left_shoulder, left_elbow, left_wrist]\n")
    assert recordings_findings(recordings_from_table(table_of(frame), torso), torso) == []


@pytest.mark.parametrize(
    ("written", "says"),
    [
        (lambda true: Rotation.from_quat(np.roll(true.as_quat(), 1, axis=1)), "written as w, x, y, z and read as"),
        (lambda true: Rotation.from_quat(np.roll(true.as_quat(), -1, axis=1)), "written as x, y, z, w and read as"),
        (lambda true: true.inv(), "Transpose them"),
        (lambda true: true.as_rotvec(), "rotation vectors"),
        (lambda true: true.as_euler("ZYX"), "A, B, C about z, y, x"),
        (lambda true: true.as_euler("XYZ"), "moving axes, first x, then y, then z"),
        (lambda true: true.as_euler("ZYZ"), "O, A, T"),
    ],
)
def test_orientations_written_otherwise_are_said(
    arm: Robot, written: Callable[[Rotation], Rotation | np.ndarray], says: str
) -> None:
    turns = [f"measured_r{axis}_rad" for axis in "xyz"]
    frame = mixed(60)
    assert recordings_findings(recordings_of(frame), arm) == []
    given = frame[turns].astype(float)
    posed = given.notna().all(axis=1)
    other = written(Rotation.from_euler("xyz", given[posed].to_numpy()))
    frame.loc[posed, turns] = other.as_euler("xyz") if isinstance(other, Rotation) else other
    (finding,) = recordings_findings(recordings_of(frame), arm)
    assert says in finding.likely
    assert finding.otherwise


@pytest.mark.parametrize("written", ["xyz", "rotation vectors"])
def test_poses_of_a_camera_on_the_tip_are_called_inverse(arm: Robot, written: str) -> None:
    """Eye in hand: the instrument's pose in the target's frame; with rotation vectors both are named."""
    names = [f"measured_{axis}_m" for axis in "xyz"] + [f"measured_r{axis}_rad" for axis in "xyz"]
    frame = mixed(60)
    frame = frame[frame[names].notna().all(axis=1)].copy()
    pose = frame[names].to_numpy(dtype=float, copy=True)
    inverse = Rotation.from_euler("xyz", pose[:, 3:]).inv()
    turns = inverse.as_euler("xyz") if written == "xyz" else inverse.as_rotvec()
    frame[names] = np.hstack([-inverse.apply(pose[:, :3]), turns])
    (finding,) = recordings_findings(recordings_of(frame), arm)
    assert "Invert the poses" in finding.likely
    assert ("rotation vectors" in finding.likely) == (written != "xyz")
