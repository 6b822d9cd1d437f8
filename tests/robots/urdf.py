"""Texts of URDF files, and robots of such a text and a robot file."""

from pathlib import Path

from expdesign.mechanics.robots.robot_file import read_robot
from expdesign.mechanics.robots.serial import SerialRobot


def link_text(name: str, mass: float, centre: str = "0.1 0 0.02") -> str:
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    return f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/>{inertia}</inertial></link>'


def joint_text(
    name: str, parent: str, child: str, xyz: str, axis: str, *, rule: str = "", kind: str = "revolute"
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}"/><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="{axis}"/><limit lower="-3" upper="3" effort="1" velocity="1"/>{rule}</joint>'
    )


def robot_of(folder: Path, urdf: str, text: str) -> SerialRobot:
    """The robot of `robot.yaml`, which names `robot.urdf`; both are written."""
    (folder / "robot.urdf").write_text(urdf, encoding="utf-8")
    (folder / "robot.yaml").write_text(text, encoding="utf-8")
    robot = read_robot(folder / "robot.yaml")
    assert isinstance(robot, SerialRobot)
    return robot
