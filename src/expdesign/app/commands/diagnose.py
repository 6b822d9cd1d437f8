"""`expdesign diagnose`: where and why the model and the recordings differ."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.identify import recordings_of
from expdesign.app.api.inputs import purpose_of, robot_of
from expdesign.app.commands.console import note, note_unknown_columns
from expdesign.app.commands.writing import Folder, Force, OtherRobot, RobotPath, SharedReference, require_folder

GROUP = ("way", 6)
"""Where it stands in the list of commands."""


def command(
    robot: RobotPath,
    recordings: Annotated[Path, typer.Argument(help="Recordings (CSV).")],
    out: Folder,
    series: Annotated[int, typer.Option(min=1, help="Series of a plan that separates two explanations.")] = 3,
    shared_reference: SharedReference = None,
    targets: Annotated[
        Path | None,
        typer.Option(help="Run configuration (YAML) at whose targets the model that is found is accepted or not."),
    ] = None,
    other_robot: OtherRobot = False,
    force: Force = False,
) -> None:
    """Say where the recordings and the model differ, which physics was left out, and whether adding it helps.

    Ctrl-C ends it with the best model so far, a second Ctrl-C without.

    Example: expdesign diagnose configs/robots/hexapod-h1.yaml recordings.csv --out results/diagnosis
    """
    require_folder(out, xd.DiagnosisResult, purpose_of("diagnose", robot, recordings), force=force)
    machine = robot_of(robot)
    measured = recordings_of(recordings, machine)
    note_unknown_columns(measured)
    result = xd.diagnose(
        machine,
        measured,
        series=series,
        shared_reference=shared_reference,
        targets=targets,
        other_robot=other_robot,
        interruptible=True,
        progress=True,
    )
    page = result.save(out, force=force)
    if result.result.ended:
        note("interrupted: the best model so far is written")
    for line in result.lines:
        print(line)
    print(page)
