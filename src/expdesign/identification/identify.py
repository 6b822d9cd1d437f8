"""Identification of the base model: compliances, how well they are known, and what speaks against them."""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.chain import Chain
from expdesign.elastostatics.maps import actuator_forces, observation_matrix
from expdesign.errors import InputError
from expdesign.identification.estimability import (
    idle_actuators,
    idle_remarks,
    require_estimable,
    require_regular_rows,
)
from expdesign.identification.fit import Fit, idle_knowledge, linear_fit
from expdesign.identification.geometric import Calibration, calibration_of, geometry_slice
from expdesign.identification.goodness import Goodness, goodness_of_fit
from expdesign.identification.influence import Influence, influence
from expdesign.identification.intervals import Intervals, uncertainty
from expdesign.identification.noise_level import NoiseLevel, noise_from_replicates, noise_from_residuals
from expdesign.identification.positions import PositionFit, fit_positions
from expdesign.identification.suspicions import require_positive, suspicions
from expdesign.identification.whitening import Whitening
from expdesign.recordings.recordings import Recordings
from expdesign.recordings.remark import Remark
from expdesign.robots.robot import Robot


@dataclass(frozen=True)
class Identification:
    """What recordings say about a robot's stiffness.

    Attributes:
        robot: the robot.
        recordings: all rows.
        fitted: rows that were fitted, shape (N,).
        fit: of the fitted rows; its parameters are compliances in units of 1/apK, and its covariance allows for a noise
            level that was estimated, and is inflated by the Birge ratio where the model is refuted.
        noise: standard deviations of the fitted rows.
        compliance: with 95 % intervals (m/N or rad/(N·m)).
        stiffness: with 95 % intervals (N/m or N·m/rad), infinite or NaN where the compliance's interval contains zero.
        goodness: tests of the fit.
        influence: contributions of the fitted rows.
        test_residuals: of the rows that were held out, divided by their standard deviations, shape (n_test, k).
        prior: relative standard deviation of the prior compliances, or None.
        shared_reference: whether the rows of a series share their unloaded measurement.
        suspicions: what looks like a mistake in the recordings, or limits what they tell.
        calibration: what was identified.
        geometry: errors of joints and lengths with 95 % intervals (m or rad), or None where the geometry is nominal.
    """

    robot: Robot
    recordings: Recordings
    fitted: BoolArray
    fit: Fit
    noise: NoiseLevel
    compliance: Intervals
    stiffness: Intervals
    goodness: Goodness
    influence: Influence
    test_residuals: FloatArray
    prior: float | None
    shared_reference: bool
    suspicions: list[Remark]
    calibration: Calibration = "elastostatic"
    geometry: Intervals | None = None

    @property
    def geometry_names(self) -> tuple[str, ...]:
        """Names of the errors in `geometry`."""
        part = geometry_slice(self.fit.chain)
        return () if part is None else tuple(parameter.name for parameter in self.fit.chain.parameters[part])

    @property
    def covariance(self) -> FloatArray:
        """Of the compliances, m²/N² (or rad²/(N·m)²), shape (n_p, n_p)."""
        scale = self.robot.compliance
        count = len(scale)
        covariance: FloatArray = self.fit.covariance[:count, :count] * np.outer(scale, scale)
        return covariance


def identify(
    robot: Robot,
    recordings: Recordings,
    *,
    shared_reference: bool = False,
    prior: float | None = None,
    calibration: Calibration | None = None,
    frames_known: bool = True,
) -> Identification:
    """Identify the compliances by weighted (or, with a shared reference, generalised) least squares.

    theory.md 3: ĉ = (G·A_M)⁺·G·ΔX̂_M and Cov(ĉ) = (A_MᵀV⁻¹A_M)⁻¹, through an orthogonal factorisation of G·A_M.

    Args:
        robot: the robot; its approximate stiffness scales the problem and is the mean of the prior.
        recordings: what was measured; rows marked `test` are predicted but not fitted.
        shared_reference: whether half of the variance of each row is common to its series.
        prior: relative standard deviation with which the approximate compliances are known beforehand; None for no
            prior.
        calibration: what is identified; None for what the columns say (`calibration_of`).
        frames_known: whether measured poses are in the very frames of the commands.

    Raises:
        InputError: there is nothing to fit, or the deflections have the wrong sign.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the recordings do not determine every compliance.
    """
    chosen = calibration_of(robot, recordings, calibration)
    if recordings.measurand.absolute:
        found = fit_positions(
            robot, recordings, shared_reference=shared_reference, calibration=chosen, frames_known=frames_known
        )
        return _of_positions(robot, recordings, found, chosen, shared_reference=shared_reference)
    return _of_deflections(robot, recordings, prior, shared_reference=shared_reference)


