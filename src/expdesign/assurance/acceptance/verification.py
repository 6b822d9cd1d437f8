"""Attained against predicted, and attained against tolerance, after a check measurement.

Two questions, two tests. Does the model predict what was attained? The residuals r of N rows and k axes have, under the
model, the covariance V = V_noise + S·P·Sᵀ (P of the identified parameters, S their sensitivities, the same for all
rows), so that rᵀV⁻¹r is χ² with N·k degrees of freedom; single readings are tested by z with Holm's correction (Holm
1979). Does the robot attain its tolerances? The measured error e of an axis, the mean of its readings, with expanded
uncertainty U of the measurement, proves conformity where |e| + U ≤ T and non-conformity where |e| − U > T (ISO 14253-1;
JCGM 106:2012, 8.3). Only proven conformity passes; an axis that is beyond its tolerance then passes with a probability
of at most Φ(−k), and so does a robot with at least one such axis, since all axes have to pass (Berger 1982). A robot
fails where an axis is proven to be beyond its tolerance; otherwise conformity is not proven.

The decision rests on the readings alone, and holds for the targets that were measured even where the model is refuted.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import ndtr

from expdesign.arrays import FloatArray, IntArray, TextArray
from expdesign.assurance.acceptance.check_measurement import FARTHEST, CheckMeasurement
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.recordings.references import groups
from expdesign.chain.row import row_data
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.estimation.compensation.arm_targets import ArmTargets, instrument_of
from expdesign.estimation.compensation.joint_space import at_targets, tip_chain
from expdesign.estimation.compensation.prediction import chain_of
from expdesign.estimation.coverage_factor import Coverage
from expdesign.estimation.goodness import StatementOfFit, WorstRow
from expdesign.mechanics.robots.orientation import rotations_of
from expdesign.mechanics.robots.robot import Robot

SAME_TARGET = 1e-7
"""m or rad, N or N·m by which rows of one target may differ."""


@dataclass(frozen=True)
class Comparison:
    """Attained and predicted errors (attained minus wanted pose) of N rows along k measured axes (m, rad).

    Attributes:
        attained: shape (N, k).
        predicted: shape (N, k).
        noise: covariance of the readings, shape (N·k, N·k).
        model: covariance of the prediction, shape (N·k, N·k).
    """

    attained: FloatArray
    predicted: FloatArray
    noise: FloatArray
    model: FloatArray

    def turned(self, rotation: FloatArray) -> "Comparison":
        """The same along other axes: shifts and rotation vectors, k = 3 or 6, turned by a rotation (3, 3)."""
        rows, axes = self.attained.shape
        one = np.kron(np.eye(axes // 3), rotation)
        every = np.kron(np.eye(rows), one)
        noise, model = every @ self.noise @ every.T, every @ self.model @ every.T
        return Comparison(self.attained @ one.T, self.predicted @ one.T, noise, model)

    @property
    def residuals(self) -> FloatArray:
        """Attained minus predicted, shape (N, k)."""
        return self.attained - self.predicted

    @property
    def chi2(self) -> float:
        """rᵀV⁻¹r."""
        flat = self.residuals.ravel()
        scale = np.sqrt(np.diag(self.noise))
        factor = cho_factor((self.noise + self.model) / np.outer(scale, scale))
        return float((flat / scale) @ cho_solve(factor, flat / scale))

    def statement(self, points: LoadedPoints, columns: Sequence[str]) -> StatementOfFit:
        """Whether the model predicts what was attained at these points, along these columns of deflection."""
        z = np.abs(self.z)
        row, axis = (int(i) for i in np.unravel_index(int(z.argmax()), z.shape))
        worst = WorstRow(points.where(row), columns[axis], float(z[row, axis]))
        return StatementOfFit.of_chi2(self.chi2, self.residuals.size, worst)

    @property
    def z(self) -> FloatArray:
        """Residuals in standard deviations, shape (N, k)."""
        deviation = np.sqrt(np.diag(self.noise + self.model))
        z: FloatArray = self.residuals / deviation.reshape(self.residuals.shape)
        return z

    @property
    def adjusted(self) -> FloatArray:
        """Two-sided p-values of `z` with Holm's correction for their number, shape (N, k)."""
        p = (2.0 * ndtr(-np.abs(self.z))).ravel()
        order = np.argsort(p)
        stepped = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
        adjusted = np.empty_like(p)
        adjusted[order] = np.minimum(stepped, 1.0)
        return adjusted.reshape(self.z.shape)


