"""Lists of named points as trackers and their software write them.

One point a line: its name, three coordinates, and its three standard deviations where they were exported. Understood
are

    Collection::Group::Point X Y Z        SpatialAnalyzer (also `Collection Group Point`, `Group Point`, commas)
    Point;X;Y;Z                           PolyWorks and others, with commas, semicolons, tabulators or blanks
    Point X Y Z  or  X Y Z                plain; points without names are numbered in their order

Lines that begin with `//`, `#`, `!` or `%` are comments. Lines before the first point are titles or headers, unless
they have numbers as a point has (`_is_title`). The unit is that of a comment or a header (`// Units: mm`, `X [mm]`,
`X_mm`), or is given; it is never guessed.

Points that carry another's name, and points that do not lie where the drawing has them.

Between an unloaded and a loaded state points move by far less than they are apart, so that each is recognised by its
place. Against the drawing only distances count: points are registered, under their names and with any two exchanged.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from expdesign.arrays import FloatArray
from expdesign.chain.readings.registration import registered
from expdesign.errors import InputError
from expdesign.io.table_text import decoded
from expdesign.io.units import NUMBER, Unit, known_units, unit_of
from expdesign.io.yaml_reader import read_bytes


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


_GAIN = 10.0
"""Factor by which distances or residuals must fall under the other reading for points to be taken for mistaken."""
_SMALLEST = 1e-3
"""m; distances and residuals below which nothing is suspected."""
_REFUSED = 0.05
"""Largest residual against the drawing, in parts of the points' size, beyond which it is another object."""


@dataclass(frozen=True)
class MarkerFit:
    """How the points of a state fit the places of the robot's markers.

    Attributes:
        rms: of the distances (m) that registration leaves.
        worst: the point that is farthest from its place.
        size: how far it is (m).
        off: whether the others fit far better without it.
    """

    rms: float
    worst: str
    size: float
    off: bool


def require_own_names(before: FloatArray, after: FloatArray, names: Sequence[str], where: str) -> None:
    """Raise an `InputError` where points (N, 3) would hardly have moved under each other's names."""
    distances = cdist(after, before)
    order = linear_sum_assignment(distances**2)[1]
    stated, matched = (
        float(np.sqrt((distances[range(len(names)), o] ** 2).mean())) for o in (range(len(names)), order)
    )
    if stated < _SMALLEST or matched * _GAIN >= stated:
        return
    wrong = [name for name, own in zip(names, order != np.arange(len(names)), strict=True) if own]
    what = (
        f"the points {_listed(wrong)} are swapped: each is where another was without load ({stated * 1e3:.3g} mm off)"
    )
    raise InputError(what, where=where, remedy="Correct their names in the list, or measure the state again.")


def marker_fit(points: PointSet, markers: Mapping[str, FloatArray]) -> MarkerFit | None:
    """How points fit the markers of the same names; None where fewer than three have a place.

    Raises:
        InputError: they do not lie so, with the two that would if their names were exchanged, or the one that is off.
    """
    names = [name for name in points.points if name in markers]
    if len(names) < 3:
        return None
    seen = np.array([points.points[name].position for name in names])
    places = np.array([markers[name] for name in names])
    left = _left(places, seen)
    rms, worst = _rms(left), int(np.argmax(left))
    size, off = float(left[worst]), False
    if len(names) > 3 and size > _SMALLEST:
        without = [np.delete(np.arange(len(names)), i) for i in range(len(names))]
        rest = np.array([_rms(_left(places[kept], seen[kept])) for kept in without])
        worst, off = int(np.argmin(rest)), bool(rest.min() * _GAIN < rms)
        if off:
            turn, shift = registered(places[without[worst]], seen[without[worst]])
            size = float(np.linalg.norm(seen[worst] - places[worst] @ turn.T - shift))
    extent = float(np.linalg.norm(places - places.mean(axis=0), axis=1).max())
    if left.max() > _REFUSED * extent:
        what = f"the points do not lie as the robot's `markers` say ({left.max() * 1e3:.3g} mm off)"
        remedy = "Check names and units of the points and of `markers`."
        pair = _exchanged(places, seen, names, rms)
        if pair is not None:
            what = f"the points {pair[0]} and {pair[1]} are swapped: exchanged, all lie as the robot's `markers` say"
            remedy = "Correct their names in the lists or in `markers`."
        elif off:
            what += f": {names[worst]} by {size * 1e3:.3g} mm, the others fit"
            remedy = f"Correct the place of {names[worst]} in the robot file, or its name."
        raise InputError(what, where=f"{points.source}, {points.name}", remedy=remedy)
    return MarkerFit(rms, names[worst], size, off)


