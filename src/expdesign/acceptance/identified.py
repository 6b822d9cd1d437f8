"""The uncertainty budget at the targets after identification, with what was measured.

The noise is that of the identification: the covariance of the compliances, whose degrees of freedom are those of the
noise level where it was estimated from the recordings. The load errors are the configuration's, carried through the
recorded poses and loads. Where the test of the fit rejects the model, the residuals are larger than the noise, and a
contribution `model` stands for that: √(χ²/ν − 1) times the contribution of the noise (Birge's ratio; Birge 1932).
"""

import numpy as np

from expdesign.acceptance.budget import (
    MODEL,
    NOISE,
    Contribution,
    UncertaintyBudget,
    load_contributions,
    tolerances,
)
from expdesign.arrays import FloatArray
from expdesign.design.problem import DesignProblem
from expdesign.errors import InputError
from expdesign.identification.identify import Identification

DOUBTFUL = 0.01
"""Probability below which the test of the fit rejects the model."""


def identified_budget(problem: DesignProblem, result: Identification) -> UncertaintyBudget:
    """The budget of a robot that was identified, at the targets of a configuration.

    Raises:
        InputError: the configuration is of another robot.
    """
    robot, other = result.robot, problem.loaded.robot
    if robot.kind != other.kind or robot.actuators != other.actuators:
        what = f"the configuration is of a {other.kind} with {len(other.actuators)} actuators, the recordings are not"
        raise InputError(what, where=problem.source, remedy="Give the configuration of the robot that was measured.")
    problem.require_elastostatic("an identified robot can be accepted")
    rows = problem.targets.observation
    variance = np.einsum("tip,pq,tiq->ti", rows, result.covariance, rows)
    noise = np.sqrt(np.maximum(variance, 0.0))
    degrees = min((group.dof for group in result.noise.groups), default=np.inf) if not result.noise.known else np.inf
    contributions = [Contribution(NOISE, noise, True, float(degrees)), *_load_errors(problem, result)]
    goodness = result.goodness
    if goodness.p_value is not None and goodness.p_value < DOUBTFUL and goodness.chi2 is not None:
        ratio = np.sqrt(max(goodness.chi2 / goodness.dof - 1.0, 0.0))
        contributions.append(Contribution(MODEL, noise * ratio, False))
    return UncertaintyBudget(
        contributions=tuple(contributions),
        tolerance=tolerances(problem),
        axes=other.coordinates.deflection,
        coverage=problem.coverage,
        measurements=int(result.fitted.sum()),
    )


def _load_errors(problem: DesignProblem, result: Identification) -> tuple[Contribution, ...]:
    if not problem.loaded.sources:
        return ()
    recorded = result.recordings.rows(result.fitted)
    loads: FloatArray = recorded.wrenches
    if problem.loaded.load.kind == "payload":
        if recorded.payload is None:
            what = "the load errors of the configuration are those of a payload, and the recordings have wrenches"
            remedy = "Record mass_kg and the centre of mass, or use a configuration with `kind: wrench`."
            raise InputError(what, where=recorded.source, remedy=remedy)
        loads = np.concatenate([recorded.payload, recorded.gravity], axis=1)
    assessment = problem.assess(recorded.configurations[None], loads[None], recorded.series[None])
    return load_contributions(problem, assessment)
