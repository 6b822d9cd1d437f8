"""`diagnose`: where and why the model and the recordings differ."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from expdesign.acceptance.identified import identified_budget
from expdesign.api.identify import RecordingsInput, recorded_accuracy, recordings_of
from expdesign.api.inputs import Config, PathLike, RobotFile, RobotInput, problem_of, robot_of
from expdesign.design.problem import DesignProblem
from expdesign.diagnosis.diagnose import Diagnosis
from expdesign.diagnosis.diagnose import diagnose as diagnose_recordings
from expdesign.diagnosis.law_findings import curves
from expdesign.diagnosis.next_experiment import discriminating_series
from expdesign.errors import InputError
from expdesign.files.csv_writer import csv_text
from expdesign.files.output import json_text, output_folder, write_file
from expdesign.identification.identify import identify as identify_recordings
from expdesign.model_error.record import hidden_record, meir_of_problem
from expdesign.model_error.recorded import HiddenByRecordings, hidden_by
from expdesign.model_error.statement import AccuracyStatement
from expdesign.model_error.words import sentence
from expdesign.models.model_file import Model, model_text
from expdesign.report.diagnosis_record import diagnosis_record
from expdesign.report.page import Page

NEXT_PLAN = "plan-next.csv"


@dataclass(frozen=True)
class Diagnosed:
    """A diagnosis.

    Attributes:
        robot: with its file.
        result: everything that the diagnosis found.
        model: the robot with the effects that were found; what prediction and compensation need.
        series: number of series of a plan that separates two explanations.
        hidden: what may still be wrong at the targets although the recordings are consistent; None where they are not,
            or where no targets were named.
        accuracy: the same beside noise and load errors.
    """

    robot: RobotFile
    result: Diagnosis
    model: Model
    series: int
    hidden: HiddenByRecordings | None = None
    accuracy: AccuracyStatement | None = None

    @property
    def verdict(self) -> str:
        """`consistent`, `explained`, `modelled` or `unexplained`."""
        return self.result.verdict

    @property
    def effects(self) -> pd.DataFrame:
        """The effects that are present together: physics, component, probability and what it does."""
        columns = ("physics", "component", "variant", "probability", "sentence")
        rows = [[getattr(finding, name) for name in columns] for finding in self.result.findings]
        return pd.DataFrame(rows, columns=list(columns))

    @property
    def next_plan(self) -> pd.DataFrame | None:
        """A plan that separates two explanations, where two remain; else None."""
        rival = self.result.rival
        if rival is None:
            return None
        return discriminating_series(self.result.search, self.result.model, rival, self.series)

    @property
    def record(self) -> dict[str, Any]:
        """The content of `diagnosis.json` (file-formats.md, diagnosis.json)."""
        record = diagnosis_record(self.result, None if self.result.rival is None else NEXT_PLAN)
        hidden = self.hidden
        if hidden is not None:
            record["hidden"] = hidden_record(hidden.physics, hidden.freedom, "these recordings")
            record["accuracy"] = None if self.accuracy is None else self.accuracy.record
        return record

    @property
    def hidden_sentence(self) -> str | None:
        """What may still be hidden, in words."""
        if self.hidden is None:
            return None
        if self.accuracy is not None:
            return self.accuracy.sentence
        return sentence(self.hidden.physics[0], self.hidden.freedom, "these recordings")

    def page(self) -> Page:
        """The report."""
        from expdesign.report.diagnosis_report import diagnosis_report  # noqa: PLC0415 (slow to import)

        return diagnosis_report(self.result, self.hidden, self.accuracy)

    def save(self, folder: PathLike) -> Path:
        """Write the files of `expdesign diagnose` into a folder and return the path of the report."""
        from expdesign.report.stored import PAGE, write_report  # noqa: PLC0415 (slow to import)

        plan = self.next_plan
        with output_folder(Path(folder)) as scratch:
            if plan is not None:
                write_file(scratch / NEXT_PLAN, csv_text(plan))
            for number, finding in enumerate(curves(self.result.findings), start=1):
                if finding.curve is not None:
                    write_file(scratch / f"law-{number}.csv", csv_text(finding.curve.frame(list(finding.columns))))
            write_file(scratch / "model.yaml", model_text(self.model, Path(folder)))
            write_file(scratch / "diagnosis.json", json_text(self.record))
            write_report(scratch, self.page())
        return Path(folder) / PAGE


def diagnose(
    robot: RobotInput,
    recordings: RecordingsInput,
    *,
    series: int = 3,
    shared_reference: bool = False,
    targets: Config | None = None,
    without: frozenset[str] = frozenset(),
    report: Callable[[str], None] = lambda text: None,
) -> Diagnosed:
    """Say where the recordings and the model differ, which physics was left out, and whether adding it helps.

    Args:
        robot: that was measured.
        recordings: in one or more files, or as a frame.
        series: number of series of a plan that separates two explanations.
        shared_reference: whether the rows of a series share the noise of their reference.
        targets: run configuration of this robot; where the recordings are consistent, it is said what may still be
            hidden at its targets.
        without: identifiers of physics that the library shall not offer (file-formats.md, Identifiers of physics): what
            it is then taken for, and how well a law at a port stands in for it.
        report: called with a sentence on what is being done.

    Raises:
        InputError: a file is missing or wrong.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the recordings do not determine the stiffness.
    """
    machine = robot_of(robot)
    problem = None if targets is None else _problem_for(targets, machine)
    measured = recordings_of(recordings, machine)
    result = diagnose_recordings(
        machine.robot, measured, shared_reference=shared_reference, without=without, report=report
    )
    model = Model.from_fit(result.predictive.fit, machine.document, measured.source)
    hidden, accuracy = None, None
    if problem is not None and result.verdict == "consistent":
        report("looking for what may still be hidden")
        meir = meir_of_problem(problem)
        assumptions = None if meir is None else meir.impact.assumptions
        hidden = hidden_by(problem, measured, result.noise.deviations, assumptions)
        fitted = identify_recordings(machine.robot, measured, shared_reference=shared_reference)
        accuracy = recorded_accuracy(problem, identified_budget(problem, fitted), hidden)
    return Diagnosed(machine, result, model, series, hidden, accuracy)


def _problem_for(targets: Config, machine: RobotFile) -> DesignProblem:
    """The problem of a configuration, which has to be about this robot."""
    problem = problem_of(targets)
    problem.require_elastostatic("what recordings hide is known")
    robot = problem.loaded.robot
    if robot.kind != machine.robot.kind or robot.actuators != machine.robot.actuators:
        what = f"the configuration is about {robot.name}, and not about {machine.robot.name}"
        raise InputError(what, where=problem.source, remedy="Give the configuration of the robot that was measured.")
    return problem
