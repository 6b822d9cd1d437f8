"""`check`: what is wrong with a file, or not identifiable."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from expdesign.app.api.configuration import checked_problem, problem_of
from expdesign.app.api.inputs import RobotFile, RobotInput, named_arguments, purpose_of, robot_of
from expdesign.app.api.load import read_document
from expdesign.app.api.recorded import referenced, say_unknown_columns
from expdesign.app.api.result import PAGE, FolderResult, PathLike, Result
from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.assurance.plausibility.robot import robot_findings
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.filled_in import check_structure
from expdesign.chain.recordings.joint_columns import with_joint_columns
from expdesign.chain.recordings.measured import with_targets
from expdesign.chain.recordings.reader import recordings_from_table, require_measured
from expdesign.chain.recordings.recordings import Recordings
from expdesign.counted import counted
from expdesign.errors import InputError
from expdesign.estimation.identify import Identification
from expdesign.estimation.identify import identify as identify_recordings
from expdesign.io.kinds import kind_of
from expdesign.io.table import is_table_name, read_table
from expdesign.io.written import Purpose
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.robot import Robot, RobotSection
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import require_regular
from expdesign.planning.sampling import Feasibility, feasibility
from expdesign.planning.schema import RunSection
from expdesign.report import fit_texts
from expdesign.report.page import Page
from expdesign.report.remark_texts import sentences
from expdesign.report.robot_section import actuator_sentences, problem_report, robot_report

if TYPE_CHECKING:
    from expdesign.app.sweeps.runs import SweepRun


@dataclass(frozen=True, repr=False)
class Checked(FolderResult):
    """What was checked and can be used."""

    FILES: ClassVar = PAGE

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is doubtful about it."""
        return ()

    @property
    def doubts(self) -> tuple[str, ...]:
        """Those of the remarks for which `--strict` refuses it."""
        return self.remarks

    @property
    def details(self) -> list[str]:
        """What there is to know beside the summary."""
        return []

    @property
    def lines(self) -> list[str]:
        """The file, what it is, and details."""
        return [f"{', '.join(self.purpose.inputs)}: {self.summary}", *self.details]

    @property
    def notes(self) -> tuple[str, ...]:
        """What is doubtful about it."""
        return self.remarks

    def page(self) -> Page:
        """The robot, drawn with its legs or joints numbered.

        Raises:
            InputError: there is none in what was checked.
        """
        remedy = "Give a robot, a model or a run configuration; of others no page is made."
        where = ", ".join(self.purpose.inputs)
        raise InputError("there is no robot to draw in this file", where=where, remedy=remedy)


