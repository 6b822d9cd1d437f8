"""`expdesign predict`: deflections of an identified robot, with their standard deviations."""

from pathlib import Path
from typing import Annotated

import typer

from expdesign.commands.console import note
from expdesign.compensation.prediction import in_file_order, predict, require_history, require_regular_points
from expdesign.design.plan import csv_text
from expdesign.files.output import write_file
from expdesign.files.table import read_table
from expdesign.identification.model_file import read_model
from expdesign.recordings.reader import points_from_table


def command(
    model: Annotated[Path, typer.Argument(help="Identified model (YAML).")],
    points: Annotated[Path, typer.Argument(help="Points (CSV) in recordings form without the measured columns.")],
    out: Annotated[Path, typer.Option(help="File for the points with dx_m ... and sx_m ... filled in.")],
    platform: Annotated[
        bool, typer.Option("--platform", help="As the platform moves, not as the instrument would read it.")
    ] = False,
) -> None:
    """Predict deflections at points in recordings form.

    Example: expdesign predict results/mine/model.yaml points.csv --out predicted.csv
    """
    identified = read_model(model)
    robot = identified.chain.robot
    table = read_table(points)
    require_history(identified, table)
    loaded = points_from_table(table, robot)
    require_regular_points(robot, loaded)
    prediction = predict(identified, loaded, platform=platform)
    deflections, deviations = in_file_order(loaded, prediction.deflections, prediction.deviations)
    frame = table.frame.copy()
    for axis, name in enumerate(robot.coordinates.deflection):
        frame[name] = deflections[:, axis]
    for axis, name in enumerate(robot.coordinates.deviation):
        frame[name] = deviations[:, axis]
    write_file(out, csv_text(frame))
    note(f"{len(frame)} points predicted")
    print(out)
