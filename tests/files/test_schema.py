"""A section knows where it stands, whichever way it came to be."""

import pickle
from pathlib import Path

import pytest
from pydantic import Field

from expdesign.errors import InputError
from expdesign.io.schema import Number, Section, validate
from expdesign.io.yaml_reader import YamlDocument, parse_yaml

TEXT = """\
first: 1.0
shelves:
  - {width_m: 0.5}
  - {width_m: 0.7}
named:
  left:
    width_m: 0.2
from: 3
"""


class ShelfSection(Section):
    width_m: Number


class CupboardSection(Section):
    first: Number
    shelves: list[ShelfSection]
    named: dict[str, ShelfSection]
    start: int = Field(alias="from")


def cupboard() -> CupboardSection:
    return validate(CupboardSection, parse_yaml(TEXT, "cupboard.yaml", Path("/there")))


def test_every_section_knows_its_line() -> None:
    found = cupboard()
    assert str(found.where()) == "cupboard.yaml"
    assert str(found.where("from")) == "cupboard.yaml, line 8, from"
    assert str(found.shelves[1].where("width_m")) == "cupboard.yaml, line 4, shelves[1].width_m"
    assert str(found.where("shelves").where(1, "width_m")) == "cupboard.yaml, line 4, shelves[1].width_m"
    assert str(found.named["left"].where()) == "cupboard.yaml, line 6, named.left"
    with pytest.raises(InputError, match="there is no file"):
        _ = YamlDocument("a.yaml", Path("/there"), "x.csv").file


def test_what_is_raised_names_the_place() -> None:
    with pytest.raises(InputError, match="too wide") as caught:
        raise cupboard().shelves[0].where("width_m").fault("too wide", "Saw it off.")
    assert caught.value.where == "cupboard.yaml, line 3, shelves[0].width_m"


def test_the_place_is_no_part_of_what_a_section_says() -> None:
    read, made = cupboard().shelves[0], ShelfSection(width_m=0.5)
    assert read == made
    assert str(made.where("width_m")) == "Shelf, width_m"
    assert str(pickle.loads(pickle.dumps(read)).where("width_m")) == "Shelf, width_m"  # another process has no file


def test_other_values_leave_the_place() -> None:
    changed = cupboard().with_values(first=2.0)
    assert changed.first == 2.0
    assert str(changed.where("first")) == "cupboard.yaml, line 1, first"
