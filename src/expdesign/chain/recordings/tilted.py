"""Rows under a tilted base: the tilt is stated as in a configuration, and read as the gravity of the row."""

from dataclasses import replace

import numpy as np

from expdesign.io.table import Table
from expdesign.mechanics.loads.load import tilted_gravity
from expdesign.mechanics.robots.robot import Robot


def with_gravity(table: Table, robot: Robot) -> Table:
    """The table with gravity in the place of tilts.

    Raises:
        InputError: a row has both.
    """
    tilts, gravity = robot.coordinates.tilt, robot.coordinates.gravity
    stated = [name for name in tilts if table.has(name)]
    if not stated:
        return table
    both = [name for name in gravity if table.has(name)]
    if both:
        raise table.fault(f"gravity is stated as well, by {', '.join(both)}", column=stated[0], remedy="Leave one out.")
    angles = [table.numbers((name,))[:, 0] if table.has(name) else np.zeros(len(table)) for name in tilts]
    (found,) = tilted_gravity(robot.gravity)(np.column_stack(angles))
    columns = {name: [repr(float(value)) for value in found[:, i]] for i, name in enumerate(gravity)}
    return replace(table, frame=table.frame.drop(columns=stated).assign(**columns))
