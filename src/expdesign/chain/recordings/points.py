"""Loaded points of a table: order, commands, loads, gravity and temperatures, each asked of the table once.

Faults name file, row and column (file-formats.md, Recordings).
"""

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.columns import known_columns, leg_temperatures, require_mass, whole_load
from expdesign.chain.recordings.joint_columns import with_joints
from expdesign.chain.recordings.load_errors import read_load_errors
from expdesign.chain.recordings.measured import KINDS, read_aims, read_fixed, with_targets
from expdesign.chain.recordings.recordings import (
    ALONG,
    POINT,
    SESSION,
    SPAN_DEVIATIONS,
    SPANS,
    STATION,
    LoadedPoints,
    in_order,
    markers_in,
    measured_names,
)
from expdesign.chain.recordings.references import read_references
from expdesign.chain.recordings.tilted import with_gravity
from expdesign.coordinates import Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table
from expdesign.mechanics.loads.load import Payload
from expdesign.mechanics.robots.orientation import rotations_of
from expdesign.mechanics.robots.robot import Robot

LARGEST_ANGLE = 2.0 * np.pi
"""rad; a larger angle of a platform is in degrees."""
LARGEST_STRETCH = 10.0
"""A pose at which a leg is this many times longer than at the reference pose is in mm."""
CONTRADICTION = 0.01
"""Relative difference of a payload and a wrench that are both given, above which they contradict each other."""
LEVER = 0.05
"""m; moments below `CONTRADICTION` × force × this lever are not compared."""


def points_from_table(table: Table, robot: Robot, *, measured: bool = False) -> LoadedPoints:
    """Points in a table. Where they are to be `measured`, rows of a series share one command."""
    table = with_joints(with_targets(in_order(table), jointed=robot.jointed), robot)
    return points_of(table, robot, measured=measured, recorded=False)


def points_of(table: Table, robot: Robot, *, measured: bool, recorded: bool) -> LoadedPoints:
    """Points of a table in order, whose joints have their numbered names (`with_joints`) and whose measured poses of an
    arm stand as positions (`with_targets`).

    Where they are to be `measured` the rows of a series share one command; where they were `recorded` those of one
    unloaded reading do as well.
    """
    table = with_gravity(table, robot)
    coordinates, poses = robot.coordinates, _measures_poses(table, robot)
    configurations = table.numbers(robot.configuration)
    _sensible_poses(table, robot, configurations)
    sequence = read_sequence(table)
    series = table.integers("series") if table.has("series") else sequence
    time = read_time(table)
    marker, markers, sites, stations = read_markers(table)
    point, fixed, along = read_fixed(table) if markers and robot.jointed else (None, (), None)
    # A body has no actuators: its pose says where it is, and is not a command that a series shares.
    commanded = measured and robot.actuated and not markers and not poses
    if commanded:
        require_one_command(table, robot.configuration, configurations, series)
    gravity = _stated(table, coordinates.gravity, np.tile(robot.gravity, (len(table), 1)))
    payload = read_payload(table, coordinates) if table.has("mass_kg") else None
    unloaded = payload is None and not any(table.has(name) for name in coordinates.wrench)
    # Deflections need a load; absolute readings show the weight of what is there.
    unloaded &= poses or bool(markers) or (robot.jointed and not measured)
    load = (table, robot, configurations, payload, gravity)
    wrenches = np.zeros((len(table), coordinates.n)) if unloaded else _wrenches(*load)
    whole = whole_load(coordinates)
    given = any(table.has(name) for name in whole)
    errors, weight = read_load_errors(table, coordinates, wrenches, payload) if recorded else (None, None)
    legs = leg_temperatures(robot)
    known = known_columns(robot) | ({"kind", SESSION} if poses or markers else set())
    known |= {POINT, *ALONG, *SPANS, *SPAN_DEVIATIONS} if point is not None else set()
    # A standard deviation whose reading is missing has no meaning, and is not to be dropped in silence.
    readings = dict(zip(coordinates.deviation, coordinates.deflection, strict=True))
    if measured and not poses and not markers:
        known -= {deviation for deviation, reading in readings.items() if not table.has(reading)}
    angles = read_aims(table) if markers else None
    return LoadedPoints(
        source=table.source,
        lines=table.lines,
        sequence=sequence,
        series=series,
        time=time,
        configurations=configurations,
        wrenches=wrenches,
        absolute=_stated(table, whole, np.zeros_like(wrenches)) if given else wrenches.copy(),
        payload=payload,
        gravity=gravity,
        temperature=table.numbers(("temperature_degC",))[:, 0] if table.has("temperature_degC") else None,
        leg_temperature=table.numbers(legs) if any(table.has(name) for name in legs) else None,
        extra=table.frame[[name for name in table.columns if name not in known]],
        written=table.written,
        files=table.files,
        marker=marker,
        markers=markers,
        sites=sites,
        stations=stations,
        aim=None if angles is None else rotations_of(angles),
        angles=angles,
        point=point,
        fixed=fixed,
        along=along,
        poses=poses,
        references=read_references(table, configurations if commanded and recorded else None),
        errors=errors,
        weight=weight,
    )


