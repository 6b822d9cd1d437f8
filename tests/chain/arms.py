"""A small arm with a marker on its tip, and positions that an instrument would read."""

from pathlib import Path

import numpy as np

from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.recordings.recordings import Recordings
from expdesign.mechanics.robots.robot_file import read_robot
from expdesign.mechanics.robots.serial import SerialRobot
from tests.oracle import Array
from tests.robots.urdf import joint_text, link_text

_JOINTS = [  # name, origin, axis, mass and centre of the link that it moves, kind
    ("lift", "0 0 0.2", "0 0 1", 6.0, "0 0 0.1", "prismatic"),
    ("waist", "0 0 0.3", "0 0 1", 8.0, "0.02 0 0.1", "revolute"),
    ("shoulder", "0.05 0 0.2", "0 1 0", 7.0, "0 0 0.2", "revolute"),
    ("elbow", "0 0.03 0.45", "0 1 0", 4.0, "0.15 0 0", "revolute"),
    ("roll", "0.40 0 0.02", "1 0 0", 2.0, "0.05 0 0", "revolute"),
    ("wrist", "0.10 0 0", "0 1 0", 1.5, "0.04 0 0.01", "revolute"),
    ("flange", "0.08 0 0", "1 0 0", 0.8, "0.03 0.01 0", "revolute"),
]
STIFFNESS = np.array([3e6, 6e4, 8e4, 5e4, 2e4, 1.5e4, 1e4])
PLACE = np.array([0.06, -0.03, 0.11])
INSTRUMENT = np.array([2.5, -1.4, 0.9, 0.02, -0.03, 2.1])
DEVIATION = 5e-5
READING = MarkerPosition(("ball",), {}, None, np.array([*INSTRUMENT, *PLACE]))
"""By that instrument, of the marker on the tip."""


def write_arm(folder: Path) -> Path:
    """URDF and robot file of a seven-joint arm; returns the robot file."""
    parents = ["base", *(f"{joint[0]}_link" for joint in _JOINTS)]
    text = "".join(
        link_text(f"{name}_link", mass, centre) + joint_text(name, parent, f"{name}_link", xyz, axis, kind=kind)
        for parent, (name, xyz, axis, mass, centre, kind) in zip(parents, _JOINTS, strict=False)
    )
    (folder / "arm.urdf").write_text(f'<robot name="arm"><link name="base"/>{text}</robot>', encoding="utf-8")
    file = folder / "arm.yaml"
    file.write_text(
        "name: arm\nkind: serial\nurdf: arm.urdf\nbase_link: base\ntip_link: flange_link\n"
        f"actuator_stiffness: {STIFFNESS.tolist()}\n",
        encoding="utf-8",
    )
    return file


def read_arm(folder: Path) -> SerialRobot:
    robot = read_robot(write_arm(folder))
    assert isinstance(robot, SerialRobot)
    return robot


def configurations(count: int, seed: int, *, one_orientation: bool = False) -> Array:
    """Joint coordinates (count, 7); with one orientation only the lift and a shoulder-elbow-wrist motion remain."""
    generator = np.random.default_rng(seed)
    q = generator.uniform(-1.2, 1.2, (count, 7))
    q[:, 0] = generator.uniform(0.0, 0.8, count)
    if one_orientation:
        q[:, [1, 4, 6]] = 0.3, 0.0, 0.2
        q[:, 5] = -q[:, 2] - q[:, 3]
    return q


def recordings_of(robot: SerialRobot, q: Array, positions: Array, test: Array | None = None) -> Recordings:
    """Positions (N, 3) of one marker as recordings."""
    import pandas as pd  # noqa: PLC0415

    count = len(q)
    zeros = np.zeros((count, 6))
    return Recordings(
        source="arm.csv",
        lines=np.arange(2, count + 2),
        sequence=np.arange(1, count + 1),
        series=np.ones(count, dtype=np.int64),
        time=10.0 * np.arange(count),
        configurations=q,
        wrenches=zeros,
        absolute=zeros,
        payload=None,
        gravity=np.tile(robot.gravity, (count, 1)),
        temperature=None,
        leg_temperature=None,
        extra=pd.DataFrame(index=range(count)),
        axes=np.arange(3),
        deflections=positions,
        deviations=np.full((count, 3), DEVIATION),
        test=np.zeros(count, dtype=bool) if test is None else test,
        marker=np.zeros(count, dtype=np.int64),
        markers=("ball",),
    )
