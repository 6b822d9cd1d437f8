"""Calibration of arms from absolute readings: geometry, compliances, instrument and markers, all rows at once.

The model is the measurement chain with `CalibratedGeometryError`, linearised exactly. A minimal complete set of
parameters is chosen from the rigid kinematics (`arm_problem.py`); the rest stays as drawn. Beforehand zeros, lengths
and angles are normal with the sizes of `ArmOptions`, times one factor for each kind that the rows decide (`groups.py`),
so that what they do not determine stays at the drawing. Instrument and markers are as unknown as their readings say.

Where the residuals exceed what is stated, the variance is the stated one and a second component σ² for every kind of
reading, with which χ² is its degrees of freedom: Σ r²/(s² + σ²) = n − tr(H) of that kind. Where nothing is stated, or
far too much, the level itself is found likewise.
"""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY, INSTRUMENT, PLATFORM, heavy_links
from expdesign.chain.effect import Effect
from expdesign.chain.effects.instrument.frame import Duration, FrameWander
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError, LinkFrames
from expdesign.chain.effects.joints.readings import JointHarmonics
from expdesign.chain.effects.links.links import LinkMassError
from expdesign.chain.effects.load.payload import UnknownTool
from expdesign.chain.identified import Identified
from expdesign.chain.models.drawn import Drawn
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.recordings.recordings import Recordings, Remark
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.estimation.accuracy import Accuracies, accuracies, nominal_readings, nominal_start, pose_folds
from expdesign.estimation.arm_noise import ArmNoise, Settled
from expdesign.estimation.arm_options import ArmOptions, Further
from expdesign.estimation.arm_problem import (
    ANGLE,
    GROUPS,
    LENGTH,
    ArmProblem,
    Level,
    beyond_manufacture,
    blind_poses,
    chosen_set,
    levels_of,
    priors_of,
    sizes_of,
)
from expdesign.estimation.coverage import HeldOutRows, held_out_rows
from expdesign.estimation.fit import Data, Fit, fit
from expdesign.estimation.gaussian import Gaussian
from expdesign.estimation.left_over import LeftOver, left_over
from expdesign.estimation.noise_level import NoiseLevel
from expdesign.estimation.redundancy import Redundant, labels_of, redundancies
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.elastostatics.calibration import Calibration
from expdesign.mechanics.minimal_set import MinimalSet
from expdesign.mechanics.robots.robot import Robot

_DETERMINED = 0.5
"""Part of its deviation beforehand that a parameter keeps at most where the rows tell it apart."""
_FOLDS = 5
"""Of the cross-validation where no rows are marked `test`."""
_HIDDEN = 0.3
"""Standard deviations by which a parameter moves all readings together, at its size beforehand, that do not show it."""


@dataclass(frozen=True)
class ArmCalibration:
    """What absolute readings say of an arm.

    Attributes:
        fitted: the rows that were fitted, shape (N,).
        fit: of the fitted rows.
        noise: standard deviations of the fitted rows.
        stated: χ², degrees of freedom and p-value at the stated standard deviations, or None where there are none.
        held_out: readings of the rows marked `test` that can be predicted, one by one.
        remarks: what these poses leave blind, and what is wrong with the noise.
        labels: of all parameters of the chain, for people.
        minimal: which of them are identified.
        redundant: the others as combinations of them.
        sizes: of all parameters before the rows were read, those of a kind as the rows size them, shape (p,).
        told_apart: parameters that the rows determine one by one, shape (p,).
        accuracy: before and after.
        left: what the fit leaves of the fitted rows.
        levels: sizes of the groups of errors, by evidence.
        mean_square: of the residuals as a robust loss weighs them; None where all count alike.
        drawn: what no reading shows and the drawing alone says.
    """

    fitted: BoolArray
    fit: Fit
    noise: NoiseLevel
    stated: tuple[float, int, float] | None
    held_out: HeldOutRows
    remarks: list[Remark]
    labels: list[str]
    minimal: MinimalSet
    redundant: list[Redundant]
    sizes: FloatArray
    told_apart: BoolArray
    accuracy: Accuracies
    left: LeftOver
    levels: list[Level]
    mean_square: float | None
    drawn: Drawn


