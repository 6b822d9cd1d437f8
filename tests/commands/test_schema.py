"""The schema for editors accepts every file that the program accepts, and what is kept in docs is current."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import expdesign as xd
from expdesign.app.api.schema import KINDS, robot_sections
from expdesign.app.templates import kinds
from expdesign.io.output import json_text
from expdesign.io.yaml_reader import read_yaml
from tests.commands.calls import Printed, call

ROOT = Path(__file__).parents[2]
FILES = [file for file in sorted((ROOT / "configs").glob("*.yaml")) if not file.name.startswith("study")]
FILES += [file for files in kinds().values() for file in files if file.name in ("config.yaml", "sweep.yaml")]
ROBOTS = sorted((ROOT / "configs/robots").glob("*.yaml"))
KEPT = ("bipod", "body", "hexapod", "serial")
"""Kinds of robots that the kept schema has; a new kind need not be added to it."""


@cache
def schema(kind: str) -> Any:
    return xd.schema(kind)


def properties(kind: str) -> list[tuple[str, str, dict[str, Any]]]:
    """Section, key and schema of every key of a kind of file."""
    content = xd.schema(kind, KEPT)
    sections = {"": content} | content["$defs"]
    return [
        (name, key, value) for name, section in sections.items() for key, value in section.get("properties", {}).items()
    ]


@pytest.mark.parametrize("file", FILES + ROBOTS, ids=lambda file: f"{file.parent.name}-{file.stem}")
def test_it_accepts_the_files_that_come_with_the_program(file: Path) -> None:
    content = read_yaml(file).content
    kind = "robot" if file in ROBOTS else "sweep" if "vary" in content else "configuration"
    jsonschema.validate(content, schema(kind))


def test_it_marks_mistakes_in_robots() -> None:
    content = read_yaml(ROBOTS[0]).content
    for changed in (content | {"kind": "hexpod"}, content | {"hom": [0, 0]}, content | {"actuator_stiffness": [0.0]}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(changed, schema("robot"))


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_has_a_description(kind: str) -> None:
    found = properties(kind)
    assert len(found) > 5
    assert not [(section, key) for section, key, value in found if not value.get("description", "").strip()]


def test_every_robot_has_a_section() -> None:
    assert set(KEPT) <= set(robot_sections())


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("experiment", "measurments"), 3),
        (("experiment", "measurements"), 0),
        (("experiment", "load", "mass_kg"), [1, 2, 3]),
        (("experiment", "load", "mass_kg"), {"choices": []}),
        (("optimiser", "seed"), "one"),
        (("aggregate",), "median"),
        (("targets",), []),
    ],
)
def test_it_marks_mistakes(place: tuple[str, ...], value: object) -> None:
    content = read_yaml(ROOT / "configs/hexapod-h1.yaml").content
    part = content
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, schema("configuration"))


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_kept_is_current(kind: str, capsys: Printed) -> None:
    """Make it again with `expdesign schema KIND > docs/schema/KIND.schema.json`."""
    assert call("schema", kind) == 0
    assert json.loads(capsys.readouterr().out) == schema(kind)
    kept = (ROOT / "docs/schema" / f"{kind}.schema.json").read_text(encoding="utf-8")
    assert kept == json_text(xd.schema(kind, KEPT))


def test_numbers_may_be_texts_with_their_units(capsys: Printed) -> None:
    assert call("schema", "configuration") == 0
    printed = json.loads(capsys.readouterr().out)
    content = read_yaml(ROOT / "configs/hexapod-h1.yaml").content
    content["experiment"]["load"]["com_z_m"] = "120 mm"
    content["experiment"]["poses"]["bounds"]["x_m"] = ["-30 mm", 0.03]
    jsonschema.validate(content, printed)
    content["experiment"]["load"]["com_z_m"] = "twelve"
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, printed)
