"""`expdesign table`: corrections of commands over poses and loads, for a machine's control."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.api.table import ERROR, MOST_NODES
from expdesign.app.commands.writing import Force, require_folder
from expdesign.errors import InputError
from expdesign.io.units import quantity

GROUP = ("data", 5)
"""Where it stands in the list of commands."""


def command(
    model: Annotated[Path, typer.Argument(help="Identified model (YAML).")],
    over: Annotated[list[str], typer.Option(help="What varies, as NAME=LOW:HIGH, e.g. x_mm=-30:30; repeatable.")],
    out: Annotated[Path, typer.Option(help="Folder for table.csv, correction.c and table.json.")],
    at: Annotated[
        list[str] | None, typer.Option(help="What is held, as NAME=VALUE, e.g. mass_kg=26.5; repeatable.")
    ] = None,
    error: Annotated[
        str, typer.Option(help="Largest error of interpolation, of lengths and angles.")
    ] = "0.01 um, 0.1 urad",
    nodes: Annotated[int, typer.Option(help="At most.")] = MOST_NODES,
    seed: Annotated[int, typer.Option(help="Of the points at which the table is checked.")] = 1,
    force: Force = False,
) -> None:
    """Tabulate corrections of commands, as CSV and as a file of C99, with the error of interpolation stated.

    Example: expdesign table model.yaml --over x_mm=-20:20 --over mass_kg=0:30 --at com_z_m=0.12 --out table
    """
    require_folder(out, xd.CorrectionTableResult, purpose_of("table", model), force=force)
    ranges = {name: (_number(low, "--over"), _number(high, "--over")) for name, low, high in map(_range, over)}
    if len(ranges) < len(over):
        raise InputError("a coordinate stands there twice", where="--over", remedy="Name each once.")
    held = dict(map(_value, at or []))
    if nodes < 2 or seed < 0:
        raise InputError("nodes must be at least 2 and the seed at least 0", where="--nodes", remedy="Correct it.")
    result = xd.table(model, ranges, held, error=_errors(error), nodes=nodes, seed=seed)
    result.save(out, force=force)
    print(result.summary)
    print(out / "correction.c")


def _range(text: str) -> tuple[str, str, str]:
    name, equals, numbers = text.partition("=")
    low, colon, high = numbers.partition(":")
    if not equals or not colon:
        raise InputError(f"`{text}` is not a range", where="--over", remedy="Write e.g. x_mm=-30:30.")
    return name.strip(), low, high


def _value(text: str) -> tuple[str, float]:
    name, equals, number = text.partition("=")
    if not equals:
        raise InputError(f"`{text}` is not a value", where="--at", remedy="Write e.g. mass_kg=26.5.")
    return name.strip(), _number(number, "--at")


def _number(text: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        remedy = "Write a number; its unit stands in the name (x_mm=-30:30)."
        raise InputError(f"`{text.strip()}` is not a number", where=where, remedy=remedy) from None


def _errors(text: str) -> dict[str, float]:
    wanted = dict(ERROR)
    for part in text.split(","):
        value, unit = quantity(part, "--error")
        if unit.dimension not in wanted or value <= 0.0:
            what = f"`{part.strip()}` is no length or angle above 0"
            raise InputError(what, where="--error", remedy="Write e.g. `0.01 um, 0.1 urad`.")
        wanted[unit.dimension] = value
    return wanted
