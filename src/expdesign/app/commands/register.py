"""`expdesign register`: recordings from lists of points that were measured unloaded and loaded."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.console import note
from expdesign.app.commands.writing import Force, Units, require_file
from expdesign.errors import InputError
from expdesign.io.units import quantity

GROUP = ("data", 1)
"""Where it stands in the list of commands."""


def command(
    robot: Annotated[Path, typer.Argument(help="Robot (YAML), with `markers` or `instrument`.")],
    plan: Annotated[Path, typer.Argument(help="Plan or laboratory sheet (CSV, .xlsx).")],
    points: Annotated[list[Path], typer.Argument(help="Lists of points, in one or more files.")],
    out: Annotated[Path, typer.Option(help="File for the recordings.")],
    unit: Annotated[
        str | None, typer.Option(help="Of the coordinates, where a list does not state it, e.g. mm.")
    ] = None,
    std: Annotated[
        str | None, typer.Option(help="Standard deviation of a coordinate, e.g. '15 um'; else as listed, or estimated.")
    ] = None,
    base_frame: Annotated[
        bool, typer.Option("--base-frame", help="The points were measured in the robot's base frame.")
    ] = False,
    positions: Annotated[
        bool, typer.Option("--positions", help="Write positions of markers instead of deflections.")
    ] = False,
    record: Annotated[Path | None, typer.Option(help="JSON file for the covariance of every row.")] = None,
    units: Units = None,
    force: Force = False,
) -> None:
    """Turn lists of points, measured unloaded and loaded, into recordings.

    Sets of points (groups of a list, or files) named `loaded-SEQUENCE` and `unloaded-SERIES` belong to rows of the
    plan.

    Example: expdesign register robot.yaml plan.csv unloaded.txt loaded.txt --out recordings.csv
    """
    purpose = purpose_of("register", robot, plan, points)
    require_file(out, purpose, force=force)
    require_file(record, purpose, force=force)
    deviation = None
    if std is not None:
        deviation, measured = quantity(std, "--std")
        if measured.dimension != "length":
            raise InputError(f"`{std}` is no length", where="--std", remedy="Write e.g. '15 um'.")
    result = xd.register(
        robot, plan, points, unit=unit, deviation=deviation, base_frame=base_frame, positions=positions
    )
    result.save(out, units, force=force)
    if record is not None:
        result.save_record(record, force=force)
    print(result.summary)
    if result.estimated is not None:
        print(f"standard deviation of a coordinate, estimated from the residuals: {result.estimated * 1e6:.3g} µm")
    if result.marker_fit:
        print(result.marker_fit)
    for text in result.suspicions:
        note(f"warning: {text}")
    if result.unmeasured:
        note(f"no points for row {', '.join(map(str, result.unmeasured))} of the plan: left out")
    print(out)
