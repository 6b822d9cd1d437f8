"""`table`: corrections of commands over poses and loads, for a machine's control."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from itertools import product
from numbers import Real
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from expdesign.app.api.inputs import ModelInput, load_model, named_arguments, purpose_of, require_seed
from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.targets import correction_findings, target_findings
from expdesign.chain.models.estimable import OutsideRange
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.errors import ArgumentError, ConvergenceError, InfeasibleError, InputError, SingularConfigurationError
from expdesign.estimation.compensation.c_source import c_source
from expdesign.estimation.compensation.compensate import Compensation, corrections_of
from expdesign.estimation.compensation.compensate import compensate as commands_for
from expdesign.estimation.compensation.correction_table import CorrectionTable, correction_table
from expdesign.estimation.compensation.prediction import require_history
from expdesign.io.nearest import nearest
from expdesign.io.table import Table
from expdesign.io.units import measured_column
from expdesign.mechanics.robots.robot import Robot
from expdesign.report.compensation_texts import beyond_text, tabulated
from expdesign.report.result import FolderResult
from expdesign.report.said import Said

MOST_NODES = 50_000
"""Nodes at most where nothing is said."""
ERROR = {"length": 1e-8, "angle": 1e-7}
"""m, rad."""


ROUNDED = 1e-9
"""Parts of a step beyond the range that are the rounding of a number, as in the file of C."""


@dataclass(frozen=True, repr=False)
class CorrectionTableResult(FolderResult):
    """A table of corrections: command = target + correction.

    Attributes:
        axes: the coordinates that vary, with their SI units.
        outputs: the corrected coordinates, with their SI units.
        held: coordinates with one value in the whole table.
        table: nodes, values and the error of interpolation.
        model: of the robot.
        extrapolated: commands and loads at the corners of the table that are outside of those of the model's
            recordings, the farthest of each kind.
    """

    FILES: ClassVar = {"table.csv": "frame", "correction.c": "c_source", "table.json": "record"}
    FIRST: ClassVar = "correction.c"
    axes: tuple[str, ...]
    outputs: tuple[str, ...]
    held: dict[str, float]
    table: CorrectionTable
    model: Model
    extrapolated: tuple[OutsideRange, ...] = ()

    @property
    def said(self) -> Said:
        return tabulated(self.table, self.axes, self.outputs, self.model.source, self.held, self.extrapolated)

    @property
    def frame(self) -> pd.DataFrame:
        """One row per node: the axes and the corrections in SI units."""
        names = [*self.axes, *(f"correction_{name}" for name in self.outputs)]
        return pd.DataFrame(np.concatenate([self.table.grid.nodes, self.table.values], axis=1), columns=names)

    def exact(self, points: FloatArray) -> FloatArray:
        """What the table interpolates: command − target of `compensate` (N, o) at points (N, d)."""
        return _corrections(self.model, self.axes, self.held, points)

    def interpolated(self, points: FloatArray) -> FloatArray:
        """What the table says at points (N, d) within its range, shape (N, o), as the file of C does.

        Raises:
            ArgumentError: a point is outside of the range or not a number, for which the C function returns 1 with the
                correction at the edge.
        """
        grid = self.table.grid
        places = (points - grid.low) / (grid.high - grid.low) * (grid.counts - 1)
        outside = ~((places >= -ROUNDED) & (places <= grid.counts - 1 + ROUNDED))
        if outside.any():
            row, axis = (int(index) for index in np.argwhere(outside)[0])
            what = f"{self.axes[axis]} = {points[row, axis]:g} in row {row} is outside of the table"
            remedy = f"It has {grid.low[axis]:g} to {grid.high[axis]:g}; make a larger one, or ask `exact`."
            raise ArgumentError(what, argument="points", remedy=remedy)
        points = np.clip(points, grid.low, grid.high)
        return self.table.grid.interpolate(self.table.values, points)

    @property
    def c_source(self) -> str:
        """The table as one file of C99."""
        about = f"Robot {self.model.robot.get('name', '')}, model {Path(self.model.source).name}; "
        about += f"made by expdesign {version('expdesign')}. SI units."
        about += f" {beyond_text(self.extrapolated)}." if self.extrapolated else ""
        return c_source(self.table, self.axes, self.outputs, list(self.held.items()), about)


@named_arguments
def table(
    model: ModelInput,
    over: Mapping[str, tuple[float, float]],
    at: Mapping[str, float] | None = None,
    *,
    error: Mapping[str, float] = ERROR,
    nodes: int = MOST_NODES,
    seed: int = 1,
) -> CorrectionTableResult:
    """Tabulate corrections of commands, as CSV and as a file of C99, with the error of interpolation stated.

    The table has as many nodes as the wanted error of interpolation takes.

    Args:
        model: identified model (YAML).
        over: range of every coordinate of target or load that varies, by column name (`x_m`, `z_mm`).
        at: values of coordinates that do not vary. Poses and places left out are those of the robot's reference,
            wrenches are 0.
        error: largest error of interpolation, of lengths and angles. In Python `length` in m and `angle` in rad.
        nodes: largest number of nodes.
        seed: seed of the points at which the table is checked.

    Raises:
        InputError: a coordinate is unknown or named twice, a range is empty, no load is named, or the model depends on
            history, or a corner of the ranges cannot be meant.
        InfeasibleError: a command in the range is beyond the robot's limits.
        SingularConfigurationError: the robot is singular in the range.
        ConvergenceError: more nodes would be needed.

    Command:
        expdesign table model.yaml --over x_mm=-20:20 --over mass_kg=0:30 --at com_z_m=0.12 --out table
    """
    require_seed(seed)
    if nodes < 2:
        raise ArgumentError(f"{nodes} nodes are no table", argument="nodes", remedy="Use at least 2.")
    identified = load_model(model)
    robot = identified.chain.robot
    ranges = {name: _range(name, pair) for name, pair in _in_si(over, "over", robot).items()}
    held = {
        name: float(value[0]) for name, value in _in_si({k: (v,) for k, v in (at or {}).items()}, "at", robot).items()
    }
    both = next((name for name in held if name in ranges), None)
    if both is not None:
        raise ArgumentError(f"{both} is both varied and held", argument="at", remedy="Name it once.")
    if not ranges:
        raise ArgumentError("nothing varies", argument="over", remedy="Name a coordinate, e.g. x_m=-0.03:0.03.")
    loads = ("mass_kg", *robot.coordinates.wrench)
    if not any(name in ranges or name in held for name in loads):
        raise ArgumentError("no load is named", argument="at", remedy=f"Name {', '.join(loads[:4])} ..., or vary it.")
    if not error.get("length", 0.0) > 0.0 or not error.get("angle", 0.0) > 0.0:
        raise ArgumentError("the error must be positive", argument="error", remedy="Give lengths (m) and angles (rad).")
    axes = tuple(ranges)
    low, high = np.array(list(ranges.values())).T
    wanted = np.array([error["length" if name.endswith("_m") else "angle"] for name in robot.configuration])
    _require_no_history(identified, axes, held)

    def exact(points: FloatArray) -> FloatArray:
        return _corrections(identified, axes, held, points)

    extrapolated = _judged(identified, axes, held, np.array(list(product(*ranges.values()))))
    found = correction_table(exact, low, high, wanted, most=nodes, seed=seed)
    purpose = purpose_of("table", model)
    return CorrectionTableResult(axes, robot.configuration, held, found, identified, extrapolated, purpose=purpose)


def _in_si(values: Mapping[str, tuple[float, ...]], where: str, robot: Robot) -> dict[str, tuple[float, ...]]:
    """The named coordinates in SI units."""
    coordinates = robot.coordinates
    known = (
        *robot.configuration, "mass_kg", *coordinates.centre_of_mass, *coordinates.wrench, *coordinates.gravity,
        "temperature_degC",
    )  # fmt: skip
    found: dict[str, tuple[float, ...]] = {}
    for name, numbers in values.items():
        measured = measured_column(name)
        si = name if measured is None else measured.si_name
        if si not in known:
            raise ArgumentError(f"unknown coordinate `{name}`", argument=where, remedy=nearest(name, known))
        if si in found:
            raise ArgumentError(f"{si} is named twice", argument=where, remedy="Name it once.")
        if not _are_numbers(numbers, 2 if where == "over" else 1):
            what = f"{numbers if where == 'over' else numbers[0]!r} is no {'range' if where == 'over' else 'value'}"
            remedy = f"Give {'two numbers, (low, high)' if where == 'over' else 'one number'}."
            raise ArgumentError(what, argument=f"{where}[{name!r}]", remedy=remedy)
        found[si] = numbers if measured is None else tuple(measured.unit.to_si(number) for number in numbers)
    return found


def _are_numbers(values: object, count: int) -> bool:
    if not isinstance(values, Sequence | np.ndarray) or len(values) != count:
        return False
    return all(isinstance(value, Real) for value in values)


def _range(name: str, pair: tuple[float, ...]) -> tuple[float, float]:
    low, high = pair
    if not low < high or not np.isfinite(high - low):
        what = f"the range of {name} from {low:g} to {high:g} is empty"
        raise ArgumentError(what, argument="over", remedy="Give the lower end first, or hold the coordinate.")
    return low, high


def _points(model: Model, axes: tuple[str, ...], held: Mapping[str, float], points: FloatArray) -> Table:
    robot = model.chain.robot
    columns: dict[str, Any] = dict(zip(robot.configuration, robot.reference_configuration().tolist(), strict=True))
    given = {*axes, *held}
    if "mass_kg" in given:
        columns |= dict.fromkeys(robot.coordinates.centre_of_mass, 0.0)
    if given & set(robot.coordinates.wrench):
        columns |= dict.fromkeys(robot.coordinates.wrench, 0.0)
    columns |= dict(held) | {name: points[:, index] for index, name in enumerate(axes)}
    frame = pd.DataFrame({name: np.broadcast_to(value, len(points)) for name, value in columns.items()})
    return Table("table", frame, np.arange(len(points)))


def _judged(
    model: Model, axes: tuple[str, ...], held: Mapping[str, float], corners: FloatArray
) -> tuple[OutsideRange, ...]:
    """What the corners (2^d, d) of a table have outside of what was calibrated, the farthest of each kind.

    What is implausible there is said as `compensate` says it of targets.
    """
    robot, calibrated = model.chain.robot, model.calibrated
    points = points_from_table(_points(model, axes, held, corners), robot)
    found = target_findings(points, robot, calibrated)
    if calibrated is None:
        corrections = corrections_of(robot, points, _commands(model, axes, corners, points), None)
        found += correction_findings(robot, points, corrections.translation, corrections.rotation)
    say([replace(finding, where=_place(axes, corners, finding.where)) for finding in found], "table")
    beyond: dict[str, OutsideRange] = {}
    for each in (one for row in calibrated.beyond(points, robot) for one in row) if calibrated is not None else ():
        if each.name not in beyond or each.outside > beyond[each.name].outside:
            beyond[each.name] = each
    return tuple(beyond.values())


def _corrections(model: Model, axes: tuple[str, ...], held: Mapping[str, float], points: FloatArray) -> FloatArray:
    """Command − target (N, n_q) at points (N, d)."""
    loaded = points_from_table(_points(model, axes, held, points), model.chain.robot)
    corrections: FloatArray = _commands(model, axes, points, loaded).commands - loaded.configurations
    return corrections


def _commands(model: Model, axes: tuple[str, ...], points: FloatArray, loaded: LoadedPoints) -> Compensation:
    """The commands at points (N, d); what is wrong is said with the values there."""
    try:
        return commands_for(model, loaded)
    except (InfeasibleError, SingularConfigurationError, ConvergenceError) as error:
        remedy = "Take smaller ranges, in which every target can be reached."
        raise type(error)(error.what, where=f"table {_place(axes, points, error.where)}", remedy=remedy) from None


def _place(axes: tuple[str, ...], points: FloatArray, where: str) -> str:
    """The point that `row N` names, by its values."""
    row = int(where.rpartition("row ")[2]) if "row " in where else 0
    return "at " + ", ".join(f"{name} {value:.4g}" for name, value in zip(axes, points[row], strict=True))


def _require_no_history(model: Model, axes: tuple[str, ...], held: Mapping[str, float]) -> None:
    one = np.zeros((1, len(axes)))
    try:
        require_history(model, _points(model, axes, held, one))
    except InputError as error:
        what = f"the model depends on more than pose and load, which a table cannot tell ({error.where.split()[-1]})"
        remedy = "Use `expdesign compensate` with the history, or a model without these effects."
        raise InputError(what, where=model.source, remedy=remedy) from None
