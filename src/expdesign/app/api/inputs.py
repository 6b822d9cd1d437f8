"""What the functions of the package take: a path, or what was loaded or computed before."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.robot import robot_findings
from expdesign.chain.models.model_file import Model, model_from_document, model_of_robot, read_model
from expdesign.chain.recordings.columns import COLUMNS
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError
from expdesign.io.kinds import kind_of
from expdesign.io.output import csv_text
from expdesign.io.schema import Section
from expdesign.io.table import Table, parse_table, read_table
from expdesign.io.written import Purpose
from expdesign.io.yaml_reader import YamlDocument, document_from_mapping, read_yaml
from expdesign.mechanics.robots.robot import RobotSection
from expdesign.mechanics.robots.robot_file import RobotFile, robot_from_document
from expdesign.report.result import PathLike, Result

RobotInput = PathLike | Mapping[str, Any] | RobotSection | RobotFile
ModelInput = PathLike | Model | Result
TruthInput = ModelInput | RobotFile | RobotSection | Mapping[str, Any]
TableInput = PathLike | pd.DataFrame | Result


def purpose_of(command: str, *inputs: object) -> Purpose:
    """The purpose of what a command writes from its main inputs, paths or objects; None is left out."""
    return Purpose(command, tuple(name for each in inputs for name in _names(each)))


def _names(given: object) -> list[str]:
    """Paths of an input, or a name and the digest of what is in memory only."""
    if given is None:
        return []
    if isinstance(given, str | Path):
        return [str(given)]
    if isinstance(given, list | tuple):
        return [name for each in given for name in _names(each)]
    if isinstance(given, RobotFile):
        given = given.document
    if isinstance(given, Result):
        rows = given.as_table()
        return [f"{given.purpose.command} {_digest('' if rows is None else csv_text(rows))}", *given.purpose.inputs]
    if isinstance(given, pd.DataFrame):
        return [f"frame {_digest(csv_text(given))}"]
    if isinstance(given, Section):
        given = given.as_mapping()
    if isinstance(given, Mapping):
        return [f"mapping {_digest(json.dumps(given, sort_keys=True, default=str))}"]
    if isinstance(given, Recordings):
        files = [given.source] if given.files is None else dict.fromkeys(given.files.tolist())
        return [file.partition(", sheet `")[0] for file in files]
    source = str(getattr(given, "source", type(given).__name__))
    content = getattr(given, "content", None) or getattr(given, "config", None)
    return [source] if content is None or Path(source).exists() else [f"{source} {_names(content)[0]}"]


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8")).hexdigest()[:12]


def document_of(content: PathLike | Mapping[str, Any] | Section, name: str) -> YamlDocument:
    """A YAML file, or a mapping or object with its content (relative paths are then those of the working folder)."""
    if isinstance(content, Mapping | Section):
        return document_from_mapping(content, name)
    return read_yaml(_path(content, name, f"a path, a mapping or an object that describes a {name}"))


def _path(given: object, name: str, known: str) -> Path:
    """A path; raises an `InputError` where something else was given."""
    if isinstance(given, str | Path):
        return Path(given)
    what = f"the {name} cannot be a `{type(given).__name__}`"
    raise InputError(what, remedy=f"Give {known}.")


def load_robot(robot: RobotInput) -> RobotFile:
    """The robot of a YAML file.

    Raises:
        InputError: the file is missing or wrong.
    """
    if isinstance(robot, RobotFile):
        return robot
    document = document_of(robot, "robot")
    machine = robot_from_document(document)
    say(robot_findings(machine), document.source)
    return RobotFile(machine, document)


def load_model(model: ModelInput) -> Model:
    """The model of a `model.yaml`, as `identify` and `diagnose` write it, or of a result.

    Raises:
        InputError: the file is missing or wrong.
    """
    if isinstance(model, Model):
        return model
    own = model.as_model() if isinstance(model, Result) else None
    if own is not None:
        return own
    return read_model(_path(model, "model", "the path of a model file, a `Model`, or what `identify` returned"))


def truth_of(truth: TruthInput) -> Model:
    """What really deflects: an identified model, or a robot whose stiffness is then exact."""
    if isinstance(truth, Model | Result):
        return load_model(truth)
    document = truth.document if isinstance(truth, RobotFile) else document_of(truth, "model")
    if kind_of(document.content) == "identified model":
        return model_from_document(document)
    return model_of_robot(robot_from_document(document), document)


def table_of(table: TableInput, name: str) -> Table:
    """A CSV file, or a frame or the rows of a result as the table that their CSV file gives; NaN is an empty cell."""
    rows = table.as_table() if isinstance(table, Result) else table
    if isinstance(rows, pd.DataFrame):
        return parse_table(csv_text(rows.astype(object).where(rows.notna(), "")), name, COLUMNS)
    path = _path(table if rows is None else rows, name, "a path, a frame, or a result that has rows")
    return read_table(path, COLUMNS)
