"""The columns of recordings that mean the same for every robot; every fault is named with file, row and column."""

import numpy as np
import pandas as pd

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.coordinates import Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table

LARGEST_DEFLECTION = 0.1
"""m; a larger "deflection" is a wrong unit or an absolute pose."""
LARGEST_ROTATION = 0.2
"""rad; likewise."""
SMALLEST_DEVIATION = 1e-18
"""m, rad; no instrument has a smaller one."""


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
    if differs.any():
        row, column = np.argwhere(differs)[0]
        what = f"the command differs from that of the first row of series {series[row]}"
        remedy = "Rows of one series share one command; give the row a series of its own, or correct the command."
        raise InputError(what, where=table.where(int(order[row]), names[column]), remedy=remedy)


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
    wrong = np.abs(deflections) > _largest(coordinates, axes)
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        largest = float(_largest(coordinates, axes)[column])
        what = f"{deflections[row, column]:g} cannot be a deflection (the largest taken for one is {largest:g})"
        where = table.where(int(order[row]), names[column])
        raise InputError(what, where=where, remedy="Check the unit (m, rad), and that it is not an absolute pose.")
    return axes, deflections


def read_deviations(table: Table, coordinates: Coordinates, axes: IntArray, order: IntArray) -> FloatArray | None:
    """Standard deviations of the measured components (m, rad) (N, k), or None where the file states none."""
    names = tuple(coordinates.deviation[i] for i in axes)
    if not any(table.has(name) for name in names):
        return None
    deviations = table.numbers(names)[order]
    for wrong, what, remedy in (
        (deviations <= 0.0, "a standard deviation must be positive, not {:g}", "Correct it."),
        (
            deviations < SMALLEST_DEVIATION,
            "{:g} is smaller than the standard deviation of any instrument",
            "Check the unit (m, rad).",
        ),
        (
            deviations > _largest(coordinates, axes),
            "{:g} cannot be the standard deviation of a deflection",
            "Check the unit (m, rad).",
        ),
    ):
        if wrong.any():
            row, column = np.argwhere(wrong)[0]
            where = table.where(int(order[row]), names[column])
            raise InputError(what.format(deviations[row, column]), where=where, remedy=remedy)
    return deviations


def read_test_rows(table: Table, order: IntArray) -> BoolArray:
    """Rows that must not be fitted, in the order of the sequence, shape (N,)."""
    if not table.has("split"):
        return np.zeros(len(table), dtype=bool)
    split = table.frame["split"].str.strip().to_numpy()
    wrong = np.flatnonzero(~np.isin(split, ["train", "test", ""]))
    if wrong.size:
        what = f"`{split[wrong[0]]}` is neither `train` nor `test`"
        raise InputError(what, where=table.where(int(wrong[0]), "split"), remedy="Correct it.")
    test: BoolArray = (split == "test")[order]
    return test


def _largest(coordinates: Coordinates, axes: IntArray) -> FloatArray:
    return np.where(axes < coordinates.translations, LARGEST_DEFLECTION, LARGEST_ROTATION)
