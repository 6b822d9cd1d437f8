"""What was measured, read by the kind of quantity that the columns of a table hold."""

from collections.abc import Callable

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.columns import read_deflections, read_deviations
from expdesign.chain.recordings.measurand import DEFLECTIONS, POSES, POSITIONS, Measurand
from expdesign.chain.recordings.pose_columns import read_measured
from expdesign.chain.recordings.positions import read_position_deviations, read_positions
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.recordings.spans import read_span_deviations, read_spans
from expdesign.chain.recordings.target_readings import read_turn_deviations, turned
from expdesign.coordinates import Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table

Measured = tuple[IntArray, FloatArray, FloatArray | None]
"""Indices of the measured components (k,), readings (N, k) and their standard deviations (N, k), where stated."""


def _deflections(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings = read_deflections(table, coordinates, order)
    return axes, readings, read_deviations(table, coordinates, axes, order)


def _poses(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings = read_measured(table, points, coordinates, order)
    return axes, readings, read_deviations(table, coordinates, axes, order)


def _positions(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings, deviations = _points(table, points, coordinates, order)
    if points.point is None:
        return axes, readings, deviations
    spans, stated = read_spans(table, order), read_span_deviations(table, order)
    readings, axes = np.hstack([readings, spans]), np.concatenate([axes, [6, 7]])
    seen: BoolArray = np.logical_or.reduce(np.isfinite(readings), axis=0)
    if (stated is None) != (deviations is None) and seen[:-2].any():
        what = "standard deviations of positions or of distances are missing where the others are stated"
        raise InputError(what, where=table.where(), remedy="State both, or none to have them estimated.")
    if stated is None:
        return axes[seen], readings[:, seen], None
    none = np.full((len(readings), len(axes) - 2), np.nan)
    both = np.hstack([none if deviations is None else deviations, stated])
    return axes[seen], readings[:, seen], both[:, seen]


def _points(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    positions, deviations = read_positions(table, coordinates, order), read_position_deviations(table, order)
    if points.aim is None:
        return np.arange(3), positions, deviations
    rotations = turned(table, order)
    stated = read_turn_deviations(table, coordinates, rotations, order)
    if (stated is None) != (deviations is None):
        what = "standard deviations of positions or of orientations are missing where the others are stated"
        raise InputError(what, where=table.where(), remedy="State both, or none to have them estimated.")
    both = None if stated is None or deviations is None else np.hstack([deviations, stated])
    return np.arange(6), np.hstack([positions, rotations]), both


READERS: dict[Measurand, Callable[[Table, LoadedPoints, Coordinates, IntArray], Measured]] = {
    DEFLECTIONS: _deflections,
    POSES: _poses,
    POSITIONS: _positions,
}