def _stated(table: Table, names: tuple[str, ...], otherwise: FloatArray) -> FloatArray:
    """Numbers of the columns that are there (N, k), and what holds otherwise of the rest (N, k)."""
    columns = [table.numbers((name,)) if table.has(name) else otherwise[:, [i]] for i, name in enumerate(names)]
    return np.hstack(columns)


def _measures_poses(table: Table, robot: Robot) -> bool:
    """Whether a table is one of measured poses: by its columns `measured_x_m` ..., or by `kind` where those are due."""
    if not robot.on_legs:
        return False
    if any(table.has(name) for name in measured_names(robot.coordinates)):
        return True
    return table.has("kind") and bool(np.isin(table.text("kind"), KINDS).all())


def _sensible_poses(table: Table, robot: Robot, configurations: FloatArray) -> None:
    """Raise where an angle must be in degrees or a position in mm."""
    if not robot.on_legs:
        return
    split = robot.coordinates.translations
    angles, what = configurations[:, split:], "{:g} cannot be an angle of the platform in rad"
    large = np.abs(angles) > LARGEST_ANGLE
    table.refuse(large, robot.configuration[split:], what, "Check the unit.", angles)
    farthest = np.abs(configurations[:, :split])
    row, column = divmod(int(np.argmax(farthest)), split)
    closed_form = robot.inverse_kinematics
    reference = closed_form.lengths(robot.reference_configuration()).max()
    stretch = float(closed_form.lengths(configurations[row]).max() / reference)
    if stretch > LARGEST_STRETCH:
        where = table.where(row, robot.configuration[column])
        what = f"at {configurations[row, column]:g} m a leg would be {stretch:.3g} times as long as it is"
        raise InputError(what, where=where, remedy="Check the unit (m).")


def _wrenches(
    table: Table,
    robot: Robot,
    configurations: FloatArray,
    payload: FloatArray | None,
    gravity: FloatArray,
) -> FloatArray:
    coordinates = robot.coordinates
    require_load(table, coordinates)
    given, stated = None, [name for name in coordinates.wrench if table.has(name)]
    if payload is not None and 0 < len(stated) < len(coordinates.wrench):
        what = f"`mass_kg` and `{stated[0]}` state two loads, the second without all components of the wrench"
        remedy = f"Take {', '.join(stated)} out, or take `mass_kg` out and add the other components."
        raise table.fault(what, column=stated[0], remedy=remedy)
    if payload is None or stated:
        given = table.numbers(coordinates.wrench)
    if payload is None:
        assert given is not None
        return given
    weights = hanging(robot, configurations, payload, gravity)
    if given is not None:
        _no_contradiction(table, robot, given, weights)
    return weights


def hanging(robot: Robot, configurations: FloatArray, payload: FloatArray, gravity: FloatArray) -> FloatArray:
    """Wrenches (N, n) of payloads (N, 1 + d) in gravity (N, d) as they hang at configurations (N, n_q)."""
    rotation = robot.jacobians(configurations).rotation
    return Payload(robot.coordinates).wrenches(rotation, np.concatenate([payload, gravity], axis=1))


def require_load(table: Table, coordinates: Coordinates) -> None:
    """Raise an `InputError` where a table has neither payload nor wrench."""
    if not any(table.has(name) for name in ("mass_kg", *coordinates.wrench)):
        table.require_known_units(("mass_kg", *coordinates.wrench))
        remedy = f"Add {', '.join(coordinates.wrench)}, or mass_kg and the centre of mass."
        raise table.fault("there is no load", remedy=remedy)


