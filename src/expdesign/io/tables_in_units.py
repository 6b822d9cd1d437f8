"""Tables in units of choice: columns become SI columns where a table is read, and are written in other units.

Units are written in many ways (`DX (mm)`, `dz mm`); what can mean one thing only is read so. Columns that are known by
their names are handed in (`known_columns.py`).
"""

import re
from collections.abc import Collection
from dataclasses import dataclass

import pandas as pd

from expdesign.errors import InputError
from expdesign.io.known_columns import NONE_KNOWN, KnownColumns
from expdesign.io.units import (
    NUMBER,
    SI,
    UNITS,
    MeasuredColumn,
    Unit,
    measured_column,
    quantities,
    unit_of,
    wanted_units,
)

_FORMS = (
    re.compile(r"(?P<base>\w[\w ]*?)[\s_]*[\[(]\s*(?P<unit>[^\[\]()]+?)\s*[\])]"),
    re.compile(r"(?P<base>\w+)\s+(?P<unit>\S+)"),
    re.compile(r"(?P<base>\w+)_(?P<unit>[^_\s]+(?:_s2)?)"),
)


def measured_as(name: str, where: str = "") -> MeasuredColumn | None:
    """Quantity and unit of a column whose name says both in other letters or with other marks, or None.

    Raises:
        InputError: its unit may be one of two (`MN` in capitals).
    """
    for form in _FORMS:
        found = form.fullmatch(name.strip())
        if found is None:
            continue
        base = re.sub(r"\s+", "_", found["base"].strip()).lower()
        dimensions = quantities(base)
        unit = unit_of(found["unit"])
        capitals = name.isupper() and found["unit"].isalpha()  # `MN` may then be mN
        if dimensions and (unit is None or unit.dimension not in dimensions or capitals):
            text = found["unit"].replace(" ", "")
            units = [one for one in UNITS.values() if one.name.lower() == text.lower() and one.dimension in dimensions]
            if len(units) > 1:
                what = f"the unit {found['unit']} may be {' or '.join(one.name for one in units)}"
                raise InputError(what, where=where, remedy="Write it in its own letters.")
            unit = units[0] if units else None
        if dimensions and unit is not None:
            return MeasuredColumn(base, unit)
    return None


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


def in_si(frame: pd.DataFrame, source: str, known: KnownColumns = NONE_KNOWN) -> SiFrame:
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
    exact = {found[0] for column in map(str, frame.columns) if (found := _stated(column, source)) is not None}
    exact |= set(map(str, frame.columns))
    for column in map(str, frame.columns):
        name, unit = _stated(column, source) or _spelt(frame[column], column, exact, source, known)
        if name in names:
            what = f"the columns {names[name]} and {column} give the same quantity"
            raise InputError(what, where=f"{source}, column {column}", remedy="Keep one of them.")
        names[name] = column
        convert = unit is not None and unit.name != SI[unit.dimension]
        columns[name] = frame[column]
        if convert:  # cells that are numbers
            columns[name] = frame[column].map(
                lambda cell, unit=unit: repr(unit.to_si(cell)) if NUMBER.fullmatch(cell.strip()) else cell
            )
        if name != column:
            written[name] = column
        if unit is not None and convert:
            units[unit.name] = None
    return SiFrame(pd.DataFrame(columns, dtype=str) if written else frame, written, tuple(units))


def _stated(column: str, source: str) -> tuple[str, Unit | None] | None:
    """SI name and unit of a column that names both, or None."""
    measured = measured_column(column, f"{source}, column {column}")
    return None if measured is None else (measured.si_name, measured.unit)


def _spelt(
    cells: "pd.Series[str]", column: str, taken: Collection[str], source: str, known: KnownColumns
) -> tuple[str, Unit | None]:
    """The same of a column in other letters; any other column keeps its name.

    Raises:
        InputError: it is nearly the name of a known column that is missing.
    """
    measured = measured_as(column, f"{source}, column {column}")
    if measured is not None and measured.si_name not in taken:
        return measured.si_name, measured.unit
    plain = known.in_other_letters(column)
    if plain is not None and plain not in taken:
        return plain, None
    near = known.meant(column)
    numeric = all(NUMBER.fullmatch(cell.strip()) or cell.strip() == "" for cell in cells)
    if near is not None and near not in taken and numeric:
        what = f"the column `{column}` is not known"
        other = " Its unit stands behind the underscore." if known.has_unit(near) else ""
        remedy = f"Did you mean `{near}`?{other}"
        raise InputError(what, where=f"{source}, column {column}", remedy=remedy)
    return column, None


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
