"""Data flow in one direction: what the drawing of docs/structure.md shows."""

import re
from collections import defaultdict
from pathlib import Path

import pytest

from tests.docs.test_tutorial import loaded

SCRIPT = loaded("structure")
ROOT = Path(__file__).parents[2]


def test_nothing_is_imported_against_the_flow() -> None:
    found = SCRIPT.structure()
    assert tuple(found.packages) == SCRIPT.ORDER
    assert found.against == []


@pytest.mark.parametrize("place", ["mechanics/wrong.py", "planning/criteria/wrong.py"])
def test_an_import_against_the_flow_is_seen(tmp_path: Path, place: str) -> None:
    for name in ("estimation", "report"):
        (tmp_path / "expdesign" / name).mkdir(parents=True)
        (tmp_path / "expdesign" / name / "one.py").write_text("from expdesign.io import table\n", encoding="utf-8")
    file = tmp_path / "expdesign" / place
    file.parent.mkdir(parents=True)
    file.write_text("def f() -> None:\n    from expdesign.report.one import g\n", encoding="utf-8")
    found = SCRIPT.structure(tmp_path)
    assert found.against == [(Path(place).parts[0], "report")]
    assert "#c0392b" in SCRIPT.drawing(found)


def test_a_class_name_stands_for_one_thing() -> None:
    """Except what configurations and robot files say, as objects of the API."""
    found = defaultdict(set)
    for path in (ROOT / "src" / "expdesign").rglob("*.py"):
        for name in re.findall(r"^ *class (\w+)", path.read_text(encoding="utf-8"), flags=re.MULTILINE):
            if path.name != "objects.py":
                found[name].add(path)
    assert {name: paths for name, paths in found.items() if len(paths) > 1} == {}