@dataclass(frozen=True, repr=False)
class CheckedRobot(Checked):
    """A robot that can be used.

    Attributes:
        source: its file.
        robot: the robot.
        condition: scaled condition number at its reference configuration.
    """

    source: str
    robot: Robot
    condition: float

    @property
    def summary(self) -> str:
        """What it is, in one sentence."""
        robot = self.robot
        usable = "cannot be at its reference pose" if self.beyond else "is usable"
        return (
            f"{robot.kind} `{robot.name}` with {counted(len(robot.stiffness), 'actuator')} {usable} "
            f"(scaled condition number {self.condition:.3g} at its reference pose)."
        )

    @property
    def beyond(self) -> bool:
        """Whether the limits exclude the reference pose."""
        return float(self.robot.limit_excess(self.robot.reference_configuration())) > 0.0

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is doubtful about it."""
        reference = self.robot.reference_configuration()
        if not self.beyond:
            return ()
        return (f"{self.source}: at the reference pose {self.robot.limit_message(reference)}",)

    @property
    def details(self) -> list[str]:
        """Which leg or joint is which: a line for each of them."""
        return actuator_sentences(self.robot)

    def page(self) -> Page:
        """The robot, drawn with its numbers."""
        return robot_report(self.robot, self.summary)


@dataclass(frozen=True, repr=False)
class CheckedModel(CheckedRobot):
    """An identified model that can be used, with its robot.

    Attributes:
        model: the model.
    """

    model: Model

    @property
    def summary(self) -> str:
        """What it is, in one sentence."""
        return f"identified model with {counted(len(self.model.chain.effects), 'effect')} of a {super().summary}"


@dataclass(frozen=True, repr=False)
class CheckedProblem(Checked):
    """A run configuration that can be solved.

    Attributes:
        problem: what it asks for.
        feasibility: shares of the design space that can be reached and that identify what the targets need.
    """

    problem: DesignProblem
    feasibility: Feasibility

    def page(self) -> Page:
        """The robot, drawn with its numbers, at rest and at the targets."""
        return problem_report(self.problem, self.summary)

    @property
    def summary(self) -> str:
        """What it asks for, in one sentence."""
        return fit_texts.problem_summary(self.problem, self.feasibility)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is doubtful about it."""
        return fit_texts.problem_remarks(self.problem, self.feasibility)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Those that are no mere statement of what the robot is."""
        return fit_texts.problem_doubts(self.problem, self.feasibility)

    @property
    def refused(self) -> bool:
        """Whether none of the poses drawn at random can be reached."""
        return self.feasibility.reachable == 0.0


@dataclass(frozen=True, repr=False)
class CheckedSweep(Checked):
    """A sweep whose every run is a configuration.

    Attributes:
        runs: what is run.
    """

    runs: list[SweepRun]

    @property
    def summary(self) -> str:
        """What it asks for, in one sentence."""
        keys = dict.fromkeys(key for run in self.runs for key in run.values)
        return f"sweep of {counted(len(self.runs), 'run')} over {', '.join(keys)}"


@dataclass(frozen=True, repr=False)
class CheckedRecordings(Checked):
    """Recordings that can be read.

    Attributes:
        structure: rows, series and measured components, in words.
        recordings: read as those of the robot, or None without one.
        identification: of the base model, or None where there is no robot or nothing to identify.
    """

    structure: str
    recordings: Recordings | None = None
    identification: Identification | None = None

    @property
    def summary(self) -> str:
        """What they hold and, with a robot, what they identify."""
        return " ".join([self.structure, *self.details])

    @property
    def details(self) -> list[str]:
        """What they identify, and how well the base model fits, a line for each sentence."""
        if self.recordings is None:
            return ["Give the robot (argument `robot`) to see what they identify."]
        return [] if self.identification is None else fit_texts.identified_sentences(self.identification)

    @property
    def lines(self) -> list[str]:
        """The file, what it holds, and details."""
        return [f"{', '.join(self.purpose.inputs)}: {self.structure}", *self.details]

    @property
    def remarks(self) -> tuple[str, ...]:
        """What limits what they tell; mistakes are warned of where they are read."""
        if self.identification is None:
            return ()
        return tuple(f"warning: {text}" for text in sentences(self.identification.suspicions))


@named_arguments
def check(
    file: PathLike | RobotFile | RobotSection | Model | DesignProblem | RunSection | Result,
    robot: RobotInput | None = None,
    *,
    shared_reference: bool | None = None,
) -> Checked:
    """Read a robot, a configuration, a sweep or recordings, and say what is wrong or not identifiable.

    Args:
        file: a robot, a model, a configuration or a sweep (YAML), or recordings (CSV). In Python also an
            object, or a model.
        robot: robot (YAML) that was measured, if the file holds recordings.
        shared_reference: whether all rows of one series share the noise of one unloaded reading; if left out, as the
            recordings say.

    Returns:
        What was read, with a `summary` and `remarks`.

    Raises:
        InputError: the file is missing or wrong, or none of these.
        SingularConfigurationError: the robot is singular at its reference pose or in a row.
        InfeasibleError: no pose of a configuration can be reached.
        NotIdentifiableError: a configuration's designs, or the recordings, do not identify what they have to.

    Command:
        With --out a page is written in which the robot is drawn, its legs or joints numbered.

        expdesign check configs/hexapod-h1.yaml
    """
    purpose = purpose_of("check", file)
    found: object = (file.as_model() or file) if isinstance(file, Result) else file
    if isinstance(found, str | Path):
        path = Path(found)
        if is_table_name(path):
            return _recordings(path, robot, purpose, shared_reference=shared_reference)
        document = read_yaml(path)
        if kind_of(document.content) == "sweep":
            from expdesign.app.sweeps.runs import sweep_runs  # noqa: PLC0415 (of sweeps alone)

            return CheckedSweep(sweep_runs(document), purpose=purpose)
        found = read_document(document, checked_problem)
    if isinstance(found, DesignProblem | RunSection):
        problem = problem_of(found)
        return CheckedProblem(problem, feasibility(problem), purpose=purpose)
    if isinstance(found, RobotFile | RobotSection):
        machine = robot_of(found)
        return CheckedRobot(*_usable(machine.robot, machine.document.source), purpose=purpose)
    if isinstance(found, Model):
        return CheckedModel(*_usable(found.chain.robot, found.source), found, purpose=purpose)
    what = f"a `{type(file).__name__}` cannot be checked"
    raise InputError(what, remedy="Give a path, an object, a model, or what `load` returned.")


def _usable(robot: Robot, source: str) -> tuple[str, Robot, float]:
    """The file, the robot and the scaled condition number at its reference pose, where that can be used."""
    say(robot_findings(robot), source)
    reference = robot.reference_configuration()
    require_regular(robot, reference, f"{source}, reference pose")
    return source, robot, float(robot.jacobians(reference).condition)


def _recordings(
    file: Path, robot: RobotInput | None, purpose: Purpose, *, shared_reference: bool | None
) -> CheckedRecordings:
    table = read_table(file)
    if robot is None:
        return CheckedRecordings(check_structure(table), purpose=purpose)
    machine = robot_of(robot).robot
    table = with_targets(with_joint_columns(table, machine), machine)
    structure = check_structure(table, commanded=machine.actuated)
    recordings = referenced(recordings_from_table(table, machine), shared_reference)
    require_measured(recordings, machine)
    say_unknown_columns(recordings)
    say(recordings_findings(recordings, machine), str(file))
    if not machine.actuated:
        return CheckedRecordings(structure, recordings, purpose=purpose)
    found = identify_recordings(machine, recordings)
    return CheckedRecordings(structure, recordings, found, purpose=purpose)
