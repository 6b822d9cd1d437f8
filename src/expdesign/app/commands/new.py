"""`expdesign new`: a commented configuration that runs as it is."""

import difflib
import shlex
from pathlib import Path
from typing import Annotated

import typer

from expdesign.app.commands.call import Force, note
from expdesign.app.templates import kinds, needed
from expdesign.errors import InputError
from expdesign.io.output import require_writable, write_file
from expdesign.io.written import Purpose, require_free


def command(
    kind: Annotated[str, typer.Argument(help=f"One of {', '.join(kinds())}; an arm is `serial`.")],
    out: Annotated[Path, typer.Option(help="Folder for the files.")] = Path(),
    force: Force = False,
) -> None:
    """Write a commented configuration that runs as it is, with its robot; or a sweep of one.

    Example: expdesign new hexapod --out my-hexapod
    """
    known = kinds()
    if kind not in known:
        near = difflib.get_close_matches(kind, list(known), n=1, cutoff=0.5)
        remedy = f"Did you mean `{near[0]}`?" if near else f"Known: {', '.join(known)}; an arm is `serial`."
        raise InputError(f"there is no template `{kind}`", remedy=remedy)
    require_writable(out)
    files = needed(kind, out)
    for file in files:
        if not _is_there(out / file.name, file):
            require_free(out / file.name, Purpose(f"new {kind}"), force=force)
    for file in files:
        write_file(out / file.name, file.read_text(encoding="utf-8"))
        print(out / file.name)
    command, start, results = ("sweep", "sweep.yaml", "sweep") if kind == "sweep" else ("run", "config.yaml", "results")
    note(f"next: {shlex.join(['expdesign', command, str(out / start), '--out', str(out / results)])}")


def _is_there(path: Path, template: Path) -> bool:
    """Whether a file already holds what would be written, so that nothing is lost."""
    return path.is_file() and path.read_bytes() == template.read_bytes()
