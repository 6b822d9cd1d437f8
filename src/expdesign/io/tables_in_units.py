"""Tables in units of choice: columns become SI columns where a table is read, and are written in other units."""

from collections.abc import Collection
from dataclasses import dataclass

import pandas as pd

from expdesign.errors import InputError
from expdesign.io.column_names import PLAIN, meant, measured_as, plain_as
from expdesign.io.units import NUMBER, SI, Unit, measured_column, wanted_units


@dataclass(frozen=True)
class SiFrame:
    """A frame whose columns are in SI.

    Attributes:
        frame: the cells.
        written: name in the file of every column that was converted, by its SI name.
        units: from which columns were converted.
    """

    frame: pd.DataFrame
    written: dict[str, str]
    units: tuple[str, ...] = ()


def in_si(frame: pd.DataFrame, source: str) -> SiFrame:
    """The cells of a table (text) with every column that names another unit converted to SI.

    Cells that are not numbers stay as they are, so that whoever needs the column says where they stand.

    Raises:
        InputError: a unit contradicts what its column measures, two columns give the same quantity, or a column is
            nearly a known one.
    """
    names: dict[str, str] = {}
    written: dict[str, str] = {}
    units: dict[str, None] = {}
    columns: dict[str, pd.Series] = {}
    exact = {known[0] for column in map(str, frame.columns) if (known := _stated(column, source)) is not None}
    exact |= set(map(str, frame.columns))
    for column in map(str, frame.columns):
        name, unit = _stated(column, source) or _spelt(frame[column], column, exact, source)
        if name in names:
            what = f"the columns {names[name]} and {column} give the same quantity"
            raise InputError(what, where=f"{source}, column {column}", remedy="Keep one of them.")
        names[name] = column
        convert = unit is not None and unit.name != SI[unit.dimension]
        columns[name] = frame[column].map(lambda cell, unit=unit: _cell_in_si(cell, unit)) if convert else frame[column]
        if name != column:
            written[name] = column
        if unit is not None and convert:
            units[unit.name] = None
    return SiFrame(pd.DataFrame(columns, dtype=str) if written else frame, written, tuple(units))


def _stated(column: str, source: str) -> tuple[str, Unit | None] | None:
    """SI name and unit of a column that names both, or None."""
    try:
        measured = measured_column(column)
    except InputError as error:
        raise InputError(error.what, where=f"{source}, column {column}", remedy=error.remedy) from None
    return None if measured is None else (measured.si_name, measured.unit)


def _spelt(cells: "pd.Series[str]", column: str, taken: Collection[str], source: str) -> tuple[str, Unit | None]:
    """The same of a column in other letters; any other column keeps its name.

    Raises:
        InputError: it is nearly the name of a known column that is missing.
    """
    try:
        measured = measured_as(column)
    except InputError as error:
        raise InputError(error.what, where=f"{source}, column {column}", remedy=error.remedy) from None
    if measured is not None and measured.si_name not in taken:
        return measured.si_name, measured.unit
    plain = plain_as(column)
    if plain is not None and plain not in taken:
        return plain, None
    known = meant(column)
    numeric = all(NUMBER.fullmatch(cell.strip()) or cell.strip() == "" for cell in cells)
    if known is not None and known not in taken and numeric:
        what = f"the column `{column}` is not known"
        other = "" if known in PLAIN else " Its unit stands behind the underscore."
        remedy = f"Did you mean `{known}`?{other}"
        raise InputError(what, where=f"{source}, column {column}", remedy=remedy)
    return column, None


def _cell_in_si(cell: str, unit: Unit) -> str:
    return repr(unit.to_si(cell)) if NUMBER.fullmatch(cell.strip()) else cell


def in_units(frame: pd.DataFrame, units: str | None) -> pd.DataFrame:
    """A frame with SI columns in the units of a list such as `mm,mrad`; other columns stay as they are.

    Raises:
        InputError: a unit is unknown, or two measure the same.
    """
    if units is None:
        return frame
    wanted = wanted_units(units)
    columns = {}
    for column in map(str, frame.columns):
        measured = measured_column(column)
        unit = None if measured is None else wanted.get(measured.unit.dimension)
        if measured is None or unit is None or not measured.is_si:
            columns[column] = frame[column]
            continue
        columns[f"{measured.base}_{unit.name}"] = frame[column].map(lambda cell, unit=unit: _in_unit(cell, unit))
    return pd.DataFrame(columns)


def _in_unit(cell: object, unit: Unit) -> object:
    text = repr(float(cell)) if isinstance(cell, float) else str(cell)
    return unit.from_si(text) if NUMBER.fullmatch(text.strip()) else cell
