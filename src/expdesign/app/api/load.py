"""What is read back: robots, configurations, models and recordings by what a file holds, results by their folder."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from expdesign.app.api.inputs import RobotInput
from expdesign.app.api.recorded import read_recordings
from expdesign.chain.models.model_file import Model, model_from_document, read_model
from expdesign.chain.recordings.columns import COLUMNS
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError
from expdesign.io.kinds import kind_of
from expdesign.io.table import is_table_name, read_table
from expdesign.io.written import RECORD, Purpose, entries
from expdesign.io.yaml_reader import YamlDocument, read_text, read_yaml
from expdesign.mechanics.robots.robot_file import RobotFile, robot_from_document
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.report.result import PathLike, Result, numeric
from expdesign.report.said import Said

Loaded = RobotFile | DesignProblem | Model | Recordings | pd.DataFrame


def load(file: PathLike, robot: RobotInput | None = None) -> Loaded:
    """Read a file.

    Args:
        file: a robot, a run configuration or an identified model (YAML), or a table (CSV).
        robot: the robot that was recorded, for a table of recordings.

    Returns:
        `RobotFile`, `DesignProblem` or `Model`; of a table, `Recordings` where a robot is given, else a frame.

    Raises:
        InputError: the file is missing, wrong, or none of these.
    """
    path = Path(file)
    if is_table_name(path):
        return numeric(read_table(path, COLUMNS).frame) if robot is None else read_recordings(path, robot)
    return read_document(read_yaml(path), problem_from_document)


def read_document(
    document: YamlDocument, problem_of: Callable[[YamlDocument], DesignProblem]
) -> RobotFile | DesignProblem | Model:
    """What a YAML file holds; `problem_of` reads a run configuration.

    Raises:
        InputError: the file is wrong, or none of these.
    """
    kind = kind_of(document.content)
    if kind == "identified model":
        return model_from_document(document)
    if kind == "robot":
        return RobotFile(robot_from_document(document), document)
    if kind == "run configuration" or (isinstance(document.content, dict) and "schema_version" in document.content):
        return problem_of(document)
    remedy = "A robot and a model have the key `kind`, a run configuration `experiment`, a sweep `vary`."
    raise InputError("neither a robot, a run configuration nor a model", where=document.source, remedy=remedy)


MODEL = "model.yaml"
_ROWS = ("plan.csv", "sheet.csv")
"""Tables that stand for the result of several tables."""


@dataclass(frozen=True, repr=False)
class SavedResult(Result):
    """A result as its files hold it; functions take it where they take the result itself.

    Attributes:
        folder: where the files lie.
        written: content of its JSON file (`run.json`, `identification.json`, ...); empty where it has none.
        tables: content of its CSV files by their names without ending.
        model: the model that was identified, or None.
    """

    folder: Path
    written: dict[str, Any]
    tables: dict[str, pd.DataFrame]
    model: Model | None

    @property
    def said(self) -> Said:
        held = [*self.tables, *(["model"] if self.model is not None else [])]
        return Said(f"{self.purpose.command} in {self.folder}: {', '.join(held)}", document=lambda: self.written)

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
    records = [path for path in found if path.suffix == ".json"]
    # Inputs are named relative to the folder; the name of what is no file stays.
    inputs = tuple(str((place / one).resolve()) if (place / one).exists() else one for one in about["inputs"])
    return SavedResult(
        place,
        json.loads(read_text(records[0])) if records else {},
        {path.stem: numeric(read_table(path, COLUMNS).frame) for path in found if path.suffix == ".csv"},
        read_model(place / MODEL) if MODEL in names and (place / MODEL).exists() else None,
        purpose=Purpose(about["command"], inputs),
    )
