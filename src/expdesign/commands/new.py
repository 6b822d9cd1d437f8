"""`expdesign new`: a commented configuration that runs as it is."""

import difflib
from pathlib import Path
from typing import Annotated

import typer

from expdesign.commands.console import note
from expdesign.errors import InputError
from expdesign.files.output import require_writable, write_file
from expdesign.templates import kinds


def command(
    kind: Annotated[str, typer.Argument(help=f"One of {', '.join(kinds())}.")],
    out: Annotated[Path, typer.Option(help="Folder for the files.")] = Path(),
) -> None:
    """Write a commented configuration that runs as it is, with its robot; or a sweep of one.

    Example: expdesign new hexapod --out my-hexapod
    """
    known = kinds()
    if kind not in known:
        near = difflib.get_close_matches(kind, list(known), n=1, cutoff=0.5)
        remedy = f"Did you mean `{near[0]}`?" if near else f"Known: {', '.join(known)}."
        raise InputError(f"there is no template `{kind}`", remedy=remedy)
    require_writable(out)
    for file in known[kind]:
        if (out / file.name).exists():
            remedy = "Nothing was written. Remove it, or name another folder (--out)."
            raise InputError("this file is there already", where=str(out / file.name), remedy=remedy)
    for file in known[kind]:
        write_file(out / file.name, file.read_text(encoding="utf-8"))
        print(out / file.name)
    if (out / "sweep.yaml").exists() and kind == "sweep":
        note(f"next: expdesign sweep {out / 'sweep.yaml'} --out {out / 'sweep'}")
    else:
        note(f"next: expdesign run {out / 'config.yaml'} --out {out / 'results'}")
