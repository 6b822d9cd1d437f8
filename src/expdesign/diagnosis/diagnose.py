"""Diagnosis of recordings: consistent, explained by named physics, or unexplained (file-formats.md, diagnosis.json)."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.recordings.recordings import Recordings, Remark
from expdesign.diagnosis.at_once import AtOnce
from expdesign.diagnosis.caveats import caveats
from expdesign.diagnosis.confirmation import confirmed, gains, pruned
from expdesign.diagnosis.dispersion import dispersion
from expdesign.diagnosis.findings import Finding, findings, set_aside
from expdesign.diagnosis.frame import Frame, framed
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.law_findings import law_findings
from expdesign.diagnosis.laws import Laws, left_out_alone, sought_laws, without_mistakes
from expdesign.diagnosis.library import OUTLIER
from expdesign.diagnosis.locate import Location, drivers, locate
from expdesign.diagnosis.nameable import Nameable, nameable
from expdesign.diagnosis.not_sought import not_sought
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.outliers import in_common
from expdesign.diagnosis.sample import Sample
from expdesign.diagnosis.selection import Model, Search
from expdesign.diagnosis.stability import Stability, stability
from expdesign.diagnosis.statement import Widening, statement, tested, widened, widening
from expdesign.diagnosis.support_findings import support_findings
from expdesign.diagnosis.support_laws import Support, support_laws
from expdesign.diagnosis.together import LAWS, TOGETHER, Method, errors_together, group_findings, verdict_together
from expdesign.diagnosis.verdict import at_limits, doubt, fits, verdict_with, verdict_without, within_noise
from expdesign.estimation.coverage import reading_deviations
from expdesign.estimation.fit import Fit, fit
from expdesign.estimation.goodness import StatementOfFit
from expdesign.estimation.noise_level import NoiseLevel
from expdesign.mechanics.robots.robot import Robot


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
        before, after: whether the base model accounts for the fitted rows, and the chosen one.
        location: of the mismatch.
        findings: effects that are present together.
        errors: of the predictive model, on fitted and held-out rows.
        search: everything that was considered.
        laws: at ports, of a mismatch that named physics does not explain; None where none was sought or found.
        method: the way of working that the data call for, and why.
        caveats: what limits these statements: what cannot be told apart, and readings that are not independent.
        scatter: RMS of readings in blocks that were left out, by all effects at once; 0 where these are not the model.
        stability: how often nine tenths of the rows name the same; None where nothing, or laws are named.
        ended: what was being done when somebody ended the diagnosis, whose model is the best so far; empty otherwise.
    """

    robot: Robot
    recordings: Recordings
    noise: NoiseLevel
    base: Fit
    model: Model
    predictive: Model
    verdict: str
    before: StatementOfFit
    after: StatementOfFit
    location: Location
    findings: tuple[Finding, ...]
    errors: HeldOut
    search: Search
    laws: Laws | None
    method: Method
    caveats: tuple[Remark, ...] = ()
    scatter: float = 0.0
    stability: Stability | None = None
    ended: str = ""

    @property
    def refuted(self) -> bool:
        """Whether the model that predicts is refuted by the recordings, or no explanation of them."""
        return self.verdict == "unexplained" or self.after.refuted

    @property
    def widening(self) -> Widening:
        """By what the recordings widen what the predictive model predicts."""
        sample = self.search.sample.restricted(~self.predictive.outliers)
        return widening(self.predictive.fit, sample, known_noise=self.noise.known, scatter=self.scatter)

    @property
    def known(self) -> Fit:
        """The predictive model with the covariance that its predictions have."""
        return widened(self.predictive.fit, self.widening)

    @property
    def reading_deviations(self) -> FloatArray:
        """Standard deviation of a reading (m, rad), as the fit asks for, shape (k,)."""
        return reading_deviations(self.noise.deviations[self.search.sample.counts], self.widening.readings)

    @property
    def rival(self) -> Model | None:
        """A model with other physics that explains the recordings as well, where there is one."""
        return next((finding.rival for finding in self.findings if finding.rival is not None), None)


