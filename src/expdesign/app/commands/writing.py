"""Where a command writes: whether it can, and whether anything would be lost, is asked before the work."""

from pathlib import Path
from typing import Annotated

import typer

from expdesign.app.api.result import Result
from expdesign.io.output import require_writable
from expdesign.io.written import Purpose, is_stream, require_free, require_free_names

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