def compare(model: Model, check: CheckMeasurement, deviations: FloatArray) -> Comparison:
    """What was attained beside what the model predicts, of an arm along the axes of its base.

    Args:
        model: the identified robot.
        check: what was measured.
        deviations: standard deviations of the readings, shape (N, k).

    Raises:
        NotIdentifiableError: a prediction depends on parameters that were not determined.
    """
    robot = model.chain.robot
    if check.poses is not None:
        predicted, motion = tip_errors(model, check, check.poses)
        flat = motion[:, check.axes].reshape(-1, motion.shape[-1])
        noise = noise_covariance(deviations, None)
        found = Comparison(check.readings, predicted[:, check.axes], noise, _model_covariance(model, flat, check))
        return found if check.frame == "base" else found.turned(instrument_of(model)[1])
    rows = row_data(check.points, robot)
    moved, motion = chain_of(model, platform=True).predict_with_sensitivities(rows, model.values)
    away = _command_errors(robot, check)[:, check.axes]
    platform = moved[:, check.axes]
    if check.absolute or not model.chain.reading.linear:
        attained = check.readings if check.absolute else away + check.readings
        sensitivities = motion
    else:
        reading, sensitivities = chain_of(model, platform=False).predict_with_sensitivities(rows, model.values)
        # What the instrument adds to the platform's motion is known from the model and taken off.
        attained = away + check.readings - (reading[:, check.axes] - platform)
    flat = sensitivities[:, check.axes].reshape(-1, sensitivities.shape[-1])
    return Comparison(
        attained,
        away + platform,
        noise_covariance(deviations, None if check.absolute else check.points.references),
        _model_covariance(model, flat, check),
    )


