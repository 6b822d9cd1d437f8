"""Diagnosis of recordings: consistent, explained by named physics, or unexplained (file-formats.md, diagnosis.json)."""

from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray, as_matrix
from expdesign.chain.ports.law import Law
from expdesign.chain.recordings.recordings import Recordings
from expdesign.diagnosis.by_groups import by_groups
from expdesign.diagnosis.caveats import not_sought
from expdesign.diagnosis.confirmation import confirmed, pruned, stability
from expdesign.diagnosis.cross_validation import LeftOut
from expdesign.diagnosis.findings import Finding, findings, set_aside
from expdesign.diagnosis.frame import Frame, framed
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.law_findings import law_findings
from expdesign.diagnosis.laws import sought_laws
from expdesign.diagnosis.library import OUTLIER
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.outliers import returning, single_mistakes
from expdesign.diagnosis.possible import at_limits
from expdesign.diagnosis.posterior import averaged
from expdesign.diagnosis.relinearised import relinearised
from expdesign.diagnosis.remarks import Averaged
from expdesign.diagnosis.result import LAWS, ONE_AT_A_TIME, Diagnosis, Method
from expdesign.diagnosis.stages import Report, Stage, unheard
from expdesign.diagnosis.statement import deviations_from_none, dispersion, statement, tested
from expdesign.diagnosis.verdict import doubt, fits, verdict_with, verdict_without, within_noise
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
        found = _diagnosed(frame, outliers=OUTLIER not in without)
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
    names = frame.names
    possible = [model for model in names.models if not at_limits(model.fit, names.reach)]
    best = min(possible, key=lambda model: model.misfit, default=names.base)
    if names.base.misfit - best.misfit < 2.0 * OPTIONS.alarm:
        best = names.base
    result = _unsought(frame, best, "it was ended")
    return replace(_with_names(frame, result) if best.candidates else result, ended=doing)


def _unsought(frame: Frame, model: NamedModel, reason: str) -> Diagnosis:
    """The diagnosis with a model as it stands, for a reason not to search on."""
    model = _as_written(frame.names, model)
    return _with_verdict(frame, model, _held_out(frame, model.fit), Method(ONE_AT_A_TIME, reason))


def _as_written(names: Names, model: NamedModel) -> NamedModel:
    """The model about its own estimate, so that what is said of it holds for its file (`relinearised`)."""
    fit = relinearised(model.fit, names.sample)
    return model if fit is model.fit else replace(model, fit=fit)


def _diagnosed(frame: Frame, *, outliers: bool) -> Diagnosis:
    """The diagnosis of a frame; `outliers` says whether rows may be set aside as single mistakes."""
    if frame.loads_account_for_it:
        reason = "the load errors that the configuration declares account for what the base model leaves over"
        return _unsought(frame, frame.names.base, reason)
    groups = by_groups(frame)
    frame.names.log.add_text("method", f"{groups.method.name}: {groups.method.reason}")
    if groups.alone:
        return groups.diagnosis()
    few = None if groups.groups is None else OPTIONS.starts
    most = frame.names.most_effects if few is None else min(few, frame.names.most_effects)
    of_all = frame
    frame, found = _without_mistakes(frame, most) if outliers else (frame, frame.search.model(most))
    named, errors = _checked(frame, found)
    if groups.beats(frame.names.left_out(named)):
        return groups.diagnosis()
    frame.names.report(Stage.ALTERNATIVES, "")
    better = "named effects predict as well as groups of effects do together, or better"
    reason = groups.method.reason if groups.groups is None else better
    result = _with_verdict(frame, named, errors, Method(ONE_AT_A_TIME, reason))
    # What a body stands on yields as its platform does, which has no names.
    contested = result.verdict == "explained" and frame.kind.contested and not frame.robot.on_support
    contested = contested and not _settled(frame, result.model)
    if result.verdict == "unexplained" or contested:
        result = _with_laws(frame if contested else of_all, result, mistaken=outliers)
    if result.model is named:
        result = _with_names(frame, result)
    return _averaged(frame, _inexact(frame, result))


