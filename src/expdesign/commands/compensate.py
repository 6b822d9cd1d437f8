"""`expdesign compensate`: command poses that reach the targets under load."""

from pathlib import Path
from typing import Annotated

import typer

from expdesign.commands.console import note
from expdesign.compensation.compensate import compensate
from expdesign.compensation.prediction import in_file_order, require_history
from expdesign.design.plan import csv_text
from expdesign.files.output import write_file
from expdesign.files.table import read_table
from expdesign.identification.model_file import read_model
from expdesign.recordings.reader import points_from_table


def command(
    model: Annotated[Path, typer.Argument(help="Identified model (YAML).")],
    targets: Annotated[Path, typer.Argument(help="Targets (CSV): where the platform shall be, and the load there.")],
    out: Annotated[Path, typer.Option(help="File for the commands.")],
) -> None:
    """Find the commands that bring the platform to the targets under load.

    The load is that at the target: a payload's wrench is taken at the orientation that the platform shall have.

    Example: expdesign compensate results/mine/model.yaml targets.csv --out commands.csv
    """
    identified = read_model(model)
    robot = identified.chain.robot
    table = read_table(targets)
    require_history(identified, table)
    points = points_from_table(table, robot)
    found = compensate(identified, points)
    commands, lengths, deviations, wanted = in_file_order(
        points, found.commands, found.lengths, found.deviations, points.configurations
    )
    frame = table.frame.copy()
    for axis, name in enumerate(robot.configuration):
        frame[name] = commands[:, axis]
    for axis, name in enumerate(robot.configuration):
        frame[f"target_{name}"] = wanted[:, axis]
    for leg in range(lengths.shape[1]):
        frame[f"leg{leg + 1}_m"] = lengths[:, leg]
    for axis, name in enumerate(robot.coordinates.deviation):
        frame[name] = deviations[:, axis]
    write_file(out, csv_text(frame))
    note(
        f"{len(frame)} commands found in {found.iterations} passes "
        f"(predicted pose within {found.residual:.1g} m or rad of the target)"
    )
    print(out)
