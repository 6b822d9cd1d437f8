"""What `check` returns, and says of what it has read: a robot, a model, a configuration, a sweep or recordings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from expdesign.chain.recordings.recordings import Recordings
from expdesign.counted import counted
from expdesign.errors import InputError
from expdesign.estimation.identify import Identification
from expdesign.io.written import Purpose
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import Feasibility
from expdesign.report.fit_texts import identified_sentences
from expdesign.report.page import Page
from expdesign.report.remark_texts import sentences
from expdesign.report.result import PAGE, FolderResult
from expdesign.report.robot_section import actuator_tables, problem_report, robot_report
from expdesign.report.robot_view import at_rest
from expdesign.report.said import Said

_FEW = 0.01
"""Share of reachable poses below which the units of `experiment.poses` are probably wrong."""


@dataclass(frozen=True, repr=False)
class CheckResult(FolderResult):
    """What was checked and can be used.

    Attributes:
        stated: what is said of it.
        read: what was read: a robot or a configuration's problem, which the page draws, or recordings; None of a sweep.
        doubts: the notes for which `--strict` refuses it.
        feasibility: shares of the design space of a configuration that can be reached, and that identify what the
            targets need; else None.
        identification: of the base model from recordings, or None.
        doubted: whether something is doubtful, and that was not to be.
    """

    FILES: ClassVar = PAGE
    stated: Said
    read: Robot | DesignProblem | Recordings | None
    doubts: Sequence[str]
    feasibility: Feasibility | None = None
    identification: Identification | None = None
    doubted: bool = False

    @property
    def said(self) -> Said:
        return self.stated

    @property
    def refused(self) -> bool:
        """Whether none of the poses of a configuration, drawn at random, can be reached; or it is `doubted`."""
        return self.doubted or (self.feasibility is not None and self.feasibility.reachable == 0.0)

    def page(self) -> Page:
        """The robot, drawn with its legs or joints numbered, at rest and at the targets of a configuration.

        Raises:
            InputError: there is none in what was checked.
        """
        if isinstance(self.read, DesignProblem):
            return problem_report(self.read, self.summary)
        if self.read is None or isinstance(self.read, Recordings):
            remedy = "Give a robot, a model or a run configuration; of others no page is made."
            raise InputError("there is no robot to draw in this file", where=_file(self.purpose), remedy=remedy)
        return robot_report(self.read, self.summary, at_rest(self.read))


def _file(purpose: Purpose) -> str:
    return ", ".join(purpose.inputs)


def checked_robot(purpose: Purpose, source: str, robot: Robot, effects: int | None = None) -> CheckResult:
    """A robot, or a model of it with effects: what it is, and which leg or joint is which; `source` is its file."""
    reference = robot.reference_configuration()
    beyond = float(robot.limit_excess(reference)) > 0.0
    usable = "cannot be at its reference pose" if beyond else "is usable"
    summary = (
        f"{robot.kind} `{robot.name}` with {counted(len(robot.stiffness), 'actuator')} {usable} (scaled condition "
        f"number {float(robot.jacobians(reference).condition):.3g} at its reference pose)."
    )
    if effects is not None:
        summary = f"identified model with {counted(effects, 'effect')} of a {summary}"
    notes = [f"{source}: at the reference pose {robot.limit_message(reference)}"] if beyond else []
    stated = Said(summary, [f"{_file(purpose)}: {summary}"], notes, tables=actuator_tables(robot))
    return CheckResult(stated, robot, notes, purpose=purpose)


def checked_problem(purpose: Purpose, problem: DesignProblem, found: Feasibility) -> CheckResult:
    """A configuration: what it asks for, how much of its design space serves, and how its robot was found."""
    space = problem.space
    continuous = int((~space.discrete).sum())
    discrete = int(space.choices.sum())
    measurements = counted(space.measurements, "measurement")
    if problem.budget is not None:  # what fits into it
        number = counted(problem.budget.largest, "measurement")
        measurements = f"at most {number}, as many as {problem.budget.minutes:g} minutes allow,"
    share = f"{100.0 * found.identifying:.0f} % of the random plans that were tried determine"
    identifying = "every random plan that was tried determines" if found.identifying == 1.0 else share
    summary = (
        f"{problem.loaded.robot.kind} `{problem.loaded.robot.name}`, {measurements} with "
        f"{continuous} continuous and {discrete} discrete variables each, "
        f"{counted(len(problem.targets.weights), 'target')}; {100.0 * found.reachable:.0f} % of the poses can be "
        f"reached, {identifying} what the targets need."
    )
    doubts = []
    if found.reachable < _FEW:
        what = "hardly any pose in `experiment.poses` can be reached; check their units (m, rad)"
        doubts.append(f"{problem.source}: {what}")
    origin = [] if problem.found is None else [f"{problem.source}: {problem.found.note}"]
    stated = Said(summary, [f"{_file(purpose)}: {summary}"], [*doubts, *origin])
    return CheckResult(stated, problem, doubts, found, purpose=purpose)


def checked_sweep(purpose: Purpose, runs: int, keys: Sequence[str]) -> CheckResult:
    """A sweep: how many runs there are, over which keys."""
    summary = f"sweep of {counted(runs, 'run')} over {', '.join(keys)}"
    return CheckResult(Said(summary, [f"{_file(purpose)}: {summary}"]), None, (), purpose=purpose)


def checked_recordings(
    purpose: Purpose, structure: str, read: Recordings | None, found: Identification | None
) -> CheckResult:
    """Recordings: what they hold, and what they identify; their mistakes are warned of before.

    Args:
        purpose: of the check.
        structure: rows, series and measured components, in words.
        read: recordings of the robot that was named, or None where none was.
        found: identification of the base model, or None where there is nothing to identify.
    """
    details = [] if found is None else identified_sentences(found)
    if read is None:
        details = ["Give the robot (argument `robot`) to see what they identify."]
    notes = [] if found is None else [f"warning: {text}" for text in sentences(found.suspicions)]
    stated = Said(" ".join([structure, *details]), [f"{_file(purpose)}: {structure}", *details], notes)
    return CheckResult(stated, read, notes, identification=found, purpose=purpose)
