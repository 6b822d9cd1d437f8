"""What the functions of the package take: a path, or what was loaded or computed before."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from expdesign.design.problem import DesignProblem
from expdesign.design.problem_file import problem_from_document
from expdesign.errors import ExpdesignError
from expdesign.files.csv_writer import csv_text
from expdesign.files.table import Table, parse_table, read_table
from expdesign.files.yaml_reader import YamlDocument, read_yaml
from expdesign.files.yaml_units import with_si_numbers
from expdesign.models.model_file import Model, model_from_document, model_of_robot, read_model
from expdesign.plausibility.finding import Finding, say
from expdesign.plausibility.problem import pose_findings, problem_findings
from expdesign.plausibility.robot import robot_findings
from expdesign.robots.robot import Robot
from expdesign.robots.robot_file import robot_from_document

PathLike = str | Path


@dataclass(frozen=True)
class RobotFile:
    """A robot with the file that describes it.

    Attributes:
        robot: for computing.
        document: the content of its file.
    """

    robot: Robot
    document: YamlDocument


Config = PathLike | Mapping[str, Any] | DesignProblem
RobotInput = PathLike | Mapping[str, Any] | RobotFile
ModelInput = PathLike | Model
TableInput = PathLike | pd.DataFrame


def document_of(content: PathLike | Mapping[str, Any], name: str) -> YamlDocument:
    """A YAML file, or a mapping with its content (whose relative paths are then those of the working folder)."""
    if isinstance(content, Mapping):
        return with_si_numbers(YamlDocument(name, Path(), dict(content)))
    return read_yaml(Path(content))


def problem_of(config: Config) -> DesignProblem:
    """A run configuration, read."""
    if isinstance(config, DesignProblem):
        return config
    return checked_problem(document_of(config, "configuration"))


def checked_problem(document: YamlDocument) -> DesignProblem:
    """The problem of a run configuration, of which physics has been asked what it says.

    Raises:
        InputError: the configuration is wrong, or impossible.
    """
    try:
        problem = problem_from_document(document)
    except ExpdesignError:
        # A target beyond the limits, say: units may be the reason, which the message that follows cannot know.
        say(target_findings(document), document.source)
        raise
    say(problem_findings(problem), problem.source)
    return problem


def target_findings(document: YamlDocument) -> list[Finding]:
    """What speaks against the robot and the targets' poses of a configuration that could not be read as a whole."""
    try:
        robot = robot_from_document(_robot_document(document))
        poses = np.array([target["pose"] for target in document.content["targets"]], dtype=float)
    except (ExpdesignError, KeyError, TypeError, ValueError):
        return []
    found = robot_findings(robot)
    if poses.ndim == 2 and poses.shape[1] == len(robot.configuration):
        found += pose_findings(robot, poses, "targets")
    return found


def _robot_document(document: YamlDocument) -> YamlDocument:
    robot = document.content["robot"]
    return read_yaml(document.folder / robot) if isinstance(robot, str) else document.part("robot")


def robot_of(robot: RobotInput) -> RobotFile:
    """A robot file, read."""
    if isinstance(robot, RobotFile):
        return robot
    document = document_of(robot, "robot")
    machine = robot_from_document(document)
    say(robot_findings(machine), document.source)
    return RobotFile(machine, document)


def model_of(model: ModelInput) -> Model:
    """A model file, read."""
    return model if isinstance(model, Model) else read_model(Path(model))


def truth_of(truth: ModelInput) -> Model:
    """What really deflects: an identified model, or a robot file whose stiffness is then exact."""
    if isinstance(truth, Model):
        return truth
    document = read_yaml(Path(truth))
    if isinstance(document.content, dict) and document.content.get("kind") == "model":
        return model_from_document(document)
    return model_of_robot(robot_from_document(document), document)


def table_of(table: TableInput, name: str) -> Table:
    """A CSV file, or a frame as the table that its CSV file would give."""
    return parse_table(csv_text(table), name) if isinstance(table, pd.DataFrame) else read_table(Path(table))


def numeric(text: pd.DataFrame) -> pd.DataFrame:
    """A frame whose cells are as in a CSV file, with the columns that hold numbers only as numbers, exactly as read."""
    return pd.DataFrame({name: _numbers(text[name].tolist()) for name in text.columns})


def _numbers(cells: list[Any]) -> list[Any]:
    for kind in (int, float):
        try:
            return [float("nan") if kind is float and cell == "" else kind(cell) for cell in _texts(cells)]
        except ValueError:
            continue
    return cells


def _texts(cells: list[Any]) -> list[str]:
    return [repr(float(cell)) if isinstance(cell, float) else str(cell) for cell in cells]
