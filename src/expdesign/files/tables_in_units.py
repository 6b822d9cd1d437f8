"""Tables in units of choice: columns become SI columns where a table is read, and are written in other units."""

from dataclasses import dataclass

import pandas as pd

from expdesign.errors import InputError
from expdesign.files.units import NUMBER, Unit, measured_column, wanted_units


@dataclass(frozen=True)
class SiFrame:
    """A frame whose columns are in SI.

    Attributes:
        frame: the cells.
        written: name in the file of every column that was converted, by its SI name.
    """

    frame: pd.DataFrame
    written: dict[str, str]


def in_si(frame: pd.DataFrame, source: str) -> SiFrame:
    """The cells of a table (text) with every column that names another unit converted to SI.

    Cells that are not numbers stay as they are, so that whoever needs the column says where they stand.

    Raises:
        InputError: a unit contradicts what its column measures, or two columns give the same quantity.
    """
    names: dict[str, str] = {}
    written: dict[str, str] = {}
    columns: dict[str, pd.Series] = {}
    for column in map(str, frame.columns):
        name, cells = _converted(frame[column], column, source)
        if name in names:
            what = f"the columns {names[name]} and {column} give the same quantity"
            raise InputError(what, where=f"{source}, column {column}", remedy="Keep one of them.")
        names[name] = column
        columns[name] = cells
        if name != column:
            written[name] = column
    return SiFrame(pd.DataFrame(columns, dtype=str) if written else frame, written)


def _converted(cells: "pd.Series[str]", column: str, source: str) -> tuple[str, "pd.Series[str]"]:
    try:
        measured = measured_column(column)
    except InputError as error:
        raise InputError(error.what, where=f"{source}, column {column}", remedy=error.remedy) from None
    if measured is None:
        return column, cells
    if measured.is_si:
        return measured.si_name, cells
    return measured.si_name, cells.map(lambda cell: _cell_in_si(cell, measured.unit))


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