def _of_deflections(
    robot: Robot, recordings: Recordings, prior: float | None, *, shared_reference: bool
) -> Identification:
    """Identification of the compliances alone, in which deflections are linear."""
    fitted = ~recordings.test & ~reference_rows(recordings)
    if not fitted.any():
        what = "no row is left to fit"
        raise InputError(what, where=recordings.source, remedy="Mark some loaded rows `train` in the column `split`.")
    train = recordings.rows(fitted)
    jacobians = robot.jacobians(train.configurations)
    require_regular_rows(train, jacobians)
    observation = observation_matrix(jacobians, train.wrenches)[:, train.axes] * robot.compliance
    start = np.zeros(len(robot.stiffness))
    knowledge: tuple[FloatArray, FloatArray] | None = None
    if prior is not None:
        knowledge = np.ones_like(start), np.full_like(start, prior)
    idle = idle_actuators(robot, jacobians, train.wrenches, train.axes)
    if prior is None and idle is not None:
        observation[..., idle] = 0.0
        knowledge = idle_knowledge(idle, len(start))
    chain = Chain(robot)

    def solve(deviations: FloatArray) -> Fit:
        whitening = Whitening(deviations, train.series, shared_reference=shared_reference)
        readings, sensitivities = whitening.apply(train.deflections), whitening.apply(observation)
        return linear_fit(chain, start, readings, sensitivities, knowledge)

    if prior is None and len(start):
        size = np.abs(train.deflections).max(axis=0)
        sensitivities = observation / np.where(size > 0.0, size, 1.0)[:, None]
        used = np.ones(len(start), dtype=bool) if idle is None else ~idle
        forces = actuator_forces(jacobians, train.wrenches)[:, used]
        require_estimable([robot.actuators[i] for i in np.flatnonzero(used)], train, forces, sensitivities[..., used])
    translations = robot.coordinates.translations
    if train.deviations is not None:
        noise = NoiseLevel(train.deviations, "recordings")
    else:
        replicated = noise_from_replicates(train, translations, shared_reference=shared_reference)
        noise = replicated or noise_from_residuals(train, translations, solve)
    fit = solve(noise.deviations)
    require_positive(fit, train, robot)
    goodness = goodness_of_fit(fit, train, noise, shared_reference=shared_reference)
    known = uncertainty(fit, noise).inflated(goodness.birge_ratio, goodness.dof)
    if prior is None and idle is not None:
        # What stays as the robot file has it was not determined.
        fit = replace(fit, rank=fit.rank - int(idle.sum()))
    compliance = _scaled(known.intervals(fit.values), robot.compliance)
    return Identification(
        robot=robot,
        recordings=recordings,
        fitted=fitted,
        fit=fit.known_as(known.estimable),
        noise=noise,
        compliance=compliance,
        stiffness=compliance.inverse(),
        goodness=goodness,
        influence=influence(fit, noise_known=noise.known),
        test_residuals=_test_residuals(robot, recordings, fit, noise),
        prior=prior,
        shared_reference=shared_reference,
        suspicions=suspicions(fit, train, robot, noise_known=noise.known)
        + ([] if prior is not None or idle is None else idle_remarks(robot, idle)),
    )


def _of_positions(
    robot: Robot, recordings: Recordings, found: PositionFit, calibration: Calibration, *, shared_reference: bool
) -> Identification:
    """Identification from absolute readings; a prior on the compliances is part of the model (`positions`)."""
    train = recordings.rows(found.fitted)
    goodness = goodness_of_fit(found.fit, train, found.noise, shared_reference=shared_reference)
    known = uncertainty(found.fit, found.noise).inflated(goodness.birge_ratio, goodness.dof)
    count = len(robot.stiffness)
    intervals = known.intervals(found.fit.values)
    compliance = _scaled(intervals.part(slice(count)), robot.compliance)
    part = geometry_slice(found.fit.chain)
    effect = influence(found.fit, noise_known=found.noise.known)
    return Identification(
        robot=robot,
        recordings=recordings,
        fitted=found.fitted,
        fit=found.fit.known_as(known.estimable),
        noise=found.noise,
        compliance=compliance,
        stiffness=compliance.inverse(),
        goodness=goodness,
        influence=replace(effect, share=effect.share[:, :count]),
        test_residuals=found.test_residuals,
        prior=None,
        shared_reference=shared_reference,
        suspicions=found.remarks,
        calibration=calibration,
        geometry=None if part is None else intervals.part(part),
    )


def reference_rows(recordings: Recordings) -> BoolArray:
    """Unloaded rows whose deflections are exactly zero: references by definition, which measure nothing; shape (N,)."""
    unloaded = (recordings.wrenches == 0.0).all(axis=1)
    rows: BoolArray = unloaded & (recordings.deflections == 0.0).all(axis=1)
    return rows


def _scaled(intervals: Intervals, factor: FloatArray) -> Intervals:
    return replace(
        intervals,
        estimate=intervals.estimate * factor,
        low=intervals.low * factor,
        high=intervals.high * factor,
    )


def _test_residuals(robot: Robot, recordings: Recordings, fit: Fit, noise: NoiseLevel) -> FloatArray:
    """Measured minus predicted, in standard deviations, of the rows that were held out, shape (n_test, k)."""
    test = recordings.rows(recordings.test)
    if len(test) == 0:
        return np.zeros((0, len(recordings.axes)))
    observation = observation_matrix(robot.jacobians(test.configurations), test.wrenches)[:, test.axes]
    deviations = test.deviations if test.deviations is not None else noise.deviations[0]
    residuals: FloatArray = (test.deflections - observation @ (fit.values * robot.compliance)) / deviations
    return residuals
