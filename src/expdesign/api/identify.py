"""`identify`: stiffness with confidence intervals, from recordings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd

from expdesign.acceptance.budget import MODEL, NOISE, UncertaintyBudget
from expdesign.acceptance.decision import Decision, acceptance_record
from expdesign.acceptance.identified import identified_budget
from expdesign.api.inputs import Config, PathLike, RobotFile, RobotInput, problem_of, robot_of, table_of
from expdesign.design.problem import DesignProblem
from expdesign.errors import InputError
from expdesign.files.output import json_text, output_folder, write_file
from expdesign.identification.geometric import Calibration
from expdesign.identification.identify import Identification
from expdesign.identification.identify import identify as identify_recordings
from expdesign.model_error.record import meir_of_problem
from expdesign.model_error.recorded import HiddenByRecordings, hidden_by
from expdesign.model_error.statement import AccuracyStatement, given_variances
from expdesign.models.model_file import Model, model_text
from expdesign.plausibility.finding import say
from expdesign.plausibility.recordings import recordings_findings
from expdesign.recordings.reader import read_several, recordings_from_table, require_measured
from expdesign.recordings.recordings import Recordings
from expdesign.report.identification_record import identification_record, stiffness_unit
from expdesign.report.page import Page

SMALLEST_PRIOR = 1e-6
"""%; a smaller deviation would say that nothing has to be identified."""

Frames = Literal["known", "unknown"]

RecordingsInput = PathLike | Sequence[PathLike] | pd.DataFrame | Recordings


@dataclass(frozen=True)
class Identified:
    """An identified robot.

    Attributes:
        robot: with its file.
        result: everything that the identification found.
        model: what prediction and compensation need.
        acceptance: of the targets of a configuration, where one was given.
        configuration: its path; empty where none was given.
        hidden: what the recordings may hide at its targets, where it asks for MEIR.
        accuracy: the same beside noise and load errors.
    """

    robot: RobotFile
    result: Identification
    model: Model
    acceptance: Decision | None = None
    configuration: str = ""
    hidden: HiddenByRecordings | None = None
    accuracy: AccuracyStatement | None = None

    @property
    def stiffness(self) -> pd.DataFrame:
        """Estimate and 95 % interval of every actuator's stiffness, by its name."""
        interval = self.result.stiffness
        columns = {"estimate": interval.estimate, "low": interval.low, "high": interval.high}
        frame = pd.DataFrame(columns, index=pd.Index(self.result.robot.actuators, name="actuator"))
        frame["unit"] = stiffness_unit(self.result)
        return frame

    @property
    def geometry(self) -> pd.DataFrame | None:
        """Estimate and 95 % interval of every error of the geometry (m or rad), or None where it is nominal."""
        interval = self.result.geometry
        if interval is None:
            return None
        columns = {"estimate": interval.estimate, "low": interval.low, "high": interval.high}
        return pd.DataFrame(columns, index=pd.Index(self.result.geometry_names, name="parameter"))

    @property
    def record(self) -> dict[str, Any]:
        """The content of `identification.json` (file-formats.md, identification.json)."""
        accepted = {} if self.acceptance is None else {"acceptance": acceptance_record(self.acceptance)}
        stated = {} if self.accuracy is None else {"accuracy": self.accuracy.record}
        return identification_record(self.result) | accepted | stated

    def page(self) -> Page:
        """The report."""
        from expdesign.report.identification_report import identification_report  # noqa: PLC0415 (slow to import)

        page = identification_report(self.result, self.robot.document.source, self.configuration)
        if self.acceptance is None:
            return page
        from expdesign.report.acceptance import acceptance_section  # noqa: PLC0415 (slow to import)

        section = acceptance_section(self.acceptance, "the identified robot")
        sections = [page.sections[0], section]
        if self.hidden is not None:
            from expdesign.report.hidden_physics import recordings_section  # noqa: PLC0415 (slow to import)

            sections.append(recordings_section(self.hidden, self.accuracy))
        return replace(page, sections=(*sections, *page.sections[1:]))

    def save(self, folder: PathLike) -> Path:
        """Write the files of `expdesign identify` into a folder and return the path of the report."""
        from expdesign.report.stored import PAGE, write_report  # noqa: PLC0415 (slow to import)

        with output_folder(Path(folder)) as scratch:
            write_file(scratch / "model.yaml", model_text(self.model, Path(folder)))
            write_file(scratch / "identification.json", json_text(self.record))
            write_report(scratch, self.page())
        return Path(folder) / PAGE


