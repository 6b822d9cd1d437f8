"""Robot files (file-formats.md, Robot files), with joints by coordinates, or by radii and angles."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from expdesign.errors import InputError
from expdesign.io.yaml_reader import parse_yaml
from expdesign.mechanics.robots.bipod import Bipod
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.robot_file import read_robot, robot_from_document
from tests.design.problems import BIPOD, HEXAPOD

SHIPPED = sorted((Path(__file__).parents[2] / "configs" / "robots").glob("*.yaml"))


def test_the_file_of_the_interfaces(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    joints = HEXAPOD["robot"]
    path.write_text(
        "name: demo\nkind: hexapod\norientation: moving-xyz\nhome: [0.0, 0.0, 0.25]\n"
        f"base_joints: {joints['base_joints']}\nplatform_joints: {joints['platform_joints']}\n"
        "actuator_stiffness: [2.5e7, 2.5e7, 2.5e7, 2.5e7, 2.5e7, 1e8]\nlimits:\n  leg_length: [0.2, 0.35]\n"
        "gravity_m_s2: [0, 1, -9]\n"
    )
    robot = read_robot(path)
    assert isinstance(robot, Hexapod)
    assert robot.orientation == "moving-xyz"
    assert robot.actuators == tuple(f"leg {i}" for i in range(1, 7))
    assert robot.leg_length == (0.2, 0.35)
    np.testing.assert_array_equal(robot.stiffness, [2.5e7] * 5 + [1e8])
    np.testing.assert_array_equal(robot.compliance, 1.0 / robot.stiffness)
    np.testing.assert_array_equal(robot.gravity, [0.0, 1.0, -9.0])
    np.testing.assert_array_equal(robot.base_joints, joints["base_joints"])
    np.testing.assert_array_equal(robot.platform_joints, joints["platform_joints"])
    np.testing.assert_array_equal(robot.home, [0.0, 0.0, 0.25])


def test_a_bipod_has_two_coordinates_and_standard_gravity(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(BIPOD["robot"]))
    robot = read_robot(path)
    assert isinstance(robot, Bipod)
    assert robot.configuration == ("x_m", "y_m")
    np.testing.assert_array_equal(robot.gravity, [0.0, -9.80665])
    assert robot.leg_length is None


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_robots_are_regular_at_their_zero_pose_and_within_their_limits(path: Path) -> None:
    robot = read_robot(path)
    zero = np.array([0.0, 0.6]) if isinstance(robot, Bipod) else np.zeros(len(robot.configuration))
    assert bool(robot.usable(zero))


H1 = Path(__file__).parents[2] / "configs" / "robots" / "hexapod-h1.yaml"


def read(content: dict[str, Any]) -> Any:
    return robot_from_document(parse_yaml(yaml.safe_dump(content), "robot.yaml", Path()))


def content(**changes: Any) -> dict[str, Any]:
    result: dict[str, Any] = {
        "name": "H1",
        "kind": "hexapod",
        "home": [0.0, 0.0, 0.3],
        "base": {"radius_m": 0.24, "angles_deg": [-10, 10, 110, 130, 230, 250], "yaw_deg": 90},
        "platform": {"radius_m": 0.17, "angles_deg": [-50, 50, 70, 170, 190, 290], "height_m": -0.03, "yaw_deg": 90},
        "actuator_stiffness": [5.24e6] * 6,
    }
    return {key: value for key, value in (result | changes).items() if value is not None}


def test_the_example_hexapod_by_its_angles() -> None:
    robot, expected = read(content()), read_robot(H1)

    def by_height(rows: Any) -> Any:
        return rows[np.lexsort(rows.T)]

    assert isinstance(expected, Hexapod)
    np.testing.assert_allclose(
        by_height(robot.platform_joints.round(8)), by_height(expected.platform_joints.round(8)), atol=1e-8
    )
    np.testing.assert_allclose(np.linalg.norm(robot.base_joints, axis=1), 0.24, rtol=1e-12)


def test_half_angles_are_three_pairs() -> None:
    rings = {"base": {"radius_m": 0.24, "half_angle_deg": 10, "yaw_deg": 90},
             "platform": {"radius_m": 0.17, "half_angle_deg": 10, "height_m": -0.03, "yaw_deg": 90}}  # fmt: skip
    robot, same = read(content(**rings)), read(content())
    np.testing.assert_allclose(robot.base_joints, same.base_joints, atol=1e-12)
    np.testing.assert_allclose(robot.platform_joints, same.platform_joints, atol=1e-12)
    # All legs are equally long, and the robot is regular.
    assert np.ptp(robot.lengths(np.zeros(6))) < 1e-12
    assert float(robot.jacobians(np.zeros(6)).condition) < 5.0


def test_a_text_with_its_unit_is_the_number_in_the_unit_of_the_key() -> None:
    angles = [0.1, 75, 115, 195, 235, 355]
    written = content(
        home=[0, 0, "500 mm"],
        base={"radius_m": "400 mm", "half_angle_deg": 10},
        platform={"radius_m": 0.3, "angles_deg": ["0.1 rad", *angles[1:]], "height_m": "-30 mm", "yaw_deg": "0.5 rad"},
    )
    plain = content(
        home=[0, 0, 0.5],
        base={"radius_m": 0.4, "half_angle_deg": 10},
        platform={
            "radius_m": 0.3,
            "angles_deg": [float(np.rad2deg(0.1)), *angles[1:]],
            "height_m": -0.03,
            "yaw_deg": float(np.rad2deg(0.5)),
        },
    )
    np.testing.assert_allclose(read(written).lengths(np.zeros(6)), read(plain).lengths(np.zeros(6)), atol=1e-15)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"base": None}, "base_joints"),
        ({"base_joints": [[0.0, 0.0, 0.0]] * 6}, "also given as `base`"),
        ({"base": {"radius_m": 0.24}}, "exactly one of"),
        ({"base": {"radius_m": 0.24, "half_angle_deg": 90}}, "less than 60"),
        ({"base": {"radius": 0.24, "half_angle_deg": 9}}, "Did you mean `radius_m`"),
    ],
)
def test_bad_rings(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(content(**changes))
