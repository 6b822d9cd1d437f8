"""The uncertainty budget at the targets of a model with any physics, as recordings determined it.

With parameters θ, their covariance P and the sensitivities T of the attained pose at a target, the noise contributes
√(T·P·Tᵀ). An error of the recorded loads moves the readings by g, and the estimate by P·Sᵀ·V⁻¹·g (theory.md 5.1 with
the sensitivities S of all parameters); what a parameter of the load takes up no longer reaches the others.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.budget import NOISE, Contribution, UncertaintyBudget, tolerances
from expdesign.assurance.model_error.left_out import target_points
from expdesign.chain.chain import Chain
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.estimation.compensation.arm_targets import of_joints
from expdesign.estimation.compensation.joint_space import at_targets, tip_chain
from expdesign.estimation.fit import Fit
from expdesign.estimation.load_errors import declared_load_errors
from expdesign.estimation.propagated import Propagated
from expdesign.estimation.whitening import Whitening
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class FittedModel:
    """A model as recordings determined it.

    Attributes:
        fit: of the rows, its covariance being that with which it predicts.
        recordings: the rows that were fitted.
        whitening: of these rows.
        degrees: degrees of freedom of the noise level, infinite where it is stated.
        loads: load errors that the covariance of the fit contains; None where it contains none.
    """

    fit: Fit
    recordings: Recordings
    whitening: Whitening
    degrees: float = float("inf")
    loads: Propagated | None = None


def fitted_budget(problem: DesignProblem, model: FittedModel) -> UncertaintyBudget:
    """The budget of a model at the targets of a configuration of the same robot.

    Raises:
        InputError: the load errors of the configuration are of another kind of load than was recorded, or the geometry
            is calibrated and the model has none.
    """
    require_what_is_calibrated(problem, shown=not model.fit.chain.reading.linear)
    sensitivities = target_sensitivities(problem, model.fit)
    deviations = model.fit.estimable.deviations(sensitivities)
    generalised = model.fit.estimable.generalised
    together = np.einsum("tnp,pq,smq->tnsm", sensitivities, generalised, sensitivities, optimize=True)
    loads = []
    propagated = _propagated(problem, model)
    for effect, moved in zip(propagated.effects, propagated.moved, strict=True):
        errors = np.einsum("tnp,mpd->tnmd", sensitivities, moved)
        part = np.einsum("tnmd,skmd->tnsk", errors, errors, optimize=True)
        deviation = np.sqrt((errors**2).sum(axis=(2, 3)))
        loads.append(Contribution(effect.name, deviation, not effect.shared, covariance=part))
        if model.loads is not None:  # the covariance of the fit contains them
            together = together - part
    own = np.sqrt(np.maximum(np.einsum("tntn->tn", together), 0.0))
    noise = np.where(np.isfinite(deviations), own if model.loads is not None else deviations, np.nan)
    contributions = [Contribution(NOISE, noise, True, model.degrees, together), *loads]
    return UncertaintyBudget(
        contributions=tuple(contributions),
        tolerance=tolerances(problem),
        axes=problem.loaded.robot.coordinates.deflection,
        coverage=problem.coverage,
        measurements=len(model.recordings),
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


def target_sensitivities(problem: DesignProblem, fit: Fit) -> FloatArray:
    """Derivatives of the attained pose along the axes of the tolerances, shape (t, n, p).

    Of an arm that absolute readings placed they are those of the pose of its tip, geometry included; of a robot on legs
    the motion counts from the command.
    """
    known = fit.chain
    chain = Chain(known.robot, known.effects, reading=known.reading, instrument=False, from_command=True)
    placed = Model(known, fit.values, fit.covariance, {}, Path(), problem.source, fit.subspace)
    if places_tip(fit):
        chain = tip_chain(placed, "base")
    turned = problem.targets.axes
    rows = []
    for index in range(len(problem.targets.configurations)):
        points = target_points(problem, index)
        if places_tip(fit):
            points = at_targets(placed, of_joints(known.robot, points), "base")
        moved = chain.predict_with_sensitivities(row_data(points, known.robot), fit.values)[1][0]
        rows.append(moved if turned is None else turned[index] @ moved)
    return np.array(rows)


def _propagated(problem: DesignProblem, model: FittedModel) -> Propagated:
    """What errors of the loads do to the parameters: those that the fit contains, else as they are declared."""
    if model.loads is not None:
        return model.loads
    fit, recorded = model.fit, model.recordings
    errors = declared_load_errors(fit.chain.robot, recorded, problem.load_errors)
    effects = () if errors is None else errors.effects(fit.chain, fit.values, recorded)
    return Propagated.of(fit, model.whitening, effects, [1.0] * len(effects))
