"""Which leg or joint is which: numbers in pictures, places and directions in words."""

from pathlib import Path

import numpy as np
import pytest

import expdesign as xd
from expdesign.mechanics.robots.hexapod import Hexapod, RingSection
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.problem import DesignProblem
from expdesign.report.page import content_of
from expdesign.report.robot_section import actuator_frame, actuator_tables
from expdesign.report.robot_view import at_rest, view_data
from tests.commands.calls import Printed, refusal

ROOT = Path(__file__).parents[2]
ROBOTS = ROOT / "configs" / "robots"


def checked(name: str) -> Robot:
    return xd.load_robot(ROBOTS / name).robot


def ring_hexapod() -> Hexapod:
    """Base joints 12° to either side of 0°, 120° and 240°, platform joints halfway between."""
    base = RingSection(radius_m=0.25, half_angle_deg=12.0).joints(platform=False)
    platform = RingSection(radius_m=0.10, half_angle_deg=12.0).joints(platform=True)
    return Hexapod(
        base_joints=base, platform_joints=platform, home=np.array([0.0, 0.0, 0.25]), stiffness=np.full(6, 1e7)
    )


def test_a_ring_of_joints_says_where_leg_1_is() -> None:
    (table,) = actuator_tables(ring_hexapod())
    assert list(table.rows[0])[:3] == ["leg 1", "(244.5, −52.0, 0.0)", "−12.0"]
    assert list(table.rows[1])[2] == "12.0"
    assert "counter-clockwise" in table.caption


def test_lengths_are_distances_between_the_joints() -> None:
    robot = ring_hexapod()
    frame = actuator_frame(robot)
    base = frame[["base_x_m", "base_y_m", "base_z_m"]].to_numpy()
    platform = frame[["platform_x_m", "platform_y_m", "platform_z_m"]].to_numpy() + robot.home
    np.testing.assert_allclose(frame["length_m"], np.linalg.norm(platform - base, axis=1), rtol=1e-12)


def test_a_swapped_joint_shows() -> None:
    """The longest leg of a robot with two platform joints swapped is not the neighbour of its like."""
    robot = ring_hexapod()
    swapped = ring_hexapod()
    swapped.platform_joints = robot.platform_joints[[3, 1, 2, 0, 4, 5]]
    swapped.geometry = np.concatenate([swapped.base_joints.ravel(), swapped.platform_joints.ravel()])
    lengths = actuator_frame(swapped)["length_m"].to_numpy()
    assert np.ptp(actuator_frame(robot)["length_m"]) < 1e-12
    assert np.ptp(lengths) > 0.02


def test_joints_of_an_arm_turn_the_tip_about_the_axes_that_are_drawn() -> None:
    """The tip's velocity per joint rate is axis × lever: Jacobian against the drawing, at a bent configuration."""
    robot = checked("ur5.yaml")
    q = np.array([0.3, -1.2, 1.4, -1.7, -1.4, 0.2])
    drawing = robot.drawing(q)
    assert drawing is not None
    forward = robot.jacobians(q).forward
    for k, name in enumerate(robot.actuators):
        axis, at = drawing.directions[name], drawing.points[drawing.components[name][0]]
        np.testing.assert_allclose(forward[3:, k], axis, atol=1e-12)
        np.testing.assert_allclose(forward[:3, k], np.cross(axis, drawing.origin - at), atol=1e-12)


@pytest.mark.parametrize("name", ["hexapod-h1.yaml", "bipod.yaml", "ur5.yaml"])
def test_the_picture_has_every_number_and_what_is_concerned(name: str) -> None:
    robot: Robot = checked(name)
    states = at_rest(robot)
    assert states is not None
    second = robot.actuators[1]
    view = view_data(robot, states, [second])
    assert view["labels"] == list(robot.actuators)
    (path,) = view["concerned"]
    assert path == states.drawing.components[second]
    # One point for each label behind the tip of the arrow.
    points = np.array(view["states"][0]).reshape(-1, view["dimension"])
    assert len(points) == view["tip"] + 1 + len(view["labels"])


def test_known_markers_are_drawn_where_they_are() -> None:
    robot = ring_hexapod()
    robot.markers = {"ball <1>": np.array([0.05, 0.0, 0.02])}
    states = at_rest(robot)
    assert states is not None
    view = view_data(robot, states)
    np.testing.assert_allclose(np.array(view["states"][0]).reshape(-1, 3)[-1], [0.05, 0.0, 0.27])
    assert view["markers"] == ["ball &lt;1&gt;"]


@pytest.mark.parametrize("name", ["robots/hexapod-h1.yaml", "robots/ur5.yaml", "bipod.yaml"])
def test_check_writes_a_page_with_the_drawing(name: str, tmp_path: Path) -> None:
    found = xd.check(ROOT / "configs" / name)
    page = found.save(tmp_path / "out").read_text(encoding="utf-8")
    view = content_of(page)["data"]["view"]
    assert len(view["labels"]) >= 2
    assert view["loaded"] == isinstance(found.read, DesignProblem)


def test_recordings_have_no_robot_to_draw(tmp_path: Path, capsys: Printed) -> None:
    table = tmp_path / "recordings.csv"
    table.write_text("sequence,series,x_m,y_m,fx_N,fy_N,dx_m,dy_m\n1,1,0,0,1,0,1e-6,0\n", encoding="utf-8")
    assert "no robot to draw" in refusal(capsys, "check", table, "--out", tmp_path / "out")
