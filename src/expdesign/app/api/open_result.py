"""`open_result`: what a command or `save` wrote into a folder, for use in the place of the result."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from expdesign.app.api.result import PathLike, Result, numeric
from expdesign.chain.models.model_file import Model, read_model
from expdesign.errors import InputError
from expdesign.io.table import read_table
from expdesign.io.written import RECORD, Purpose, entries
from expdesign.io.yaml_reader import read_text

MODEL = "model.yaml"
_PAGE = ("report.json",)
"""JSON files that hold a page, not a result."""
_ROWS = ("plan.csv", "sheet.csv")
"""Tables that stand for the result of several tables."""


@dataclass(frozen=True, repr=False)
class SavedResult(Result):
    """A result as its files hold it; functions take it where they take the result itself.

    Attributes:
        folder: where the files lie.
        record: content of its JSON file (`run.json`, `identification.json`, ...); empty where it has none.
        tables: content of its CSV files by their names without ending.
        model: the model that was identified, or None.
    """

    folder: Path
    record: dict[str, Any]
    tables: dict[str, pd.DataFrame]
    model: Model | None

    @property
    def summary(self) -> str:
        """The command, and what there is."""
        held = [*self.tables, *(["model"] if self.model is not None else [])]
        return f"{self.purpose.command} in {self.folder}: {', '.join(held)}"

    def as_table(self) -> pd.DataFrame | None:
        """The plan or sheet, or the only table."""
        first = next((self.tables[Path(name).stem] for name in _ROWS if Path(name).stem in self.tables), None)
        return next(iter(self.tables.values())) if first is None and len(self.tables) == 1 else first

    def as_model(self) -> Model | None:
        """The model that was identified."""
        return self.model


def open_result(folder: PathLike) -> SavedResult:
    """Read what `save`, or a command with `--out`, wrote into a folder.

    Args:
        folder: with the files of one result.

    Returns:
        The record, tables and model of the command that wrote last into it.

    Raises:
        InputError: nothing was written there, or a file is wrong.
    """
    place = Path(folder)
    written = entries(place)
    if not written:
        remedy = f"Name a folder that `save` or `--out` filled (it has a file `{RECORD}`)."
        raise InputError("no result is in this folder", where=str(folder), remedy=remedy)
    last = max(written, key=lambda name: (place / name).stat().st_mtime if (place / name).exists() else 0.0)
    about = written[last]
    names = [name for name, entry in written.items() if entry["command"] == about["command"]]
    found = [place / name for name in names if (place / name).exists()]
    records = [path for path in found if path.suffix == ".json" and path.name not in _PAGE]
    return SavedResult(
        place,
        json.loads(read_text(records[0])) if records else {},
        {path.stem: numeric(read_table(path).frame) for path in found if path.suffix == ".csv"},
        read_model(place / MODEL) if MODEL in names and (place / MODEL).exists() else None,
        purpose=Purpose(about["command"], tuple(about.get("paths", about["inputs"]))),
    )
