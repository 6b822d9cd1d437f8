"""Run configurations that the functions of the package take, read; whatever takes none need not wait for planning."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from expdesign.app.api.inputs import document_of
from expdesign.app.api.result import PathLike
from expdesign.assurance.plausibility.finding import Implausibility, say
from expdesign.assurance.plausibility.problem import problem_findings
from expdesign.assurance.plausibility.robot import robot_findings
from expdesign.assurance.plausibility.targets import pose_findings
from expdesign.errors import ExpdesignError
from expdesign.io.yaml_reader import YamlDocument, read_yaml
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import require_same_robot, robot_from_document
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.schema import RunSection

Config = PathLike | Mapping[str, Any] | RunSection | DesignProblem


def problem_of(config: Config) -> DesignProblem:
    """A run configuration, read."""
    if isinstance(config, DesignProblem):
        return config
    return checked_problem(document_of(config, "configuration"))


def problem_of_robot(config: Config | None, robot: Robot, source: str, *, confirmed: bool) -> DesignProblem | None:
    """A run configuration of a robot, read; None where there is none.

    Args:
        config: run configuration.
        robot: that it has to be about.
        source: the robot's file, for messages.
        confirmed: whether a configuration of another geometry is meant.

    Raises:
        InputError: the configuration is wrong, or of another robot.
    """
    if config is None:
        return None
    problem = problem_of(config)
    require_same_robot(problem.loaded.robot, problem.source, robot, source, confirmed=confirmed)
    return problem


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


def target_findings(document: YamlDocument) -> list[Implausibility]:
    """What speaks against the robot and the targets' poses of a configuration that could not be read as a whole."""
    try:
        robot = document.content["robot"]
        named = isinstance(robot, str)
        robot = robot_from_document(read_yaml(document.file(robot)) if named else document.part("robot"))
        poses = np.array([target["pose"] for target in document.content["targets"]], dtype=float)
    except (ExpdesignError, KeyError, TypeError, ValueError):
        return []
    found = robot_findings(robot)
    if poses.ndim == 2 and poses.shape[1] == len(robot.configuration):
        found += pose_findings(robot, poses, "targets")
    return found
