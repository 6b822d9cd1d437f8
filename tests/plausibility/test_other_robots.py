"""Robot files and recordings that fit a machine, and not this one: joints, legs, limits, units of deviations."""

from copy import deepcopy
from typing import Any

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.app.api.inputs import load_robot, table_of
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.assurance.plausibility.robot import robot_findings
from expdesign.chain.recordings.reader import recordings_from_table
from tests.plausibility.sound import content_of, recordings_of

CONTENT = content_of("hexapod-h1")
RINGS = {
    "base": {"radius_m": 0.2, "half_angle_deg": 8, "height_m": 0.0},
    "platform": {"radius_m": 0.14, "half_angle_deg": 10, "height_m": -0.03},
}


def by_rings(**changes: dict[str, Any]) -> dict[str, Any]:
    """The hexapod by radius and angles, with changes of its rings."""
    robot = {key: value for key, value in CONTENT["robot"].items() if not key.endswith("_joints")}
    return robot | {name: {**ring, **changes.get(name, {})} for name, ring in RINGS.items()}


def of_robot(robot: dict[str, Any]) -> list[Implausibility]:
    return robot_findings(load_robot(robot).robot)


def found(frame: pd.DataFrame, robot: dict[str, Any] | None = None) -> list[Implausibility]:
    machine = load_robot(CONTENT["robot"] if robot is None else robot).robot
    return recordings_findings(recordings_from_table(table_of(frame, "recordings"), machine), machine)


def test_half_angles_in_rad_are_asked_about() -> None:
    assert of_robot(by_rings()) == []
    (finding,) = of_robot(by_rings(base={"half_angle_deg": 0.14}))
    assert finding.likely.startswith("Is `half_angle_deg` in rad? 0.14 rad are 8.02°")
    assert finding.where == "base"
    shared = deepcopy(CONTENT["robot"])
    for rows in (shared["base_joints"], shared["platform_joints"]):
        rows[1::2] = rows[::2]
    assert of_robot(shared | {"name": "pairs share a joint"}) == []


def test_legs_that_cross_are_named() -> None:
    robot = deepcopy(CONTENT["robot"])
    rows = robot["platform_joints"]
    rows[0], rows[1] = rows[1], rows[0]
    (finding,) = of_robot(robot)
    assert finding.what == "leg 1 and leg 2 cross at the reference pose"
    assert "another order" in finding.likely


@pytest.mark.parametrize(("height", "usable"), [(0.30, True), (0.45, False)])
def test_a_robot_whose_limits_exclude_its_home_is_not_called_usable(height: float, usable: bool) -> None:
    robot = CONTENT["robot"] | {"home": [0.0, 0.0, height]}
    checked = xd.check(load_robot(robot))
    assert ("is usable" in checked.summary) == usable
    assert ("cannot be at its reference pose" in checked.summary) == (not usable)


def test_a_recorded_pose_out_of_reach_is_named_with_its_rows_and_no_swap() -> None:
    frame = recordings_of(CONTENT, 5, rows=12, series=3)
    assert found(frame) == []
    frame.loc[frame["series"] == 2, "x_m"] = 0.4
    (finding,) = [each for each in found(frame) if "cannot have been" in each.what]
    assert "rows 5, 6, 7" in finding.what
    assert "m (limits 0.25 to 0.37 m)" in finding.what
    assert finding.otherwise
    assert "swapped" not in " ".join(each.likely for each in found(frame))


def test_deviations_of_translations_in_mm_are_named() -> None:
    frame = recordings_of(CONTENT, 6, rows=12)
    frame[["sx_m", "sy_m", "sz_m"]] *= 1e-3
    text = " ".join(f"{each.what}. {each.likely}" for each in found(frame))
    assert "the readings of dx_m, dy_m, dz_m scatter" in text
    assert "a thousand times too small (numbers in mm" in text


def test_recordings_of_another_robot_whose_columns_fit_are_asked_about() -> None:
    """Of a hexapod that is two thirds as wide and three times as stiff; its poses are within the limits of this one."""
    other = deepcopy(CONTENT)
    robot = other["robot"]
    robot["base_joints"] = (np.array(robot["base_joints"]) * [0.7, 0.7, 1.0]).tolist()
    robot["platform_joints"] = (np.array(robot["platform_joints"]) * [0.7, 0.7, 1.0]).tolist()
    robot["actuator_stiffness"] = (3.0 * np.array(robot["actuator_stiffness"])).tolist()
    frame = recordings_of(other, 4, rows=14, spread=0.05)
    assert any("another robot" in each.likely for each in found(frame))
