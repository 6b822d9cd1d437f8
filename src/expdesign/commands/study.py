"""`expdesign study`: a study of the thesis, made again from its configuration."""

import time
from pathlib import Path
from typing import Annotated

import typer

from expdesign.commands.console import note
from expdesign.errors import InputError
from expdesign.files.output import require_writable


def command(
    name: Annotated[str, typer.Argument(help="Name of the study, or `all`.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; each study has its own in it.")] = Path(
        "results/studies"
    ),
    configurations: Annotated[Path, typer.Option(help="Folder with the studies' configurations.")] = Path(
        "configs/studies"
    ),
) -> None:
    """Make a study of the thesis again: tables, figures and a page.

    Example: expdesign study all --out results/studies
    """
    try:
        import matplotlib  # noqa: F401, PLC0415 (an extra, needed here alone)
    except ImportError:
        remedy = "Install it: pip install 'expdesign[studies]'."
        raise InputError("studies draw with matplotlib, which is not installed", remedy=remedy) from None
    from thesis_studies.making import make, prepare, write_index  # noqa: PLC0415
    from thesis_studies.study import known_studies  # noqa: PLC0415

    wanted = list(known_studies()) if name == "all" else [name]
    require_writable(out)
    for each in wanted:
        prepare(each, configurations)  # what is wrong with any of them is said before the work
    for each in wanted:
        started = time.monotonic()
        make(each, configurations, out)
        note(f"{each}: {time.monotonic() - started:.1f} s")
        print(out / each / "README.md")
    if all((out / each / "study.json").is_file() for each in known_studies()):
        write_index(out)
