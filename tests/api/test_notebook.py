"""The notebooks of the Python API and of the machine run from first cell to last, and show what they are kept with."""

import re
from pathlib import Path
from typing import Any

import nbclient
import nbformat
import pytest

from tests.docs.test_tutorial import NUMBER

DOCS = Path(__file__).parents[2] / "docs"


def shown(notebook: Any) -> list[str]:
    """Text of the result of every cell."""
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    found = [output["data"]["text/plain"] for cell in code for output in cell.outputs]
    assert len(found) == len(code)  # one result a cell, no warning beside it
    return found


def alike(texts: list[str]) -> list[str]:
    """Numbers, rules and blanks made alike: another linear algebra rounds otherwise."""
    return [re.sub(r"\s+", " ", NUMBER.sub("#", text)) for text in texts]


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")  # of the kernel's client
@pytest.mark.parametrize("name", ["api", "on-the-machine"])
def test_it_runs_and_shows_what_it_is_kept_with(name: str) -> None:
    notebook = nbformat.read(DOCS / f"{name}.ipynb", as_version=4)  # type: ignore[no-untyped-call]
    kept = shown(notebook)
    folder = {"metadata": {"path": str(DOCS)}}
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources=folder).execute()
    assert alike(shown(notebook)) == alike(kept)
    if name == "api":
        assert len(kept) > 8
        assert "consistent" in str(kept)
    else:
        bent, corrected = (float(text) for text in NUMBER.findall(kept[-1].splitlines()[-1])[-2:])
        assert bent > 10.0
        assert corrected < 0.3
