"""`expdesign diagnose`: where and why the model and the recordings differ."""

from pathlib import Path
from typing import Annotated

import typer

from expdesign.commands.console import note, note_unknown_columns, progress
from expdesign.design.plan import csv_text
from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.next_experiment import discriminating_series
from expdesign.diagnosis.record import correction_frame, diagnosis_record
from expdesign.files.output import json_text, output_folder, require_writable, write_file
from expdesign.files.yaml_reader import read_yaml
from expdesign.identification.model_file import Model, model_text
from expdesign.recordings.reader import read_recordings
from expdesign.robots.robot_file import robot_from_document

NEXT_PLAN = "plan-next.csv"


def command(
    robot: Annotated[Path, typer.Argument(help="Robot (YAML).")],
    recordings: Annotated[Path, typer.Argument(help="Recordings (CSV).")],
    out: Annotated[Path, typer.Option(help="Folder for the results.")],
    series: Annotated[int, typer.Option(min=1, help="Series of a plan to tell two explanations apart.")] = 3,
    shared_reference: Annotated[
        bool, typer.Option("--shared-reference", help="The rows of a series share the noise of their reference.")
    ] = False,
) -> None:
    """Say where the recordings and the model differ, which physics was left out, and whether adding it helps.

    Example: expdesign diagnose configs/robots/hexapod-h1.yaml recordings.csv --out results/diagnosis
    """
    from expdesign.report.diagnosis_report import diagnosis_report  # noqa: PLC0415 (slow to import)
    from expdesign.report.stored import write_report  # noqa: PLC0415

    require_writable(out)
    document = read_yaml(robot)
    machine = robot_from_document(document)
    data = read_recordings(recordings, machine)
    note_unknown_columns(data)
    steps = 0
    with progress("diagnosing") as bar:

        def report(text: str) -> None:
            nonlocal steps
            steps += 1
            bar.update(steps, steps + 1, text)

        result = diagnose(machine, data, shared_reference=shared_reference, report=report)
    rival = result.rival
    record = diagnosis_record(result, None if rival is None else NEXT_PLAN)
    with output_folder(out) as scratch:
        if rival is not None:
            plan = discriminating_series(result.search, result.model, rival, series)
            write_file(scratch / NEXT_PLAN, csv_text(plan))
        if result.correction is not None:
            write_file(scratch / "correction.csv", csv_text(correction_frame(result)))
        model = Model.from_fit(result.model.fit, document, str(recordings))
        write_file(scratch / "model.yaml", model_text(model, out))
        write_file(scratch / "diagnosis.json", json_text(record))
        write_report(scratch, diagnosis_report(result))
    note(f"Verdict: {result.verdict}.")
    for finding in result.findings:
        note(f"{finding.sentence} (probability {finding.probability:.2f})")
    print(out / "report.html")
