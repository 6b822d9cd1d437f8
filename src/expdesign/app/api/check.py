"""`check`: what is wrong with a file, or not identifiable."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

from expdesign.app.api.configuration import checked_problem, problem_of
from expdesign.app.api.inputs import RobotInput, load_robot, named_arguments, purpose_of
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
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError
from expdesign.estimation.identify import Identification
from expdesign.estimation.identify import identify as identify_recordings
from expdesign.io.kinds import kind_of
from expdesign.io.table import is_table_name, read_table
from expdesign.io.written import Purpose
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.robot import Robot, RobotSection
from expdesign.mechanics.robots.robot_file import RobotFile
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import require_regular
from expdesign.planning.sampling import Feasibility, feasibility
from expdesign.planning.schema import RunSection
from expdesign.report.check_texts import problem_doubts, problem_said, recordings_said, robot_said, sweep_said
from expdesign.report.page import Page
from expdesign.report.result import PAGE, FolderResult, PathLike, Result
from expdesign.report.robot_section import problem_report, robot_report
from expdesign.report.said import Said

Checked = PathLike | RobotFile | RobotSection | Model | DesignProblem | RunSection | Result


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
            where = ", ".join(self.purpose.inputs)
            raise InputError("there is no robot to draw in this file", where=where, remedy=remedy)
        return robot_report(self.read, self.summary)


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
            keys = list(dict.fromkeys(key for run in runs for key in run.values))
            return CheckResult(sweep_said(str(file), len(runs), keys), None, (), purpose=purpose)
        found = read_document(document, checked_problem)
    if isinstance(found, DesignProblem | RunSection):
        problem = problem_of(found)
        shares = feasibility(problem)
        doubts = problem_doubts(problem, shares)
        stated = problem_said(", ".join(purpose.inputs), problem, shares, doubts)
        return CheckResult(stated, problem, doubts, shares, purpose=purpose)
    if isinstance(found, RobotFile | RobotSection):
        machine = load_robot(found)
        return _usable(machine.robot, machine.document.source, None, purpose)
    if isinstance(found, Model):
        return _usable(found.chain.robot, found.source, len(found.chain.effects), purpose)
    what = f"a `{type(file).__name__}` cannot be checked"
    raise InputError(what, remedy="Give a path, an object, a model, or what `load` returned.")


def _usable(robot: Robot, source: str, effects: int | None, purpose: Purpose) -> CheckResult:
    """What is said of a robot, or of a model with effects, that is regular at its reference pose."""
    say(robot_findings(robot), source)
    reference = robot.reference_configuration()
    require_regular(robot, reference, f"{source}, reference pose")
    condition = float(robot.jacobians(reference).condition)
    stated = robot_said(", ".join(purpose.inputs), source, robot, condition, effects)
    return CheckResult(stated, robot, stated.notes, purpose=purpose)


def _recordings(
    file: Path, robot: RobotInput | None, purpose: Purpose, *, shared_reference: bool | None
) -> CheckResult:
    table = read_table(file, COLUMNS)
    if robot is None:
        return CheckResult(
            recordings_said(str(file), check_structure(table), None, robot=False), None, (), purpose=purpose
        )
    machine = load_robot(robot).robot
    table = with_targets(with_joint_columns(table, machine), jointed=machine.jointed)
    structure = check_structure(table, commanded=machine.actuated)
    recordings = referenced(recordings_from_table(table, machine), shared_reference)
    require_measured(recordings, machine)
    say_unknown_columns(recordings)
    say(recordings_findings(recordings, machine), str(file))
    found = identify_recordings(machine, recordings) if machine.actuated else None
    stated = recordings_said(str(file), structure, found, robot=True)
    return CheckResult(stated, recordings, stated.notes, identification=found, purpose=purpose)
