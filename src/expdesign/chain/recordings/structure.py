"""What can be said of recordings without knowing the robot: columns, numbers, order, series, units."""

import re

import numpy as np

from expdesign.chain.recordings.columns import (
    order_in_time,
    read_deflections,
    read_deviations,
    read_markers,
    read_payload,
    read_positions,
    read_sequence,
    read_test_rows,
    read_time,
    require_one_command,
)
from expdesign.chain.recordings.filled_in import filled_in, reading_names
from expdesign.chain.recordings.measurand import POSITION, POSITION_DEVIATION, measured_names
from expdesign.coordinates import PLANAR, PLANE, SPATIAL, Coordinates
from expdesign.counted import counted
from expdesign.errors import InputError
from expdesign.io.table import Table

_JOINT = re.compile(r"q[0-9]+_(m|rad)")
_NAMED = re.compile(r".+_(m|rad)")
_NO_JOINTS = frozenset(
    (
        *SPATIAL.pose, *SPATIAL.deflection, *SPATIAL.deviation, *SPATIAL.centre_of_mass, *measured_names(SPATIAL),
        *reading_names(SPATIAL), *POSITION, *POSITION_DEVIATION,
    )
)  # fmt: skip
_MARKER = ("px_m", "py_m", "pz_m")


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
    table, _ = filled_in(table, coordinates)
    read_sequence(table)
    order = order_in_time(table)
    configurations = table.numbers(names)[order]
    series = table.integers("series")[order]
    read_time(table, order)
    arm = names != coordinates.pose
    poses = tuple(name for name in measured_names(coordinates) if table.has(name))
    loads = ("mass_kg", *coordinates.wrench)
    absolute = bool(poses) or table.has("marker") or any(table.has(name) for name in _MARKER)
    if not absolute or any(table.has(name) for name in loads):
        _check_loads(table, coordinates)
    for name in ("temperature_degC", *coordinates.gravity, *(f"abs_{n}" for n in coordinates.wrench)):
        if table.has(name):
            table.numbers((name,))
    test = read_test_rows(table, order)
    if poses:
        table.numbers_where_filled(poses) if arm else table.numbers(poses)
        measured = ", ".join(poses) + (" and positions" if any(table.has(name) for name in _MARKER) else "")
    elif absolute:
        table.require(("marker",))
        read_markers(table, order)
        read_positions(table, coordinates, order)
        measured = "marker positions"
    else:
        if commanded:
            require_one_command(table, names, configurations, series, order)
        axes, _ = read_deflections(table, coordinates, order)
        stated = read_deviations(table, coordinates, axes, order) is not None
        measured = ", ".join(coordinates.deflection[i] for i in axes)
        measured += " with standard deviations" if stated else " without standard deviations"
    held_out = f", {int(test.sum())} of them for testing" if test.any() else ""
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


def _check_loads(table: Table, coordinates: Coordinates) -> None:
    payload = table.has("mass_kg")
    wrench = any(table.has(name) for name in coordinates.wrench)
    if not payload and not wrench:
        remedy = f"Add {', '.join(coordinates.wrench)}, or mass_kg and the centre of mass."
        raise InputError("there is no load", where=table.where(), remedy=remedy)
    if payload:
        read_payload(table, coordinates)
    if wrench:
        table.numbers(coordinates.wrench)


def _beyond(larger: Coordinates, smaller: Coordinates) -> set[str]:
    """Columns of poses, deflections and wrenches that only the larger of two workspaces has."""
    names = {*larger.pose, *larger.deflection, *larger.wrench}
    return names - {*smaller.pose, *smaller.deflection, *smaller.wrench}