def calibrate(
    robot: Robot, recordings: Recordings, calibration: Calibration, options: ArmOptions | None = None
) -> ArmCalibration:
    """Fit geometry (unless `elastostatic`) and compliances (unless `geometric`) to the rows that are not marked `test`.

    Raises:
        InputError: no row is left to fit.
        NotIdentifiableError: the rows do not place the instrument, or leave nothing over to estimate the noise from.
    """
    options = options or ArmOptions()
    fitted = ~recordings.test
    if not fitted.any():
        remedy = "Mark some rows `train` in the column `split`."
        raise InputError("no row is left to fit", where=recordings.source, remedy=remedy)
    train, reading = recordings.rows(fitted), reading_of(robot, recordings)
    assert isinstance(reading, MarkerPosition)
    if reading.fixed:  # what distances tell apart depends on where the markers are
        plain = Chain(robot, reading=reading)
        reading = replace(reading, start=nominal_start(plain, train)[plain.compliances :])
    effects = (*_geometry(reading, robot, calibration), *further_effects(robot, train, options.further))
    chain = Chain(robot, effects, reading=reading)
    problem = ArmProblem(chain, train, row_data(train, robot), np.arange(len(chain.parameters)))
    sizes, kinds = sizes_of(chain)
    compliances = calibration != "geometric" and "compliances" not in options.hold
    minimal = chosen_set(problem, sizes, options.hold, compliances=compliances)
    problem = replace(problem, live=minimal.kept)
    priors = priors_of(chain, minimal.widened(sizes), kinds, minimal.kept)
    found = ArmNoise(problem, priors, options.loss).settled(_start(chain, calibration))
    beforehand = np.zeros(len(sizes))
    beforehand[minimal.kept] = priors.deviations(found.solution.factors)
    levels = found.solution.factors
    factors = np.where(kinds >= 0, levels[kinds], 1.0)
    hidden = _among(minimal.kept[_hidden(found)], len(sizes))
    factors = np.where(hidden, np.maximum(factors, 1.0), factors)
    fit = _fit(problem, found, factors)
    labels = labels_of(chain)
    told = (np.sqrt(np.diag(fit.covariance)) <= _DETERMINED * beforehand) & _among(minimal.kept, len(sizes))
    typical = np.where(np.isfinite(sizes), sizes, 1e-3)
    errors = _errors(chain, recordings, fit)
    of_fitted = (errors[0][fitted], errors[1][fitted])
    beyond = beyond_manufacture(chain, fit.values, minimal, sizes, labels)
    remarks = [
        *beyond,
        *found.remarks,
        *reading.degeneracies,
        *blind_poses(problem, minimal, labels, sizes, options.hold),
    ]
    return ArmCalibration(
        fitted=fitted,
        fit=fit,
        noise=found.noise,
        stated=found.stated,
        held_out=_held_out(chain, recordings, fit, found),
        remarks=remarks,
        labels=labels,
        minimal=minimal,
        redundant=redundancies(minimal, labels, typical),
        sizes=sizes * factors,
        told_apart=told,
        accuracy=_accuracy(errors, recordings, problem, found),
        left=left_over(of_fitted, train.axes, fit.residuals, train.deflections[:, :3]),
        levels=levels_of(sizes, kinds, minimal.kept, found.solution),
        mean_square=None if options.loss == "squares" else found.mean_square,
        drawn=_drawn(chain, minimal, sizes * factors, levels),
    )


