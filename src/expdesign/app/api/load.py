"""`load`: a robot, a configuration, a model, or recordings, by what the file holds."""

from pathlib import Path

import pandas as pd

from expdesign.app.api.inputs import ModelInput, RobotFile, RobotInput, model_of, robot_of
from expdesign.app.api.recorded import RecordingsInput, recordings_of
from expdesign.app.api.result import PathLike, numeric
from expdesign.chain.models.model_file import Model, model_from_document
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError
from expdesign.io.kinds import kind_of
from expdesign.io.table import is_table_name, read_table
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.robot_file import robot_from_document
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document

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
        return numeric(read_table(path).frame) if robot is None else read_recordings(path, robot)
    document = read_yaml(path)
    kind = kind_of(document.content)
    if kind == "identified model":
        return model_from_document(document)
    if kind == "run configuration":
        return problem_from_document(document)
    if kind == "robot":
        return RobotFile(robot_from_document(document), document)
    remedy = "A robot and a model have the key `kind`, a run configuration `experiment`."
    raise InputError("neither a robot, a run configuration nor a model", where=str(path), remedy=remedy)


def load_robot(file: RobotInput) -> RobotFile:
    """The robot of a YAML file.

    Raises:
        InputError: the file is missing or wrong.
    """
    return robot_of(file)


def load_model(file: ModelInput) -> Model:
    """The model of a `model.yaml`, as `identify` and `diagnose` write it.

    Raises:
        InputError: the file is missing or wrong.
    """
    return model_of(file)


def read_recordings(recordings: RecordingsInput, robot: RobotInput) -> Recordings:
    """Recordings of a robot, from one or more files or from a frame.

    Raises:
        InputError: a file is missing or wrong.
    """
    return recordings_of(recordings, robot_of(robot))