def tip_errors(model: Model, check: CheckMeasurement, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Predicted errors (N, 6) of an arm's tip at the commands, against wanted poses (N, 6), and their derivatives.

    They are along the axes of the check's frame. Seen from the instrument, its own pose is uncertain as well.

    Raises:
        InputError: the model puts a tip where the wanted poses, in this frame, cannot be meant.
    """
    place, turn = (np.zeros(3), np.eye(3)) if check.frame == "base" else instrument_of(model)
    targets = ArmTargets(
        check.points, poses[:, :3] @ turn.T + place, turn @ rotations_of(poses[:, 3:]), check.frame, None
    )
    rows = row_data(at_targets(model, targets, check.frame), model.chain.robot)
    predicted, slopes = tip_chain(model, check.frame).predict_with_sensitivities(rows, model.values)
    errors = predicted - np.hstack([poses[:, :3], np.zeros((len(poses), 3))])
    away = np.linalg.norm(errors[:, :3], axis=1)
    if away.max() > FARTHEST:
        row = int(away.argmax())
        what = f"by the model the tip is {away[row]:.3g} m from its target in the frame of the {check.frame}"
        remedy = "State the frame of the targets as for `compensate` (argument `frame`)."
        raise InputError(what, where=check.points.where(row), remedy=remedy)
    return errors, slopes


def _command_errors(robot: Robot, check: CheckMeasurement) -> FloatArray:
    """Unloaded pose at the command minus wanted pose, shape (N, n)."""
    commands = check.points.configurations
    difference = commands - check.targets
    if robot.configuration == robot.coordinates.pose:
        return difference
    halfway = robot.jacobians(check.targets + difference / 2.0).pose
    errors: FloatArray = (halfway @ difference[..., None])[..., 0]
    return errors


def noise_covariance(deviations: FloatArray, references: TextArray | None) -> FloatArray:
    """Covariance (N·k, N·k) of readings with standard deviations (N, k), half of it common to rows of one reference."""
    rows, axes = deviations.shape
    across = np.eye(rows)
    if references is not None:
        numbers = groups(references)
        across = 0.5 * (np.eye(rows) + (numbers[:, None] == numbers[None, :]))
    covariance = np.zeros((rows, axes, rows, axes))
    for axis in range(axes):
        covariance[:, axis, :, axis] = across * np.outer(deviations[:, axis], deviations[:, axis])
    return covariance.reshape(rows * axes, rows * axes)


def _model_covariance(model: Model, flat: FloatArray, check: CheckMeasurement) -> FloatArray:
    known = np.isfinite(np.diag(model.covariance))
    lost = (flat[:, ~known] != 0.0).any(axis=1)
    if lost.any():
        row = int(np.flatnonzero(lost)[0]) // len(check.axes)
        what = "the attained pose depends on parameters that the recordings of the model did not determine"
        remedy = "Identify the robot from measurements that load every actuator."
        raise NotIdentifiableError(what, where=check.points.where(row), remedy=remedy)
    inner = model.covariance[np.ix_(known, known)]
    covariance: FloatArray = flat[:, known] @ inner @ flat[:, known].T
    return covariance


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


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of targets that a configuration names.

    Attributes:
        configurations: shape (t, n_q).
        tolerance: ± (m, rad), shape (t, n), NaN where an axis does not matter.
        axes: errors along the axes of the tolerances per error of the pose coordinates, shape (t, n, n), or None.
        readings: standard uncertainty of a single reading of each (m, rad), shape (t, n), NaN where it is not known.
    """

    configurations: FloatArray
    tolerance: FloatArray
    axes: FloatArray | None = None
    readings: FloatArray | None = None


def judge(
    check: CheckMeasurement, comparison: Comparison, tolerances: Tolerances | None, coverage: Coverage, robot: Robot
) -> tuple[TargetResult, ...]:
    """The results of every target that was measured, and of those of the configuration that were not.

    Raises:
        InputError: the tolerances are along axes of the body, and not all axes were measured.
    """
    results, met = [], set()
    for rows in _groups(check):
        configuration = check.targets[rows[0]]
        index = None if tolerances is None else _match(configuration, tolerances.configurations)
        if index is not None:
            met.add(index)
        results.append(_result(check, comparison, rows, tolerances, index, coverage, robot))
    for index in range(0 if tolerances is None else len(tolerances.configurations)):
        if index not in met and tolerances is not None:
            none = np.zeros(0, dtype=np.int64)
            readings = None if tolerances.readings is None else tolerances.readings[index]
            axes = _axis_results(None, None, tolerances.tolerance[index], coverage, robot, readings)
            results.append(TargetResult(tolerances.configurations[index], none, axes))
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


def _match(configuration: FloatArray, known: FloatArray) -> int | None:
    distance = np.abs(known - configuration).max(axis=1)
    nearest = int(np.argmin(distance))
    return nearest if distance[nearest] <= SAME_TARGET else None


def _result(
    check: CheckMeasurement,
    comparison: Comparison,
    rows: IntArray,
    tolerances: Tolerances | None,
    index: int | None,
    coverage: Coverage,
    robot: Robot,
) -> TargetResult:
    n, k = robot.coordinates.n, len(check.axes)
    flat = (rows[:, None] * k + np.arange(k)).ravel()
    mean = np.tile(np.eye(k), (1, len(rows))) / len(rows)
    covariance = mean @ comparison.noise[np.ix_(flat, flat)] @ mean.T
    errors = comparison.attained[rows].mean(axis=0)
    limits = np.full(n, np.nan)
    if check.tolerance is not None:
        limits = check.tolerance[rows].min(axis=0)
    elif tolerances is not None and index is not None:
        limits = tolerances.tolerance[index]
        if tolerances.axes is not None:
            if k < n:
                what = "tolerances along the axes of the body need every component to be measured"
                raise InputError(what, where=check.points.where(int(rows[0])), remedy="Measure all of them.")
            turned = tolerances.axes[index]
            errors, covariance = turned @ errors, turned @ covariance @ turned.T
    full, deviation = np.full(n, np.nan), np.full(n, np.nan)
    full[check.axes], deviation[check.axes] = errors, np.sqrt(np.diag(covariance))
    return TargetResult(check.targets[rows[0]], rows, _axis_results(full, deviation, limits, coverage, robot))


def _axis_results(
    errors: FloatArray | None,
    deviation: FloatArray | None,
    limits: FloatArray,
    coverage: Coverage,
    robot: Robot,
    readings: FloatArray | None = None,
) -> tuple[AxisResult, ...]:
    def number(values: FloatArray | None, axis: int) -> float | None:
        return None if values is None or not np.isfinite(values[axis]) else float(values[axis])

    found = []
    for axis, name in enumerate(robot.coordinates.deflection):
        result = AxisResult(
            name,
            number(errors, axis),
            number(deviation, axis),
            number(limits, axis),
            coverage.factor,
            number(readings, axis),
        )
        if result.error is not None or result.tolerance is not None:
            found.append(result)
    return tuple(found)


@dataclass(frozen=True)
class Verification:
    """What a check measurement says.

    Attributes:
        comparison: attained against predicted.
        statement: whether the model predicts what was attained.
        targets: attained against tolerance.
        coverage: of the expanded uncertainties.
        model_refuted: whether the model's own recordings refute it.
    """

    comparison: Comparison
    statement: StatementOfFit
    targets: tuple[TargetResult, ...]
    coverage: Coverage
    model_refuted: bool = False

    @property
    def consistent(self) -> bool:
        """Whether the model predicts what was attained."""
        return not self.statement.refuted

    @property
    def decided(self) -> bool:
        """Whether any axis has a tolerance."""
        return any(target.decided for target in self.targets)

    @property
    def verdict(self) -> str:
        """`pass`, `fail` (an axis is proven to be beyond its tolerance), `not proven`, or `no tolerance`."""
        if not self.decided:
            return "no tolerance"
        if all(target.passes for target in self.targets):
            return "pass"
        conformities = {axis.conformity for target in self.targets for axis in target.axes}
        return "fail" if "does not conform" in conformities else "not proven"

    @property
    def off_target(self) -> bool:
        """Whether the configuration's tolerances are of targets at none of which there is a reading."""
        with_tolerance = [target for target in self.targets if target.decided]
        return bool(with_tolerance) and all(len(target.rows) == 0 for target in with_tolerance)

    @property
    def readings_needed(self) -> int | None:
        """How many independent readings of every target with a tolerance would prove conformity; None where no number
        is known to.
        """
        judged = [target for target in self.targets if target.decided]
        needed = [target.measurements_needed for target in judged if not target.passes]
        taken = [len(target.rows) for target in judged if target.passes]
        if None in needed:
            return None
        return max([*taken, *(count for count in needed if count is not None)], default=None)

    @property
    def risk(self) -> float:
        """Largest probability with which a robot that is beyond a tolerance passes: Φ(−k)."""
        return float(ndtr(-self.coverage.factor))
