"""`table`: corrections of commands over poses and loads, for a machine's control."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from numbers import Real
from typing import Annotated

import numpy as np

from expdesign.app.api.arguments import Seed, Within, named_arguments
from expdesign.app.api.inputs import ModelInput, load_model, purpose_of
from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.targets import correction_findings, target_findings
from expdesign.chain.models.estimable import OutsideRange
from expdesign.errors import ArgumentError
from expdesign.estimation.compensation.compensate import corrections_of
from expdesign.estimation.compensation.correction_table import correction_table
from expdesign.estimation.compensation.tabulated import Tabulated
from expdesign.io.nearest import nearest
from expdesign.io.units import measured_column
from expdesign.mechanics.robots.robot import Robot
from expdesign.report.compensation_texts import CorrectionTableResult

MOST_NODES = 50_000
"""Nodes at most where nothing is said."""
ERROR = {"length": 1e-8, "angle": 1e-7}
"""m, rad."""

Nodes = Annotated[int, Within("a number of nodes", "Use at least 2.", 2)]


@named_arguments
def table(
    model: ModelInput,
    over: Mapping[str, tuple[float, float]],
    at: Mapping[str, float] | None = None,
    *,
    error: Mapping[str, float] = ERROR,
    nodes: Nodes = MOST_NODES,
    seed: Seed = 1,
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
    tabulated = Tabulated(identified, tuple(ranges), held)
    low, high = np.array(list(ranges.values())).T
    wanted = np.array([error["length" if name.endswith("_m") else "angle"] for name in robot.configuration])
    tabulated.require_no_history()
    extrapolated = _judged(tabulated, np.array(list(product(*ranges.values()))))
    found = correction_table(tabulated.corrections, low, high, wanted, most=nodes, seed=seed)
    return CorrectionTableResult(tabulated, found, extrapolated, purpose=purpose_of("table", model))


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
        listed = isinstance(numbers, Sequence | np.ndarray) and len(numbers) == (2 if where == "over" else 1)
        if not listed or not all(isinstance(number, Real) for number in numbers):
            what = f"{numbers if where == 'over' else numbers[0]!r} is no {'range' if where == 'over' else 'value'}"
            remedy = f"Give {'two numbers, (low, high)' if where == 'over' else 'one number'}."
            raise ArgumentError(what, argument=f"{where}[{name!r}]", remedy=remedy)
        found[si] = numbers if measured is None else tuple(measured.unit.to_si(number) for number in numbers)
    return found


def _range(name: str, pair: tuple[float, ...]) -> tuple[float, float]:
    low, high = pair
    if not low < high or not np.isfinite(high - low):
        what = f"the range of {name} from {low:g} to {high:g} is empty"
        raise ArgumentError(what, argument="over", remedy="Give the lower end first, or hold the coordinate.")
    return low, high


def _judged(tabulated: Tabulated, corners: FloatArray) -> tuple[OutsideRange, ...]:
    """What the corners (2^d, d) of a table have outside of what was calibrated, the farthest of each kind.

    What is implausible there is said as `compensate` says it of targets.
    """
    robot, calibrated = tabulated.model.chain.robot, tabulated.model.calibrated
    points = tabulated.points(corners)
    found = target_findings(points, robot, calibrated)
    if calibrated is None:
        corrections = corrections_of(robot, points, tabulated.commands(corners, points), None)
        found += correction_findings(robot, points, corrections.translation, corrections.rotation)
    say([replace(finding, where=tabulated.named(corners, finding.where)) for finding in found], "table")
    beyond: dict[str, OutsideRange] = {}
    for each in (one for row in calibrated.beyond(points, robot) for one in row) if calibrated is not None else ():
        if each.name not in beyond or each.outside > beyond[each.name].outside:
            beyond[each.name] = each
    return tuple(beyond.values())
