"""`expdesign study`: a study of the thesis, made again from its configuration."""

import importlib.util
import sys
import time
from pathlib import Path
from typing import Annotated

import typer

from expdesign.app.commands.call import Force, note
from expdesign.errors import InputError
from expdesign.io.output import require_writable


def command(
    name: Annotated[str, typer.Argument(help="Name of the study, or `all`.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; each study has its own in it.")] = Path(
        "results/studies"
    ),
    configurations: Annotated[Path, typer.Option(help="Folder with the studies' configurations.")] = Path(
        "configs/studies"
    ),
    force: Force = False,
) -> None:
    """Make a study of the thesis again: tables, figures and a page.

    Example: expdesign study all --out results/studies
    """
    try:
        import matplotlib  # noqa: F401, PLC0415 (an extra, needed here alone)
    except ImportError:
        remedy = "Install it: pip install 'expdesign[studies]'."
        raise InputError("studies draw with matplotlib, which is not installed", remedy=remedy) from None
    _require_checkout()
    from thesis_studies.making import make, prepare, require_free_study, write_index  # noqa: PLC0415
    from thesis_studies.study import known_studies  # noqa: PLC0415

    wanted = list(known_studies()) if name == "all" else [name]
    require_writable(out)
    for each in wanted:  # what is wrong with any of them is said before the work
        prepare(each, configurations)
        require_free_study(each, configurations, out, force=force)
    for each in wanted:
        started = time.monotonic()
        make(each, configurations, out, force=force)
        note(f"{each}: {time.monotonic() - started:.1f} s")
        print(out / each / "README.md")
    if all((out / each / "study.json").is_file() for each in known_studies()):
        write_index(out, force=force)


def _require_checkout() -> None:
    """Make `thesis_studies` importable: the studies belong to the project's source, not to the installed package.

    Raises:
        InputError: they are not in the current folder.
    """
    if importlib.util.find_spec("thesis_studies") is not None:
        return
    folder = Path.cwd()
    if not (folder / "thesis_studies" / "study.py").is_file():
        remedy = "Run this command in the folder of the project's source."
        raise InputError("the thesis' studies are not in this folder", where=str(folder), remedy=remedy)
    sys.path.insert(0, str(folder))