def _drawn(chain: Chain, minimal: MinimalSet, sizes: FloatArray, levels: FloatArray) -> Drawn:
    """What no reading shows, from the sizes of all parameters (p,) and the factors by group (g,).

    What the instrument's pose stands for is the place of the base. A tip that markers of unknown places show is as far
    from where it is drawn as other frames of this arm are.
    """
    reading = chain.reading
    assert isinstance(reading, MarkerPosition)
    count = 0 if reading.instrument is not None else 6 * len(reading.standing)
    of_base = np.isin(minimal.dropped, minimal.standing_in(slice(chain.compliances, chain.compliances + count)))
    steps = minimal.unseen(len(sizes)) * np.where(np.isfinite(sizes), sizes, 0.0)[minimal.dropped]
    known = not any(isinstance(effect, CalibratedGeometryError) for effect in chain.effects)
    known |= all(site in chain.robot.markers for site in reading.sited)
    length, angle = (LENGTH * levels[GROUPS.index("lengths")], ANGLE * levels[GROUPS.index("angles")])
    tip = (0.0, 0.0) if known else (float(length), float(angle))
    return Drawn(steps[:, ~of_base], steps[:, of_base], tip)


def identified_by(calibration: ArmCalibration, recordings: Recordings) -> Identified:
    """What a calibration of these recordings found, for other effects to be sought beside.

    Every parameter is free within its size, those that the minimal set holds as well: what it leaves to others is
    where further physics may want it. So they are fitted once more.
    """
    chain, rows = calibration.fit.chain, recordings.rows(calibration.fitted)
    deviations = np.broadcast_to(calibration.noise.deviations[:1], rows.deflections.shape)
    data = Data(rows, row_data(rows, chain.robot), Whitening(deviations), reading=chain.reading)
    found = Identified(chain, calibration.fit.values, calibration.sizes, calibration.minimal, calibration.drawn)
    knowledge = found.beside().knowledge()
    return replace(found, values=fit(chain, data, chain.start(), knowledge).values)


def _geometry(reading: MarkerPosition, robot: Robot, calibration: Calibration) -> tuple[Effect, ...]:
    if calibration == "elastostatic":
        return ()
    return (CalibratedGeometryError(robot, GEOMETRY, _frames(reading, robot)),)


def further_effects(robot: Robot, train: Recordings, asked: tuple[Further, ...]) -> tuple[Effect, ...]:
    """What is identified beside geometry and compliances.

    Raises:
        InputError: a drift is asked for and no time was recorded.
    """
    found: list[Effect] = []
    if "masses" in asked:
        found += [LinkMassError(robot, link) for link in heavy_links(robot)]
    if "tool" in asked:
        found += [UnknownTool(robot, PLATFORM, variant) for variant in UnknownTool.variants(robot)]
    if "harmonics" in asked:
        found += [JointHarmonics(robot, component) for component in JointHarmonics.components(robot)]
    if "drift" in asked:
        if train.time is None or not np.ptp(train.time) > 0.0:
            remedy = "Add the time of every row (s) to the recordings."
            raise InputError("a drift needs times", where=f"{train.source}, column time_s", remedy=remedy)
        found.append(FrameWander(robot, INSTRUMENT, Duration(float(train.time.max()))))
    return tuple(found)


def _frames(reading: MarkerPosition, robot: Robot) -> LinkFrames:
    """Whose frames are known apart from the joints': of the base with the instrument's, of tips with markers'.

    A gauge shows where the base is as well: its direction is one of O.
    """
    base, tips = (
        reading.instrument is not None or bool(reading.gauges),
        all(site in robot.markers for site in reading.sited),
    )
    return {(False, False): LinkFrames.JOINTS, (True, False): LinkFrames.BASE, (False, True): LinkFrames.TIPS,
            (True, True): LinkFrames.BASE_AND_TIPS}[base, tips]  # fmt: skip


def _start(chain: Chain, calibration: Calibration) -> FloatArray:
    start = chain.start()
    if calibration == "geometric" and not np.isfinite(chain.robot.stiffness).all():
        start[: chain.compliances] = 0.0
    return start


