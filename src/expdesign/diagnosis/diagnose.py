"""Diagnosis of recordings: consistent, explained by named physics, or unexplained (file-formats.md, diagnosis.json)."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.row import row_data
from expdesign.diagnosis.base_models import base_model
from expdesign.diagnosis.caveats import caveats
from expdesign.diagnosis.confirmation import confirmed, gains, pruned
from expdesign.diagnosis.dispersion import ALIKE, dispersion
from expdesign.diagnosis.findings import Finding, findings
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.law_findings import law_findings
from expdesign.diagnosis.laws import CONTESTED, Laws, laws_beside, left_out_alone
from expdesign.diagnosis.library import OUTLIER, Candidate, candidates, library
from expdesign.diagnosis.locate import Location, drivers, locate
from expdesign.diagnosis.many import Many
from expdesign.diagnosis.nameable import Nameable, nameable
from expdesign.diagnosis.not_sought import not_sought
from expdesign.diagnosis.outliers import in_common
from expdesign.diagnosis.probability import FITTING, TENTATIVE
from expdesign.diagnosis.sample import Sample
from expdesign.diagnosis.selection import Model, Search
from expdesign.diagnosis.stability import Stability, stability
from expdesign.diagnosis.support_findings import support_findings
from expdesign.diagnosis.support_laws import Support, support_laws
from expdesign.diagnosis.together import (
    LAWS,
    TOGETHER,
    Method,
    errors_together,
    group_findings,
    together,
    verdict_together,
)
from expdesign.diagnosis.verdict import HALVED, doubt, fits, verdict_with, verdict_without, within_noise
from expdesign.errors import InputError
from expdesign.identification.estimability import require_regular_rows
from expdesign.identification.fit import Data, Fit, fit
from expdesign.identification.noise_level import NoiseLevel, noise_from_replicates, noise_from_residuals
from expdesign.identification.whitening import Whitening
from expdesign.recordings.recordings import Recordings
from expdesign.recordings.remark import Remark
from expdesign.robots.robot import Robot


@dataclass(frozen=True)
class Diagnosis:
    """What was found.

    Attributes:
        robot, recordings: what was diagnosed.
        noise: standard deviations of the readings.
        base: fit of the base model.
        model: the chosen model, which is the base model where nothing was found.
        predictive: what predictions are made with: the chosen model, or the base model where the chosen one explains
            too little of what was not fitted.
        verdict: `consistent`, `explained`, `modelled` (by laws at ports) or `unexplained`.
        p_before, p_after: of χ² of the base model and of the chosen one; NaN where the noise level is estimated.
        location: of the mismatch.
        findings: effects that are present together.
        errors: of the predictive model, on fitted and held-out rows.
        search: everything that was considered.
        laws: at ports, of a mismatch that named physics does not explain; None where none was sought or found.
        method: the way of working that the data call for, and why.
        caveats: what limits these statements: what cannot be told apart, and readings that are not independent.
        stability: how often nine tenths of the rows name the same; None where nothing, or laws are named.
    """

    robot: Robot
    recordings: Recordings
    noise: NoiseLevel
    base: Fit
    model: Model
    predictive: Model
    verdict: str
    p_before: float
    p_after: float
    location: Location
    findings: tuple[Finding, ...]
    errors: HeldOut
    search: Search
    laws: Laws | None
    method: Method
    caveats: tuple[Remark, ...] = ()
    stability: Stability | None = None

    @property
    def rival(self) -> Model | None:
        """A model with other physics that explains the recordings as well, where there is one."""
        return next((finding.rival for finding in self.findings if finding.rival is not None), None)


@dataclass(frozen=True)
class _Frame:
    """What is known before effects are sought."""

    robot: Robot
    recordings: Recordings
    noise: NoiseLevel
    base: Fit
    search: Search
    entries: list[Candidate]
    method: Method


def diagnose(
    robot: Robot,
    recordings: Recordings,
    *,
    shared_reference: bool = False,
    without: frozenset[str] = frozenset(),
    report: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """Say where the base model and the recordings differ, which physics was left out, and whether adding it helps.

    Args:
        robot: the robot.
        recordings: what was measured.
        shared_reference: whether the rows of a series share the noise of their reference.
        without: identifiers of physics that the library shall not offer.
        report: is told what is being done.

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
    sample_with = _sampler(robot, recordings, shared_reference=shared_reference)
    report("fitting the base model")
    noise = _noise(robot, recordings, sample_with, shared_reference=shared_reference)
    sample = sample_with(noise.deviations)
    base = fit(Chain(robot, reading=sample.reading), sample)
    judged = _judged(robot, sample)
    kind = base_model(robot, sample.reading)
    kind.require_determined(robot, recordings, base, sample.idle)
    report("preparing the library")
    entries = candidates(library(robot, recordings, without=without), sample, robot, base.values)
    search = Search(robot, sample, entries, known_noise=noise.known, report=report)
    many, method = together(robot, sample, base, entries, report)
    frame = _Frame(robot, recordings, noise, base, search, entries, method)
    at_once = _at_once(frame, many, judged)
    if at_once is not None and (at_once.support is None or at_once.support.nameless(sample)):
        return at_once.diagnosis
    named = nameable(search, outliers=False) if OUTLIER in without else _searched(search, sample, robot)
    model = named.model
    report("checking on held-out recordings")
    model, errors = _checked(search, model, base, noise, judged)
    if at_once is not None and at_once.beats(model):
        return at_once.diagnosis
    report("weighing alternatives")
    spread = dispersion(model.fit.residuals, sample.restricted(~model.outliers))
    stable = stability(search, model)
    found = findings(search, model, gains(search, model, judged), spread, stable)
    variance = 1.0 if noise.known else float(model.fit.chi2 / max(sample.readings - model.fit.rank, 1))
    location = locate(base, sample, robot, entries, variance)
    before = (base.chi2, _dof(base, sample))
    after = (model.fit.chi2, _dof(model.fit, sample.restricted(~model.outliers)))
    p_before, p_after = (_p_value(each, noise) for each in (before, after))
    if noise.origin == "residuals" and found and model.fit.chi2 > 0.0:
        # What the base model leaves is noise and the physics that was found; the noise is what the chosen model leaves.
        errors = errors.divided_by(float(np.sqrt(after[0] / after[1])))
    verdict = verdict_without(p_before, known_noise=noise.known)
    if found:
        reason = doubt(
            model, before, after, errors, most=search.most_effects, known_noise=noise.known, at_limit=named.at_limit
        )
        verdict = "unexplained" if reason else "explained"
        search.log.add("verdict", model, not reason, reason or "it explains the recordings")
    if verdict == "consistent":
        kind.require_plausible(robot, recordings, base)
    predictive = model
    if verdict == "unexplained":
        found = _doubted(found, FITTING if fits(before, after) else TENTATIVE)
        predictive, errors = _predictive(search, model, errors, judged)
    result = Diagnosis(
        robot=robot,
        recordings=recordings,
        noise=noise,
        base=base,
        model=model,
        predictive=predictive,
        verdict=verdict,
        p_before=p_before,
        p_after=p_after,
        location=location,
        findings=found,
        errors=errors,
        search=search,
        laws=None,
        method=method,
        caveats=(*named.remarks, *caveats(sample, model, spread, errors)),
        stability=stable,
    )
    contested = verdict == "explained" and kind.contested and noise.known
    return _with_laws(result, judged, report) if verdict == "unexplained" or contested else result


