"""Attained against tolerance: does a robot conform at the targets of a check measurement?

The measured error e of an axis, the mean of its readings, with expanded uncertainty U of the measurement, proves
conformity where |e| + U ≤ T and non-conformity where |e| − U > T (ISO 14253-1; JCGM 106:2012, 8.3). It rests on the
readings alone, and holds for the targets that were measured even where the model is refuted.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.acceptance.attained import Comparison
from expdesign.assurance.acceptance.budget import tolerances
from expdesign.assurance.acceptance.check_measurement import CheckMeasurement
from expdesign.assurance.acceptance.planned import reading_deviations
from expdesign.errors import InputError
from expdesign.estimation.coverage import Coverage
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.problem import DesignProblem

SAME_TARGET = 1e-7
"""m or rad, N or N·m by which rows of one target may differ."""


@dataclass(frozen=True)
class AxisResult:
    """One axis of one target.

    Attributes:
        axis: deflection column along the axis.
        error: mean of the measured errors (m, rad), or None where the axis was not measured.
        uncertainty: standard uncertainty of `error`.
        tolerance: ±, or None where none is stated.
        factor: k.
        reading: standard uncertainty of a single reading, or None where it is not known.
    """

    axis: str
    error: float | None
    uncertainty: float | None
    tolerance: float | None
    factor: float
    reading: float | None = None

    @property
    def expanded(self) -> float | None:
        """U."""
        return None if self.uncertainty is None else self.factor * self.uncertainty

    @property
    def conformity(self) -> str:
        """`conforms`, `does not conform`, `not proven`, or `no tolerance`."""
        if self.tolerance is None:
            return "no tolerance"
        if self.error is None or self.expanded is None:
            return "not proven"
        if abs(self.error) + self.expanded <= self.tolerance:
            return "conforms"
        return "does not conform" if abs(self.error) - self.expanded > self.tolerance else "not proven"


@dataclass(frozen=True)
class TargetResult:
    """One target: its configuration, the rows that measured it, and its axes."""

    configuration: FloatArray
    rows: IntArray
    axes: tuple[AxisResult, ...]

    @property
    def decided(self) -> bool:
        """Whether any axis has a tolerance."""
        return any(axis.tolerance is not None for axis in self.axes)

    @property
    def passes(self) -> bool:
        """Whether every axis that has a tolerance conforms."""
        return all(axis.conformity in ("conforms", "no tolerance") for axis in self.axes)

    @property
    def measurements_needed(self) -> int | None:
        """How many readings would prove conformity if their mean stayed where it is and they are independent.

        Of an axis that was not measured, as many as would if their mean were 0. None where an axis' mean error is
        itself beyond its tolerance, or where it is not known how exact a reading is.
        """
        most = len(self.rows)
        for axis in self.axes:
            if axis.tolerance is None or axis.conformity == "conforms":
                continue
            if axis.error is None and axis.reading is not None:
                most = max(most, int(np.ceil((axis.factor * axis.reading / axis.tolerance) ** 2 * (1.0 - 1e-12))))
                continue
            if axis.error is None or axis.expanded is None or abs(axis.error) >= axis.tolerance:
                return None
            ratio = axis.expanded / (axis.tolerance - abs(axis.error))
            most = max(most, int(np.ceil(len(self.rows) * ratio**2 * (1.0 - 1e-12))))
        return most or None


def judge(
    check: CheckMeasurement, comparison: Comparison, problem: DesignProblem | None, coverage: Coverage, robot: Robot
) -> tuple[TargetResult, ...]:
    """The results of every target that was measured, and of those of a configuration that were not.

    Raises:
        InputError: the tolerances are along axes of the body, and not all axes were measured.
    """
    names, nothing = robot.coordinates.deflection, np.full(robot.coordinates.n, np.nan)
    stated = np.zeros((0, check.targets.shape[1])) if problem is None else problem.targets.configurations
    limits = np.zeros((0, len(names))) if problem is None else tolerances(problem)
    results, met = [], set()
    for rows in _groups(check):
        target = check.targets[rows[0]]
        distance = np.abs(stated - target).max(axis=1)
        index = int(distance.argmin()) if (distance <= SAME_TARGET).any() else None
        met.add(index)
        turn, limit = None, nothing
        if check.tolerance is not None:
            limit = check.tolerance[rows].min(axis=0)
        elif index is not None and problem is not None:
            limit, turn = limits[index], None if problem.targets.axes is None else problem.targets.axes[index]
        error, deviation = _mean(check, comparison, rows, turn, len(names))
        results.append(TargetResult(target, rows, _axes(names, coverage, error, deviation, limit, nothing)))
    if problem is not None:
        readings = reading_deviations(problem)
        for index in (index for index in range(len(stated)) if index not in met):
            axes = _axes(names, coverage, nothing, nothing, limits[index], readings[index])
            results.append(TargetResult(stated[index], np.zeros(0, dtype=np.int64), axes))
    return tuple(results)


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


def _axes(names: tuple[str, ...], coverage: Coverage, *columns: FloatArray) -> tuple[AxisResult, ...]:
    """The axes that were measured or have a tolerance; `columns`: error, its uncertainty, tolerance, reading, (n,)."""
    found = []
    for name, *values in zip(names, *columns, strict=True):
        error, uncertainty, tolerance, reading = (float(each) if np.isfinite(each) else None for each in values)
        if error is not None or tolerance is not None:
            found.append(AxisResult(name, error, uncertainty, tolerance, coverage.factor, reading))
    return tuple(found)
