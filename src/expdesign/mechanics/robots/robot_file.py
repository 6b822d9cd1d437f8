"""Read a robot from its YAML file; the kinds are found by the files that lie beside this one."""

import difflib
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.io.kinds import require_kind
from expdesign.io.yaml_reader import YamlDocument, read_yaml
from expdesign.mechanics.robots.robot import Robot
from expdesign.plugins import implementations


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
        raise InputError("a mapping (`key: value`) is needed here", where=document.where(), remedy=remedy)
    kinds = {robot.kind: robot for robot in implementations("expdesign.mechanics.robots", Robot)}  # type: ignore[type-abstract]
    if "kind" not in content:
        remedy = f"Add `kind:` with one of {', '.join(sorted(kinds))}."
        raise InputError("the key is missing", where=document.where(("kind",)), remedy=remedy)
    kind = content["kind"]
    if not isinstance(kind, str) or kind not in kinds:
        near = difflib.get_close_matches(str(kind), list(kinds), n=1)
        remedy = f"Did you mean `{near[0]}`?" if near else f"Known kinds: {', '.join(sorted(kinds))}."
        raise InputError(f"unknown kind of robot `{kind}`", where=document.where(("kind",)), remedy=remedy)
    robot = kinds[kind].from_document(document)
    _read_instrument(robot, content, document)
    return robot


def _read_instrument(robot: Robot, content: dict[str, Any], document: YamlDocument) -> None:
    """Known places of markers and of the instrument, whose numbers the kind's own section has checked."""
    markers: dict[str, FloatArray] = {}
    for name, place in (content.get("markers") or {}).items():
        if len(place) != 3:
            where = document.where(("markers", name))
            raise InputError("three coordinates are needed here", where=where, remedy="Write `[x, y, z]` in m.")
        markers[str(name)] = np.array(place, dtype=float)
    robot.markers = markers
    if content.get("instrument") is not None:
        if len(content["instrument"]) != 6:
            where = document.where(("instrument",))
            remedy = "Write `[x, y, z, rx, ry, rz]` in m and rad."
            raise InputError("six numbers are needed here", where=where, remedy=remedy)
        robot.instrument = np.array(content["instrument"], dtype=float)
    if content.get("geometry_std_m") is not None:
        if not robot.on_legs:
            what = f"a {robot.kind} has no legs whose geometry is identified"
            raise InputError(what, where=document.where(("geometry_std_m",)), remedy="Take the key out.")
        robot.geometry_std = float(content["geometry_std_m"])