@dataclass(frozen=True)
class _AtOnce:
    """The diagnosis with all effects at once, and the laws of a body's support where it is by these."""

    diagnosis: Diagnosis
    support: Support | None = None

    def beats(self, named: Model) -> bool:
        """Whether laws of the support predict left-out blocks better than named effects."""
        kept = self.diagnosis.search.sample.restricted(~named.outliers)
        return self.support is not None and self.support.beats(named.fit, kept)


def _at_once(known: _Frame, many: Many | None, judged: BoolArray) -> _AtOnce | None:
    """All effects at once, of a machine or of what a body stands on; None where held-out rows refute them."""
    base, sample = known.base, known.search.sample
    known.search.log.add_text("method", f"{known.method.name}: {known.method.reason}")
    support = support_laws(known.robot, sample, base) if many is None else None
    found = many or support
    if found is None:
        return None
    errors = errors_together(found, base, sample, judged)
    if errors.test_after >= errors.test_before:
        return None
    if support is None:
        assert many is not None
        return _AtOnce(_of_all(known, many, group_findings(many), errors))
    frame = replace(known, method=Method(TOGETHER, support.why))
    return _AtOnce(_of_all(frame, support, support_findings(support, known.robot), errors), support)


def _of_all(known: _Frame, many: Many | Support, found: tuple[Finding, ...], errors: HeldOut) -> Diagnosis:
    """The diagnosis with all effects at once."""
    search, base, sample = known.search, known.base, known.search.sample
    aside = np.zeros(len(sample.counts), dtype=bool)
    model = Model((), aside, many.fit, float("nan"))
    verdict = verdict_together(errors)
    spread = dispersion(many.fit.residuals, sample)
    variance = 1.0 if known.noise.known else many.noise**2
    search.log.add_text("verdict", f"{len(many.groups)} groups of effects; verdict {verdict}")
    return Diagnosis(
        robot=known.robot,
        recordings=known.recordings,
        noise=known.noise,
        base=base,
        model=model,
        predictive=model,
        verdict=verdict,
        p_before=_p_value((base.chi2, _dof(base, sample)), known.noise),
        p_after=_p_value((many.fit.chi2, _dof(many.fit, sample)), known.noise),
        location=locate(base, sample, known.robot, known.entries, variance),
        findings=found,
        errors=errors,
        search=search,
        laws=None,
        method=known.method,
        caveats=caveats(sample, model, spread, errors),
        stability=many.stability,
    )


