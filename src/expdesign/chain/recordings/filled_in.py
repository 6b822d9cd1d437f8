"""Tables that a person has filled in: rows left empty, columns not used, and readings in place of deflections.

A laboratory sheet has a row for every measurement and a column for everything that may be read. Rows in which nothing
was filled in are left out, and so are columns that are empty throughout. Where the instrument shows positions of the
platform instead of deflections (`reading_x_m` …, from any zero), a row without load is the reference of the loaded rows
that follow it in its series, and a deflection is the difference of their readings (file-formats.md, Conventions). Rows
that are counted from one reference share its noise, which the column `reference` then says.

What can be said of recordings without knowing the robot: columns, numbers, order, series, units.
"""

import re
from dataclasses import replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, TextArray
from expdesign.chain.recordings.columns import REFERENCE, whole_load
from expdesign.chain.recordings.measured import read_measured, read_test_rows, with_targets
from expdesign.chain.recordings.points import (
    read_markers,
    read_payload,
    read_sequence,
    read_time,
    require_load,
    require_one_command,
)
from expdesign.chain.recordings.recordings import (
    DEFLECTIONS,
    POSES,
    POSITION,
    POSITION_DEVIATION,
    POSITIONS,
    SPANS,
    in_order,
    measured_names,
    reading_names,
)
from expdesign.chain.recordings.references import first_disagreement, read_references
from expdesign.coordinates import PLANAR, PLANE, SPATIAL, Coordinates
from expdesign.counted import counted
from expdesign.errors import InputError
from expdesign.io.table import Table

_HISTORY = ("time_s", "temperature_degC")


def filled_in(table: Table, coordinates: Coordinates) -> tuple[Table, list[str]]:
    """The rows and columns of a table in order that were filled in, with deflections; and notes on what was left out.

    Raises:
        InputError: nothing is filled in, or a loaded row has no reference.
    """
    table, notes = _without_empty(table, coordinates)
    names = [name for name in reading_names(coordinates) if table.has(name)]
    if not names:
        return table, notes
    for name in coordinates.deflection:
        if table.has(name):
            what = f"there are readings together with the deflections {name} ..."
            raise table.fault(what, column=name, remedy="Fill in one of them; take the other out.")
    table, used = _with_deflections(table, names, coordinates)
    return table, [*notes, used]


def _without_empty(table: Table, coordinates: Coordinates) -> tuple[Table, list[str]]:
    known = (*coordinates.deflection, *POSITION, *SPANS, *reading_names(coordinates), *measured_names(coordinates))
    values = [name for name in known if table.has(name)]
    if not values:
        return table, []
    blank = np.all([table.text(name) == "" for name in values], axis=0)
    if blank.all():
        what = f"nothing is filled in under {', '.join(values[:3])}{' ...' if len(values) > 3 else ''}"
        raise table.fault(what, remedy="Fill in what was measured.")
    notes = []
    if blank.any():
        lines = ", ".join(str(line) for line in table.lines[blank][:8]) + (" ..." if blank.sum() > 8 else "")
        left = counted(int(blank.sum()), "row")
        notes.append(f"{left} left out: no measured value (row {lines})")
        table = table.rows(~blank)
    optional = [*values, *coordinates.deviation, *POSITION_DEVIATION, *_HISTORY, "split"]
    optional += [name for name in table.columns if name.startswith("leg") and name.endswith("_degC")]
    unused = [n for n in optional if table.has(n) and (table.text(n) == "").all()]
    if unused:
        notes.append(f"columns without an entry are left out: {', '.join(dict.fromkeys(unused))}")
        table = replace(table, frame=table.frame.drop(columns=list(dict.fromkeys(unused))))
    return table, notes


def _with_deflections(table: Table, names: list[str], coordinates: Coordinates) -> tuple[Table, str]:
    """Readings as deflections from the last unloaded row before each; references that are used up are left out."""
    series = table.integers("series")
    readings = table.numbers(tuple(names))
    unloaded = unloaded_rows(table, coordinates)
    deflections = np.zeros_like(readings)
    references = np.full(len(table), "", dtype=object)
    keep = np.zeros(len(table), dtype=bool)
    for number in dict.fromkeys(series.tolist()):
        rows = np.flatnonzero(series == number)
        loaded = np.flatnonzero(~unloaded[rows])
        if not unloaded[rows[0]]:
            what = f"series {number} does not begin with a row without load, from which its readings could be counted"
            remedy = "Fill in the reference row of the series, or write deflections."
            raise table.fault(what, int(rows[0]), "series", remedy=remedy)
        reference = rows[0]
        keep[rows[0]] = table.has("time_s") or table.has("temperature_degC")
        for index, row in enumerate(rows):
            if index and unloaded[row] and loaded.size and index < loaded[-1]:
                reference = row
                continue
            if index:
                deflections[row] = readings[row] - readings[reference]
                keep[row] = True
                references[row] = f"row {table.lines[reference]} of {table.source}"
    frame, written = table.frame.drop(columns=names), dict(table.written)
    for column, name in enumerate(names):
        deflection = coordinates.deflection[coordinates.pose.index(name.removeprefix("reading_"))]
        if name in written:
            written[deflection] = written[name]
        frame[deflection] = [repr(float(value)) for value in deflections[:, column]]
    _require_agreement(table, references, keep)
    frame[REFERENCE] = references
    kept = replace(table, frame=frame, written=written).rows(keep)
    sizes = np.unique(references[references != ""].astype(str), return_counts=True)[1]
    text = f"readings of {counted(int(sizes.sum()), 'row')} counted from {counted(len(sizes), 'reference row')}"
    if (sizes > 1).any():
        text += "; rows with a common reference share its noise"
    return kept, text


