"""Attained against tolerance: does a robot conform at the targets of a check measurement?

The measured error e of an axis, the mean of its readings, with expanded uncertainty U of the measurement, proves
conformity where |e| + U ≤ T and non-conformity where |e| − U > T (ISO 14253-1; JCGM 106:2012, 8.3). It rests on the
readings alone, and holds for the targets that were measured even where the model is refuted.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray, TextArray
from expdesign.assurance.acceptance.attained import Comparison
from expdesign.assurance.acceptance.budget import tolerances
from expdesign.assurance.acceptance.check_measurement import CheckMeasurement
from expdesign.assurance.acceptance.planned import reading_deviations
from expdesign.errors import InputError
from expdesign.estimation.compensation.target_loads import EXPERIMENT, SAME_AS, TargetLoads
from expdesign.estimation.coverage import Coverage
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.problem import DesignProblem
from expdesign.planning.target_table import target_loads

SAME_TARGET = 1e-7
"""m or rad, N or N·m by which rows of one target may differ."""
SAME_LOAD, LEVER = 1e-3, 0.05
"""Part of a load by which a row may be rounded; m of a centre of mass below which this is a part of that much."""


@dataclass(frozen=True)
class TargetResult:
    """One target along n axes; NaN where an axis was not measured, or has no tolerance.

    Attributes:
        configuration: of the target, shape (n_q,).
        rows: that measured it, shape (m,).
        error: mean of the measured errors (m, rad), shape (n,).
        uncertainty: standard uncertainty of `error`, shape (n,).
        tolerance: ±, shape (n,).
        factor: k.
        reading: standard uncertainty of a single reading where there is none yet, shape (n,).
    """

    configuration: FloatArray
    rows: IntArray
    error: FloatArray
    uncertainty: FloatArray
    tolerance: FloatArray
    factor: float
    reading: FloatArray

    @property
    def expanded(self) -> FloatArray:
        """U, shape (n,)."""
        return self.factor * self.uncertainty

    @property
    def matters(self) -> BoolArray:
        """Which axes have a tolerance, shape (n,)."""
        return np.isfinite(self.tolerance)

    @property
    def conformity(self) -> TextArray:
        """`conforms`, `does not conform`, `not proven`, or `no tolerance` of each axis, shape (n,)."""
        size, most = np.abs(self.error), self.tolerance
        cases = (~self.matters, size + self.expanded <= most, size - self.expanded > most)
        return np.select(cases, ("no tolerance", "conforms", "does not conform"), "not proven")

    @property
    def decided(self) -> bool:
        """Whether any axis has a tolerance."""
        return bool(self.matters.any())

    @property
    def passes(self) -> bool:
        """Whether every axis that has a tolerance conforms."""
        return bool((self.conformity[self.matters] == "conforms").all())

    @property
    def measurements_needed(self) -> int | None:
        """How many readings would prove conformity if their mean stayed where it is and they are independent.

        Of an axis that was not measured, as many as would if their mean were 0. None where an axis' mean error is
        itself beyond its tolerance, or where it is not known how exact a reading is.
        """
        room, count = self.tolerance - np.abs(self.error), len(self.rows)
        with np.errstate(divide="ignore", invalid="ignore"):
            measured = np.where(room > 0.0, count * (self.expanded / room) ** 2, np.nan)
            needed = np.where(np.isnan(self.error), (self.factor * self.reading / self.tolerance) ** 2, measured)
        needed = np.ceil(needed[self.matters & (self.conformity != "conforms")] * (1.0 - 1e-12))
        return None if not np.isfinite(needed).all() else int(needed.max(initial=count)) or None


def judge(
    check: CheckMeasurement,
    comparison: Comparison,
    problem: DesignProblem | None,
    coverage: Coverage,
    robot: Robot,
    carried: TargetLoads,
) -> tuple[TargetResult, ...]:
    """The results of every target that was measured, and of those of a configuration that were not.

    Raises:
        InputError: the tolerances are along axes of the body, and not all axes were measured; or they are those of a
            target that carries another load than a row (`carried`: whose weights).
    """
    nothing = np.full(robot.coordinates.n, np.nan)
    stated = np.zeros((0, check.targets.shape[1])) if problem is None else problem.targets.configurations
    limits = np.zeros((0, len(nothing))) if problem is None else tolerances(problem)
    measured = np.full(len(check), -1) if problem is None else _measured(check, problem, robot, carried)
    results, met = [], set()
    for rows in _groups(check):
        target, index = check.targets[rows[0]], int(measured[rows[0]])
        met.add(index)
        turn, limit = None, nothing
        if check.tolerance is not None:
            limit = check.tolerance[rows].min(axis=0)
        elif index >= 0 and problem is not None:
            limit, turn = limits[index], None if problem.targets.axes is None else problem.targets.axes[index]
        found = _mean(check, comparison, rows, turn, len(nothing))
        results.append(TargetResult(target, rows, *found, limit, coverage.factor, nothing))
    if problem is not None:
        readings = reading_deviations(problem)
        for index in (index for index in range(len(stated)) if index not in met):
            limit, none = limits[index], np.zeros(0, dtype=np.int64)
            results.append(TargetResult(stated[index], none, nothing, nothing, limit, coverage.factor, readings[index]))
    return tuple(results)


def _measured(check: CheckMeasurement, problem: DesignProblem, robot: Robot, carried: TargetLoads) -> IntArray:
    """Index of the configuration's target that each row measures, by pose and load, -1 where there is none, (N,).

    Raises:
        InputError: a row at the pose of a target, without a tolerance of its own, is under another load than its.
    """
    points, own = check.points, problem.own_loads
    names, wanted = target_loads(problem)
    if names == robot.coordinates.wrench or points.payload is None:
        names, given, wanted = robot.coordinates.wrench, points.wrenches, problem.target_wrenches
        allowed = SAME_LOAD * np.broadcast_to(np.abs(wanted).max(axis=1, keepdims=True), wanted.shape)
    else:
        given = np.hstack([points.payload, points.gravity])
        allowed = SAME_LOAD * np.maximum(np.abs(wanted), LEVER)
    if own is not None:
        known = problem.coverage.factor * own.deviations if names[0] == "mass_kg" else 0.0
        allowed[:, : own.deviations.shape[1]] += known
        names, allowed = (*names, SAME_AS), np.pad(allowed, ((0, 0), (0, 1)))
        given, wanted = np.column_stack([given, carried.carries]), np.column_stack([wanted, own.carries])
    differs = np.abs(given[:, None] - wanted) > allowed
    there = np.abs(check.targets[:, None] - problem.targets.configurations).max(axis=-1) <= SAME_TARGET
    same = there & ~differs.any(axis=-1)
    astray = np.flatnonzero(there.any(axis=1) & ~same.any(axis=1))
    if len(astray) and check.tolerance is None:
        row, target = int(astray[0]), int(there[astray[0]].argmax())
        column = int(differs[row, target].argmax())
        here, other = (f"{each[column]:g}" for each in (given[row], wanted[target]))
        if names[column] == SAME_AS:
            here, other = (f"`{EXPERIMENT}`" if each == "1" else "empty" for each in (here, other))
        what = f"{names[column]} is {here} in the row and {other} at target {target + 1} of {problem.source}"
        remedy = "Measure a target under its own load, or correct the row or the configuration."
        raise InputError(what, where=points.where(row, names[column]), remedy=remedy)
    return np.where(same.any(axis=1), same.argmax(axis=1), -1)


def _groups(check: CheckMeasurement) -> list[IntArray]:
    """Rows of each target (pose and load), in the order of their first row."""
    keys = np.concatenate([check.targets, check.points.absolute], axis=1)
    groups: list[list[int]] = []
    for row, key in enumerate(keys):
        for group in groups:
            if np.abs(keys[group[0]] - key).max() <= SAME_TARGET * max(1.0, float(np.abs(key).max())):
                group.append(row)
                break
        else:
            groups.append([row])
    return [np.array(group) for group in groups]


def _mean(
    check: CheckMeasurement, comparison: Comparison, rows: IntArray, turn: FloatArray | None, n: int
) -> tuple[FloatArray, FloatArray]:
    """Mean error of the rows of one target along the axes of its tolerances, and its standard uncertainty, (n,) each.

    NaN where an axis was not measured.
    """
    k = len(check.axes)
    flat = (rows[:, None] * k + np.arange(k)).ravel()
    mean = np.tile(np.eye(k), (1, len(rows))) / len(rows)
    covariance = mean @ comparison.noise[np.ix_(flat, flat)] @ mean.T
    errors = comparison.attained[rows].mean(axis=0)
    if turn is not None:
        if k < n:
            what = "tolerances along the axes of the body need every component to be measured"
            raise InputError(what, where=check.points.where(int(rows[0])), remedy="Measure all of them.")
        errors, covariance = turn @ errors, turn @ covariance @ turn.T
    full, deviation = np.full(n, np.nan), np.full(n, np.nan)
    full[check.axes], deviation[check.axes] = errors, np.sqrt(np.diag(covariance))
    return full, deviation
