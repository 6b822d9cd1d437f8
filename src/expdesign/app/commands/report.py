"""`expdesign report`: the report of a folder of results, made again."""

from pathlib import Path
from typing import Annotated

import typer

from expdesign.app.commands.call import Force


def command(
    folder: Annotated[Path, typer.Argument(help="Folder that a command wrote.")],
    force: Force = False,
) -> None:
    """Make the report of stored results again, without the work that led to them.

    Example: expdesign report results/mine
    """
    from expdesign.report.stored import remake_report  # noqa: PLC0415 (slow to import)

    print(remake_report(folder, force=force))
