"""What commands have in common: their options, and where they write.

Whether a file can be written, and whether anything would be lost, is asked before the work.
"""

from pathlib import Path
from typing import Annotated

import typer

from expdesign.app.api.result import Result
from expdesign.io.output import require_writable
from expdesign.io.written import Purpose, is_stream, require_free, require_free_names

Config = Annotated[Path, typer.Argument(help="Run configuration (YAML).")]
RobotPath = Annotated[Path, typer.Argument(help="Robot (YAML).")]
PlanPath = Annotated[Path, typer.Argument(help="Plan (CSV), of any number of rows.")]
Folder = Annotated[Path, typer.Option(help="Folder for the results.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on standard output.")]
Units = Annotated[str | None, typer.Option(help="Units to write, by what they measure, e.g. mm,mrad; SI if left out.")]
SharedReference = Annotated[
    bool | None,
    typer.Option(
        "--shared-reference/--no-shared-reference",
        help="Whether rows of one series share the noise of one unloaded reading. "
        "Default: what the recordings or the configuration say.",
    ),
]
OtherRobot = Annotated[
    bool, typer.Option("--other-robot", help="A configuration of another geometry than the robot's is meant.")
]
Force = Annotated[bool, typer.Option("--force", help="Replace files that are there for another purpose.")]


def require_folder(folder: Path, kind: type[Result], purpose: Purpose, *, force: bool) -> None:
    """Raise an `InputError` where the files of a kind of result cannot be written into a folder, or replace others."""
    require_writable(folder)
    require_free_names(folder, kind.FILES, purpose, force=force)


def require_file(file: Path | None, purpose: Purpose, *, force: bool) -> None:
    """Raise an `InputError` where a file cannot be written, or is there for another purpose."""
    if file is None or is_stream(file):
        return
    require_free(file, purpose, force=force)
    require_writable(file.parent)