def _doubted(found: tuple[Finding, ...], factor: float) -> tuple[Finding, ...]:
    """Findings of a model that is no explanation."""
    return tuple(replace(finding, probability=finding.probability * factor) for finding in found)


def _guarded(search: Search, model: Model, base: Fit) -> str:
    """Why left-out series speak against a model that explains nothing; empty where they do not."""
    if not model.candidates:
        return ""
    kept = search.sample.restricted(~model.outliers)
    doubt = left_out_alone(model.fit, base, kept, known_noise=search.known_noise).doubt
    if doubt:
        search.log.add("held out", model, False, f"not predicted with: {doubt}")
    return doubt


def _with_laws(result: Diagnosis, judged: BoolArray, report: Callable[[str], None]) -> Diagnosis:
    """The diagnosis with laws at ports, where these predict left-out rows better than what was found without them."""
    search, base = result.search, result.base
    rival = result.predictive if result.predictive.candidates else search.base
    explained = result.verdict == "explained"
    worth = 0.5 * (search.base.misfit - result.model.misfit) + CONTESTED if explained else 0.0
    found = laws_beside(
        search, base, result.model.outliers, rival, known_noise=result.noise.known, report=report, worth=worth
    )
    if explained and not found.wins:
        return result
    result = replace(result, caveats=(*result.caveats, *not_sought(search.sample)))
    if found.laws is None:
        return result
    laws = found.laws
    changed = replace(result, laws=laws)
    errors = held_out(base, laws.fit, search.sample, judged, found.aside) if found.wins else result.errors
    # Rows that were held out do not choose among laws, but none is predicted with that they refute.
    if found.wins and errors.test_after <= errors.test_before:
        named = tuple(part.named for part in laws.parts if part.named is not None)
        model = Model(named, found.aside, laws.fit, float("nan"))
        changed = replace(
            changed,
            model=model,
            predictive=model,
            errors=errors,
            findings=law_findings(laws, result.robot, 1.0),
            method=Method(LAWS, "left-out rows are predicted better with laws at ports than with named effects alone"),
            p_after=laws.p_value if result.noise.known else float("nan"),
            verdict=verdict_with(laws, errors),
            stability=None,
        )
    search.log.add_text("laws", laws.summary(changed.verdict))
    return changed


