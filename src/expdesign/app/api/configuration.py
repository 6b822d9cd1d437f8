"""Run configurations that the functions of the package take, read; whatever takes none need not wait for planning."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from expdesign.app.api.inputs import TableInput, document_of, table_of
from expdesign.app.api.points_said import say_limits, say_unknown_columns
from expdesign.assurance.plausibility.configured import bound_findings, plan_findings
from expdesign.assurance.plausibility.finding import Implausibility, say
from expdesign.assurance.plausibility.problem import problem_findings
from expdesign.assurance.plausibility.robot import robot_findings
from expdesign.assurance.plausibility.targets import pose_findings
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.errors import ExpdesignError
from expdesign.io.table import Table
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.robot import LIMIT_MARGIN, Robot
from expdesign.mechanics.robots.robot_file import require_same_robot, robot_from_document
from expdesign.planning.plan import Plan, completed, read_plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.schema import RunSection
from expdesign.report.result import PathLike

Config = PathLike | Mapping[str, Any] | RunSection | DesignProblem


def problem_of(config: Config) -> DesignProblem:
    """A run configuration, read."""
    if isinstance(config, DesignProblem):
        return config
    return read_problem(document_of(config, "configuration"))


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


def read_problem(document: YamlDocument) -> DesignProblem:
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


@dataclass(frozen=True)
class GivenPlan:
    """A plan that was read for a configuration.

    Attributes:
        plan: its rows.
        table: as it stands in the file.
        complete: the table with every column that recordings need.
        points: its rows as they will be recorded, in the order of their sequence.
    """

    plan: Plan
    table: Table
    complete: Table
    points: LoadedPoints


def plan_of(plan: TableInput, problem: DesignProblem, name: str = "plan", *, within: bool = True) -> GivenPlan:
    """A plan as it stands in a file, with all that its recordings would be refused for, beside the configuration.

    Args:
        plan: the plan.
        problem: of the configuration.
        name: of a plan that is no file.
        within: whether its rows are to be measured under the configuration, and so within its limits; commands of
            targets are not.

    Raises:
        InputError: a column is missing, a cell is wrong or impossible, or a pose cannot be reached.
        SingularConfigurationError: the robot is singular, or nearly so, in one of the rows.
    """
    table, robot = table_of(plan, name), problem.loaded.robot
    given = read_plan(table, problem.loaded, problem.noise)
    complete = completed(table, given, problem.loaded)
    points = points_from_table(complete, robot, measured=True)
    say_unknown_columns(points)
    within = within and not table.has(f"target_{robot.configuration[0]}")
    say([finding for finding in plan_findings(points, problem) if within or finding.impossible], table.source)
    if within:
        require_reachable(problem, given, table)
        say(bound_findings(given, table.lines, problem), table.source)
    else:
        robot.jacobians(given.configurations).require_regular(table.where)
        say_limits(points, robot)
    return GivenPlan(given, table, complete, points)


def require_reachable(problem: DesignProblem, plan: Plan, table: Table) -> None:
    """Raise where a row is singular, or beyond the robot's limits."""
    robot = problem.loaded.robot
    robot.jacobians(plan.configurations).require_regular(table.where)
    rows, beyond = robot.beyond_limits(plan.configurations)
    if rows.size:
        raise table.fault(f"the pose is {beyond}", int(rows[0]), remedy="Choose a pose within them.")
    if problem.constraints is None:
        return
    collisions, seen = problem.constraints.collisions, problem.constraints.visibility
    if collisions is not None and ((excess := collisions.excess(robot, plan.configurations)) > LIMIT_MARGIN).any():
        row = int(np.argmax(excess))
        distance = 1e3 * (collisions.stated.clearance_m - excess[row])
        what = f"parts of the robot or its payload come within {distance:.3g} mm (`experiment.constraints.collisions`)"
        raise table.fault(what, row, remedy="Choose another pose, or correct the parts.")
    if seen is not None and ((hidden := seen.excess(robot, plan.configurations)) > LIMIT_MARGIN).any():
        row = int(np.argmax(hidden.max(axis=1)))
        what = f"{seen.sentence(hidden[row])} (`experiment.constraints.visibility`)"
        raise table.fault(what, row, remedy="Choose another pose, or correct station and reflectors.")


def target_findings(document: YamlDocument) -> list[Implausibility]:
    """What speaks against the robot and the targets' poses of a configuration that could not be read as a whole."""
    try:
        robot = robot_from_document(document.where("robot").written_out)
        poses = np.array([target["pose"] for target in document.content["targets"]], dtype=float)
    except (ExpdesignError, KeyError, TypeError, ValueError):
        return []
    found = robot_findings(robot)
    if poses.ndim == 2 and poses.shape[1] == len(robot.configuration):
        found += pose_findings(robot, poses, "targets")
    return found
