"""Which of a robot's several tips a measurement of a plan reads, and which one a target is of.

A configuration ends with its tip's number (`kinematic_tree.py`). Run configurations name tips instead: poses there are
joint coordinates, `poses.tips` says which tips may be read at them, and every target names its own.
"""

from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.io.nearest import nearest
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.kinematic_tree import PAYLOAD_COLUMNS, TIP_COLUMN
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.variables import Choices


def tips_of(robot: Robot) -> tuple[str, ...]:
    """Names of the tips of a robot that has several; none of another one."""
    several = robot.configuration[-1] == TIP_COLUMN
    return robot.links.tree.tips if several else ()


def named_tips(robot: Robot, configurations: FloatArray) -> dict[str, Any]:
    """The column of tips by name of configurations (m, n_q); none of a robot with one tip."""
    tips = np.array(tips_of(robot))
    return {TIP_COLUMN: tips[robot.tip_numbers(configurations) - 1]} if len(tips) else {}


def pose_columns(robot: Robot) -> tuple[str, ...]:
    """What a pose in a run configuration consists of: a configuration without its tip."""
    return robot.configuration[: len(robot.configuration) - bool(tips_of(robot))]


def pose_of(values: list[float], robot: Robot, place: YamlDocument) -> FloatArray:
    """A pose of a run configuration in the order of `pose_columns`; links carry nothing where it ends before them.

    Raises:
        InputError: there are too few numbers, or too many.
    """
    names = pose_columns(robot)
    loads = len(PAYLOAD_COLUMNS) * len(robot.links.tree.carriers) if robot.jointed else 0
    if len(values) not in (len(names), len(names) - loads):
        what = f"{len(names) - loads} numbers are needed here, not {len(values)}"
        order = f"Order: {', '.join(names[: len(names) - loads])}."
        further = f" Then, or 0: {', '.join(names[len(names) - loads :])}." if loads else ""
        raise place.fault(what, order + further)
    return np.array([*values, *[0.0] * (len(names) - len(values))], dtype=float)


def tip_number(name: str | None, robot: Robot, place: YamlDocument) -> FloatArray:
    """What follows a target's pose in its configuration: the number of its tip (1,), or nothing (0,).

    Raises:
        InputError: the tip is not named, or is none of the robot's.
    """
    tips = tips_of(robot)
    if name is None and tips:
        what = "the key is missing, and the robot has several tips"
        raise place.fault(what, f"Name one of {_listed(tips)}.")
    return np.zeros(0) if name is None else np.array([float(_number(name, tips, place))])


def asked_tips(names: list[str] | None, robot: Robot, place: YamlDocument) -> Choices | None:
    """Numbers of the tips that may be measured; None of a robot with one tip.

    Raises:
        InputError: a name is none of the robot's tips, or appears twice.
    """
    tips = tips_of(robot)
    if names is None:
        return Choices(tuple(float(number) for number in range(1, len(tips) + 1))) if tips else None
    numbers = [_number(name, tips, place.where(index)) for index, name in enumerate(names)]
    if len(set(numbers)) < len(numbers):
        raise place.fault("a tip appears twice", "Name each once.")
    return Choices(tuple(float(number) for number in numbers))


def at_tips(poses: FloatArray, tips: Choices | None) -> FloatArray:
    """Poses (r, n) at every one of the tips, with its number, (r·tips, n + 1); as they are where there is one tip."""
    if tips is None:
        return poses
    numbers = np.tile(tips.values, len(poses))
    return np.column_stack([np.repeat(poses, len(tips.values), axis=0), numbers])


def _number(name: str, tips: tuple[str, ...], place: YamlDocument) -> int:
    if not tips:
        raise place.fault("the robot has one tip, which need not be named", "Take the key out.")
    if name not in tips:
        raise place.fault(f"`{name}` is no tip of the robot", nearest(name, tips))
    return tips.index(name) + 1


def _listed(tips: tuple[str, ...]) -> str:
    return ", ".join(f"`{tip}`" for tip in tips)