def _sampler(robot: Robot, recordings: Recordings, *, shared_reference: bool) -> Callable[[FloatArray], Sample]:
    """The rows that may be fitted, for given standard deviations of the readings (N, k)."""
    rows = row_data(recordings, robot)
    fitted = recordings.rows(~recordings.test)
    reading = reading_of(robot, recordings)
    idle = base_model(robot, reading).idle(robot, fitted)

    def sample_with(deviations: FloatArray) -> Sample:
        whitening = Whitening(deviations, recordings.series, shared_reference=shared_reference)
        return Sample.of(Data(recordings, rows, whitening, idle=idle, reading=reading), ~recordings.test)

    return sample_with


def _judged(robot: Robot, sample: Sample) -> BoolArray:
    """Held-out rows on which a model can be judged: not those that need what no fitted row determines, shape (N,)."""
    test = sample.recordings.test
    predictable = test & sample.reading.predictable(robot, sample.recordings)
    return predictable if predictable.any() else test


def _searched(search: Search, sample: Sample, robot: Robot) -> Nameable:
    """The best model; rows are set aside only where they are single mistakes."""
    library, found = search.library, nameable(search)
    common = _in_common(sample, found.model, robot)
    if not common:
        return found
    search.log.add("outliers", found.model, False, f"the rows set aside are no single mistakes: {common}")
    search.library = library
    return nameable(search, outliers=False)


def _checked(search: Search, model: Model, base: Fit, noise: NoiseLevel, test: BoolArray) -> tuple[Model, HeldOut]:
    """The model as far as held-out recordings confirm it, with its errors."""
    sample = search.sample
    model, errors = pruned(search, model, base, test)
    # Where more than noise remains, or rows are alike, the penalised misfit trusts what is not so.
    kept = sample.restricted(~model.outliers)
    alike = dispersion(model.fit.residuals, kept).correlation > ALIKE
    trusted = noise.known and within_noise((model.fit.chi2, _dof(model.fit, kept))) and not alike
    if model.candidates and not trusted:
        model = confirmed(search, model, test)
        errors = held_out(base, model.fit, sample, test, model.outliers)
    return model, errors


def _predictive(search: Search, model: Model, errors: HeldOut, test: BoolArray) -> tuple[Model, HeldOut]:
    """What to predict with where a model does not explain: it, or the base model, with the errors of that."""
    base = search.base
    if errors.test_after <= HALVED * errors.test_before and not _guarded(search, model, base.fit):
        return model, errors
    return base, held_out(base.fit, base.fit, search.sample, test, base.outliers)


def _in_common(sample: Sample, model: Model, robot: Robot) -> str:
    """What the rows set aside have in common, among the rows that may be fitted."""
    counts = sample.counts
    residuals = sample.residuals(model.fit.chain, model.fit.values)[counts]
    quantities = {name: values[counts] for name, values in drivers(sample, robot).items()}
    return in_common(residuals, model.outliers[counts], sample.recordings.series[counts], quantities)


def _p_value(chi2: tuple[float, int], noise: NoiseLevel) -> float:
    """Of χ² (with its degrees of freedom) against the stated noise; NaN where the noise level is estimated."""
    return float(chi2_distribution.sf(*chi2)) if noise.known else float("nan")


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
    chain = Chain(robot, reading=reading_of(robot, recordings))
    return noise_from_residuals(recordings, translations, lambda deviations: fit(chain, sample_with(deviations)))
