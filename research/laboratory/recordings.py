"""Rows of a plan or of recordings: their columns, their states and their series."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from .errors import LaboratoryError
from .kinematics import Vector
from .legs import LegConditions
from .loads import Load
from .robot import Robot

_AXES = ("x", "y", "z", "rx", "ry", "rz")
_POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
_FORCE = ("fx_N", "fy_N", "fz_N")
_MOMENT = ("mx_Nm", "my_Nm", "mz_Nm")
_CENTRE = ("com_x_m", "com_y_m", "com_z_m")
_GRAVITY = ("gx_m_s2", "gy_m_s2", "gz_m_s2")


def pose_columns(robot: Robot) -> list[str]:
    """Columns of the pose: `x_m` ..."""
    return list(_POSE[: 2 if robot.planar else 6])


def deflection_columns(robot: Robot) -> list[str]:
    """Columns of the deflection: `dx_m` ..."""
    return [f"d{column}" for column in pose_columns(robot)]


def std_columns(robot: Robot) -> list[str]:
    """Columns of the standard deviation: `sx_m` ..."""
    return [f"s{column}" for column in pose_columns(robot)]


@dataclass(frozen=True)
class State:
    """One row: its place in the file, the load it states, the load of its reference, and its conditions."""

    row: int
    load: Load
    reference_load: Load
    conditions: tuple[LegConditions, ...]


@dataclass(frozen=True)
class Series:
    """Rows of one command, in the order in which they were recorded."""

    pose: Vector
    lengths: Vector | None
    states: tuple[State, ...]


class Rows:
    """A frame in plan or recordings form, read for one robot."""

    def __init__(self, frame: pd.DataFrame, robot: Robot) -> None:
        self._frame = frame
        self._robot = robot
        self._count = len(frame)
        self._poses = self._columns(pose_columns(robot), required=True)
        self._gravity = self._columns(_GRAVITY[: 2 if robot.planar else 3], fallback=robot.gravity)

    def series(self, lengths: bool = False) -> list[Series]:
        """The series of the frame, in time order; `lengths` commands `leg1_m` ... instead of the pose."""
        order = np.argsort(self._one("sequence", np.arange(self._count, dtype=float)), kind="stable").tolist()
        commands = (
            self._columns([f"leg{leg + 1}_m" for leg in range(self._robot.legs)], required=True) if lengths else None
        )
        series = []
        for rows in self._groups(order):
            first = rows[0]
            if np.abs(self._poses[rows] - self._poses[first]).max() > 1e-12:
                raise LaboratoryError(f"series of row {first + 2}: its rows have different poses")
            states = tuple(self._state(row) for row in rows)
            series.append(Series(self._poses[first], None if commands is None else commands[first], states))
        return series

    def _groups(self, order: Sequence[int]) -> list[list[int]]:
        groups: dict[object, list[int]] = {}
        if "series" in self._frame:
            numbers = self._one("series", np.zeros(self._count))
            for row in order:
                groups.setdefault(numbers[row], []).append(row)
            return list(groups.values())
        number, last = 0, None  # without the column: consecutive rows at the same pose
        for row in order:
            if last is not None and not np.array_equal(self._poses[row], self._poses[last]):
                number += 1
            groups.setdefault(number, []).append(row)
            last = row
        return list(groups.values())

    def _state(self, row: int) -> State:
        load = self._load(row)
        reference = Load.none()
        if any(column.startswith("abs_f") or column.startswith("abs_m") for column in self._frame.columns):
            whole = self._wrench(row, "abs_")
            change = load.about_origin(self._robot.pose(self._poses[row]).rotation)
            reference = Load.wrench(whole.force - change.force, whole.moment - change.moment)
            load = whole
        return State(row, load, reference, self._conditions(row))

    def _conditions(self, row: int) -> tuple[LegConditions, ...]:
        time = self._one("time_s", np.full(self._count, np.nan))[row]
        temperature = self._one("temperature_degC", np.full(self._count, np.nan))
        return tuple(
            LegConditions(float(time), float(self._one(f"leg{leg + 1}_degC", temperature)[row]), np.nan)
            for leg in range(self._robot.legs)
        )

    def _load(self, row: int) -> Load:
        mass = self._one("mass_kg", np.full(self._count, np.nan))[row]
        if np.isfinite(mass):
            centre = [self._one(column, np.zeros(self._count))[row] for column in _CENTRE]
            gravity = np.zeros(3)
            gravity[: self._gravity.shape[1]] = self._gravity[row]
            return Load.payload(float(mass), np.zeros(3) if self._robot.planar else np.array(centre), gravity)
        if not any(column in self._frame for column in _FORCE + _MOMENT):
            raise LaboratoryError(f"row {row + 2}: neither a payload (mass_kg) nor a wrench (fx_N ...)")
        return self._wrench(row, "")

    def _wrench(self, row: int, prefix: str) -> Load:
        force = [self._one(prefix + column, np.zeros(self._count))[row] for column in _FORCE]
        moment = [self._one(prefix + column, np.zeros(self._count))[row] for column in _MOMENT]
        if not np.all(np.isfinite(force + moment)):
            raise LaboratoryError(f"row {row + 2}: the load is not a number")
        return Load.wrench(np.array(force), np.array(moment))

    def _columns(self, names: Sequence[str], required: bool = False, fallback: Vector | None = None) -> Vector:
        values = []
        for index, name in enumerate(names):
            if required and name not in self._frame:
                raise LaboratoryError(f"column {name}: missing")
            start = 0.0 if fallback is None else fallback[index]
            values.append(self._one(name, np.full(self._count, start)))
        array = np.column_stack(values)
        if not np.all(np.isfinite(array)):
            row, column = np.argwhere(~np.isfinite(array))[0]
            raise LaboratoryError(f"row {row + 2}, column {names[column]}: not a number")
        return array

    def _one(self, name: str, fallback: Vector) -> Vector:
        if name not in self._frame:
            return fallback
        try:
            return self._frame[name].to_numpy(dtype=float)
        except (TypeError, ValueError):
            raise LaboratoryError(f"column {name}: holds something that is not a number") from None