def _hidden(found: Settled) -> BoolArray:
    """Parameters, of those that are fitted, that no reading shows at their size beforehand.

    What others of their group show says nothing of them: they are known as well as they were drawn.
    """
    deviation, moved = found.solution.priors.deviation, np.linalg.norm(found.solution.slopes, axis=0)
    hidden: BoolArray = np.isfinite(deviation) & (moved * np.where(np.isfinite(deviation), deviation, 0.0) < _HIDDEN)
    return hidden


def _fit(problem: ArmProblem, found: Settled, factors: FloatArray) -> Fit:
    """The fit with the covariance of what was identified; what stays as drawn has none.

    `factors` are on the sizes of all parameters beforehand (p,).
    """
    chain, train, live = problem.chain, problem.train, problem.live
    values = found.start.copy()
    values[live] = found.solution.values
    predicted, slopes = chain.predict_with_sensitivities(problem.rows, values)
    seen, deviations = problem.seen, found.noise.deviations
    residuals = np.where(seen, (train.deflections - predicted[:, train.axes]) / deviations, 0.0)
    sensitivities = np.where(seen[..., None], slopes[:, train.axes] / deviations[..., None], 0.0)
    # Held is not known: what depends on it is as uncertain as it is.
    priors, frames = found.solution.priors, slice(chain.compliances, chain.base)
    spreads = np.full(len(values), np.inf)
    spreads[live] = priors.deviation
    spreads[frames] = chain.reading.released(spreads[frames])
    grouped = np.where(priors.group >= 0, factors[live], 1.0)
    known = Gaussian(found.solution.slopes, found.solution.residuals, spreads[live] * grouped).estimable
    covariance = np.zeros((len(values), len(values)))
    covariance[np.ix_(live, live)] = known.generalised
    return Fit(
        chain=chain,
        values=values,
        estimable=Estimable.from_covariance(covariance),
        residuals=residuals,
        sensitivities=sensitivities,
        chi2=float((residuals**2).sum()),
        dof=round(found.dof),
        rank=len(live),
    )


def _among(indices: IntArray, count: int) -> BoolArray:
    inside = np.zeros(count, dtype=bool)
    inside[indices] = True
    return inside


def _held_out(chain: Chain, recordings: Recordings, fit: Fit, found: Settled) -> HeldOutRows:
    test = recordings.rows(recordings.test & chain.reading.predictable(chain.robot, recordings))
    level = np.sqrt((found.noise.deviations**2).mean(axis=0))
    deviations = level if found.noise.groups or test.deviations is None else test.deviations
    return held_out_rows(chain, test, fit.values, deviations)


def _errors(chain: Chain, recordings: Recordings, fit: Fit) -> tuple[FloatArray, FloatArray]:
    """Errors of all rows (N, k): of the robot file's robot, and of the calibrated one."""
    after = recordings.deflections - chain.predict(row_data(recordings, chain.robot), fit.values)[:, recordings.axes]
    return recordings.deflections - nominal_readings(chain, recordings), after


def _accuracy(
    errors: tuple[FloatArray, FloatArray],
    recordings: Recordings,
    problem: ArmProblem,
    found: Settled,
) -> Accuracies:
    """Of `_errors`; left-out folds where no rows are marked `test`."""
    before, after = errors
    left_out = None
    if not recordings.test.any():
        seen = problem.seen
        folds = np.repeat(pose_folds(problem.train, _FOLDS)[:, None], seen.shape[1], axis=1)[seen]
        left_out = np.full(seen.shape, np.nan)
        left_out[seen] = found.solution.left_out(folds) * found.effective[seen]
    judged = recordings.test & problem.chain.reading.predictable(problem.chain.robot, recordings)
    return accuracies(before, after, ~recordings.test, judged, left_out, recordings.axes)
