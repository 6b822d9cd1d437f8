"""Tables of measured poses: what is read, and what is refused with its place and a remedy."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from expdesign.app.api.inputs import table_of
from expdesign.chain.recordings.filled_in import check_structure
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSES
from expdesign.errors import InputError
from expdesign.estimation.identify import identify
from expdesign.mechanics.robots.robot_file import read_robot

ROBOTS = Path(__file__).parents[2] / "configs" / "robots"
ROBOT = read_robot(ROBOTS / "hexapod-h1.yaml")
POSE = list(ROBOT.coordinates.pose)
MEASURED = [f"measured_{name}" for name in POSE]
REACH = np.array([0.02, 0.02, 0.01, 0.1, 0.1, 0.1])


def valid() -> pd.DataFrame:
    """Twenty poses without load that are met to 50 µm and 50 µrad; two of them references."""
    random = np.random.default_rng(1)
    frame = pd.DataFrame({"sequence": np.arange(1, 21), "series": np.arange(1, 21), "kind": "pose"})
    frame[POSE] = REACH * random.uniform(-1.0, 1.0, (20, 6))
    frame[MEASURED] = frame[POSE].to_numpy() + 5e-5 * random.standard_normal((20, 6))
    frame.loc[[0, 10], "kind"] = "reference"
    return frame


def test_poses_are_read_with_the_axes_that_were_measured() -> None:
    frame = valid().drop(columns=["measured_z_m", "measured_rx_rad"])
    recordings = recordings_from_table(table_of(frame, "poses"), ROBOT)
    assert recordings.measurand is POSES
    assert recordings.axes.tolist() == [0, 1, 4, 5]
    assert not recordings.wrenches.any()
    np.testing.assert_array_equal(recordings.deflections[:, 0], frame["measured_x_m"])
    assert not len(recordings.extra.columns)


def test_the_column_kind_marks_points_at_which_poses_are_wanted() -> None:
    wanted = valid().drop(columns=MEASURED)
    assert points_from_table(table_of(wanted, "points"), ROBOT).measurand is POSES
    loaded = wanted.drop(columns="kind").assign(**dict.fromkeys(ROBOT.coordinates.wrench, 0.0))
    assert points_from_table(table_of(loaded, "points"), ROBOT).measurand is DEFLECTIONS


def test_the_structural_check_knows_them_without_a_robot() -> None:
    assert "measured_x_m, measured_y_m" in check_structure(table_of(valid(), "poses"))


def _scaled(name: str, factor: float) -> Callable[[pd.DataFrame], pd.DataFrame]:
    return lambda frame: frame.assign(**{name: factor * frame[name]})


def _shifted(name: str, amount: float) -> Callable[[pd.DataFrame], pd.DataFrame]:
    return lambda frame: frame.assign(**{name: frame[name] + amount})


def _kind(frame: pd.DataFrame) -> pd.DataFrame:
    frame.loc[3, "kind"] = "zero"
    return frame


FAULTS: list[tuple[Callable[[pd.DataFrame], pd.DataFrame], str, str]] = [
    (_scaled("measured_x_m", 1e3), "as one in mm would", "measured_x_m"),
    (_scaled("measured_ry_rad", 180.0 / np.pi), "as one in degrees would", "measured_ry_rad"),
    (_shifted("measured_z_m", 0.4), "more than 0.1 away from the commanded", "measured_z_m"),
    (_shifted("measured_rz_rad", 0.03), "all rows are off by 0.03", "measured_rz_rad"),
    (_shifted("measured_y_m", -0.02), "all rows are off by -0.02", "measured_y_m"),
    (_kind, "`zero` is neither `reference` nor `pose`", "row 5, column kind"),
    (lambda frame: frame.assign(dx_m=0.0), "`dx_m` together with poses measured_x_m", "dx_m"),
    (lambda frame: frame.drop(columns=MEASURED), "there is no measured column", "poses"),
    (lambda frame: frame.assign(measured_x_m="x"), "measured_x_m", "row 2"),
]


@pytest.mark.parametrize(("change", "what", "where"), FAULTS)
def test_what_cannot_be_right_is_refused(change: Callable[[pd.DataFrame], pd.DataFrame], what: str, where: str) -> None:
    with pytest.raises(InputError) as error:
        recordings_from_table(table_of(change(valid()), "poses"), ROBOT)
    assert what in str(error.value)
    assert where in str(error.value)


def test_geometry_is_not_sought_where_it_does_not_show() -> None:
    recordings = recordings_from_table(table_of(valid(), "poses"), ROBOT)
    with pytest.raises(InputError, match="no row has a load"):
        identify(ROBOT, recordings, calibration="both")
    loads = dict.fromkeys(ROBOT.coordinates.wrench, 1.0)
    deflections = valid().drop(columns=[*MEASURED, "kind"]).assign(dx_m=1e-6, **loads)
    with pytest.raises(InputError, match="deflections are differences"):
        identify(ROBOT, recordings_from_table(table_of(deflections, "d"), ROBOT), calibration="geometric")
    loaded = recordings_from_table(table_of(valid().assign(**loads), "poses"), ROBOT)
    with pytest.raises(InputError, match="no row without load is left"):
        identify(ROBOT, loaded, calibration="geometric")


def test_only_robots_on_legs_have_a_standard_deviation_of_their_geometry(tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text((ROBOTS / "hexapod-h1.yaml").read_text() + "\ngeometry_std_m: 2.0e-4\n")
    assert read_robot(file).geometry_std == 2e-4
    (tmp_path / "ur5.urdf").write_text((ROBOTS / "ur5.urdf").read_text())
    file.write_text((ROBOTS / "ur5.yaml").read_text() + "\ngeometry_std_m: 2.0e-4\n")
    with pytest.raises(InputError, match="geometry_std_m"):
        read_robot(file)