def near_names(names: Sequence[str], known: Sequence[str]) -> str:
    """A remedy for names that differ from known ones in capitals alone, or nothing."""
    lower = {name.lower(): name for name in known}
    pairs = [(name, lower[name.lower()]) for name in names if name not in known and name.lower() in lower]
    if not pairs:
        return ""
    return f"`{pairs[0][0]}` and `{pairs[0][1]}` differ in capitals: did you mean `{pairs[0][1]}`?"


def _left(places: FloatArray, seen: FloatArray) -> FloatArray:
    """Distances (N,) that registration leaves."""
    turn, shift = registered(places, seen)
    left: FloatArray = np.linalg.norm(seen - places @ turn.T - shift, axis=1)
    return left


def _rms(left: FloatArray) -> float:
    return float(np.sqrt((left**2).mean()))


def _exchanged(places: FloatArray, seen: FloatArray, names: Sequence[str], rms: float) -> tuple[str, str] | None:
    """The two points that have each other's names, or None."""
    best: tuple[float, tuple[str, str]] | None = None
    for first, second in combinations(range(len(names)), 2):
        order = np.arange(len(names))
        order[[first, second]] = second, first
        found = _rms(_left(places[order], seen))
        if best is None or found < best[0]:
            pair = sorted((names[first], names[second]))
            best = found, (pair[0], pair[1])
    return best[1] if best is not None and best[0] * _GAIN < rms else None


def _listed(names: Sequence[str]) -> str:
    return " and ".join(names) if len(names) < 3 else f"{', '.join(names[:-1])} and {names[-1]}"


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


def read_point_sets(path: Path, unit: Unit | None = None) -> list[PointSet]:
    """The groups of points in a file, in its order.

    Args:
        path: text in any usual encoding.
        unit: of the coordinates, where the file states none.

    Raises:
        InputError: the file is missing or no list of points, states no unit or another one than `unit`, or names a
            point twice.
    """
    text, _ = decoded(read_bytes(path), str(path))
    found: dict[str, dict[str, MeasuredPoint]] = {}
    stated: Unit | None = None
    raw: list[tuple[int, str, str, list[float]]] = []
    headed = False
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
            if raw or not _is_title(cells, headed=headed):
                what = f"`{line.strip()[:40]}` is no point: a name and 3 coordinates (and 3 deviations) are needed"
                remedy = (
                    "Correct the line. Is the file cut off?" if raw else "Correct it, or write `//` before a title."
                )
                raise InputError(what, where=where, remedy=remedy)
            stated = _unit_in(line, stated, where)
            headed = headed or _heads_coordinates(cells)
            continue
        if raw and count != len(raw[0][3]):
            what = f"the line ends with {count} numbers, and the first point with {len(raw[0][3])}"
            raise InputError(what, where=where, remedy="State 3 coordinates for all points, or 3 deviations with them.")
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
            what = f"the point {label} appears twice{f' in group {group}' if group else ''}"
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


def _heads_coordinates(cells: list[str]) -> bool:
    """Whether cells name coordinates: then points follow."""
    return {cell.strip('"')[:1].lower() for cell in cells} >= {"x", "y", "z"}


def _is_title(cells: list[str], *, headed: bool) -> bool:
    """Whether a line that is no point is a title or a header, and not a point that was mistyped.

    A mistyped point has numbers as two of its last three cells, names its group with `::`, or has digits among its last
    cells where the header stands already.
    """
    last = cells[-3:]
    numbers = sum(NUMBER.fullmatch(cell) is not None for cell in last)
    digits = headed and any(character.isdigit() for cell in last for character in cell)
    return numbers < 2 and not digits and not any("::" in cell for cell in cells)


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
        remedy = "Give it (argument `unit=mm`), or write it into the file (`// Units: mm`)."
        raise InputError("the file does not state the unit of its coordinates", where=source, remedy=remedy)
    return unit