def _no_contradiction(table: Table, robot: Robot, given: FloatArray, weights: FloatArray) -> None:
    split = robot.coordinates.translations
    force = np.maximum(np.linalg.norm(given[:, :split], axis=1), np.linalg.norm(weights[:, :split], axis=1))
    moment = np.maximum(np.linalg.norm(given[:, split:], axis=1), np.linalg.norm(weights[:, split:], axis=1))
    allowed = np.empty_like(given)
    allowed[:, :split] = force[:, None]
    allowed[:, split:] = np.maximum(moment, LEVER * force)[:, None]
    differs = np.abs(given - weights) > CONTRADICTION * allowed + 1e-12
    if differs.any():
        row, column = np.argwhere(differs)[0]
        what = f"the wrench ({given[row, column]:g}) contradicts the payload (which makes {weights[row, column]:g})"
        remedy = "They describe the same load; correct one of them, or leave one out."
        raise table.fault(what, int(row), robot.coordinates.wrench[column], remedy=remedy)


def read_sequence(table: Table) -> IntArray:
    """Sequence numbers as they stand in the file (counted from 1 where there are none), shape (N,)."""
    sequence = table.integers("sequence") if table.has("sequence") else np.arange(len(table)) + 1
    repeated = pd.Series(sequence).duplicated().to_numpy()
    remedy = "Number the rows in the order of recording."
    table.refuse(repeated, ("sequence",), "the sequence number {} appears twice", remedy, sequence)
    return sequence


def read_time(table: Table) -> FloatArray | None:
    """Times (s), shape (N,), or None where there are none; rows in the order of their sequence."""
    if not table.has("time_s"):
        return None
    time = table.numbers(("time_s",))[:, 0]
    back, what = np.diff(time, prepend=time[:1]) < 0.0, "time runs backwards in the order of `sequence`"
    table.refuse(back, ("time_s",), what, "Correct `sequence` or `time_s`.")
    return time


def require_one_command(table: Table, names: tuple[str, ...], configurations: FloatArray, series: IntArray) -> None:
    """Raise where rows of one series have different commands (N, n_q)."""
    _, first, index = np.unique(series, return_index=True, return_inverse=True)
    differs = np.abs(configurations - configurations[first[index]]) > 1e-9
    what = "the command differs from that of the first row of series {:g}"
    remedy = "Rows of one series share one command; give the row a series of its own, or correct the command."
    table.refuse(differs, names, what, remedy, np.broadcast_to(series[:, None], differs.shape))


def read_payload(table: Table, coordinates: Coordinates) -> FloatArray:
    """Mass (kg) and centre of mass (m), shape (N, 1 to 4); the latter is 0 where a row without load leaves it empty."""
    mass, centre = table.numbers(("mass_kg",)), coordinates.centre_of_mass
    require_mass(table, "mass_kg")
    table.require(centre)
    stated = np.nan_to_num(table.numbers_where_filled(centre), nan=0.0)
    loaded = np.flatnonzero(mass[:, 0] != 0.0)
    stated[loaded] = table.rows(loaded).numbers(centre)
    return np.concatenate([mass, stated], axis=1)


def read_markers(table: Table) -> tuple[IntArray | None, tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Index of every row's marker (N,), or None, the markers' names, sites and stations.

    A marker that is seated anew for each `session` and an instrument that is moved between each `station` make one of
    every combination; sites and stations are empty where there is one session or one station alone.
    """
    if not table.has("marker"):
        if table.has("px_m") or any(table.has(name) for name in SPANS):
            remedy = "Name the marker of each row (one name where there is one marker)."
            raise table.fault("the column is missing", column="marker", remedy=remedy)
        return None, (), (), ()
    names = table.text("marker")
    table.refuse(names == "", ("marker",), "the marker has no name", "Write its name.")
    groups = {}
    for column in (SESSION, STATION):
        own = table.text(column) if table.has(column) else np.full(len(names), "")
        groups[column] = own if len(np.unique(own.astype(str))) > 1 else np.full(len(names), "")
    return markers_in(names, groups[SESSION], groups[STATION])
