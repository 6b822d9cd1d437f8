"""`schema`: the keys of a file, for editors and for the documentation."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

from pydantic import BaseModel

from expdesign.app.api.arguments import named_arguments
from expdesign.app.sweeps.runs import SweepSection
from expdesign.errors import InputError
from expdesign.io.nearest import nearest
from expdesign.io.units import QUANTITY
from expdesign.mechanics.robots.robot import Robot, RobotSection
from expdesign.planning.schema import RunSection
from expdesign.plugins import implementations

KINDS = ("configuration", "robot", "sweep")
"""Kinds of files that have a schema."""


@named_arguments
def schema(kind: str = "configuration", robots: Sequence[str] | None = None) -> dict[str, Any]:
    """Give the JSON schema of a kind of file, with which an editor completes keys and marks mistakes.

    Every key has its type, meaning, unit and default.

    Args:
        kind: `configuration`, `robot` or `sweep`.
        robots: kinds of robots that the schema of robots has; all that there are if left out.

    Raises:
        InputError: there is no such kind.

    Command:
        expdesign schema configuration > configuration.schema.json
    """
    if kind not in KINDS:
        raise InputError(f"there is no schema of `{kind}`", remedy=nearest(kind, KINDS))
    if kind == "robot":
        content = _robots(robot_sections(robots))
    else:
        sections: dict[str, type[BaseModel]] = {"configuration": RunSection, "sweep": SweepSection}
        content = sections[kind].model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | _with_texts(content)


def _with_texts(schema: Any) -> Any:
    """The schema in which a number may also be a text of number and unit (`0.5 mm`)."""
    if isinstance(schema, list):
        return [_with_texts(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if schema.get("type") != "number":
        return {key: _with_texts(value) for key, value in schema.items()}
    outer = {key: value for key, value in schema.items() if key in ("title", "default", "description")}
    inner = {key: value for key, value in schema.items() if key not in outer}
    return outer | {"anyOf": [inner, {"type": "string", "pattern": f"^{QUANTITY.pattern}$"}]}


def robot_sections(kinds: Sequence[str] | None = None) -> dict[str, type[RobotSection]]:
    """The section that reads the robot file of each kind: the one that stands beside the kind's class."""
    found: dict[str, type[RobotSection]] = {}
    for robot in implementations("expdesign.mechanics.robots", Robot):  # type: ignore[type-abstract]
        module = importlib.import_module(robot.__module__)
        if kinds is None or robot.kind in kinds:
            classes = [item for item in vars(module).values() if isinstance(item, type)]
            own = [item for item in classes if item.__module__ == module.__name__ and issubclass(item, RobotSection)]
            found |= {robot.kind: own[0]} if own else {}
    return dict(sorted(found.items()))


def _robots(sections: dict[str, type[RobotSection]]) -> dict[str, Any]:
    definitions: dict[str, Any] = {}
    for kind, section in sections.items():
        content = section.model_json_schema(ref_template="#/$defs/{model}")
        definitions |= content.pop("$defs", {})
        content["properties"]["kind"] |= {"const": kind}
        definitions[section.__name__] = content
    references = [{"$ref": f"#/$defs/{section.__name__}"} for section in sections.values()]
    return {"$defs": definitions, "anyOf": references, "title": "Robot"}
