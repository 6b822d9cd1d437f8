"""What was measured, read by the kind of quantity that the columns of a table hold."""

from collections.abc import Callable

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.coordinates import Coordinates
from expdesign.files.table import Table
from expdesign.recordings.columns import read_deflections, read_deviations
from expdesign.recordings.measurand import DEFLECTIONS, POSES, POSITIONS, Measurand
from expdesign.recordings.pose_columns import read_measured
from expdesign.recordings.positions import read_position_deviations, read_positions
from expdesign.recordings.recordings import LoadedPoints

Measured = tuple[IntArray, FloatArray, FloatArray | None]
"""Indices of the measured components (k,), readings (N, k) and their standard deviations (N, k), where stated."""


def _deflections(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings = read_deflections(table, coordinates, order)
    return axes, readings, read_deviations(table, coordinates, axes, order)


def _poses(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings = read_measured(table, points, coordinates, order)
    return axes, readings, read_deviations(table, coordinates, axes, order)


def _positions(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    return np.arange(3), read_positions(table, coordinates, order), read_position_deviations(table, order)


READERS: dict[Measurand, Callable[[Table, LoadedPoints, Coordinates, IntArray], Measured]] = {
    DEFLECTIONS: _deflections,
    POSES: _poses,
    POSITIONS: _positions,
}
