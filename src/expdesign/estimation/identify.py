"""Identification of the base model: compliances, how well they are known, and what speaks against them."""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY
from expdesign.chain.effects.legs.geometry import LegGeometry
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.recordings import Recordings, Remark
from expdesign.chain.recordings.references import reference_rows
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.estimation.arm import ArmCalibration, calibrate
from expdesign.estimation.arm_options import ArmOptions
from expdesign.estimation.coverage import HeldOutRows, held_out_rows, reading_deviations
from expdesign.estimation.estimability import (
    CORRECT_ROW,
    idle_actuators,
    idle_remarks,
    negative_compliances,
    require_estimable,
    require_positive,
)
from expdesign.estimation.fit import Data, Fit, idle_knowledge, linear_fit
from expdesign.estimation.fit import fit as nonlinear_fit
from expdesign.estimation.geometric import (
    calibration_of,
    geometry_remarks,
    geometry_slice,
    require_determined,
    usable_rows,
)
from expdesign.estimation.goodness import REFUTED, StatementOfFit, squares_of, statement_of_fit
from expdesign.estimation.intervals import Intervals, Uncertainty, uncertainty
from expdesign.estimation.left_over import LeftOver, left_over
from expdesign.estimation.load_errors import DeclaredLoadErrors, Estimator, declared_load_errors, load_columns
from expdesign.estimation.noise_level import NoiseLevel, noise_from_replicates, noise_from_residuals
from expdesign.estimation.outlying import Influence, influence
from expdesign.estimation.weighed import Fittable, WeighedLoads, conditional, of_parameters, weighed
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.elastostatics.calibration import Calibration
from expdesign.mechanics.elastostatics.maps import actuator_forces, observation_matrix
from expdesign.mechanics.robots.robot import Robot

_TURNS = 3
"""Times that levels of the noise and scales of load errors are estimated in turn."""


@dataclass(frozen=True)
class Identification:
    """What recordings say about a robot's stiffness.

    Attributes:
        robot: the robot.
        recordings: all rows.
        fitted: rows that were fitted, shape (N,).
        whitening: of the fitted rows, with the load errors that were weighed.
        fit: of the fitted rows; its parameters are compliances in units of 1/apK, and its covariance allows for a noise
            level that was estimated, and is inflated by the Birge ratio where the model is refuted.
        noise: standard deviations of the fitted rows.
        compliance: with 95 % intervals (m/N or rad/(N·m)).
        stiffness: with 95 % intervals (N/m or N·m/rad), infinite or NaN where the compliance's interval contains zero.
        goodness: whether the model accounts for the fitted rows.
        influence: contributions of the fitted rows.
        held_out: the rows marked `test`.
        prior: relative standard deviation of the prior compliances, or None.
        suspicions: what looks like a mistake in the recordings, or limits what they tell.
        calibration: what was identified.
        geometry: errors of joints and lengths with 95 % intervals (m or rad), or None where the geometry is nominal.
        arm: the calibration of an arm from absolute readings, or None.
        loads: declared load errors in the fit, or None.
    """

    robot: Robot
    recordings: Recordings
    fitted: BoolArray
    whitening: Whitening
    fit: Fit
    noise: NoiseLevel
    compliance: Intervals
    stiffness: Intervals
    goodness: StatementOfFit
    influence: Influence
    held_out: HeldOutRows
    prior: float | None
    suspicions: list[Remark]
    calibration: Calibration = "elastostatic"
    geometry: Intervals | None = None
    arm: ArmCalibration | None = None
    loads: WeighedLoads | None = None

    @property
    def geometry_names(self) -> tuple[str, ...]:
        """Names of the errors in `geometry`."""
        part = geometry_slice(self.fit.chain)
        return () if part is None else tuple(parameter.name for parameter in self.fit.chain.parameters[part])

    @property
    def test_residuals(self) -> FloatArray:
        """Measured minus predicted, in standard deviations, of the rows marked `test`, shape (n_test, k)."""
        return self.held_out.residuals

    @property
    def reading_deviations(self) -> FloatArray:
        """Standard deviation of a reading (m, rad), as the fit asks for, shape (k,)."""
        return reading_deviations(self.noise.deviations, self.goodness.reading_ratio)

    @property
    def coverage(self) -> float:
        """Share of the readings of rows marked `test` within their 95 % intervals; NaN where there are none."""
        return self.held_out.coverage(self.fit.estimable, self.goodness.reading_ratio)

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
    prior: float | None = None,
    calibration: Calibration | None = None,
    frames_known: bool = True,
    options: ArmOptions | None = None,
    load_errors: DeclaredLoadErrors | None = None,
    estimator: Estimator = "generalised",
) -> Identification:
    """Identify the compliances by least squares, generalised where rows share an unloaded reading or load errors.

    theory.md 3: ĉ = (G·A_M)⁺·G·ΔX̂_M and Cov(ĉ) = (A_MᵀV⁻¹A_M)⁻¹, through an orthogonal factorisation of G·A_M.

    Args:
        robot: the robot; its approximate stiffness scales the problem and is the mean of the prior.
        recordings: what was measured; rows marked `test` are predicted but not fitted.
        prior: relative standard deviation with which the approximate compliances are known beforehand; None for no
            prior.
        calibration: what is identified; None for what the columns say (`calibration_of`).
        frames_known: whether measured poses are in the very frames of the commands.
        options: of the calibration of an arm from absolute readings.
        load_errors: of the recorded loads, as a configuration declares them; the recordings may declare them as well.
            Those of an arm's absolute readings do not count: their noise is what the calibration leaves over.
        estimator: whether the fit weighs load errors, or its covariance alone contains them.

    Raises:
        InputError: there is nothing to fit, the deflections have the wrong sign, or load errors are declared twice and
            differently.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the recordings do not determine every compliance.
    """
    chosen = calibration_of(robot, recordings, calibration)
    if recordings.measurand.absolute and robot.jointed:
        return _of_arm(robot, recordings, calibrate(robot, recordings, chosen, options), chosen)
    errors = declared_load_errors(robot, recordings, load_errors)
    if recordings.measurand.absolute:
        return _of_positions(robot, recordings, chosen, errors, estimator, frames_known=frames_known)
    return _of_deflections(robot, recordings, prior, errors, estimator)


