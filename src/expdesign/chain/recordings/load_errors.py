"""Errors of the recorded loads, as standard deviations in columns of their own (file-formats.md, Recordings).

`error_mass_kg`, `error_com_x_m` …, `error_fx_N` … belong to the weights that were hung on: rows of one `weight` have
one unknown error, and so have all rows where that column is missing.
"""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, TextArray
from expdesign.coordinates import Coordinates
from expdesign.io.table import Table

WEIGHT = "weight"
"""Column that names the weights of a row."""
_LEVER = 1.0
"""m; a moment is compared with the force at this lever as well, as its own origin may lie in the force."""


def error_columns(coordinates: Coordinates) -> tuple[str, ...]:
    """Columns of standard deviations of the load's errors: of a payload, then of a wrench."""
    return tuple(f"error_{name}" for name in ("mass_kg", *coordinates.centre_of_mass, *coordinates.wrench))


def read_load_errors(
    table: Table, coordinates: Coordinates, wrenches: FloatArray, payload: FloatArray | None
) -> tuple[FloatArray | None, TextArray | None]:
    """Standard deviations by `error_columns` (N, q), NaN where none is declared, and weights (N,).

    Args:
        table: the recordings.
        coordinates: of the robot.
        wrenches: recorded loads, shape (N, n).
        payload: mass and centre of mass; None where wrenches are recorded.

    Raises:
        InputError: an error is 0, missing or larger than its load, weights have two errors, or a payload's error is
            declared of a wrench.
    """
    names, first, split = error_columns(coordinates), 1 + len(coordinates.centre_of_mass), coordinates.translations
    declared = np.array([table.has(name) for name in names])
    if not declared.any():
        return None, None
    if payload is None and declared[:first].any():
        what = "the error is that of a payload, and the recordings have wrenches"
        remedy = "Add mass_kg and the centre of mass, or declare error_fx_N ... of the wrench."
        raise table.fault(what, column=names[int(np.argmax(declared))], remedy=remedy)
    errors, loaded = table.numbers_where_filled(names), (wrenches != 0.0).any(axis=1)
    missing = declared & loaded[:, None] & np.isnan(errors)
    table.refuse(missing, names, "the cell is empty", "State it in every loaded row.")
    what, remedy = (
        "{:g} is not a standard deviation",
        "State how well the load is known, or leave the column out where it",
    )
    table.refuse(loaded[:, None] & (errors <= 0.0), names, what, f"{remedy} is exact.", errors)
    # A centre of mass has no limit.
    limits = np.full(errors.shape, np.inf)
    if payload is not None:
        limits[:, 0] = payload[:, 0]
    force = np.linalg.norm(wrenches[:, :split], axis=1, keepdims=True)
    limits[:, first : first + split] = force
    limits[:, first + split :] = np.linalg.norm(wrenches[:, split:], axis=1, keepdims=True) + _LEVER * force
    what = "the error ({:g}) is larger than the load itself"
    table.refuse(loaded[:, None] & (errors > limits), names, what, "Is it in SI units?", errors)
    errors[np.ix_(~loaded, declared)] = 0.0
    weight = table.text(WEIGHT).astype(str) if table.has(WEIGHT) else None
    _require_one_each(table, names, errors, loaded, weight)
    return errors, weight


def _require_one_each(
    table: Table,
    names: tuple[str, ...],
    errors: FloatArray,
    loaded: BoolArray,
    weight: TextArray | None,
) -> None:
    """Raise where rows that share an error state two standard deviations of it."""
    labels = np.full(len(errors), "") if weight is None else weight
    for label in np.unique(labels[loaded]):
        rows = np.flatnonzero(loaded & (labels == label))
        own = errors[rows]
        differs = np.abs(own - own[0]) > 1e-9 * np.abs(own[0])
        if differs.any():
            row, column = np.argwhere(differs)[0]
            said = "all rows share it" if weight is None else f"weight `{label}` has it"
            what = f"the error is {own[row, column]:g} here and {own[0, column]:g} before, and {said}"
            remedy = f"Name the weights of every row in a column `{WEIGHT}`, or state one error for each."
            raise table.fault(what, int(rows[row]), names[column], remedy=remedy)
