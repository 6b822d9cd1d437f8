"""`expdesign new`: a commented configuration that runs as it is."""

import shlex
from pathlib import Path
from typing import Annotated

import typer

from expdesign.app.commands.call import WRITTEN, Force, note
from expdesign.app.templates import kinds, needed
from expdesign.errors import InputError
from expdesign.io.nearest import nearest
from expdesign.io.output import require_writable, write_file
from expdesign.io.written import Purpose, require_free


def command(
    kind: Annotated[str, typer.Argument(help=f"What to begin with: {', '.join(kinds())}; an arm is `serial`.")],
    out: Annotated[Path, typer.Option(help="Folder for the files.", **WRITTEN)] = Path(),
    force: Force = False,
) -> None:
    """Write a commented configuration that runs as it is, with its robot; or a sweep of one.

    Example: expdesign new hexapod --out my-hexapod
    """
    known = kinds()
    if kind not in known:
        remedy = nearest(kind, known)
        arm = "" if remedy.startswith("Did") else " An arm is `serial`."
        raise InputError(f"there is no template `{kind}`", remedy=remedy + arm)
    require_writable(out)
    files = needed(kind, out)
    for file in files:
        place = out / file.name
        if not (place.is_file() and place.read_bytes() == file.read_bytes()):  # else nothing is lost
            require_free(place, Purpose(f"new {kind}"), force=force)
    for file in files:
        write_file(out / file.name, file.read_text(encoding="utf-8"))
        print(out / file.name)
    command, start, results = ("sweep", "sweep.yaml", "sweep") if kind == "sweep" else ("run", "config.yaml", "results")
    note(f"next: {shlex.join(['expdesign', command, str(out / start), '--out', str(out / results)])}")
