"""`expdesign check`: what is wrong with a file, or not identifiable."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import expdesign
from expdesign.api.inputs import checked_problem
from expdesign.commands.console import counted, note, note_unknown_columns
from expdesign.design.optimality.gradient_check import ACCEPTED, gradient_table
from expdesign.design.problem import DesignProblem
from expdesign.design.problem_file import require_regular
from expdesign.design.start import require_identifiable, starting_designs
from expdesign.errors import InputError
from expdesign.files.table import read_table
from expdesign.files.yaml_reader import YamlDocument, read_yaml
from expdesign.identification.identify import identify
from expdesign.identification.model_file import model_from_document
from expdesign.plausibility.finding import say
from expdesign.plausibility.recordings import recordings_findings
from expdesign.plausibility.robot import robot_findings
from expdesign.recordings.reader import recordings_from_table, require_measured
from expdesign.recordings.structure import check_structure
from expdesign.robots.robot import Robot
from expdesign.robots.robot_file import read_robot, robot_from_document
from expdesign.sweeps.runs import sweep_runs

_SAMPLES = 2000
_FEW = 0.01
"""Share of reachable poses below which the units of `experiment.poses` are probably wrong."""


def command(
    file: Annotated[Path, typer.Argument(help="A robot, a configuration or a sweep (YAML), or recordings (CSV).")],
    robot: Annotated[Path | None, typer.Option(help="Robot (YAML) that recordings are of.")] = None,
    shared_reference: Annotated[
        bool, typer.Option("--shared-reference", help="Half of each row's variance is common to its series.")
    ] = False,
    gradients: Annotated[
        bool, typer.Option("--gradients", help="Compare every criterion's exact gradient with central differences.")
    ] = False,
) -> None:
    """Read a robot, a configuration, a sweep or recordings, and say what is wrong or not identifiable.

    Example: expdesign check configs/hexapod-h1.yaml --gradients
    """
    if file.suffix.lower() == ".csv":
        print(f"{file}: {check_recordings(file, robot, shared_reference=shared_reference)}")
        return
    document = read_yaml(file)
    content = document.content if isinstance(document.content, dict) else {}
    if content.get("kind") == "model":
        model = model_from_document(document)
        robot_of = check_robot(model.chain.robot, str(file))
        print(f"{file}: identified model with {counted(len(model.chain.effects), 'effect')} of a {robot_of}")
    elif {"vary", "cases", "config"} & set(content):
        print(f"{file}: {check_sweep(document)}")
    elif "experiment" in content or "schema_version" in content or "targets" in content:
        problem = checked_problem(document)
        print(f"{file}: {check_problem(problem)}")
        if gradients:
            check_gradients(problem)
    elif "kind" in content or "base_joints" in content:
        print(f"{file}: {check_robot(robot_from_document(document), str(file))}")
    else:
        remedy = "A robot file has the key `kind`, a run configuration `experiment`, a sweep `vary`."
        raise InputError("neither a robot nor a run configuration", where=str(file), remedy=remedy)


def check_recordings(file: Path, robot_file: Path | None, *, shared_reference: bool) -> str:
    """Raise what is wrong with recordings, or say in words what they hold and, with a robot, what they identify."""
    table = read_table(file)
    if robot_file is None:
        return f"{check_structure(table)} Give the robot (--robot ROBOT.yaml) to see what they identify."
    robot = read_robot(robot_file)
    text = check_structure(table, commanded=len(robot.stiffness) > 0)
    recordings = recordings_from_table(table, robot)
    require_measured(recordings, robot)
    note_unknown_columns(recordings)
    say([*robot_findings(robot), *recordings_findings(recordings, robot)], str(file))
    if len(robot.stiffness) == 0:
        return text
    result = identify(robot, recordings, shared_reference=shared_reference)
    if recordings.marker is not None:
        return " ".join([text, *result.suspicions])
    relative = np.sqrt(np.diag(result.covariance)) / np.abs(result.compliance.estimate)
    for suspicion in result.suspicions:
        note(f"suspicion: {suspicion}")
    return (
        f"{text} They identify all {len(robot.stiffness)} stiffnesses, the worst "
        f"({robot.actuators[int(np.argmax(relative))]}) to {relative.max():.2%} (one standard deviation)."
    )


def check_robot(robot: Robot, source: str) -> str:
    """Raise where a robot cannot be, or is singular at its reference configuration, or say that it is usable."""
    say(robot_findings(robot), source)
    reference = robot.reference_configuration()
    require_regular(robot, reference, f"{source}, reference pose")
    usable = "is usable"
    if float(robot.limit_excess(reference)) > 0.0:
        note(f"{source}: at the reference pose {robot.limit_message(reference)}")
        usable = "is usable at poses within its limits, of which the reference pose is none"
    condition = float(robot.jacobians(reference).condition)
    return (
        f"{robot.kind} `{robot.name}` with {len(robot.stiffness)} actuators {usable} "
        f"(scaled condition number {condition:.3g} at its reference pose)."
    )


def check_sweep(document: YamlDocument) -> str:
    """Raise what is wrong with a sweep, or say in words what it asks for."""
    runs = sweep_runs(document, expdesign.__version__)
    keys = list(dict.fromkeys(key for run in runs for key in run.values))
    return f"sweep of {len(runs)} runs over {', '.join(keys)}"


def check_problem(problem: DesignProblem) -> str:
    """Raise what keeps a problem from being solved, or say in words what it asks for."""
    designs = starting_designs(problem, 100, np.random.default_rng(problem.optimiser.seed))
    space = problem.space
    genes = designs.reshape(len(designs), space.measurements, space.genes)
    share = require_identifiable(problem, genes)
    poses = space.decode(space.sample(_SAMPLES, np.random.default_rng(problem.optimiser.seed)))[0]
    reachable = float(problem.loaded.robot.usable(poses).mean())
    if reachable < _FEW:
        note(f"{problem.source}: hardly any pose in `experiment.poses` can be reached; check their units (m, rad)")
    continuous = int((~space.discrete).sum())
    return (
        f"{problem.loaded.robot.kind} `{problem.loaded.robot.name}`, {space.measurements} measurements with "
        f"{continuous} continuous and {space.genes - continuous} discrete variables each, "
        f"{counted(len(problem.targets.weights), 'target')}; {reachable:.0%} of the poses can be reached, "
        f"{share:.0%} of random designs identify what the targets need."
    )


def check_gradients(problem: DesignProblem) -> None:
    """Print the table of the gradients at two random designs; exit with status 1 where a gradient is wrong."""
    space = problem.space
    if space.discrete.all():
        what = "every variable of the design is fixed or discrete, so that there are no gradients to check"
        raise InputError(what, where=problem.source, remedy="Leave --gradients out, or give a variable an interval.")
    designs = starting_designs(problem, 100, np.random.default_rng(problem.optimiser.seed))
    genes = designs.reshape(len(designs), space.measurements, space.genes)
    # Two of those at which everything is identified; where there is none, the table says that nothing was evaluated.
    assessment = problem.assess(*space.decode(genes))
    order = np.argsort(~assessment.identifies_targets, kind="stable")
    table = gradient_table(problem, genes[order[:2]])
    print(
        "Largest relative difference between exact gradients and central differences, over all variables of two "
        "random designs,\nat steps of these parts of each variable's range:"
    )
    print(table.to_string(index=False, float_format=lambda value: f"{value:.1e}", na_rep="-"))
    if (table["verdict"] == "fail").any():
        note(f"a gradient is wrong by more than {ACCEPTED:.0e}: see the verdicts")
        raise typer.Exit(1)
