"""`compensate`: command poses that reach the targets under load."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from expdesign.api.inputs import ModelInput, PathLike, TableInput, model_of, numeric, table_of
from expdesign.api.outputs import save_table
from expdesign.compensation.compensate import Compensation
from expdesign.compensation.compensate import compensate as commands_for
from expdesign.compensation.prediction import in_file_order, require_history
from expdesign.recordings.reader import points_from_table


@dataclass(frozen=True)
class Commands:
    """What to command.

    Attributes:
        text: the targets as they stand in a file, with the command in the pose columns.
        compensation: the same as arrays, rows in the order of their sequence, and how the commands were found.
    """

    text: pd.DataFrame
    compensation: Compensation

    @property
    def frame(self) -> pd.DataFrame:
        """The commands with numbers as numbers."""
        return numeric(self.text)

    def save(self, file: PathLike, units: str | None = None) -> Path:
        """Write the commands into a file, CSV or .xlsx, in SI or in units such as `mm,mrad`."""
        return save_table(file, self.text, units)


def compensate(model: ModelInput, targets: TableInput) -> Commands:
    """Find the commands that bring the platform to the targets under load.

    Args:
        model: identified robot.
        targets: where the platform shall be, and the load there (a payload's wrench is taken at that orientation).

    Raises:
        InputError: a file is missing or wrong.
        ConvergenceError: no command is found.
        SingularConfigurationError: the robot is singular at a target.
        InfeasibleError: a command is beyond the robot's limits.
    """
    identified = model_of(model)
    robot = identified.chain.robot
    table = table_of(targets, "targets")
    require_history(identified, table)
    points = points_from_table(table, robot)
    found = commands_for(identified, points)
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
    return Commands(frame, found)
