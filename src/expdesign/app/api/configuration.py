"""Run configurations that the functions of the package take, read; whatever takes none need not wait for planning."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from expdesign.app.api.inputs import PathLike, document_of
from expdesign.assurance.plausibility.finding import Finding, say
from expdesign.assurance.plausibility.problem import pose_findings, problem_findings
from expdesign.assurance.plausibility.robot import robot_findings
from expdesign.errors import ExpdesignError
from expdesign.io.yaml_reader import YamlDocument, read_yaml
from expdesign.mechanics.robots.robot_file import robot_from_document
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.schema import RunSection

Config = PathLike | Mapping[str, Any] | RunSection | DesignProblem


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