def _inexact(frame: Frame, result: Diagnosis) -> Diagnosis:
    """With predictions that are as sure as left-out rows say of named physics, or of a base model that is refuted."""
    known = (
        any(isinstance(effect, Law) for effect in result.predictive.fit.chain.effects) or result.verdict == "consistent"
    )
    few = int(frame.names.sample.counts.sum()) < OPTIONS.fewest_rows
    if known or few or not frame.kind.contested or not len(result.predictive.fit.values):
        return result
    fit, state, sample = result.predictive.fit, frame.names.state(result.predictive), frame.names.sample
    blocks, scale = frame.names.blocks, state.noise_variance
    done = as_matrix(fit.sensitivities)[sample.kept] @ deviations_from_none(fit)
    errors = state.left_out(blocks) / np.sqrt(scale)
    variances = state.left_out_variances(blocks) / scale
    share = LeftOut(errors, errors, blocks).widened(variances, (done**2).sum(axis=1) / scale)[1]
    return replace(result, inexact=share)


def _settled(frame: Frame, model: NamedModel) -> bool:
    """Whether one effect brings readings of known noise to that noise, and says it as briefly as any law could.

    A law of one weight that takes away as much squares q would gain ½·(q − ln q) of log evidence. What needs many
    parameters, as a base that yields in all directions, may imitate what another part does with one.
    """
    names = frame.names
    if not frame.noise.known or len(model.candidates) != 1 or not within_noise(tested(model.fit, names.sample)):
        return False
    explained = max(names.state(names.base).scatter - names.state(model).scatter, 1.0)
    most = 0.5 * (explained - np.log(explained)) - OPTIONS.price_of_law(len(frame.entries)) - OPTIONS.margin
    return bool(most <= 0.5 * (names.base.misfit - model.misfit))


def _averaged(frame: Frame, result: Diagnosis) -> Diagnosis:
    """With predictions that are averaged over what may be there, where too little was measured to tell."""
    if not frame.kind.contested:
        return result
    model = averaged(frame.names, result.predictive)
    if model is result.predictive:
        return result
    beside = [
        str(effect.key) for effect in model.fit.chain.effects if effect not in result.predictive.fit.chain.effects
    ]
    caveat = Averaged(int(frame.names.sample.counts.sum()), tuple(beside))
    return replace(result, predictive=model, caveats=(*result.caveats, caveat))


def _without_mistakes(frame: Frame, most: int) -> tuple[Frame, NamedModel]:
    """The best model of so many named effects at most, in the rows without those that stand out of it by themselves.

    What a row says is asked of the final model: one that stands out of less may show what is missing there. So may one
    that the search without it explains after all, which returns.
    """
    names, model = frame.names, frame.search.model(most)
    aside, common = single_mistakes(names.state(model), names.sample, frame.robot)
    if common:
        names.log.add("outliers", model, False, f"the rows that stand out are no single mistakes: {common}")
    while aside.any():
        rest = frame.without(aside)
        found = rest.search.model(most)
        back = returning(found.fit, frame.sample, aside, known_noise=names.known_noise)
        names.log.add("outliers", found, not back.any(), f"{aside.sum()} rows set aside, {back.sum()} fit after all")
        if not back.any():
            return rest, found
        aside = aside & ~back
    return frame, model


def _with_verdict(frame: Frame, model: NamedModel, errors: HeldOut, method: Method) -> Diagnosis:
    """Whether named effects explain the recordings; `_with_names` says which they are, should they stay."""
    names, base, noise = frame.names, frame.base, frame.noise
    found = bool(model.candidates) or bool(frame.aside.any())
    before, after = tested(base, frame.sample), tested(model.fit, names.sample)
    if noise.origin == "residuals":
        errors = _in_noise_left(frame, model.fit, errors)
    verdict = verdict_without(frame.before)
    if found:
        reason = doubt(
            model,
            before,
            after,
            errors,
            most=names.most_effects,
            known_noise=noise.known,
            reach=names.reach,
            at_limit=names.at_limit(model),
        )
        verdict = "unexplained" if reason else "explained"
        names.log.add("verdict", model, not reason, reason or "it explains the recordings")
    if verdict == "consistent":
        frame.kind.require_plausible(frame.robot, frame.recordings, base)
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


