"""`expdesign schema`: the keys of a file, for editors."""

from typing import Annotated

import typer

import expdesign as xd
from expdesign.io.output import json_text

GROUP = ("research", 7)
"""Where it stands in the list of commands."""


def command(
    kind: Annotated[str, typer.Argument(help="`configuration`, `robot` or `sweep`.")] = "configuration",
) -> None:
    """Print the JSON schema of a kind of file, with which an editor completes keys and marks mistakes.

    Example: expdesign schema configuration > configuration.schema.json
    """
    print(json_text(xd.schema(kind)), end="")
