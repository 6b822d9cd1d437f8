"""The notebook of the Python API runs from its first cell to its last, and shows what it is kept with."""

import re
from pathlib import Path
from typing import Any

import nbclient
import nbformat
import pytest

NOTEBOOK = Path(__file__).parents[2] / "docs" / "api.ipynb"
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def shown(notebook: Any) -> list[str]:
    """Text of the result of every cell, with numbers, rules and blanks made alike: other machines round otherwise."""
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    found = [output["data"]["text/plain"] for cell in code for output in cell.outputs]
    assert len(found) == len(code)  # one result a cell, no warning beside it
    return [re.sub(r"\s+", " ", NUMBER.sub("#", text)) for text in found]


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")  # of the kernel's client
def test_it_runs_and_shows_what_it_is_kept_with() -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)  # type: ignore[no-untyped-call]
    kept = shown(notebook)
    assert len(kept) > 8
    folder = {"metadata": {"path": str(NOTEBOOK.parent)}}
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources=folder).execute()
    assert shown(notebook) == kept
    assert "consistent" in str(kept)
