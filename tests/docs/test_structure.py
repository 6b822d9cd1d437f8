"""Data flow in one direction: what the drawing of docs/structure.md shows."""

from pathlib import Path

import pytest
from tests.docs.test_tutorial import loaded

SCRIPT = loaded("structure")


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