@dataclass(frozen=True)
class _Outcome:
    """A fit with all that it is judged by; attributes as those of `Identification`."""

    fit: Fit
    noise: NoiseLevel
    whitening: Whitening
    goodness: StatementOfFit
    known: Uncertainty
    loads: WeighedLoads | None = None


def _fitted(
    what: Fittable, errors: DeclaredLoadErrors | None, estimator: Estimator, replicated: NoiseLevel | None = None
) -> _Outcome:
    """The fit of some rows at the noise that they state, or that they show, with declared errors of their loads.

    Args:
        what: is fitted.
        errors: of the loads, as they are declared.
        estimator: how they count.
        replicated: noise that replicates show; None where the residuals have to.
    """
    train, weighs = what.train, errors is not None and estimator == "generalised"
    weights: FloatArray | None = None

    def plain(deviations: FloatArray) -> Whitening:
        return Whitening(deviations, references=train.references, within=train.within)

    def solve(deviations: FloatArray) -> Fit:
        if errors is None or not weighs:
            return what.solve(plain(deviations))
        fit, loads = weighed(what, plain(deviations), errors, "generalised", weights)
        return conditional(what, fit, plain(deviations), loads)

    known_noise = None if train.deviations is None else NoiseLevel(train.deviations, "recordings")
    noise = known_noise or replicated or NoiseLevel(np.ones_like(train.deflections), "residuals")
    if noise.origin == "residuals":
        weights = np.ones(1)
        for _ in range(_TURNS if weighs else 1):
            noise = noise_from_residuals(train, what.chain.robot.coordinates.translations, solve)
            if errors is not None and weighs:
                weights = weighed(what, plain(noise.deviations), errors, "generalised")[1].weights
    whitening = plain(noise.deviations)
    columns = train.components(what.chain.robot.coordinates)
    if errors is None:
        fit = what.solve(whitening)
        goodness = statement_of_fit(fit, train, noise, whitening, columns)
        return _Outcome(fit, noise, whitening, goodness, uncertainty(fit, noise))
    fit, loads = weighed(what, whitening, errors, estimator)
    sized = whitening.weighing(load_columns(loads.effects, loads.sizes))
    exact = squares_of(what.solve(whitening))[0]
    goodness = statement_of_fit(what.solve(sized), train, noise, sized, columns, exact)
    own = uncertainty(conditional(what, fit, whitening, loads) if weighs and not noise.known else fit, noise)
    own = Uncertainty(of_parameters(own.estimable, len(fit.values)), own.dof[: len(fit.values)])
    known = replace(own, estimable=replace(own.estimable, generalised=own.estimable.generalised + loads.excess))
    weighing = whitening.weighing(load_columns(loads.effects, loads.weights) if weighs else None)
    return _Outcome(fit, noise, weighing, goodness, known, loads)


