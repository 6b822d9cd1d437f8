"""The uncertainty budget at the targets of a model with any physics, as recordings determined it.

With parameters θ, their covariance P and the sensitivities T of the attained pose at a target, the noise contributes
√(T·P·Tᵀ), and what is not known of the target's own payload adds to it (`target_loads`). An error of the recorded
loads moves the readings by g, and the estimate by P·Sᵀ·V⁻¹·g (theory.md 5.1 with the sensitivities S of all
parameters); what a parameter of the load takes up no longer reaches the others.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from expdesign.assurance.acceptance.budget import (
    DRAWING,
    NOISE,
    OWN_PAYLOAD,
    Contribution,
    UncertaintyBudget,
    tolerances,
)
from expdesign.assurance.acceptance.repetition import fitted_repetition
from expdesign.chain.models.acting import ActingLoads
from expdesign.chain.models.drawn import Drawn
from expdesign.chain.models.estimable import Calibrated
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError
from expdesign.estimation.compensation.arm_targets import of_joints
from expdesign.estimation.compensation.joint_space import at_targets, tip_chain
from expdesign.estimation.compensation.prediction import after_campaign, chain_of
from expdesign.estimation.compensation.target_loads import AttainedUncertainty, TargetLoads
from expdesign.estimation.fit import Fit
from expdesign.estimation.load_errors import declared_load_errors
from expdesign.estimation.propagated import Propagated, gain_of
from expdesign.estimation.weighed import WeighedLoads
from expdesign.estimation.whitening import Whitening
from expdesign.planning.problem import DesignProblem
from expdesign.planning.target_table import targets_table


@dataclass(frozen=True)
class FittedModel:
    """A model as recordings determined it.

    Attributes:
        fit: of the rows, its covariance being that with which it predicts.
        recordings: the rows that were fitted.
        whitening: of these rows.
        degrees: degrees of freedom of the noise level, infinite where it is stated.
        loads: load errors that the covariance of the fit contains, of which some act at targets too; None for none.
        drawn: what no reading shows and the covariance does not contain; None for nothing.
    """

    fit: Fit
    recordings: Recordings
    whitening: Whitening
    degrees: float = float("inf")
    loads: WeighedLoads | None = None
    drawn: Drawn | None = None


def fitted_budget(problem: DesignProblem, model: FittedModel) -> UncertaintyBudget:
    """The budget of a model at the targets of a configuration of the same robot.

    Raises:
        InputError: the load errors of the configuration are of another kind of load than was recorded, or the geometry
            is calibrated and the model has none.
    """
    require_what_is_calibrated(problem, shown=not model.fit.chain.reading.linear)
    acting = None if model.loads is None else model.loads.at_targets(model.fit)
    attained = attained_at_targets(problem, model.fit, model.recordings, acting, model.drawn)
    sensitivities, deviations = attained.sensitivities, attained.known
    known = model.fit.estimable if acting is None else acting.joined(model.fit.estimable)
    generalised = known.generalised
    together = np.einsum("tnp,pq,smq->tnsm", sensitivities, generalised, sensitivities, optimize=True)
    loads = []
    propagated = _propagated(problem, model)
    for effect, moved in zip(propagated.effects, propagated.moved, strict=True):
        errors = np.einsum("tnp,mpd->tnmd", sensitivities, moved)
        part = np.einsum("tnmd,skmd->tnsk", errors, errors, optimize=True)
        deviation = np.sqrt((errors**2).sum(axis=(2, 3)))
        loads.append(Contribution(effect.name, deviation, covariance=part))
        if model.loads is not None:  # the covariance of the fit contains them
            together = together - part
    own = np.sqrt(np.maximum(np.einsum("tntn->tn", together), 0.0))
    noise = np.where(np.isfinite(deviations), own if model.loads is not None else deviations, np.nan)
    contributions = [Contribution(NOISE, noise, model.degrees, together), *loads]
    for name, columns in ((OWN_PAYLOAD, attained.own), (DRAWING, attained.drawn)):
        if columns.any():
            spread = np.einsum("tnd,smd->tnsm", columns, columns)
            contributions.append(Contribution(name, np.sqrt((columns**2).sum(axis=-1)), covariance=spread))
    of_machine, there = np.split(sensitivities, [len(model.fit.values)], axis=-1)
    base = None
    if model.drawn is not None:
        base = np.sqrt(((of_machine[..., : len(model.drawn.base)] @ model.drawn.base) ** 2).sum(axis=-1))
    at = [np.zeros((*there.shape[:-1], effect.moved.shape[-1])) for effect in propagated.effects]
    if model.loads is not None:
        at = model.loads.acting_at(there, weighed=model.whitening.loads is not None)
    constant = (attained.own**2).sum(axis=-1) + (attained.drawn**2).sum(axis=-1)
    return UncertaintyBudget(
        contributions=tuple(contributions),
        tolerance=tolerances(problem),
        axes=problem.loaded.robot.coordinates.deflection,
        coverage=problem.coverage,
        measurements=len(model.recordings),
        base=base,
        repetition=fitted_repetition(model.fit, model.whitening, propagated.effects, (of_machine, at), constant),
    )


def require_what_is_calibrated(problem: DesignProblem, *, shown: bool) -> None:
    """Raise where a configuration calibrates geometry and the recordings have not `shown` it."""
    if not problem.loaded.regressor.referenced and not shown:
        what = "the configuration calibrates the geometry, which recordings of deflections do not show"
        remedy = "Record positions or poses, or take `experiment.calibration` out."
        raise InputError(what, where=f"{problem.source}, experiment.calibration", remedy=remedy)


def places_tip(fit: Fit) -> bool:
    """Whether the model says where an arm's tip is, and not only how it yields under a load."""
    return fit.chain.robot.jointed and not fit.chain.reading.linear


