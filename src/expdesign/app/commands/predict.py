"""`expdesign predict`: deflections of an identified robot, with their standard deviations."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.console import note
from expdesign.app.commands.writing import Force, Units, require_file

GROUP = ("data", 4)
"""Where it stands in the list of commands."""


def command(
    model: Annotated[Path, typer.Argument(help="Identified model, or a robot file (YAML).")],
    points: Annotated[Path, typer.Argument(help="Points (CSV) in recordings form without the measured columns.")],
    out: Annotated[Path, typer.Option(help="File for the points with dx_m ... and sx_m ... filled in.")],
    platform: Annotated[
        bool, typer.Option("--platform", help="As the platform moves, not as the instrument would read it.")
    ] = False,
    readings: Annotated[
        bool, typer.Option("--readings", help="Standard deviations with the noise of a reading, to hold measurements.")
    ] = False,
    units: Units = None,
    force: Force = False,
) -> None:
    """Predict deflections at points in recordings form.

    Example: expdesign predict results/mine/model.yaml points.csv --out predicted.csv
    """
    require_file(out, purpose_of("predict", model, points), force=force)
    result = xd.predict(model, points, platform=platform, readings=readings)
    result.save(out, units, force=force)
    note(f"{result.summary}; {result.contains}")
    print(out)
