"""Lists of named points as trackers and their software write them.

One point a line: its name, three coordinates, and its three standard deviations where they were exported. Understood
are

    Collection::Group::Point X Y Z        SpatialAnalyzer (also `Collection Group Point`, `Group Point`, commas)
    Point;X;Y;Z                           PolyWorks and others, with commas, semicolons, tabulators or blanks
    Point X Y Z  or  X Y Z                plain; points without names are numbered in their order

Lines that begin with `//`, `#`, `!` or `%` are comments. The unit is that of a comment or a header (`// Units: mm`,
`X [mm]`, `X_mm`), or is given; it is never guessed.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.io.table_text import table_text
from expdesign.io.units import NUMBER, Unit, known_units, unit_of

_COMMENT = ("//", "#", "!", "%")
_UNITS = re.compile(r"\bunits?\b\W*([A-Za-zµμ]+)", re.IGNORECASE)
_HEADED = re.compile(r"\bx\s*[\[(_]\s*([A-Za-zµμ]+)", re.IGNORECASE)
_COMMA = re.compile(r"([-+]?\d*),(\d+(?:[eE][-+]?\d+)?)")
"""A number with a decimal comma."""
_WORDS = {
    "millimeters": "mm", "millimetres": "mm", "millimeter": "mm", "millimetre": "mm", "meters": "m", "metres": "m",
    "meter": "m", "metre": "m", "inches": "in", "inch": "in", "micrometers": "um", "microns": "um",
    "centimeters": "cm", "centimetres": "cm",
}  # fmt: skip


@dataclass(frozen=True)
class MeasuredPoint:
    """One point (m) with its standard deviations (m), shape (3,) each; None where they are not stated."""

    position: FloatArray
    deviation: FloatArray | None
    where: str


@dataclass(frozen=True)
class PointSet:
    """The points of one state of the machine.

    Attributes:
        name: of the group, or of the file where it names none.
        source: the file.
        points: by name.
    """

    name: str
    source: str
    points: Mapping[str, MeasuredPoint]


def read_point_sets(path: Path, unit: Unit | None = None) -> list[PointSet]:
    """The groups of points in a file, in its order.

    Args:
        path: text in any usual encoding.
        unit: of the coordinates, where the file states none.

    Raises:
        InputError: the file is missing or no list of points, states no unit or another one than `unit`, or names a
            point twice.
    """
    text, _ = table_text(path)
    found: dict[str, dict[str, MeasuredPoint]] = {}
    stated: Unit | None = None
    raw: list[tuple[int, str, str, list[float]]] = []
    for number, line in enumerate(text.splitlines(), 1):
        where = f"{path}, row {number}"
        if not line.strip():
            continue
        if line.strip().startswith(_COMMENT):
            stated = _unit_in(line, stated, where)
            continue
        cells = _cells(line)
        _no_halves(line, cells, where)
        count = _trailing_numbers(cells)
        if count not in (3, 6):
            if raw:
                what = f"`{line.strip()[:40]}` is no point: a name and 3 coordinates (and 3 deviations) are needed"
                raise InputError(what, where=where, remedy="Correct the line. Is the file cut off?")
            stated = _unit_in(line, stated, where)  # a header
            continue
        names = _names(cells[:-count])
        group = names[-2] if len(names) > 1 else ""
        raw.append((number, group, names[-1] if names else "", [float(cell) for cell in cells[-count:]]))
    unit = _agreed(unit, stated, str(path))
    if not raw:
        raise InputError("there are no points", where=str(path), remedy="A line needs a name and three coordinates.")
    for number, group, name, values in raw:
        points = found.setdefault(group or path.stem, {})
        label, where = name or str(len(points) + 1), f"{path}, row {number}"
        if label in points:
            what = f"the point {label} stands there twice{f' in group {group}' if group else ''}"
            raise InputError(what, where=where, remedy="Name every point of a group once.")
        points[label] = _point(values, unit, where)
    return [PointSet(name, str(path), points) for name, points in found.items()]


def _point(values: list[float], unit: Unit, where: str) -> MeasuredPoint:
    si = np.array([unit.to_si(value) for value in values])
    deviation = si[3:] if len(si) == 6 else None
    if deviation is not None and np.any(deviation <= 0.0):
        what = f"a standard deviation must be positive, not {values[3 + int(np.argmin(deviation))]:g}"
        raise InputError(what, where=where, remedy="Correct it, or export the points without uncertainties.")
    return MeasuredPoint(si[:3], deviation, where)


def _cells(line: str) -> list[str]:
    """The cells of a line; decimal commas are read where something else separates the cells."""
    blanks = line.split()
    if ";" not in line and "\t" not in line and len(blanks) >= 3 and all(map(_COMMA.fullmatch, blanks[-3:])):
        return [_COMMA.sub(r"\1.\2", cell) for cell in blanks]
    separator = next((mark for mark in ("\t", ";", ",") if line.count(mark) >= 2), None)
    if separator is None:
        return line.split()
    cells = [cell.strip() for cell in line.strip().rstrip(separator).split(separator)]
    if separator != ",":
        cells = [_COMMA.sub(r"\1.\2", cell) if _COMMA.fullmatch(cell) else cell for cell in cells]
    return cells


def _no_halves(line: str, cells: list[str], where: str) -> None:
    """Raise where commas stand between cells and within numbers: then a point has five whole numbers or more."""
    count = next((i for i, cell in enumerate(reversed(cells)) if re.fullmatch(r"[-+]?\d+", cell) is None), len(cells))
    if "," in line and count in (5, 6):
        what = f"`{line.strip()[:40]}` has {count} whole numbers: are they three coordinates with decimal commas?"
        remedy = "Export them with decimal points, or with semicolons between the columns."
        raise InputError(what, where=where, remedy=remedy)


def _names(cells: list[str]) -> list[str]:
    """Collection, group and point; where double colons stand between them, names may have blanks."""
    stripped = [cell.strip().strip('"') for cell in cells]
    return " ".join(stripped).split("::") if any("::" in cell for cell in stripped) else stripped


def _trailing_numbers(cells: list[str]) -> int:
    """How many of the last cells are coordinates and deviations: 3 or 6; a name before them may be a number."""
    count = 0
    while count < len(cells) and NUMBER.fullmatch(cells[-1 - count]):
        count += 1
    return {4: 3, 5: 3, 7: 6, 8: 6, 9: 6}.get(count, count)


def _unit_in(line: str, before: Unit | None, where: str) -> Unit | None:
    found = _UNITS.search(line) or _HEADED.search(line)
    if found is None:
        return before
    word = found.group(1)
    unit = unit_of(_WORDS.get(word.lower(), word)) or unit_of(word.lower())
    if unit is None or unit.dimension != "length":
        remedy = f"Known: {', '.join(known_units('length'))}."
        raise InputError(f"`{word}` is not a unit of length that is known", where=where, remedy=remedy)
    if before is not None and before != unit:
        what = f"the file states two units, {before.name} and {unit.name}"
        raise InputError(what, where=where, remedy="Correct the header.")
    return unit


def _agreed(given: Unit | None, stated: Unit | None, source: str) -> Unit:
    if given is not None and stated is not None and given != stated:
        what = f"the file is in {stated.name} by its header, and {given.name} was given"
        raise InputError(what, where=source, remedy="Leave the option out, or correct the header.")
    unit = given or stated
    if unit is None:
        remedy = "Give it (--unit mm), or write it into the file (`// Units: mm`)."
        raise InputError("the file does not state the unit of its coordinates", where=source, remedy=remedy)
    return unit