def recordings_of(recordings: RecordingsInput, robot: RobotFile) -> Recordings:
    """Recordings, read from one or more files or from a frame."""
    if isinstance(recordings, Recordings):
        return recordings
    if isinstance(recordings, pd.DataFrame):
        measured = recordings_from_table(table_of(recordings, "recordings"), robot.robot)
        require_measured(measured, robot.robot)
        say(recordings_findings(measured, robot.robot), measured.source)
        return measured
    files = [recordings] if isinstance(recordings, str | Path) else list(recordings)
    read = read_several([Path(file) for file in files], robot.robot)
    say(recordings_findings(read, robot.robot), read.source)
    return read


def require_prior(prior: float | None) -> None:
    """Raise an `InputError` where `prior` is no standard deviation in percent."""
    if prior is not None and not SMALLEST_PRIOR <= prior < float("inf"):
        raise InputError(f"{prior:g} % is not a standard deviation", where="--prior", remedy="Give e.g. 30.")


def identify(
    robot: RobotInput,
    recordings: RecordingsInput,
    *,
    shared_reference: bool = False,
    prior: float | None = None,
    targets: Config | None = None,
    calibration: Calibration | None = None,
    frames: Frames = "known",
) -> Identified:
    """Identify the stiffness of every actuator, the geometry of a robot on legs, or both from recordings.

    Args:
        robot: whose stiffness is wanted.
        recordings: in one or more files, or as a frame.
        shared_reference: whether half of each row's variance is common to its series.
        prior: prior relative standard deviation of `actuator_stiffness`, in percent; None for no prior.
        targets: run configuration at whose targets the robot is accepted or not.
        calibration: `elastostatic`, `geometric` or `both`; None for what the columns say.
        frames: `unknown` where measured poses are not in the very frames of the commands: the displacements of the
            frames of instrument and platform are then identified as well.

    Raises:
        InputError: a file is missing or wrong.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the recordings do not determine the stiffness or the geometry.
    """
    require_prior(prior)
    machine = robot_of(robot)
    problem = None if targets is None else problem_of(targets)
    measured = recordings_of(recordings, machine)
    relative = None if prior is None else prior / 100.0
    if frames not in ("known", "unknown"):
        raise InputError(f"`{frames}` says nothing of frames", where="--frames", remedy="Choose known or unknown.")
    result = identify_recordings(
        machine.robot,
        measured,
        shared_reference=shared_reference,
        prior=relative,
        calibration=calibration,
        frames_known=frames == "known",
    )
    accepted = None if problem is None else Decision(identified_budget(problem, result))
    hidden, accuracy = None, None
    meir = None if problem is None else meir_of_problem(problem)
    if problem is not None and meir is not None and accepted is not None:
        deviations, assumptions = result.noise.deviations, meir.impact.assumptions
        hidden = hidden_by(problem, result.recordings.rows(result.fitted), deviations, assumptions)
        accuracy = recorded_accuracy(problem, accepted.budget, hidden)
    model = Model.from_fit(result.fit, machine.document, measured.source, birge_ratio=result.goodness.birge_ratio)
    return Identified(machine, result, model, accepted, "" if problem is None else problem.source, hidden, accuracy)


def recorded_accuracy(
    problem: DesignProblem, budget: UncertaintyBudget, hidden: HiddenByRecordings
) -> AccuracyStatement | None:
    """The accuracy to expect at the targets from recordings: their budget, and what they may hide."""
    parts = {True: np.zeros(budget.tolerance.shape), False: np.zeros(budget.tolerance.shape)}
    for each in budget.contributions:
        parts[each.name in (NOISE, MODEL)] += each.deviation**2
    variances = given_variances(problem.targets, np.sqrt(parts[True]), np.sqrt(parts[False]))
    return AccuracyStatement.of(variances, hidden.physics, hidden.freedom, "these recordings")