def _of_deflections(
    robot: Robot, recordings: Recordings, prior: float | None, errors: DeclaredLoadErrors | None, estimator: Estimator
) -> Identification:
    """Identification of the compliances alone, in which deflections are linear."""
    if not np.isfinite(robot.stiffness).all():
        what = f"deflections show how joints yield, and `{robot.name}` has no `actuator_stiffness`"
        raise InputError(what, where=recordings.source, remedy="Add its order of magnitude to the robot file.")
    fitted = fitted_rows(recordings)
    if not fitted.any():
        what = "no row is left to fit"
        raise InputError(what, where=recordings.source, remedy="Mark some loaded rows `train` in the column `split`.")
    train = recordings.rows(fitted)
    jacobians = robot.jacobians(train.configurations)
    jacobians.require_regular(train.where, CORRECT_ROW)
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

    def solve(whitening: Whitening) -> Fit:
        readings, sensitivities = whitening.apply(train.deflections), whitening.apply(observation)
        return linear_fit(chain, start, readings, sensitivities, knowledge)

    def linearised(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        return train.deflections - observation @ values, observation

    if prior is None and len(start):
        size = np.abs(train.deflections).max(axis=0)
        sensitivities = observation / np.where(size > 0.0, size, 1.0)[:, None]
        used = np.ones(len(start), dtype=bool) if idle is None else ~idle
        forces = actuator_forces(jacobians, train.wrenches)[:, used]
        require_estimable([robot.actuators[i] for i in np.flatnonzero(used)], train, forces, sensitivities[..., used])
    replicated = None
    if train.deviations is None:
        replicated = noise_from_replicates(train, robot.coordinates.translations)
    found = _fitted(Fittable(chain, train, solve, linearised, knowledge), errors, estimator, replicated)
    require_positive(found.fit, train, robot)
    remarks = negative_compliances(found.fit, robot)
    if prior is None and idle is not None:
        # What stays as the robot file has it was not determined.
        found = replace(found, fit=replace(found.fit, rank=found.fit.rank - int(idle.sum())))
        remarks = remarks + idle_remarks(robot, idle)
    test = recordings.rows(recordings.test)
    held_out = held_out_rows(chain, test, found.fit.values, _stated(test, found.noise))
    return _identification(recordings, fitted, found, held_out, remarks, prior=prior)


def _of_positions(
    robot: Robot,
    recordings: Recordings,
    calibration: Calibration,
    errors: DeclaredLoadErrors | None,
    estimator: Estimator,
    *,
    frames_known: bool,
) -> Identification:
    """Identification from absolute readings of a robot that is no arm: compliances and geometry, with the frames of the
    instrument and the markers' places; the geometry alone from rows without load.

    What the fitted rows do not determine stays what the robot file says, within a wide tolerance (`chain.knowledge`).
    """
    usable = usable_rows(recordings, calibration)
    fitted = usable & ~recordings.test
    reading = reading_of(robot, recordings, frames_known=frames_known)
    train = recordings.rows(fitted)
    effects = () if calibration == "elastostatic" else (LegGeometry(robot, GEOMETRY),)
    chain, rows = Chain(robot, effects, reading=reading), row_data(train, robot)
    idle = np.ones(len(robot.stiffness), dtype=bool) if calibration == "geometric" else None

    def data(whitening: Whitening) -> Data:
        return Data(train, rows, whitening, idle=idle, reading=reading)

    def solve(whitening: Whitening) -> Fit:
        return nonlinear_fit(chain, data(whitening))

    plain = data(Whitening(np.ones_like(train.deflections)))
    if effects:
        require_determined(chain, plain)

    def linearised(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        return plain.residuals_with_sensitivities(chain, values)

    found = _fitted(Fittable(chain, train, solve, linearised, chain.knowledge()), errors, estimator)
    test = recordings.rows(recordings.test & usable & reading.predictable(robot, recordings))
    held_out = held_out_rows(chain, test, found.fit.values, _stated(test, found.noise))
    remarks = reading.degeneracies + geometry_remarks(found.fit)
    return _identification(recordings, fitted, found, held_out, remarks, calibration=calibration)


def _of_arm(robot: Robot, recordings: Recordings, found: ArmCalibration, calibration: Calibration) -> Identification:
    """Identification of an arm from absolute readings, whose noise already accounts for what the model leaves over."""
    train, fit, noise = recordings.rows(found.fitted), found.fit, found.noise
    whitening = Whitening(noise.deviations)
    if train.aim is None and np.isfinite(train.deflections).all():
        goodness = statement_of_fit(fit, train, noise, whitening, recordings.components(robot.coordinates))
    else:  # replicates and single rows are judged by complete readings of one kind
        p_value = found.stated[2] if noise.known and found.stated is not None else None
        mean_square = fit.chi2 / max(fit.dof, 1)
        chi2 = fit.chi2 if noise.known else None
        goodness = StatementOfFit(chi2, fit.dof, p_value, origin=noise.origin, mean_square=mean_square)
    if found.mean_square is not None:  # a row that a robust loss sets aside says nothing of the noise of the others
        goodness = replace(goodness, mean_square=found.mean_square)
        if noise.known and found.stated is not None:
            chi2, dof, p_value = found.stated
            worst = None if goodness.worst is None else replace(goodness.worst, without=None)
            goodness = replace(goodness, chi2=chi2, dof=dof, p_value=p_value, worst=worst)
    beyond = found.stated is not None and not noise.known and found.stated[2] < REFUTED
    goodness = replace(goodness, left=found.left, exceeded=found.stated if beyond else None)
    freedom = np.full(len(fit.values), np.inf if noise.known else float(max(fit.dof, 1)))
    known, held_out = Uncertainty(fit.estimable, freedom), found.held_out
    outcome = _Outcome(fit, noise, whitening, goodness, known)
    return _identification(
        recordings, found.fitted, outcome, held_out, found.remarks, calibration=calibration, arm=found
    )


def _stated(test: Recordings, noise: NoiseLevel) -> FloatArray:
    """Standard deviations that rows state, or else those that were estimated."""
    return test.deviations if test.deviations is not None else noise.deviations[:1]


def _identification(
    recordings: Recordings,
    fitted: BoolArray,
    found: _Outcome,
    held_out: HeldOutRows,
    suspicions: list[Remark],
    *,
    prior: float | None = None,
    calibration: Calibration = "elastostatic",
    arm: ArmCalibration | None = None,
) -> Identification:
    """What a fit with the uncertainty of its parameters says of the robot."""
    fit, goodness, known = found.fit, found.goodness, found.known
    if arm is None:
        looked = recordings.measurand.absolute or not found.noise.known
        goodness = replace(goodness, left=_left(fit, recordings.rows(fitted)) if looked else None)
        known = known.inflated(goodness.birge_ratio, goodness.dof)
    robot, intervals, part = fit.chain.robot, known.intervals(fit.values), geometry_slice(fit.chain)
    scale, own = robot.compliance, intervals.part(slice(len(robot.stiffness)))
    compliance = Intervals(own.estimate * scale, own.low * scale, own.high * scale)
    effect = influence(fit, found.whitening, noise_known=found.noise.known)
    if arm is None:
        fit = replace(fit.known_as(known.estimable), inflation=goodness.birge_ratio**2)
    return Identification(
        robot=robot,
        recordings=recordings,
        fitted=fitted,
        whitening=found.whitening,
        fit=fit,
        noise=found.noise,
        compliance=compliance,
        stiffness=compliance.inverse(),
        goodness=goodness,
        influence=replace(effect, share=effect.share[:, : len(scale)]),
        held_out=held_out,
        prior=prior,
        suspicions=suspicions,
        calibration=calibration,
        geometry=None if part is None else intervals.part(part),
        arm=arm,
        loads=found.loads,
    )


def _left(fit: Fit, train: Recordings) -> LeftOver:
    """What a fit leaves of its rows: of deflections, or of positions and poses beside where their mean is."""
    predicted = fit.chain.predict(row_data(train, fit.chain.robot), fit.values[: len(fit.chain.parameters)])
    after, before, points = train.deflections - predicted[:, train.axes], train.deflections, None
    translations = fit.chain.robot.coordinates.translations if train.marker is None else 3
    if train.measurand.absolute:
        points = before[:, train.axes < translations]
        before = before - np.nanmean(before, axis=0)
    return left_over((before, after), train.axes, fit.residuals, points, translations)


def fitted_rows(recordings: Recordings) -> BoolArray:
    """Rows that are neither held out nor references, shape (N,)."""
    if recordings.measurand.absolute:
        return ~recordings.test
    rows: BoolArray = ~recordings.test & ~reference_rows(recordings)
    return rows