def diagnose(
    robot: Robot,
    recordings: Recordings,
    *,
    without: frozenset[str] = frozenset(),
    interruptible: bool = False,
    report: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """Say where the base model and the recordings differ, which physics was left out, and whether adding it helps.

    Args:
        robot: the robot.
        recordings: what was measured.
        without: identifiers of physics that the library shall not offer.
        interruptible: whether a `KeyboardInterrupt` ends the search with the best model so far, once there is one.
        report: is told what is being done.

    Raises:
        InputError: no row may be fitted, or the deflections have the wrong sign.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the recordings do not determine the stiffness.
    """
    doing = [""]

    def told(text: str) -> None:
        doing[0] = text
        report(text)

    frame = framed(robot, recordings, without=without, interruptible=interruptible, report=told)
    if frame.ended:
        return _so_far(frame, frame.ended)
    try:
        return _diagnosed(frame, told, outliers=OUTLIER not in without)
    except KeyboardInterrupt:
        if not interruptible:
            raise
        return _so_far(frame, doing[0])


def _so_far(frame: Frame, doing: str) -> Diagnosis:
    """The diagnosis with the best model that a search has fitted before it was ended."""
    search = frame.search
    possible = [model for model in search.models.values() if not at_limits(model)]
    best = min(possible, key=lambda model: model.misfit, default=search.base)
    if search.base.misfit - best.misfit < OPTIONS.acceptance:
        best = search.base
    errors = _held_out(search, frame.base, best.fit, frame.judged, best.outliers)
    result = _with_verdict(frame, _Named(best, errors, Nameable(best, "", ())))
    return replace(_with_names(frame, result) if best.candidates else result, ended=doing)


def _diagnosed(frame: Frame, report: Callable[[str], None], *, outliers: bool) -> Diagnosis:
    """The diagnosis of a frame; `outliers` says whether rows may be set aside as single mistakes."""
    at_once = _at_once(frame)
    if at_once is not None and at_once.alone:
        return at_once.diagnosis
    named = _named(frame, outliers=outliers)
    if at_once is not None and at_once.beats(named.model):
        return at_once.diagnosis
    report("weighing alternatives")
    result = _with_verdict(frame, named)
    contested = result.verdict == "explained" and frame.kind.contested and frame.noise.known
    if result.verdict == "unexplained" or contested:
        result = _with_laws(result, frame.judged, report)
    return _with_names(frame, result) if result.model is named.model else result


@dataclass(frozen=True)
class _Named:
    """The best model with named effects.

    Attributes:
        model: as far as held-out rows confirm it.
        errors: of it on fitted and held-out rows.
        found: what the search for it said.
    """

    model: Model
    errors: HeldOut
    found: Nameable


def _named(frame: Frame, *, outliers: bool) -> _Named:
    """Few named effects; `outliers` says whether rows may be set aside as single mistakes."""
    search = frame.search
    found = _searched(search, search.sample, frame.robot) if outliers else nameable(search, outliers=False)
    search.report("checking on held-out recordings")
    return _Named(*_checked(search, found.model, frame.base, frame.noise, frame.judged), found)


def _with_verdict(frame: Frame, named: _Named) -> Diagnosis:
    """Whether named effects explain the recordings; `_with_names` says which they are, should they stay."""
    search, base, noise, model, errors = frame.search, frame.base, frame.noise, named.model, named.errors
    sample = search.sample
    spread = dispersion(model.fit.residuals, sample.restricted(~model.outliers))
    found = bool(model.candidates) or bool(model.outliers.any())
    kept = sample.restricted(~model.outliers)
    first = statement(base, sample, noise)
    last = statement(model.fit, kept, noise) if found else first
    before, after = tested(base, sample), tested(model.fit, kept)
    if noise.origin == "residuals" and found and model.fit.chi2 > 0.0:
        # What the base model leaves is noise and the physics that was found; the noise is what the chosen model leaves.
        errors = errors.divided_by(float(np.sqrt(after[0] / after[1])))
    verdict = verdict_without(first)
    if found:
        at_limit = named.found.at_limit
        reason = doubt(
            model, before, after, errors, most=search.most_effects, known_noise=noise.known, at_limit=at_limit
        )
        verdict = "unexplained" if reason else "explained"
        search.log.add("verdict", model, not reason, reason or "it explains the recordings")
    if verdict == "consistent":
        frame.kind.require_plausible(frame.robot, frame.recordings, base)
    predictive = model
    if verdict == "unexplained":
        predictive, errors = _predictive(search, model, errors, frame.judged)
    variance = 1.0 if noise.known else float(model.fit.chi2 / max(sample.readings - model.fit.rank, 1))
    return Diagnosis(
        robot=frame.robot,
        recordings=frame.recordings,
        noise=noise,
        base=base,
        model=model,
        predictive=predictive,
        verdict=verdict,
        before=first,
        after=last,
        location=locate(base, sample, frame.robot, frame.entries, variance),
        findings=(),
        errors=errors,
        search=search,
        laws=None,
        method=frame.method,
        caveats=(*named.found.remarks, *caveats(sample, model, spread, errors)),
    )


def _with_names(frame: Frame, result: Diagnosis) -> Diagnosis:
    """The diagnosis with the effects of its model: their probabilities, and how often parts of the rows name them."""
    search, model = frame.search, result.model
    kept = search.sample.restricted(~model.outliers)
    stable, spread = stability(search, model), dispersion(model.fit.residuals, kept)
    found = findings(search, model, gains(search, model, frame.judged), spread, stable)
    if result.verdict == "unexplained":
        before, after = tested(frame.base, search.sample), tested(model.fit, kept)
        found = _doubted(found, OPTIONS.fitting if fits(before, after) else OPTIONS.tentative)
    return replace(result, findings=found, stability=stable)


@dataclass(frozen=True)
class _AllAtOnce:
    """The diagnosis with all effects at once, and the laws of a body's support where it is by these."""

    diagnosis: Diagnosis
    support: Support | None

    @property
    def alone(self) -> bool:
        """Whether named effects need not be sought."""
        return self.support is None or self.support.nameless(self.diagnosis.search.sample)

    def beats(self, named: Model) -> bool:
        """Whether laws of the support predict left-out blocks better than named effects."""
        kept = self.diagnosis.search.sample.restricted(~named.outliers)
        return self.support is not None and self.support.beats(named.fit, kept)


def _at_once(frame: Frame) -> _AllAtOnce | None:
    """All effects at once, of a machine or of what a body stands on; None where held-out rows refute them."""
    base, sample, method = frame.base, frame.search.sample, frame.method
    frame.search.log.add_text("method", f"{method.name}: {method.reason}")
    support = support_laws(frame.robot, sample, base) if frame.many is None else None
    at_once = frame.many or support
    if at_once is None:
        return None
    errors = errors_together(at_once, base, sample, frame.judged, known_noise=frame.noise.known)
    if errors.test_after >= errors.test_before:
        return None
    if support is not None:
        found, method = support_findings(support, frame.robot), Method(TOGETHER, support.why)
    else:
        assert frame.many is not None
        found = group_findings(frame.many)
    return _AllAtOnce(_of_all(replace(frame, method=method), at_once, found, errors), support)


def _of_all(frame: Frame, at_once: AtOnce, found: tuple[Finding, ...], errors: HeldOut) -> Diagnosis:
    """The diagnosis with all effects at once."""
    search, base, sample, fitted = frame.search, frame.base, frame.search.sample, at_once.fit
    model = Model((), at_once.aside, fitted, float("nan"))
    sample = sample.restricted(~at_once.aside)
    verdict = verdict_together(errors)
    variance = 1.0 if frame.noise.known else at_once.noise**2
    search.log.add_text("verdict", f"{len(at_once.groups)} groups of effects; verdict {verdict}")
    return Diagnosis(
        robot=frame.robot,
        recordings=frame.recordings,
        noise=frame.noise,
        base=base,
        model=model,
        predictive=model,
        verdict=verdict,
        before=statement(base, search.sample, frame.noise),
        after=statement(fitted, sample, frame.noise),
        location=locate(base, sample, frame.robot, frame.entries, variance),
        findings=(*found, *set_aside(search.sample, at_once.aside, OPTIONS.most)),
        errors=errors,
        search=search,
        laws=None,
        method=frame.method,
        caveats=caveats(sample, model, dispersion(fitted.residuals, sample), errors),
        scatter=at_once.after,
        stability=at_once.stability,
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
    """The diagnosis with laws at ports beside what was named or in its place, where left-out rows ask for them."""
    search, base, known_noise = result.search, result.base, result.noise.known
    aside = without_mistakes(search.sample, result.model.outliers)
    sample = search.sample.restricted(~aside)
    start = fit(base.chain, sample) if aside.any() else base
    explained = result.verdict == "explained"
    laws = sought_laws(
        result.robot, sample, start, search.library,
        known_noise=known_noise, named=result.model, explained=explained, report=report,
    )  # fmt: skip
    wins = laws is not None and laws.predicts
    if explained and not (wins and laws is not None and laws.replaces(result.model)):
        return result
    result = replace(result, caveats=(*result.caveats, *not_sought(search.sample)))
    if laws is None:
        return result
    changed = replace(result, laws=laws)
    errors = _held_out(search, base, laws.fit, judged, aside) if wins else result.errors
    # Rows that were held out do not choose among laws, but none is predicted with that they refute.
    if wins and not errors.refuted:
        named = tuple(part.named for part in laws.parts if part.named is not None)
        model = Model(named, aside, laws.fit, float("nan"))
        changed = replace(
            changed,
            model=model,
            predictive=model,
            errors=errors,
            findings=law_findings(laws, result.robot, 1.0),
            method=Method(LAWS, "left-out rows are predicted better with laws at ports than with named effects alone"),
            after=statement(laws.fit, search.sample.restricted(~aside), result.noise),
            verdict=verdict_with(laws, errors),
            stability=None,
        )
    search.log.add_text("laws", laws.summary(changed.verdict))
    return changed


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
    alike = dispersion(model.fit.residuals, kept).correlation > OPTIONS.alike
    trusted = noise.known and within_noise(tested(model.fit, kept)) and not alike
    if model.candidates and not trusted:
        model = confirmed(search, model, test)
        errors = _held_out(search, base, model.fit, test, model.outliers)
    return model, errors


def _predictive(search: Search, model: Model, errors: HeldOut, test: BoolArray) -> tuple[Model, HeldOut]:
    """What to predict with where a model does not explain: it, or the base model, with the errors of that."""
    base = search.base
    halved = errors.test_after <= OPTIONS.halved * errors.test_before
    if halved and not errors.refuted and not _guarded(search, model, base.fit):
        return model, errors
    return base, _held_out(search, base.fit, base.fit, test, base.outliers)


def _in_common(sample: Sample, model: Model, robot: Robot) -> str:
    """What the rows set aside have in common, among the rows that may be fitted."""
    counts = sample.counts
    residuals = sample.residuals(model.fit.chain, model.fit.values)[counts]
    quantities = {name: values[counts] for name, values in drivers(sample, robot).items()}
    return in_common(residuals, model.outliers[counts], sample.recordings.series[counts], quantities)


def _held_out(search: Search, base: Fit, model: Fit, test: BoolArray, aside: BoolArray) -> HeldOut:
    return held_out(base, model, search.sample, test, aside, known_noise=search.known_noise)
