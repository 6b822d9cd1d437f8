"""The columns of recordings, declared once, and how each is read; every fault is named with file, row and column.

`RECORDED` says what every column means, which a reader takes as known and `file-formats.md` shows. What a column must
fulfil stands in the function that reads it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.recordings import POSITION, POSITION_DEVIATION, measured_names
from expdesign.chain.recordings.spans import SPANS
from expdesign.coordinates import SPATIAL, Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table
from expdesign.mechanics.robots.robot import Robot

REFERENCE = "reference"
"""Column that names the unloaded reading of a row; empty where nothing is known of it."""
LARGEST_DEFLECTION = 0.1
"""m; a larger "deflection" is a wrong unit or an absolute pose."""
LARGEST_ROTATION = 0.2
"""rad; likewise."""
SMALLEST_DEVIATION = 1e-18
"""m, rad; no instrument has a smaller one."""
FARTHEST = 1e4
"""m; no instrument of this kind sees a position farther away."""
POSITION_DEVIATIONS = (1e-12, 0.5)
"""m; a standard deviation of a position outside of it is in a wrong unit."""


@dataclass(frozen=True)
class ColumnGroup:
    """Columns that are written down together.

    Attributes:
        shown: their names on the page of file formats, those of a hexapod where they depend on the robot.
        meaning: with what holds where they are left out.
        of: their names for a robot.
    """

    shown: str
    meaning: str
    of: Callable[[Robot], tuple[str, ...]]


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _named(*names: str) -> Callable[[Robot], tuple[str, ...]]:
    return lambda robot: names


def _of(group: str) -> Callable[[Robot], tuple[str, ...]]:
    return lambda robot: getattr(robot.coordinates, group)


def whole_load(coordinates: Coordinates) -> tuple[str, ...]:
    """Columns of the whole load, where the reference state was loaded itself."""
    return tuple(f"abs_{name}" for name in coordinates.wrench)


def leg_temperatures(robot: Robot) -> tuple[str, ...]:
    """Columns of sensors in the legs or joints."""
    return tuple(f"leg{i + 1}_degC" for i in range(len(robot.stiffness)))


RECORDED = (
    ColumnGroup("`sequence`", "whole number, unique: the order in time", _named("sequence")),
    ColumnGroup(
        "`series`",
        "whole number; rows of one series have one command, and deflections from the unloaded state at its start",
        _named("series"),
    ),
    ColumnGroup(
        "`time_s`",
        "time since the first row of the recordings, also in points; optional, required for creep and drift with time",
        _named("time_s"),
    ),
    ColumnGroup(
        _listed(SPATIAL.pose),
        "commanded pose; `x_m`, `y_m` of a bipod; `q1_rad` or `q1_m`, … of an arm (or a joint by name, `elbow_rad`), "
        "and `NAME_rad` or `NAME_m` of its `branch_joints`",
        lambda robot: robot.configuration,
    ),
    ColumnGroup("`tip`", "name of the row's tip, where an arm has several", _named()),
    ColumnGroup(
        "`NAME_mass_kg`, `NAME_com_x_m`, `NAME_com_y_m`, `NAME_com_z_m`",
        "payloads of an arm's `payload_links`, in their frames",
        _named(),
    ),
    ColumnGroup(_listed(SPATIAL.wrench), "assumed wrench; or a payload", _of("wrench")),
    ColumnGroup(
        _listed(("mass_kg", *SPATIAL.centre_of_mass)),
        "assumed payload in P; or a wrench",
        lambda robot: ("mass_kg", *robot.coordinates.centre_of_mass),
    ),
    ColumnGroup(
        _listed(SPATIAL.deflection),
        "measured deflection; at least one component",
        _of("deflection"),
    ),
    ColumnGroup(
        _listed(SPATIAL.deviation),
        "standard deviation of each measured component; optional: else it is estimated, and χ² is no test",
        _of("deviation"),
    ),
    ColumnGroup(
        "`abs_fx_N`, …, `abs_mz_Nm`",
        "whole load, where the reference state was loaded and the wrench is a change; optional, default 0",
        lambda robot: whole_load(robot.coordinates),
    ),
    ColumnGroup(_listed(SPATIAL.gravity), "gravity of this row in O, where the base turns; optional", _of("gravity")),
    ColumnGroup(
        "`temperature_degC`; `leg1_degC`, …",
        "temperature, or that of each leg; optional",
        lambda robot: ("temperature_degC", *leg_temperatures(robot)),
    ),
    ColumnGroup(
        "`reference`",
        "name of the unloaded reading; rows of one name share its noise, half of each row's variance; optional",
        _named(REFERENCE),
    ),
    ColumnGroup("`split`", "`train` or `test`; rows marked `test` are never fitted; optional", _named("split")),
    ColumnGroup(
        "`station`",
        "number of a group of rows that were measured together; `diagnose` leaves out such groups (at least five; else "
        "series, else consecutive rows); optional",
        _named(),
    ),
    ColumnGroup("`marker`", "name of the marker whose position was measured", _named("marker")),
    ColumnGroup(_listed(POSITION), "its position in the instrument's frame", _named(*POSITION)),
    ColumnGroup(_listed(POSITION_DEVIATION), "standard deviations; optional", _named(*POSITION_DEVIATION)),
    ColumnGroup(
        "`measured_x_m` … `measured_rz_rad`",
        "measured pose, in place of deflections, with the same standard deviations",
        lambda robot: measured_names(robot.coordinates),
    ),
)
"""Every column; `tip` and what links carry are read with the joints, `station` is kept for a diagnosis."""


def known_columns(robot: Robot) -> set[str]:
    """Columns that mean something in recordings of a robot; others are kept and reported."""
    return {name for columns in RECORDED for name in columns.of(robot)}


def require_mass(table: Table, column: str) -> None:
    """Raise an `InputError` where a column holds a negative mass (kg)."""
    masses = table.numbers((column,))[:, 0]
    table.refuse(masses < 0.0, (column,), "a mass cannot be negative", "Correct it.")


def read_payload(table: Table, coordinates: Coordinates) -> FloatArray:
    """Mass (kg) and centre of mass (m), shape (N, 1 to 4)."""
    payload = table.numbers(("mass_kg", *coordinates.centre_of_mass))
    require_mass(table, "mass_kg")
    return payload


def order_in_time(table: Table) -> IntArray:
    """Rows in the order of their sequence numbers, or of the file where there are none, shape (N,)."""
    if not table.has("sequence"):
        return np.arange(len(table))
    order: IntArray = np.argsort(table.integers("sequence"), kind="stable")
    return order


def read_sequence(table: Table) -> IntArray:
    """Sequence numbers as they stand in the file (counted from 1 where there are none), shape (N,)."""
    sequence = table.integers("sequence") if table.has("sequence") else np.arange(len(table)) + 1
    repeated = pd.Series(sequence).duplicated().to_numpy()
    if repeated.any():
        row = int(np.argmax(repeated))
        what = f"the sequence number {sequence[row]} stands there twice"
        raise InputError(what, where=table.where(row, "sequence"), remedy="Number the rows in the order of recording.")
    return sequence


def read_time(table: Table, order: IntArray) -> FloatArray | None:
    """Times in the order of the sequence (s), shape (N,), or None where there are none."""
    if not table.has("time_s"):
        return None
    time = table.numbers(("time_s",))[order, 0]
    if np.any(np.diff(time) < 0.0):
        row = int(order[int(np.argmax(np.diff(time) < 0.0)) + 1])
        what = "time runs backwards in the order of `sequence`"
        raise InputError(what, where=table.where(row, "time_s"), remedy="Correct `sequence` or `time_s`.")
    return time


def require_one_command(
    table: Table, names: tuple[str, ...], configurations: FloatArray, series: IntArray, order: IntArray
) -> None:
    """Raise where rows of one series have different commands (N, n_q), rows in the order of the sequence."""
    _, first, index = np.unique(series, return_index=True, return_inverse=True)
    differs = np.abs(configurations - configurations[first[index]]) > 1e-9
    what = "the command differs from that of the first row of series {:g}"
    remedy = "Rows of one series share one command; give the row a series of its own, or correct the command."
    table.refuse(differs, names, what, remedy, order, np.broadcast_to(series[:, None], differs.shape))


def read_deflections(table: Table, coordinates: Coordinates, order: IntArray) -> tuple[IntArray, FloatArray]:
    """Indices of the measured components (k,) and the deflections (m, rad) in the order of the sequence (N, k)."""
    axes = np.array([i for i, name in enumerate(coordinates.deflection) if table.has(name)], dtype=np.int64)
    if axes.size == 0:
        if table.has("px_m") or table.has("marker"):
            what = "recordings of marker positions are not supported for this kind of robot"
            raise InputError(what, where=table.where(), remedy="Convert them to deflections.")
        columns = ", ".join(coordinates.deflection)
        raise InputError(
            "there is no measured column", where=table.where(), remedy=f"Fill in at least one of {columns}."
        )
    if table.has("px_m"):
        what = f"there are marker positions beside the deflections {coordinates.deflection[axes[0]]} ..."
        raise InputError(what, where=table.where(column="px_m"), remedy="One file holds one of them; take one out.")
    names = tuple(coordinates.deflection[i] for i in axes)
    deflections = table.numbers(names)[order]
    remedy = "Check the unit (m, rad), and that it is not an absolute pose."
    for column, largest in enumerate(_largest(coordinates, axes)):
        what = f"{{:g}} cannot be a deflection (the largest taken for one is {largest:g})"
        values = deflections[:, column]
        table.refuse(np.abs(values) > largest, (names[column],), what, remedy, order, values)
    return axes, deflections


def read_deviations(table: Table, coordinates: Coordinates, axes: IntArray, order: IntArray) -> FloatArray | None:
    """Standard deviations of the measured components (m, rad) (N, k), or None where the file states none."""
    names = tuple(coordinates.deviation[i] for i in axes)
    if not any(table.has(name) for name in names):
        return None
    deviations = table.numbers(names)[order]
    unit, largest = "Check the unit (m, rad).", _largest(coordinates, axes)
    for wrong, what, remedy in (
        (deviations <= 0.0, "a standard deviation must be positive, not {:g}", "Correct it."),
        (deviations < SMALLEST_DEVIATION, "{:g} is smaller than the standard deviation of any instrument", unit),
        (deviations > largest, "{:g} cannot be the standard deviation of a deflection", unit),
    ):
        table.refuse(wrong, names, what, remedy, order, deviations)
    return deviations


def read_test_rows(table: Table, order: IntArray) -> BoolArray:
    """Rows that must not be fitted, in the order of the sequence, shape (N,)."""
    if not table.has("split"):
        return np.zeros(len(table), dtype=bool)
    test: BoolArray = (table.words("split", ("train", "test", ""), "`{}` is neither `train` nor `test`") == "test")[
        order
    ]
    return test


def read_markers(table: Table, order: IntArray) -> tuple[IntArray | None, tuple[str, ...]]:
    """Index of every row's marker in the order of the sequence (N,), or None, and the markers' names."""
    if not table.has("marker"):
        if table.has("px_m") or any(table.has(name) for name in SPANS):
            remedy = "Name the marker of each row (one name where there is one marker)."
            raise InputError("the column is missing", where=table.where(column="marker"), remedy=remedy)
        return None, ()
    names = table.frame["marker"].astype(str).str.strip().to_numpy()
    table.refuse(np.array([name == "" for name in names]), ("marker",), "the marker has no name", "Write its name.")
    markers, index = np.unique(names, return_inverse=True)
    chosen: IntArray = index[order].astype(np.int64)
    return chosen, tuple(str(name) for name in markers)


def read_positions(table: Table, coordinates: Coordinates, order: IntArray) -> FloatArray:
    """Measured positions (m) in the order of the sequence, NaN where a coordinate was not read, shape (N, 3)."""
    for name in coordinates.deflection:
        if table.has(name):
            what = f"there are marker positions beside the deflections {name} ..."
            raise InputError(what, where=table.where(column=name), remedy="One file holds one of them; take one out.")
    positions = table.numbers_where_filled(POSITION)[order]
    seen = np.isfinite(np.hstack([positions, table.numbers_where_filled(SPANS)[order]]))
    empty = np.logical_not(seen.any(axis=1, keepdims=True))
    table.refuse(empty, POSITION, "no coordinate was measured", "Fill one in, or remove the row.", order)
    far = np.abs(np.nan_to_num(positions)) > FARTHEST
    table.refuse(far, POSITION, "{:g} cannot be a position in m", "Check the unit.", order, positions)
    return positions


def read_position_deviations(table: Table, order: IntArray) -> FloatArray | None:
    """Standard deviations of the positions (m), NaN where no coordinate was read, shape (N, 3); None without any."""
    if not any(table.has(name) for name in POSITION_DEVIATION):
        return None
    deviations = table.numbers_where_filled(POSITION_DEVIATION)[order]
    missing = np.isfinite(table.numbers_where_filled(POSITION)[order]) & ~np.isfinite(deviations)
    remedy = "Fill it in, or leave the columns of standard deviations out to have them estimated."
    table.refuse(missing, POSITION_DEVIATION, "the standard deviation is missing", remedy, order)
    wrong = (deviations < POSITION_DEVIATIONS[0]) | (deviations > POSITION_DEVIATIONS[1])
    what = "{:g} cannot be the standard deviation of a position in m"
    table.refuse(wrong, POSITION_DEVIATION, what, "It is positive; check the unit.", order, deviations)
    return deviations


def _largest(coordinates: Coordinates, axes: IntArray) -> FloatArray:
    return np.where(axes < coordinates.translations, LARGEST_DEFLECTION, LARGEST_ROTATION)
