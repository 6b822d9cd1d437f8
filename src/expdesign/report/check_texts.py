"""Sentences about what `check` has read: a robot, a model, a configuration, a sweep or recordings."""

from collections.abc import Sequence

from expdesign.counted import counted
from expdesign.estimation.identify import Identification
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import Feasibility
from expdesign.report.fit_texts import identified_sentences
from expdesign.report.remark_texts import sentences
from expdesign.report.robot_section import actuator_tables
from expdesign.report.said import Said

_FEW = 0.01
"""Share of reachable poses below which the units of `experiment.poses` are probably wrong."""


def robot_said(file: str, source: str, robot: Robot, condition: float, effects: int | None = None) -> Said:
    """What `check` says of a robot or a model: what it is, and which leg or joint is which.

    Args:
        file: that was named.
        source: file of the robot.
        robot: the robot.
        condition: scaled condition number at its reference pose.
        effects: number of effects of a model, or None.
    """
    reference = robot.reference_configuration()
    beyond = float(robot.limit_excess(reference)) > 0.0
    usable = "cannot be at its reference pose" if beyond else "is usable"
    summary = (
        f"{robot.kind} `{robot.name}` with {counted(len(robot.stiffness), 'actuator')} {usable} "
        f"(scaled condition number {condition:.3g} at its reference pose)."
    )
    if effects is not None:
        summary = f"identified model with {counted(effects, 'effect')} of a {summary}"
    notes = [f"{source}: at the reference pose {robot.limit_message(reference)}"] if beyond else []
    return Said(summary, [f"{file}: {summary}"], notes, tables=actuator_tables(robot))


def problem_said(file: str, problem: DesignProblem, found: Feasibility, doubts: Sequence[str]) -> Said:
    """What `check` says of a configuration: what it asks for, what is doubtful, and how its robot was found."""
    summary = _problem(problem, found)
    origin = [] if problem.found is None else [f"{problem.source}: {problem.found.note}"]
    return Said(summary, [f"{file}: {summary}"], [*doubts, *origin])


def problem_doubts(problem: DesignProblem, found: Feasibility) -> tuple[str, ...]:
    """What should be looked at before anything is planned."""
    if found.reachable >= _FEW:
        return ()
    return (f"{problem.source}: hardly any pose in `experiment.poses` can be reached; check their units (m, rad)",)


def _problem(problem: DesignProblem, found: Feasibility) -> str:
    """What a configuration asks for, and how much of its design space serves."""
    space = problem.space
    continuous = int((~space.discrete).sum())
    discrete = int(space.choices.sum())
    measurements = counted(space.measurements, "measurement")
    if problem.budget is not None:  # what fits into it
        number = counted(problem.budget.largest, "measurement")
        measurements = f"at most {number}, as many as {problem.budget.minutes:g} minutes allow,"
    share = f"{100.0 * found.identifying:.0f} % of the random plans that were tried determine"
    identifying = "every random plan that was tried determines" if found.identifying == 1.0 else share
    return (
        f"{problem.loaded.robot.kind} `{problem.loaded.robot.name}`, {measurements} with "
        f"{continuous} continuous and {discrete} discrete variables each, "
        f"{counted(len(problem.targets.weights), 'target')}; {100.0 * found.reachable:.0f} % of the poses can be "
        f"reached, {identifying} what the targets need."
    )


def sweep_said(file: str, runs: int, keys: Sequence[str]) -> Said:
    """What `check` says of a sweep: how many runs there are, over which keys."""
    summary = f"sweep of {counted(runs, 'run')} over {', '.join(keys)}"
    return Said(summary, [f"{file}: {summary}"])


def recordings_said(file: str, structure: str, found: Identification | None, *, robot: bool) -> Said:
    """What `check` says of recordings: what they hold, and what they identify; their mistakes are warned of before.

    Args:
        file: that was named.
        structure: rows, series and measured components, in words.
        found: identification of the base model, or None where there is no robot or nothing to identify.
        robot: whether the robot was named.
    """
    details = [] if found is None else identified_sentences(found)
    if not robot:
        details = ["Give the robot (argument `robot`) to see what they identify."]
    notes = [] if found is None else [f"warning: {text}" for text in sentences(found.suspicions)]
    return Said(" ".join([structure, *details]), [f"{file}: {structure}", *details], notes)
