"""Diagnosis of recordings: consistent, explained by named physics, or unexplained (file-formats.md, diagnosis.json)."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from expdesign.arrays import FloatArray, as_matrix
from expdesign.chain.ports.law import Law
from expdesign.chain.recordings.recordings import Recordings
from expdesign.diagnosis.by_groups import by_groups
from expdesign.diagnosis.caveats import not_sought
from expdesign.diagnosis.confirmation import confirmed, stability
from expdesign.diagnosis.cross_validation import LeftOut
from expdesign.diagnosis.dispersion import deviations_from_none, dispersion, statement, tested
from expdesign.diagnosis.evidence.problem import Chosen
from expdesign.diagnosis.findings import Finding, findings, set_aside
from expdesign.diagnosis.frame import Frame, framed
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.law_findings import law_findings
from expdesign.diagnosis.laws import Laws, fitted
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.outliers import returning
from expdesign.diagnosis.possible import at_limit
from expdesign.diagnosis.posterior import averaged
from expdesign.diagnosis.relinearised import relinearised
from expdesign.diagnosis.remarks import Averaged
from expdesign.diagnosis.result import LAWS, ONE_AT_A_TIME, TOGETHER, Diagnosis, Method
from expdesign.diagnosis.stages import Report, Stage, unheard
from expdesign.diagnosis.verdict import doubt, fits, verdict_with_laws, verdict_without
from expdesign.estimation.fit import Data, Fit, fit
from expdesign.estimation.load_errors import DeclaredLoadErrors, Estimator, load_columns
from expdesign.estimation.weighed import Fittable, weighed
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.robot import Robot


def diagnose(
    robot: Robot,
    recordings: Recordings,
    *,
    without: frozenset[str] = frozenset(),
    load_errors: DeclaredLoadErrors | None = None,
    estimator: Estimator = "generalised",
    interruptible: bool = False,
    report: Report = unheard,
) -> Diagnosis:
    """Say where the base model and the recordings differ, which physics was left out, and whether adding it helps.

    Args:
        robot: the robot.
        recordings: what was measured.
        without: identifiers of physics that the library shall not offer.
        load_errors: of the recorded loads, a part of the noise while physics is sought: where they account for the
            misfit of the base model, nothing is missing.
        estimator: how they count in the model that is found (`estimation/weighed.py`).
        interruptible: whether a `KeyboardInterrupt` ends the search with the best model so far, once there is one.
        report: progress callback.

    Raises:
        InputError: no row may be fitted, or the deflections have the wrong sign.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the recordings do not determine the stiffness.
    """
    doing = [Stage.BASE.value]

    def noted(stage: Stage, detail: str) -> None:
        doing[0] = f"{stage.value} {detail}".rstrip()
        report(stage, detail)

    frame = framed(robot, recordings, without=without, report=noted, load_errors=load_errors)
    try:
        found = _diagnosed(frame)
    except KeyboardInterrupt:
        if not interruptible:
            raise
        found = _so_far(frame, doing[0])
    return _with_loads(frame, found, estimator).covering(frame.judged)


def _with_loads(frame: Frame, result: Diagnosis, estimator: Estimator) -> Diagnosis:
    """The diagnosis whose predictive model takes the errors of the loads in the size that the rows ask for.

    Laws and groups stay as they were fitted, with errors of the declared size: their own sizes were learnt with these.
    """
    if frame.load_errors is None:
        return result
    model, sample = result.predictive, result.names.sample
    plain = sample.whitening.weighing(None)
    learnt = result.method.name != ONE_AT_A_TIME

    def of(whitening: Whitening) -> Data:
        return replace(sample, whitening=whitening)

    def solve(whitening: Whitening) -> Fit:
        return model.fit if learnt else fit(model.fit.chain, of(whitening), model.fit.values)

    def linearised(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        return of(Whitening(np.ones_like(plain.deviations))).residuals_with_sensitivities(model.fit.chain, values)

    knowledge = model.fit.chain.knowledge()
    what = Fittable(model.fit.chain, frame.recordings, solve, linearised, knowledge, sample.counts)
    weights = np.ones(1) if learnt else None
    found, loads = weighed(what, plain, frame.load_errors, "generalised" if learnt else estimator, weights)
    sized = of(plain.weighing(load_columns(loads.effects, loads.sizes)))
    judged = model.fit if learnt else fit(found.chain, sized, found.values)
    predictive = replace(model, fit=found)
    changed = replace(result, predictive=predictive, loads=loads, judged=judged)
    if result.model is not model:
        return changed
    after = statement(judged, sized, frame.noise)
    alone = not model.candidates and sample is frame.sample and not learnt
    return replace(changed, model=predictive, before=after if alone else result.before, after=after)


def _so_far(frame: Frame, doing: str) -> Diagnosis:
    """The diagnosis with the best model that a search has fitted before it was ended."""
    best = _best_of_names(frame.names)
    result = _unsought(frame, best, "it was ended")
    return replace(_with_names(frame, result) if best.candidates else result, ended=doing)


def _best_of_names(names: Names) -> NamedModel:
    """The likeliest model of named effects that a search has fitted."""
    possible = [model for model in names.models if not at_limit(model.fit, names.reach)]
    best = min(possible, key=lambda model: model.misfit, default=names.base)
    return names.base if names.base.misfit - best.misfit < 2.0 * OPTIONS.alarm else best


def _unsought(frame: Frame, model: NamedModel, reason: str) -> Diagnosis:
    """The diagnosis with a model as it stands, for a reason not to search on."""
    model = _as_written(frame.names, model)
    return _with_verdict(frame, model, _held_out(frame, model.fit), Method(ONE_AT_A_TIME, reason))


def _as_written(names: Names, model: NamedModel) -> NamedModel:
    """The model about its own estimate, so that what is said of it holds for its file (`relinearised`)."""
    fit = relinearised(model.fit, names.sample)
    return model if fit is model.fit else replace(model, fit=fit)


def _diagnosed(frame: Frame) -> Diagnosis:
    """The diagnosis of a frame."""
    if frame.loads_account_for_it:
        reason = "the load errors that the configuration declares account for what the base model leaves over"
        return _unsought(frame, frame.names.base, reason)
    groups, why = by_groups(frame)
    frame.names.log.add("method", f"{TOGETHER if groups else ONE_AT_A_TIME}: {why}")
    if groups and groups.alone:
        return groups.diagnosis(why)
    most, reason = None, why
    if groups:
        frame, most = replace(frame, laws=False), OPTIONS.starts
        reason = "named effects predict as well as groups of effects do together, or better"
    frame, ends = _without_mistakes(frame, most)
    result = _likeliest(frame, ends, reason)
    if groups and groups.beats(frame.names.left_out(result.model)):
        return groups.diagnosis(why)
    if result.method.name != LAWS:
        frame.names.report(Stage.ALTERNATIVES, "")
        result = _with_names(frame, result)
    return _averaged(frame, _inexact(frame, result))


def _likeliest(frame: Frame, ends: Iterator[Chosen], reason: str) -> Diagnosis:
    """The likeliest end of the search that explains the recordings, else laws that predict, else names.

    Laws that leave more than the noise imitate something, and stand behind names that explain.

    Args:
        frame: what is diagnosed.
        ends: of the search, the likeliest first.
        reason: to name effects one at a time.
    """
    unexplained: list[Diagnosis] = []
    imitating: list[Diagnosis] = []
    refuted: list[Laws] = []
    for end in ends:
        if end.laws:
            laws = fitted(frame.search, frame.dictionary.sight, end)
            found, others = _with_laws(frame, laws), imitating
            refuted.append(laws)
        else:
            found, others = _with_names_alone(frame, end.model, reason), unexplained
        if found is not None and found.verdict != "unexplained":
            return found
        others += [] if found is None else [found]
    result = unexplained[0] if unexplained else _with_names_alone(frame, _best_of_names(frame.names), reason)
    if result.verdict != "unexplained":
        return result
    if imitating:
        return imitating[0]
    caveats = (*result.caveats, *not_sought(frame.sample))
    return replace(result, laws=refuted[0].doubted if refuted else None, caveats=caveats)


def _inexact(frame: Frame, result: Diagnosis) -> Diagnosis:
    """With predictions that are as sure as left-out rows say of named physics, or of a base model that is refuted."""
    known = (
        any(isinstance(effect, Law) for effect in result.predictive.fit.chain.effects) or result.verdict == "consistent"
    )
    few = int(frame.names.sample.counts.sum()) < OPTIONS.fewest_rows
    if known or few or not frame.kind.elastic or not len(result.predictive.fit.values):
        return result
    fit, state, sample = result.predictive.fit, frame.names.state(result.predictive), frame.names.sample
    blocks, scale = frame.names.blocks, state.noise_variance
    done = as_matrix(fit.sensitivities)[sample.kept] @ deviations_from_none(fit)
    errors = state.left_out(blocks) / np.sqrt(scale)
    variances = state.left_out_variances(blocks) / scale
    share = LeftOut(errors, errors, blocks).widened(variances, (done**2).sum(axis=1) / scale, OPTIONS.form)[1]
    return replace(result, inexact=share)


def _averaged(frame: Frame, result: Diagnosis) -> Diagnosis:
    """With predictions that are averaged over what may be there, where too little was measured to tell."""
    if not frame.kind.elastic:
        return result
    model = averaged(frame.names, result.predictive)
    if model is result.predictive:
        return result
    beside = [
        str(effect.key) for effect in model.fit.chain.effects if effect not in result.predictive.fit.chain.effects
    ]
    caveat = Averaged(int(frame.names.sample.counts.sum()), tuple(beside))
    return replace(result, predictive=model, caveats=(*result.caveats, caveat))


def _without_mistakes(frame: Frame, most: int | None) -> tuple[Frame, Iterator[Chosen]]:
    """The ends of the search in the rows without those that stand out of the likeliest one by themselves.

    What a row says is asked of the final model: one that stands out of less may show what is missing there. So may one
    that the search without it explains after all, which returns.

    Args:
        frame: with all rows.
        most: effects that are looked for, see `Search.ends`.
    """
    names, ends = frame.names, frame.search.ends(most)
    first = next(ends)
    aside, common = first.mistakes.rows, first.mistakes.common
    if common:
        names.log.add("outliers", f"the rows that stand out are no single mistakes: {common}", first.model, kept=False)
    while aside.any():
        frame = frame.without(aside)
        ends = frame.search.ends(most)
        first = next(ends)
        back = returning(first.model.fit, frame.sample, aside, known_noise=names.known_noise)
        reason = f"{aside.sum()} rows set aside, {back.sum()} fit after all"
        names.log.add("outliers", reason, first.model, kept=not back.any())
        if not back.any():
            break
        aside = aside & ~back
    return frame, chain([first], ends)


def _with_names_alone(frame: Frame, model: NamedModel, reason: str) -> Diagnosis:
    """The diagnosis with named effects as far as held-out recordings confirm them."""
    return _with_verdict(frame, *_checked(frame, model), Method(ONE_AT_A_TIME, reason))


def _with_verdict(frame: Frame, model: NamedModel, errors: HeldOut, method: Method) -> Diagnosis:
    """Whether named effects explain the recordings; `_with_names` says which they are, should they stay."""
    names, base, noise = frame.names, frame.base, frame.noise
    found = bool(model.candidates) or bool(frame.aside.any())
    before, after = tested(base, frame.sample), tested(model.fit, names.sample)
    if noise.origin == "residuals":
        errors = _in_noise_left(frame, model.fit, errors)
    verdict = verdict_without(frame.before)
    if found:
        reason = doubt(names, model, before, after, errors)
        verdict = "unexplained" if reason else "explained"
        names.log.add("verdict", reason or "it explains the recordings", model, kept=not reason)
    if verdict == "consistent":
        frame.kind.require_plausible(frame.recordings, base)
    predictive = model
    if verdict == "unexplained":
        predictive, errors = _predictive(frame, model, errors)
    return frame.diagnosis(model, verdict, errors, method, predictive)


def _with_names(frame: Frame, result: Diagnosis) -> Diagnosis:
    """The diagnosis with the effects of its model: their probabilities, and how often parts of the rows name them."""
    names, model = frame.names, result.model
    stable, spread = stability(names, model), dispersion(model.fit.residuals, names.sample)
    found = findings(frame.search, model, spread, stable)
    found += set_aside(frame.recordings, frame.aside)
    if result.verdict == "unexplained":
        before, after = tested(frame.base, frame.sample), tested(model.fit, names.sample)
        found = _doubted(found, OPTIONS.doubted if fits(before, after) else OPTIONS.doubted**2)
    return replace(result, findings=found, stability=stable)


def _doubted(found: tuple[Finding, ...], factor: float) -> tuple[Finding, ...]:
    """Findings of a model that is no explanation: a name is less likely; where a law is has been weighed already."""
    return tuple(f if f.physics == Law.physics else replace(f, probability=f.probability * factor) for f in found)


def _with_laws(frame: Frame, laws: Laws) -> Diagnosis | None:
    """The diagnosis with laws at ports and the names beside them; None where rows that were not fitted refute them.

    Rows that were held out do not choose among laws, but none is predicted with that they refute.
    """
    errors = _in_noise_left(frame, laws.fit, _held_out(frame, laws.fit)) if not laws.left_out.doubt else None
    if errors is None or errors.refuted:
        frame.names.log.add("laws", laws.summary("refuted"))
        return None
    verdict = verdict_with_laws(errors)
    # What leaves more than the noise has no name: its part and what it depends on are all that is said.
    known, factor = frame.known, 1.0
    if verdict == "unexplained":
        laws, known, factor = laws.doubted, frozenset(), OPTIONS.doubted
    found = law_findings(laws, frame.robot, known) + set_aside(frame.recordings, frame.aside)
    frame.names.log.add("laws", laws.summary(verdict))
    named = tuple(part.named for part in laws.parts if part.named is not None)
    model = NamedModel(named, laws.fit, float("nan"))
    method = Method(LAWS, "left-out rows are predicted better with laws at ports than with named effects alone")
    result = frame.diagnosis(model, verdict, errors, method, model)
    caveats = (*result.caveats, *not_sought(frame.sample))
    return replace(result, laws=laws, findings=_doubted(found, factor), caveats=caveats)


def _checked(frame: Frame, model: NamedModel) -> tuple[NamedModel, HeldOut]:
    """The model as far as held-out recordings confirm it, about its own estimate, with its errors."""
    names = frame.names
    names.report(Stage.HELD_OUT, "")
    model, errors = confirmed(names, model, frame.base, frame.judged)
    written = _as_written(names, model)
    return written, errors if written is model else _held_out(frame, written.fit)


def _predictive(frame: Frame, model: NamedModel, errors: HeldOut) -> tuple[NamedModel, HeldOut]:
    """What to predict with where a model does not explain: it, or the base model, with the errors of that."""
    names = frame.names
    doubt = names.left_out(model).doubt if model.candidates else ""
    if not (doubt or errors.refuted):
        return model, errors
    if doubt:
        names.log.add("held out", f"not predicted with: {doubt}", model, kept=False)
    return names.base, _held_out(frame, names.base.fit)


def _in_noise_left(frame: Frame, model: Fit, errors: HeldOut) -> HeldOut:
    """The errors in the noise of a reading that the model file states: where none is known, what the model leaves.

    What the base model leaves is noise and the physics that was found.
    """
    value, dof = tested(model, frame.names.sample)
    return errors if frame.noise.known or value == 0.0 else errors.divided_by(float(np.sqrt(value / dof)))


def _held_out(frame: Frame, model: Fit) -> HeldOut:
    return held_out(frame.base, model, frame.names.sample, frame.judged, known_noise=frame.names.known_noise)
