"""Tables in units of choice: columns become SI columns where a table is read, and are written in other units.

Units are written in many ways (`DX (mm)`, `dz mm`); what can mean one thing only is read so. Columns that are known by
their names are handed in (`known_columns.py`).
"""

from collections.abc import Collection

import pandas as pd

from expdesign.errors import InputError
from expdesign.io.known_columns import KnownColumns
from expdesign.io.units import NUMBER, Unit, measured_column, wanted_units


def in_si(
    frame: pd.DataFrame, source: str, known: KnownColumns
) -> tuple[pd.DataFrame, dict[str, str], tuple[str, ...]]:
    """The cells of a table (text) with every column that names another unit converted to SI, the names in the file of
    the columns that were read otherwise by their SI names, and the units from which columns were converted.

    Cells that are not numbers stay as they are, so that whoever needs the column says where they stand.

    Raises:
        InputError: a unit contradicts what its column measures, two columns give the same quantity, or a column is
            nearly a known one.
    """
    names: dict[str, str] = {}
    written: dict[str, str] = {}
    units: dict[str, None] = {}
    columns: dict[str, pd.Series] = {}
    measured = {name: measured_column(name, f"{source}, column {name}") for name in map(str, frame.columns)}
    taken = {*measured, *(found.si_name for found in measured.values() if found is not None)}
    for column, stated in measured.items():
        # In other letters than a column that is there, it is another one.
        found = stated if stated and (stated.unit.name in column or stated.si_name not in measured) else None
        name = found.si_name if found else _respelt(frame[column], column, taken, source, known)
        if name in names:
            what = f"the columns {names[name]} and {column} give the same quantity"
            raise InputError(what, where=f"{source}, column {column}", remedy="Keep one of them.")
        names[name] = column
        columns[name] = frame[column]
        if found is not None and not found.is_si:  # cells that are numbers
            columns[name] = frame[column].map(
                lambda cell, unit=found.unit: repr(unit.to_si(cell)) if NUMBER.fullmatch(cell.strip()) else cell
            )
            units[found.unit.name] = None
        if name != column:
            written[name] = column
    return pd.DataFrame(columns, dtype=str) if written else frame, written, tuple(units)


def _respelt(cells: "pd.Series[str]", column: str, taken: Collection[str], source: str, known: KnownColumns) -> str:
    """The name of a column without a unit, which may be in other letters.

    Raises:
        InputError: it is nearly the name of a known column that is missing.
    """
    plain = known.in_other_letters(column)
    if plain is not None and plain not in taken:
        return plain
    near = known.meant(column)
    numeric = all(NUMBER.fullmatch(cell.strip()) or cell.strip() == "" for cell in cells)
    if near is not None and near not in taken and numeric:
        what = f"the column `{column}` is not known"
        other = " Its unit stands behind the underscore." if known.has_unit(near) else ""
        remedy = f"Did you mean `{near}`?{other}"
        raise InputError(what, where=f"{source}, column {column}", remedy=remedy)
    return column


def in_units(frame: pd.DataFrame, units: str | None) -> pd.DataFrame:
    """A frame with SI columns in the units of a list such as `mm,mrad` (`wanted_units`); others stay as they are.

    Raises:
        InputError: a unit is unknown, or three measure the same.
    """
    if units is None:
        return frame
    wanted = wanted_units(units)
    columns = {}
    for column in map(str, frame.columns):
        measured = measured_column(column)
        unit = None if measured is None else wanted.of(measured)
        if measured is None or unit is None or not measured.is_si:
            columns[column] = frame[column]
            continue
        columns[f"{measured.base}_{unit.name}"] = frame[column].map(lambda cell, unit=unit: _in_unit(cell, unit))
    return pd.DataFrame(columns)


def _in_unit(cell: object, unit: Unit) -> object:
    text = repr(float(cell)) if isinstance(cell, float) else str(cell)
    return unit.from_si(text) if NUMBER.fullmatch(text.strip()) else cell
