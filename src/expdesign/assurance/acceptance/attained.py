"""Attained against predicted: does the model predict what a check measurement found?

The residuals r of N rows and k axes have, under the model, the covariance V = V_noise + S·P·Sᵀ (P of the identified
parameters, S their sensitivities, the same for all rows), so that rᵀV⁻¹r is χ² with N·k degrees of freedom; single
readings are tested by z with Holm's correction (Holm 1979).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import ndtr

from expdesign.arrays import FloatArray, TextArray
from expdesign.assurance.acceptance.check_measurement import FARTHEST, CheckMeasurement
from expdesign.chain.chain import Chain
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.recordings.references import groups
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.estimation.compensation.arm_targets import ArmTargets, instrument_of
from expdesign.estimation.compensation.joint_space import at_targets, tip_chain
from expdesign.estimation.compensation.prediction import chain_of, moved
from expdesign.estimation.compensation.target_loads import AttainedUncertainty, TargetLoads
from expdesign.estimation.goodness import StatementOfFit, WorstRow
from expdesign.mechanics.robots.orientation import rotations_of
from expdesign.mechanics.robots.robot import Robot

UNLOADED = 1e-9
"""m, rad: how far the unloaded robot may be from where it is commanded where it is to be there."""


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


def compare(model: Model, check: CheckMeasurement, deviations: FloatArray, loads: TargetLoads) -> Comparison:
    """What was attained beside what the model predicts, of an arm along the axes of its base.

    Args:
        model: the identified robot.
        check: what was measured.
        deviations: standard deviations of the readings, shape (N, k).
        loads: what the rows carry.

    Raises:
        InputError: deflections were measured, and the model says where the unloaded robot stands.
        NotIdentifiableError: a prediction depends on parameters that were not determined.
    """
    robot = model.chain.robot
    if check.poses is not None:
        chain, aimed, predicted = tip_errors(model, check, check.poses, loads)
        noise, known = noise_covariance(deviations, None), _model_covariance(chain, model, aimed, check, loads)
        found = Comparison(check.readings, predicted[:, check.axes], noise, known)
        return found if check.frame == "base" else found.turned(instrument_of(model)[1])
    chain = chain_of(model, platform=True, from_command=True)
    motions = loads.motions(chain, model, check.points)
    if not check.absolute:
        _require_as_commanded(model, check, motions, loads)
    away = _command_errors(robot, check)[:, check.axes]
    platform = motions[:, check.axes]
    if check.absolute or not model.chain.reading.linear:
        attained = check.readings if check.absolute else away + check.readings
    else:
        chain = chain_of(model, platform=False)
        reading = loads.motions(chain, model, check.points)
        # What the instrument adds to the platform's motion is known from the model and taken off.
        attained = away + check.readings - (reading[:, check.axes] - platform)
    return Comparison(
        attained,
        away + platform,
        noise_covariance(deviations, None if check.absolute else check.points.references),
        _model_covariance(chain, model, check.points, check, loads),
    )


def _require_as_commanded(model: Model, check: CheckMeasurement, motions: FloatArray, loads: TargetLoads) -> None:
    """Raise where the model puts the unloaded robot elsewhere than where it was commanded, which no deflection shows.

    `motions` (N, n) are those from the command.
    """
    robot = model.chain.robot
    if robot.jointed:
        elsewhere = any(effect.changes_geometry for effect in model.chain.effects)
    else:
        deflections = loads.motions(chain_of(model, platform=True), model, check.points)
        elsewhere = bool((np.abs(motions - deflections) > UNLOADED).any())
    if elsewhere:
        what = "by the model the unloaded robot is not where it is commanded, and deflections do not show where it is"
        remedy = f"Measure the attained poses: columns measured_{robot.coordinates.pose[0]} ..."
        raise InputError(what, where=check.points.source, remedy=remedy)


def attained_at(model: Model, check: CheckMeasurement, loads: TargetLoads) -> AttainedUncertainty:
    """How well the model knows the poses that its commands attain, as `compensate` states it."""
    points = moved(check.points, check.targets, model.chain.robot)
    if check.poses is None:
        return AttainedUncertainty.at(chain_of(model, platform=True, from_command=True), model, points, loads)
    aimed = at_targets(model, _aims(model, points, check, check.poses), check.frame)
    return AttainedUncertainty.at(tip_chain(model, check.frame), model, aimed, loads)


def _aims(model: Model, points: LoadedPoints, check: CheckMeasurement, poses: FloatArray) -> ArmTargets:
    """The poses (N, 6) that an arm's tip shall have, in the base frame."""
    place, turn = (np.zeros(3), np.eye(3)) if check.frame == "base" else instrument_of(model)
    return ArmTargets(points, poses[:, :3] @ turn.T + place, turn @ rotations_of(poses[:, 3:]), check.frame, poses)


def tip_errors(
    model: Model, check: CheckMeasurement, poses: FloatArray, loads: TargetLoads
) -> tuple[Chain, LoadedPoints, FloatArray]:
    """Predicted errors (N, 6) of an arm's tip at the commands, against wanted poses (N, 6), by which chain and where.

    They are along the axes of the check's frame. Seen from the instrument, its own pose is uncertain as well.

    Raises:
        InputError: the model puts a tip where the wanted poses, in this frame, cannot be meant.
    """
    targets = _aims(model, check.points, check, poses)
    chain, aimed = tip_chain(model, check.frame), at_targets(model, targets, check.frame)
    errors = loads.motions(chain, model, aimed) - np.hstack([poses[:, :3], np.zeros((len(poses), 3))])
    away = np.linalg.norm(errors[:, :3], axis=1)
    if away.max() > FARTHEST:
        row = int(away.argmax())
        what = f"by the model the tip is {away[row]:.3g} m from its target in the frame of the {check.frame}"
        remedy = "State the frame of the targets as for `compensate` (argument `frame`)."
        raise InputError(what, where=check.points.where(row), remedy=remedy)
    return chain, aimed, errors


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
    covariance = np.einsum("nm,na,mb,ab->namb", across, deviations, deviations, np.eye(axes))
    return covariance.reshape(rows * axes, rows * axes)


def _model_covariance(
    chain: Chain, model: Model, points: LoadedPoints, check: CheckMeasurement, loads: TargetLoads
) -> FloatArray:
    """Of what the chain predicts along the measured axes, what is not known of the payloads included, (N·k, N·k)."""
    attained = AttainedUncertainty.at(chain, model, points, loads)
    sensitivities = attained.sensitivities[:, check.axes]
    flat = sensitivities.reshape(-1, sensitivities.shape[-1])
    own = np.concatenate([attained.own, attained.drawn], axis=-1)[:, check.axes]
    own = own.reshape(len(flat), own.shape[-1])
    known = np.isfinite(np.diag(model.covariance))
    lost = (flat[:, ~known] != 0.0).any(axis=1)
    if lost.any():
        row = int(np.flatnonzero(lost)[0]) // len(check.axes)
        what = "the attained pose depends on parameters that the recordings of the model did not determine"
        remedy = "Identify the robot from measurements that load every actuator."
        raise NotIdentifiableError(what, where=check.points.where(row), remedy=remedy)
    inner = model.covariance[np.ix_(known, known)]
    covariance: FloatArray = flat[:, known] @ inner @ flat[:, known].T + own @ own.T
    return covariance