def attained_at_targets(
    problem: DesignProblem,
    fit: Fit,
    recordings: Recordings,
    acting: ActingLoads | None = None,
    drawn: Drawn | None = None,
) -> AttainedUncertainty:
    """How well the attained poses are known along the axes of the tolerances, as `compensate` states it.

    Of an arm they are those of its tip; of a robot on legs the motion counts from the command.

    Args:
        problem: with the targets.
        fit: of the recordings.
        recordings: that were fitted.
        acting: errors of their loads that act at targets as well.
        drawn: what they do not show of an arm's tip.
    """
    table, robot = targets_table(problem), fit.chain.robot
    known = Calibrated.of(recordings, robot, ordered=fit.chain.counts_rows)
    bare = Model(fit.chain, fit.values, fit.covariance, {}, Path(), problem.source, fit.estimable)
    model = replace(bare, calibrated=known, acting=acting, drawn=drawn).at_targets
    points = after_campaign(model, points_from_table(table, robot))
    chain = chain_of(model, platform=True, from_command=True)
    if robot.jointed:
        points, chain = at_targets(model, of_joints(robot, points), "base"), tip_chain(model, "base")
    loads = TargetLoads.of_table(table, robot.coordinates)
    return AttainedUncertainty.at(chain, model, points, loads, problem.targets.axes)


def _propagated(problem: DesignProblem, model: FittedModel) -> Propagated:
    """What errors of the loads do to the parameters: those that the fit contains, else as they are declared."""
    if model.loads is not None:
        return model.loads.joined.scaled(float(np.sqrt(model.fit.inflation)))
    fit, recorded = model.fit, model.recordings
    errors = declared_load_errors(fit.chain.robot, recorded, problem.load_errors)
    effects = () if errors is None else errors.effects(fit.chain, fit.values, recorded)
    noise = model.whitening
    return Propagated.of(gain_of(fit, noise), noise.deviations, effects, [1.0] * len(effects))
