"""`expdesign diagnose`: where and why the model and the recordings differ."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.api.identify import recordings_of
from expdesign.api.inputs import robot_of
from expdesign.commands.console import note, note_unknown_columns, progress
from expdesign.files.output import require_writable


def command(
    robot: Annotated[Path, typer.Argument(help="Robot (YAML).")],
    recordings: Annotated[Path, typer.Argument(help="Recordings (CSV).")],
    out: Annotated[Path, typer.Option(help="Folder for the results.")],
    series: Annotated[int, typer.Option(min=1, help="Series of a plan that separates two explanations.")] = 3,
    shared_reference: Annotated[
        bool, typer.Option("--shared-reference", help="The rows of a series share the noise of their reference.")
    ] = False,
    targets: Annotated[
        Path | None, typer.Option(help="Run configuration (YAML) whose targets matter: says what may still be hidden.")
    ] = None,
) -> None:
    """Say where the recordings and the model differ, which physics was left out, and whether adding it helps.

    Example: expdesign diagnose configs/robots/hexapod-h1.yaml recordings.csv --out results/diagnosis
    """
    require_writable(out)
    machine = robot_of(robot)
    measured = recordings_of(recordings, machine)
    note_unknown_columns(measured)
    steps = 0
    with progress("diagnosing") as bar:

        def report(text: str) -> None:
            nonlocal steps
            steps += 1
            bar.update(steps, steps + 1, text)

        result = xd.diagnose(
            machine, measured, series=series, shared_reference=shared_reference, targets=targets, report=report
        )
    page = result.save(out)
    note(f"Verdict: {result.verdict}.")
    for finding in result.result.findings:
        note(f"{finding.sentence} (probability {finding.probability:.2f})")
    if result.hidden_sentence is not None:
        note(result.hidden_sentence)
    print(page)
