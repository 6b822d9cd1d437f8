"""The gallery's notebooks are short, kept with their outputs, and print the same when they run again."""

import re
from pathlib import Path
from typing import Any

import pytest

from tests.docs.test_tutorial import loaded

ROOT = Path(__file__).parents[2]
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?|NaN")
LARGEST = 100_000


GALLERY = loaded("gallery")


def codes(notebook: Any) -> list[Any]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def printed(notebook: Any) -> list[str]:
    """Texts of all outputs, numbers made alike: another linear algebra leads to another optimum."""
    outputs = [output for cell in codes(notebook) for output in cell.outputs]
    texts = [output.get("data", {}).get("text/plain", output.get("text", "")) for output in outputs]
    return [re.sub(r"\s+", " ", NUMBER.sub("#", text)) for text in texts if text]


def test_there_are_ten_and_the_index_shows_each() -> None:
    paths = GALLERY.notebooks()
    assert len(paths) >= 10
    assert (GALLERY.FOLDER / "index.md").read_text(encoding="utf-8") == GALLERY.index()
    for path in paths:
        assert (GALLERY.FOLDER / "thumbnails" / f"{path.stem}.png").stat().st_size < LARGEST


@pytest.mark.parametrize("path", GALLERY.notebooks(), ids=lambda path: path.stem)
def test_a_notebook_is_short_was_run_and_says_what_it_needs(path: Path) -> None:
    notebook = GALLERY.read(path)
    lines = sum(len(cell.source.splitlines()) for cell in codes(notebook))
    assert lines <= GALLERY.MOST_LINES
    assert [cell.execution_count for cell in codes(notebook)] == list(range(1, len(codes(notebook)) + 1))
    assert len(GALLERY.picture_of(notebook)) < LARGEST
    assert printed(notebook)
    assert "expdesign[studies]" in notebook.cells[0].source
    page = GALLERY.page(notebook, path.stem)
    assert f"]({path.stem}.png)" in page
    assert notebook.cells[0].source in page


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")  # of the kernel's client
@pytest.mark.parametrize("path", GALLERY.notebooks(), ids=lambda path: path.stem)
def test_a_notebook_prints_the_same_again(path: Path) -> None:
    pytest.importorskip("matplotlib", reason="the gallery needs the extra `studies`")
    assert printed(GALLERY.executed(path)) == printed(GALLERY.read(path))
