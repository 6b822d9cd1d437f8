"""The notebook that goes to the machine runs, and shows what it is kept with."""

import re
from pathlib import Path
from typing import Any

import nbclient
import nbformat
import pytest

NOTEBOOK = Path(__file__).parents[2] / "docs" / "on-the-machine.ipynb"
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def shown(notebook: Any) -> list[str]:
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    found = [output["data"]["text/plain"] for cell in code for output in cell.outputs]
    assert len(found) == len(code)  # one result a cell, no warning beside it
    return found


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")  # of the kernel's client
def test_it_runs_and_shows_what_it_is_kept_with() -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)  # type: ignore[no-untyped-call]
    kept = shown(notebook)
    folder = {"metadata": {"path": str(NOTEBOOK.parent)}}
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources=folder).execute()
    for before, after in zip(kept, shown(notebook), strict=True):
        # Numbers may differ in their last digits where another linear algebra computes them.
        assert re.sub(r"\s+", " ", NUMBER.sub("#", before)) == re.sub(r"\s+", " ", NUMBER.sub("#", after))
    bent, corrected = (float(text) for text in NUMBER.findall(kept[-1].splitlines()[-1])[-2:])
    assert bent > 10.0
    assert corrected < 0.3
