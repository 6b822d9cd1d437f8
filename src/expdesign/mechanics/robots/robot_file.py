"""Read a robot from its YAML file; the kinds are found by the files that lie beside this one.

Whether two files are about one robot: its geometry, which says more than its name and its number of actuators.

The two are compared where they stand at the same commands, the reference configuration and some with their angles
turned, so that places of joints, home, and axes of a chain all show. Identified geometry is that of the same robot.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.io.kinds import require_kind
from expdesign.io.nearest import nearest
from expdesign.io.yaml_reader import YamlDocument, read_yaml
from expdesign.mechanics.robots.robot import Robot
from expdesign.plugins import implementations


@dataclass(frozen=True)
class RobotFile:
    """A robot with the file that describes it.

    Attributes:
        robot: for computing.
        document: the content of its file.
    """

    robot: Robot
    document: YamlDocument

    def __repr__(self) -> str:
        return f"<RobotFile: {self.robot.kind} {self.robot.name} ({self.document.source})>"


def read_robot(path: Path) -> Robot:
    """The robot described by a YAML file.

    Raises:
        InputError: the file is missing or wrong.
    """
    return robot_from_document(read_yaml(path))


def robot_from_document(document: YamlDocument) -> Robot:
    """The robot described by a mapping with the keys of a robot file; see `read_robot`."""
    require_kind(document, "robot")
    content = document.content
    if not isinstance(content, dict):
        remedy = "A robot file has the keys `name`, `kind`, ..."
        raise document.where().fault("a mapping (`key: value`) is needed here", remedy)
    kinds = {robot.kind: robot for robot in implementations("expdesign.mechanics.robots", Robot)}  # type: ignore[type-abstract]
    if "kind" not in content:
        raise document.where("kind").fault("the key is missing", f"Add `kind:` with one of {', '.join(sorted(kinds))}.")
    kind = content["kind"]
    if not isinstance(kind, str) or kind not in kinds:
        raise document.where("kind").fault(f"unknown kind of robot `{kind}`", nearest(str(kind), sorted(kinds)))
    robot = kinds[kind].from_document(document)
    _read_instrument(robot, document)
    return robot


def _read_instrument(robot: Robot, document: YamlDocument) -> None:
    """Known places of markers and of the instrument, whose numbers the kind's own section has checked."""
    content: dict[str, Any] = document.content
    markers: dict[str, FloatArray] = {}
    for name, place in (content.get("markers") or {}).items():
        if len(place) != 3:
            raise document.where("markers", name).fault("three coordinates are needed here", "Write `[x, y, z]` in m.")
        markers[str(name)] = np.array(place, dtype=float)
    robot.markers = markers
    if content.get("instrument") is not None:
        if len(content["instrument"]) != 6:
            remedy = "Write `[x, y, z, rx, ry, rz]` in m and rad."
            raise document.where("instrument").fault("six numbers are needed here", remedy)
        robot.instrument = np.array(content["instrument"], dtype=float)
    if content.get("geometry_std_m") is not None:
        if not robot.on_legs:
            what = f"a {robot.kind} has no legs whose geometry is identified"
            raise document.where("geometry_std_m").fault(what, "Take the key out.")
        robot.geometry_std = float(content["geometry_std_m"])


SAME = 0.02
"""Part of the robot's size by which places may differ: identified corrections of joints and links are far smaller."""
_TURNED = 0.3
"""rad by which angles are turned, so that a chain shows its axes."""
_COMMANDS = 4


def require_same_robot(robot: Robot, source: str, other: Robot, other_source: str, *, confirmed: bool = False) -> None:
    """Raise an `InputError` where two files are about different robots.

    Args:
        robot: of the first file.
        source: its name.
        other: of the second file.
        other_source: its name.
        confirmed: whether another geometry is meant; a robot with other commands or actuators is never the same.
    """
    if (robot.kind, robot.configuration, robot.actuators) != (other.kind, other.configuration, other.actuators):
        what = f"this is about a {_described(robot)}, and {other_source} about a {_described(other)}"
        raise InputError(what, where=source, remedy="Give files of one robot.")
    differs = None if confirmed else difference(robot, other)
    if differs is not None:
        what = f"this is about `{robot.name}`, and {other_source} about `{other.name}`, another geometry: {differs}"
        remedy = "Give files of one robot, or say that another one is meant (argument `other_robot`)."
        raise InputError(what, where=source, remedy=remedy)


def difference(robot: Robot, other: Robot) -> str | None:
    """What differs most between two robots of one kind, in words; None where they are one robot."""
    if robot.orientation != other.orientation:
        return f"the orientation is {robot.orientation} in one and {other.orientation} in the other"
    commands = _commands(robot)
    places, others = _places(robot, commands), _places(other, commands)
    if places.shape != others.shape:  # fixed joints may be drawn in one and not in the other
        places, others = (each.position(commands)[:, None] for each in (robot, other))
    apart = np.linalg.norm(places - others, axis=-1)
    size = float(np.linalg.norm(np.ptp(places.reshape(-1, places.shape[-1]), axis=0)))
    most = float(apart.max())
    if most <= SAME * size:
        return None
    named = _farthest_joint(robot, other)
    if named is not None:
        return named
    return f"at the same command their parts are up to {most * 1e3:.3g} mm apart"


def _described(robot: Robot) -> str:
    return f"{robot.kind} with {len(robot.stiffness)} actuators and the command {', '.join(robot.configuration)}"


def _commands(robot: Robot) -> FloatArray:
    """Configurations (c, n_q): the reference one, and others whose angles are turned."""
    generator = np.random.default_rng(0)
    turned = np.array([_TURNED if name.endswith("_rad") else 0.0 for name in robot.configuration])
    spread = generator.uniform(-1.0, 1.0, (_COMMANDS, len(turned)))
    spread[0] = 0.0
    commands: FloatArray = robot.reference_configuration() + spread * turned
    return commands


def _places(robot: Robot, commands: FloatArray) -> FloatArray:
    """Places of the platform or tip and of what is drawn, in O (m), shape (c, k, d)."""
    position = robot.position(commands)[:, None]
    drawing = robot.drawing(commands)
    return position if drawing is None else np.concatenate([position, drawing.points], axis=1)


def _farthest_joint(robot: Robot, other: Robot) -> str | None:
    """The joint of a robot on legs whose place differs most, in words; None without one."""
    if not (robot.on_legs and other.on_legs):
        return None
    closed, same = robot.inverse_kinematics, other.inverse_kinematics
    if closed.geometry_names != same.geometry_names:
        return None
    dimension = len(closed.home)
    differences = {"home": closed.home - same.home}
    for index, name in enumerate(closed.geometry_names):
        side, _, axis = name.rpartition(" ")
        place = differences.setdefault(side, np.zeros(dimension))
        place["xyz".index(axis)] = closed.geometry[index] - same.geometry[index]
    distances = {name: float(np.linalg.norm(value)) for name, value in differences.items()}
    worst = max(distances, key=lambda name: distances[name])
    if distances[worst] == 0.0:
        return None
    label = worst if worst == "home" else "the joint `" + worst + "`"
    return f"{label} is {distances[worst] * 1e3:.3g} mm apart"
