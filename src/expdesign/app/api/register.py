"""`register`: recordings from lists of points that were measured unloaded and loaded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import casadi as ca
import numpy as np
import pandas as pd

from expdesign.app.api.arguments import Within, named_arguments
from expdesign.app.api.inputs import RobotInput, TableInput, load_robot, purpose_of, table_of
from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.recordings.columns import REFERENCE
from expdesign.chain.recordings.filled_in import unloaded_rows
from expdesign.chain.recordings.recordings import POSITION, POSITION_DEVIATION, reading_names
from expdesign.errors import ArgumentError, InputError
from expdesign.estimation.preparation.point_lists import PointSet, read_point_sets
from expdesign.estimation.preparation.registered_deflections import (
    InstrumentFrame,
    RegisteredDeflection,
    difference_variance,
    registered_deflection,
    suspicion,
)
from expdesign.estimation.preparation.states import RecordedState, matched
from expdesign.io.table import Table
from expdesign.io.units import Unit, unit_of
from expdesign.mechanics.robots.orientation import rotation_matrix
from expdesign.mechanics.robots.robot import Robot
from expdesign.report.recording_texts import RegistrationResult
from expdesign.report.result import PathLike, filled

Deviation = Annotated[
    float | None, Within("a standard deviation in m", "Give it in m, e.g. 15e-6.", 0.0, 1.0, strict=True)
]


@named_arguments
def register(
    robot: RobotInput,
    plan: TableInput,
    points: PathLike | Sequence[PathLike],
    *,
    unit: str | None = None,
    deviation: Deviation = None,
    base_frame: bool = False,
    positions: bool = False,
) -> RegistrationResult:
    """Turn lists of points, measured unloaded and loaded, into recordings.

    Sets of points (groups of a list, or files) named `loaded-SEQUENCE` and `unloaded-SERIES` belong to rows of the
    plan; docs/units-and-files.md says how else they may be named.

    Args:
        robot: robot (YAML), with `markers` (places of the points on the platform) or `instrument`, unless the points
            are in its base frame.
        plan: plan or laboratory sheet (CSV, .xlsx) with `sequence` and `series`.
        points: lists of points, in one or more files.
        unit: unit of the coordinates where a list does not state it, e.g. mm.
        deviation: standard deviation of a measured coordinate; else as the lists state it, or estimated. In Python in
            m.
        base_frame: the points were measured in the robot's base frame.
        positions: write positions of markers instead of deflections.

    Raises:
        InputError: a file is missing or wrong, points do not match the plan, or do not determine a motion.

    Command:
        expdesign register robot.yaml plan.csv unloaded.txt loaded.txt --out recordings.csv
    """
    machine = load_robot(robot).robot
    table = table_of(plan, "plan")
    table.require(("sequence", "series"))
    sets = _read(points, unit)
    unloaded = unloaded_rows(table, machine.coordinates)
    states = matched(table, sets, unloaded)
    purpose = purpose_of("register", robot, plan, points)
    if positions:
        text = _positions(table, states, machine, deviation)
        missing = _unmeasured(table, states, unloaded)
        return RegistrationResult(text, (), np.zeros((0, 6, 6)), None, (), missing, purpose=purpose)
    frames = _frames(machine, table.numbers(machine.configuration))
    instrument = _instrument(machine, base_frame=base_frame)
    markers = {} if base_frame else dict(machine.markers)
    found = [
        registered_deflection(state, frames[state.row], markers=markers, instrument=instrument, deviation=deviation)
        for state in states
    ]
    variance = None
    if any(one.variances is None for one in found):
        variance = difference_variance(found)
        if variance is None:
            what = "three points a state leave nothing over from which their standard deviation could be estimated"
            remedy = "Give it (argument `deviation`), or measure more points."
            raise InputError(what, where=sets[0].source, remedy=remedy)
    covariance = np.array([one.covariance(variance or 0.0) for one in found])
    doubts = [(state, suspicion(one, variance)) for state, one in zip(states, found, strict=True)]
    misplaced = {one.markers.worst: one.markers for one in found if one.markers is not None and one.markers.off}
    drawn = tuple(
        f"marker {name} lies {1e3 * fit.size:.3g} mm from where the robot file has it, and the others fit: correct it"
        for name, fit in misplaced.items()
    )
    return RegistrationResult(
        _deflections(table, states, found, covariance, machine),
        tuple(found),
        covariance,
        None if variance is None else float(np.sqrt(variance / 2.0)),
        drawn + tuple(f"{state.loaded.name} against {state.reference.name}: {text}" for state, text in doubts if text),
        _unmeasured(table, states, unloaded),
        purpose=purpose,
    )


def _unmeasured(table: Table, states: list[RecordedState], unloaded: BoolArray) -> tuple[int, ...]:
    """Sequence numbers of loaded rows of which there are no points."""
    rows = sorted(set(np.flatnonzero(~unloaded).tolist()) - {state.row for state in states})
    return tuple(int(number) for number in table.integers("sequence")[rows])


def _read(points: PathLike | Sequence[PathLike], unit: str | None) -> list[PointSet]:
    given: Unit | None = None
    if unit is not None:
        given = unit_of(unit)
        if given is None or given.dimension != "length":
            raise ArgumentError(f"`{unit}` is not a unit of length", argument="unit", remedy="Write e.g. mm.")
    files = [points] if isinstance(points, str | Path) else list(points)
    return [item for file in files for item in read_point_sets(Path(file), given)]


def _frames(robot: Robot, configurations: FloatArray) -> list[InstrumentFrame]:
    jacobians = robot.jacobians(configurations)
    count = robot.coordinates.n
    if count != 6 or not robot.actuated:
        what = f"deflections are registered for platforms and arms, not for a {robot.kind}"
        raise InputError(
            what, remedy="Take positions of markers instead (argument `positions`), where the robot moves in space."
        )
    origins, rates = robot.position(configurations), robot.pose_rates(configurations)
    return [InstrumentFrame(r, p, t) for r, p, t in zip(jacobians.rotation, origins, rates, strict=True)]


def _instrument(robot: Robot, *, base_frame: bool) -> tuple[FloatArray, FloatArray] | None:
    if base_frame:
        return np.eye(3), np.zeros(3)
    if robot.instrument is None:
        return None
    return np.array(ca.DM(rotation_matrix(ca.SX(robot.instrument[3:]), "fixed-xyz"))), robot.instrument[:3]


def _without_measured(table: Table, robot: Robot) -> pd.DataFrame:
    coordinates = robot.coordinates
    measured = {
        *coordinates.deflection, *coordinates.deviation, *reading_names(coordinates), "marker", *POSITION, REFERENCE,
        *POSITION_DEVIATION, "points", "reference_points",
    }  # fmt: skip
    blank = {name for name in table.columns if (table.text(name) == "").all()}
    return table.frame[[name for name in table.columns if name not in measured | blank]]


def _deflections(
    table: Table, states: list[RecordedState], found: list[RegisteredDeflection], covariance: FloatArray, robot: Robot
) -> pd.DataFrame:
    text = _without_measured(table, robot).iloc[[state.row for state in states]].reset_index(drop=True)
    text[REFERENCE] = [state.reference.name for state in states]
    text = filled(text, robot.coordinates.deflection, np.array([one.deflection for one in found]))
    return filled(text, robot.coordinates.deviation, np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)))


def _positions(table: Table, states: list[RecordedState], robot: Robot, deviation: float | None) -> pd.DataFrame:
    """One row per state and point, the unloaded state of each first."""
    plan = _without_measured(table, robot)
    loads = [name for name in ("mass_kg", *robot.coordinates.wrench) if table.has(name)]
    rows: list[dict[str, Any]] = []
    last: PointSet | None = None
    for state in states:
        pairs = [(state.loaded, False)]
        if state.reference is not last:
            pairs.insert(0, (state.reference, True))
        last = state.reference
        for points, empty in pairs:
            for name, point in points.points.items():
                row = dict(plan.iloc[state.row]) | (dict.fromkeys(loads, "0") if empty else {})
                row |= {"sequence": len(rows) + 1, "marker": name}
                row |= dict(zip(POSITION, point.position.tolist(), strict=True))
                spread = point.deviation if deviation is None else np.full(3, deviation)
                if spread is not None:
                    row |= dict(zip(POSITION_DEVIATION, spread.tolist(), strict=True))
                rows.append(row)
    return pd.DataFrame(rows)
