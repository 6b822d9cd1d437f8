"""Diagnosis of recordings: consistent, explained by named physics, or unexplained (interfaces.md, diagnosis.json)."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.chain.chain import Chain
from expdesign.chain.row import row_data
from expdesign.diagnosis.findings import Finding, findings
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.library import candidates, library
from expdesign.diagnosis.locate import Location, drivers, locate
from expdesign.diagnosis.outliers import in_common
from expdesign.diagnosis.sample import Sample
from expdesign.diagnosis.selection import Model, Search
from expdesign.diagnosis.smooth import SmoothCorrection, smooth_correction
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.identification.estimability import idle_actuators, require_regular_rows
from expdesign.identification.fit import RANK_TOLERANCE, Data, Fit, fit
from expdesign.identification.noise_level import NoiseLevel, noise_from_replicates, noise_from_residuals
from expdesign.identification.suspicions import require_positive
from expdesign.identification.whitening import Whitening
from expdesign.recordings.recordings import Recordings
from expdesign.robots.robot import Robot

CONSISTENT = 1e-3
"""Probability below which χ² speaks against a model."""
RESIDUAL_SHARE = 0.05
"""Share of the excess of χ² that may remain in an explained case: no library is exact to the last percent."""

PREDICTS = 1.3
"""RMS of held-out residuals above which a model describes the recordings but does not predict."""

TENTATIVE = 0.5
"""Factor on the probabilities of effects beside which something unexplained remains, part of which they may imitate."""


@dataclass(frozen=True)
class Diagnosis:
    """What was found.

    Attributes:
        robot, recordings: what was diagnosed.
        noise: standard deviations of the readings.
        base: fit of the base model.
        model: the chosen model, which is the base model where nothing was found.
        verdict: `consistent`, `explained` or `unexplained`.
        p_before, p_after: of χ² of the base model and of the chosen one; NaN where the noise level is estimated.
        location: of the mismatch.
        findings: effects that are present together.
        errors: on fitted and held-out rows.
        search: everything that was considered.
        correction: of an unexplained mismatch, as far as it is smooth; None in other cases.
    """

    robot: Robot
    recordings: Recordings
    noise: NoiseLevel
    base: Fit
    model: Model
    verdict: str
    p_before: float
    p_after: float
    location: Location
    findings: tuple[Finding, ...]
    errors: HeldOut
    search: Search
    correction: SmoothCorrection | None

    @property
    def rival(self) -> Model | None:
        """A model with other physics that explains the recordings as well, where there is one."""
        return next((finding.rival for finding in self.findings if finding.rival is not None), None)


def diagnose(
    robot: Robot,
    recordings: Recordings,
    *,
    shared_reference: bool = False,
    report: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """Say where the base model and the recordings differ, which physics was left out, and whether adding it helps.

    Raises:
        InputError: no row may be fitted, or the deflections have the wrong sign.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the recordings do not determine the stiffness.
    """
    if recordings.test.all():
        remedy = "Mark some loaded rows `train` in the column `split`."
        raise InputError("no row is left to fit", where=recordings.source, remedy=remedy)
    if len(robot.stiffness):
        require_regular_rows(recordings, robot.jacobians(recordings.configurations))
    rows = row_data(recordings, robot)
    fitted = recordings.rows(~recordings.test)
    idle = idle_actuators(robot, robot.jacobians(fitted.configurations), fitted.wrenches)

    def sample_with(deviations: FloatArray) -> Sample:
        whitening = Whitening(deviations, recordings.series, shared_reference=shared_reference)
        return Sample.of(Data(recordings, rows, whitening, idle=idle), ~recordings.test)

    report("fitting the base model")
    noise = _noise(robot, recordings, sample_with, shared_reference=shared_reference)
    sample = sample_with(noise.deviations)
    base = fit(Chain(robot), sample)
    _require_determined(robot, recordings, base, idle)
    report("preparing the library")
    entries = candidates(library(robot, recordings), sample, robot, base.values)
    search = Search(robot, sample, entries, known_noise=noise.known, report=report)
    model = search.run()
    common = _in_common(sample, model, robot)
    if common:
        search.log.add("outliers", model, False, f"the rows set aside are no single mistakes: {common}")
        model = search.including(model)
    report("checking on held-out recordings")
    errors = held_out(base, model.fit, sample, recordings.test, model.outliers)
    if model is not search.base and errors.test_after > errors.test_before:
        search.log.add("held out", model, False, "the prediction of held-out recordings does not improve")
        model = search.base
        errors = held_out(base, model.fit, sample, recordings.test, model.outliers)
    report("weighing alternatives")
    found = findings(search, model)
    variance = 1.0 if noise.known else float(model.fit.chi2 / max(sample.readings - model.fit.rank, 1))
    location = locate(base, sample, robot, entries, variance)
    dof_before, dof_after = _dof(base, sample), _dof(model.fit, sample.restricted(~model.outliers))
    p_before = float(chi2_distribution.sf(base.chi2, dof_before)) if noise.known else float("nan")
    p_after = float(chi2_distribution.sf(model.fit.chi2, dof_after)) if noise.known else float("nan")
    verdict = _verdict(found, noise, (base.chi2 / dof_before, p_before), (model.fit.chi2 / dof_after, p_after))
    # As many effects as the search allows are a sign that they imitate something else.
    few = len(model.candidates) < search.most_effects or (len(robot.stiffness) == 0 and p_after >= CONSISTENT)
    sound = few and errors.test_after <= PREDICTS
    if found and not (sound and not common):
        verdict = "unexplained"
    if verdict == "consistent":
        require_positive(base, recordings, robot)
    correction = None
    if verdict == "unexplained":
        report("fitting a smooth correction")
        correction = smooth_correction(model.fit, sample.restricted(~model.outliers), recordings.test)
        found = tuple(replace(finding, probability=finding.probability * TENTATIVE) for finding in found)
    return Diagnosis(
        robot, recordings, noise, base, model, verdict, p_before, p_after, location, found, errors, search, correction
    )


def _in_common(sample: Sample, model: Model, robot: Robot) -> str:
    """What the rows set aside have in common, among the rows that may be fitted."""
    counts = sample.counts
    residuals = sample.residuals(model.fit.chain, model.fit.values)[counts]
    quantities = {name: values[counts] for name, values in drivers(sample, robot).items()}
    return in_common(residuals, model.outliers[counts], sample.recordings.series[counts], quantities)


def _require_determined(robot: Robot, recordings: Recordings, base: Fit, idle: BoolArray | None) -> None:
    """Raise where a compliance is not determined; a force that is nothing but rounding determines none."""
    sizes = np.linalg.norm(as_matrix(base.sensitivities), axis=0)
    known = base.determined & (sizes > RANK_TOLERANCE * sizes.max(initial=0.0))
    known |= False if idle is None else idle
    if not known.all():
        legs = ", ".join(name for name, one in zip(robot.actuators, known, strict=True) if not one)
        remedy = "Add recordings in which every actuator carries load."
        raise NotIdentifiableError(f"no load reaches {legs}", where=recordings.source, remedy=remedy)


def _dof(result: Fit, sample: Sample) -> int:
    return max(sample.readings - result.rank, 1)


def _noise(
    robot: Robot,
    recordings: Recordings,
    sample_with: Callable[[FloatArray], Sample],
    *,
    shared_reference: bool,
) -> NoiseLevel:
    if recordings.deviations is not None:
        return NoiseLevel(recordings.deviations, "recordings")
    translations = robot.coordinates.translations
    replicated = noise_from_replicates(recordings, translations, shared_reference=shared_reference)
    if replicated is not None:
        return replicated
    return noise_from_residuals(recordings, translations, lambda deviations: fit(Chain(robot), sample_with(deviations)))


def _verdict(
    found: tuple[Finding, ...], noise: NoiseLevel, before: tuple[float, float], after: tuple[float, float]
) -> str:
    """Before and after: χ²/dof and its p-value."""
    if not noise.known:
        return "explained" if found else "consistent"
    if not found:
        return "consistent" if before[1] >= CONSISTENT else "unexplained"
    if after[1] >= CONSISTENT or after[0] - 1.0 <= RESIDUAL_SHARE * (before[0] - 1.0):
        return "explained"
    return "unexplained"