def _with_laws(frame: Frame, result: Diagnosis, *, mistaken: bool) -> Diagnosis:
    """The diagnosis with laws at ports beside what was named or in its place, where left-out rows ask for them.

    Args:
        frame: with all rows where names explain nothing: those that stood out may show what names lack.
        result: with named effects.
        mistaken: whether rows may be single mistakes.
    """
    explained = result.verdict == "explained"
    laws = sought_laws(frame.names, result.model, explained=explained, mistaken=mistaken)
    wins = laws is not None and laws.predicts
    if explained and not (wins and laws is not None and laws.replaces(result.names.base, result.model)):
        return result
    result = replace(result, caveats=(*result.caveats, *not_sought(frame.sample)))
    if laws is None:
        return result
    frame, names = replace(frame, names=laws.names), laws.names
    changed = replace(result, laws=laws if explained else laws.doubted)
    errors = _in_noise_left(frame, laws.fit, _held_out(frame, laws.fit)) if wins else result.errors
    # Rows that were held out do not choose among laws, but none is predicted with that they refute.
    if wins and not errors.refuted:
        named = tuple(part.named for part in laws.parts if part.named is not None)
        model = NamedModel(named, laws.fit, float("nan"))
        verdict = verdict_with(laws, errors)
        # What leaves more than the noise has no name: its part and what it depends on are all that is said.
        known = frame.known
        if verdict == "unexplained":
            laws, known = laws.doubted, frozenset()
        found = law_findings(laws, result.robot, known) + set_aside(frame.recordings, frame.aside)
        changed = replace(
            changed,
            laws=laws,
            model=model,
            names=names,
            predictive=model,
            errors=errors,
            findings=_doubted(found, OPTIONS.doubted) if verdict == "unexplained" else found,
            method=Method(LAWS, "left-out rows are predicted better with laws at ports than with named effects alone"),
            after=frame.stated(laws.fit, names.sample),
            verdict=verdict,
            stability=None,
        )
    names.log.add_text("laws", laws.summary(changed.verdict))
    return changed


def _checked(frame: Frame, model: NamedModel) -> tuple[NamedModel, HeldOut]:
    """The model as far as held-out recordings confirm it, about its own estimate, with its errors."""
    names = frame.names
    names.report(Stage.HELD_OUT, "")
    model, errors = pruned(names, model, frame.base, frame.judged)
    # Where more than noise remains, or rows are alike, the penalised misfit trusts what is not so.
    alike = dispersion(model.fit.residuals, names.sample).correlation > OPTIONS.correlated
    trusted = frame.noise.known and within_noise(tested(model.fit, names.sample)) and not alike
    if model.candidates and not trusted:
        smaller = confirmed(names, model)
        if smaller is not model:
            model, errors = smaller, _held_out(frame, smaller.fit)
    written = _as_written(names, model)
    return written, errors if written is model else _held_out(frame, written.fit)


def _predictive(frame: Frame, model: NamedModel, errors: HeldOut) -> tuple[NamedModel, HeldOut]:
    """What to predict with where a model does not explain: it, or the base model, with the errors of that."""
    names = frame.names
    doubt = names.left_out(model).doubt if model.candidates else ""
    if not (doubt or errors.refuted):
        return model, errors
    if doubt:
        names.log.add("held out", model, False, f"not predicted with: {doubt}")
    return names.base, _held_out(frame, names.base.fit)


def _in_noise_left(frame: Frame, model: Fit, errors: HeldOut) -> HeldOut:
    """The errors in the noise of a reading that the model file states: where none is known, what the model leaves.

    What the base model leaves is noise and the physics that was found.
    """
    value, dof = tested(model, frame.names.sample)
    return errors if frame.noise.known or value == 0.0 else errors.divided_by(float(np.sqrt(value / dof)))


def _held_out(frame: Frame, model: Fit) -> HeldOut:
    return held_out(frame.base, model, frame.names.sample, frame.judged, known_noise=frame.names.known_noise)