def _require_agreement(table: Table, counted: TextArray, kept: BoolArray) -> None:
    """Raise an `InputError` where a column `reference` says otherwise than the rows from which readings are counted."""
    stated = read_references(table)
    pair = None if stated is None else first_disagreement(np.where(kept, stated, ""), counted)
    if pair is not None:
        own = " and ".join(f"row {table.lines[row]} is counted from {counted[row]}" for row in pair)
        remedy = "Empty the column, or move the rows without load to where they were read."
        raise InputError(f"the names contradict the rows without load: {own}", where=table.where(pair[1], REFERENCE),
                         remedy=remedy)  # fmt: skip


def unloaded_rows(table: Table, coordinates: Coordinates) -> BoolArray:
    """Rows whose mass or whose wrench is 0, shape (N,)."""
    require_load(table, coordinates)
    names = ("mass_kg",) if table.has("mass_kg") else tuple(n for n in coordinates.wrench if table.has(n))
    loads: FloatArray = table.numbers(names)
    unloaded: BoolArray = np.all(loads == 0.0, axis=1)
    return unloaded


_JOINT = re.compile(r"q[0-9]+_(m|rad)")
_NAMED = re.compile(r".+_(m|rad)")
_NO_JOINTS = frozenset(
    (
        *SPATIAL.pose, *SPATIAL.deflection, *SPATIAL.deviation, *SPATIAL.centre_of_mass, *measured_names(SPATIAL),
        *reading_names(SPATIAL), *POSITION, *POSITION_DEVIATION,
    )
)  # fmt: skip


def check_structure(table: Table, *, commanded: bool = True) -> str:
    """Raise the first fault of recordings, or say in words what they hold.

    Args:
        table: the recordings.
        commanded: whether the pose is a command that the rows of a series share (not so for a body).

    Raises:
        InputError: with file, row and column.
    """
    table.require(("sequence", "series"))
    coordinates, names = _kind(table)
    table, _ = filled_in(in_order(table), coordinates)
    read_sequence(table)
    read_time(table)
    configurations, series = table.numbers(names), table.integers("series")
    shown = [name for name in (*coordinates.deflection, *measured_names(coordinates)) if table.has(name)]
    table = with_targets(table, jointed=names != coordinates.pose)
    posed = any(table.has(name) for name in measured_names(coordinates))
    measurand = POSES if posed and names == coordinates.pose else DEFLECTIONS
    if table.has("marker") or any(table.has(name) for name in POSITION):
        table.require(("marker",))
        read_markers(table)
        measurand = POSITIONS
        shown += [measurand.name]
    if not measurand.absolute or any(table.has(name) for name in ("mass_kg", *coordinates.wrench)):
        require_load(table, coordinates)
        if table.has("mass_kg"):
            read_payload(table, coordinates)
        if any(table.has(name) for name in coordinates.wrench):
            table.numbers(coordinates.wrench)
    plain = ("temperature_degC", *coordinates.gravity, *whole_load(coordinates))
    table.numbers(tuple(name for name in plain if table.has(name)))
    if commanded and not measurand.absolute:
        require_one_command(table, names, configurations, series)
    spans = any(table.has(name) for name in SPANS)
    stated = read_measured(table, measurand, coordinates, spans=spans)[2] is not None
    test = read_test_rows(table)
    held_out = f", {int(test.sum())} of them for testing" if test.any() else ""
    measured = f"{', '.join(shown)} {'with' if stated else 'without'} standard deviations"
    return f"{counted(len(table), 'row')} in {len(np.unique(series))} series{held_out}; measured: {measured}."


def _kind(table: Table) -> tuple[Coordinates, tuple[str, ...]]:
    """Coordinates and command columns that the table must belong to."""
    joints = tuple(name for name in table.columns if _JOINT.fullmatch(name))
    if not joints and not table.has("x_m"):
        # Joints by their names in the URDF, which without the robot are whatever else is an angle or a travel.
        joints = tuple(name for name in table.columns if _NAMED.fullmatch(name) and name not in _NO_JOINTS)
    if joints and not table.has("x_m"):
        return SPATIAL, joints
    coordinates = next(
        (each for each, flat in ((SPATIAL, PLANE), (PLANE, PLANAR)) if any(table.has(n) for n in _beyond(each, flat))),
        PLANAR,
    )
    return coordinates, coordinates.pose


def _beyond(larger: Coordinates, smaller: Coordinates) -> set[str]:
    """Columns of poses, deflections and wrenches that only the larger of two workspaces has."""
    names = {*larger.pose, *larger.deflection, *larger.wrench}
    return names - {*smaller.pose, *smaller.deflection, *smaller.wrench}
