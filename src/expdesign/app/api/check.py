"""`check`: what is wrong with a file, or not identifiable."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

from expdesign.app.api.arguments import named_arguments
from expdesign.app.api.configuration import problem_of, read_problem
from expdesign.app.api.inputs import RobotInput, load_robot, purpose_of
from expdesign.app.api.load import read_document
from expdesign.app.api.points_said import say_unknown_columns
from expdesign.app.api.recorded import referenced
from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.assurance.plausibility.robot import robot_findings
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.columns import COLUMNS
from expdesign.chain.recordings.filled_in import check_structure
from expdesign.chain.recordings.joint_columns import with_joint_columns
from expdesign.chain.recordings.measured import with_targets
from expdesign.chain.recordings.reader import recordings_from_table, require_measured
from expdesign.errors import InputError
from expdesign.estimation.identify import identify as identify_recordings
from expdesign.io.kinds import kind_of
from expdesign.io.table import is_table_name, read_table
from expdesign.io.written import Purpose
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.robot import RobotSection
from expdesign.mechanics.robots.robot_file import RobotFile
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import require_regular
from expdesign.planning.sampling import feasibility
from expdesign.planning.schema import RunSection
from expdesign.report.check_texts import (
    CheckResult,
    checked_problem,
    checked_recordings,
    checked_robot,
    checked_sweep,
)
from expdesign.report.result import PathLike, Result

Checked = PathLike | RobotFile | RobotSection | Model | DesignProblem | RunSection | Result


@named_arguments
def check(
    file: Checked,
    robot: RobotInput | None = None,
    *,
    shared_reference: bool | None = None,
    strict: bool = False,
) -> CheckResult:
    """Read a robot, a configuration, a sweep or recordings, and say what is wrong or not identifiable.

    Args:
        file: a robot, a model, a configuration or a sweep (YAML), or recordings (CSV). In Python also an
            object, or a model.
        robot: robot (YAML) that was measured, if the file holds recordings.
        shared_reference: whether all rows of one series share the noise of one unloaded reading; if left out, as the
            recordings say.
        strict: exit with status 3 where anything is doubtful. In Python the result is `refused` then.

    Returns:
        What was read, with a `summary` and `remarks`.

    Raises:
        InputError: the file is missing or wrong, or none of these.
        SingularConfigurationError: the robot is singular at its reference pose or in a row.
        InfeasibleError: no pose of a configuration can be reached.
        NotIdentifiableError: a configuration's designs, or the recordings, do not identify what they have to.

    Command:
        With --out it writes a page that shows the robot with its legs or joints numbered.

        expdesign check configs/hexapod-h1.yaml
    """
    warned, log = _Warned(), logging.getLogger("expdesign")
    log.addHandler(warned)
    try:
        result = _checked(file, robot, purpose_of("check", file), shared_reference=shared_reference)
    finally:
        log.removeHandler(warned)
    if not strict or not (warned.count or result.doubts):
        return result
    notes = [*result.stated.notes, "refused (argument `strict`): see the warnings"]
    return replace(result, stated=replace(result.stated, notes=notes), doubted=True)


class _Warned(logging.Handler):
    """Counts what is warned of while a file is read."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.count = 0

    def emit(self, record: logging.LogRecord) -> None:
        self.count += 1


def _checked(
    file: Checked, robot: RobotInput | None, purpose: Purpose, *, shared_reference: bool | None
) -> CheckResult:
    found: object = (file.as_model() or file) if isinstance(file, Result) else file
    if isinstance(found, str | Path):
        path = Path(found)
        if is_table_name(path):
            return _recordings(path, robot, purpose, shared_reference=shared_reference)
        document = read_yaml(path)
        if kind_of(document.content) == "sweep":
            from expdesign.app.sweeps.runs import sweep_runs  # noqa: PLC0415 (of sweeps alone)

            runs = sweep_runs(document)
            return checked_sweep(purpose, len(runs), list(dict.fromkeys(key for run in runs for key in run.values)))
        found = read_document(document, read_problem)
    if isinstance(found, DesignProblem | RunSection):
        problem = problem_of(found)
        return checked_problem(purpose, problem, feasibility(problem))
    if isinstance(found, RobotFile | RobotSection):
        machine = load_robot(found)
        source, read, effects = machine.document.source, machine.robot, None
    elif isinstance(found, Model):
        source, read, effects = found.source, found.chain.robot, len(found.chain.effects)
    else:
        what = f"a `{type(file).__name__}` cannot be checked"
        raise InputError(what, remedy="Give a path, an object, a model, or what `load` returned.")
    say(robot_findings(read), source)
    require_regular(read, read.reference_configuration(), f"{source}, reference pose")
    return checked_robot(purpose, source, read, effects)


def _recordings(
    file: Path, robot: RobotInput | None, purpose: Purpose, *, shared_reference: bool | None
) -> CheckResult:
    table = read_table(file, COLUMNS)
    if robot is None:
        return checked_recordings(purpose, check_structure(table), None, None)
    machine = load_robot(robot).robot
    table = with_targets(with_joint_columns(table, machine), jointed=machine.jointed)
    structure = check_structure(table, commanded=machine.actuated)
    recordings = referenced(recordings_from_table(table, machine), shared_reference)
    require_measured(recordings, machine)
    say_unknown_columns(recordings)
    say(recordings_findings(recordings, machine), str(file))
    found = identify_recordings(machine, recordings) if machine.actuated else None
    return checked_recordings(purpose, structure, recordings, found)
