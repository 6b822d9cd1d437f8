"""Designs refined by the gradient of one criterion, so that the best design by it is a local optimum and not the place
where a search was stopped.

What all searches found is joined, because a design that was sought by one criterion often lies in a better valley of
another. Gradient rounds along the criterion (theory.md 6) exchange measurements between these designs; sequential
quadratic programming then takes the best of them to their local optima.
"""

from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import Criterion
from expdesign.design.optimality.descents import Pace, pursued
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.optimality.polish import polish
from expdesign.design.problem import DesignProblem

STARTS, PACE = 8, Pace(steps=100, tolerance=1e-9, inner=1e-9)


def refined(
    problem: DesignProblem, criterion: Criterion, decisions: FloatArray, seed: int, generations: int | None = None
) -> FloatArray:
    """Designs better by `criterion` than those given, as they can be set.

    Args:
        problem: what can be measured; its own objectives do not count.
        criterion: the only objective.
        decisions: feasible designs (d, m, g), not all with the same value of the criterion as a rule.
        seed: of the exchanges.
        generations: that allow as many rounds of exchanges; the configuration's setting if left out.

    Returns:
        Genes (d', m, g); none where nothing is continuous, or where the estimator has redundant parameters, whose
        gradients are not known.
    """
    if not (~problem.space.discrete).any() or problem.loaded.regressor.redundant:
        return decisions[:0]
    settings = replace(problem.optimiser, seed=seed, generations=generations or problem.optimiser.generations)
    alone = replace(problem, objectives=(criterion,), optimiser=settings)
    objectives = Objectives(alone)
    pool = np.concatenate([decisions, polish(alone, decisions, points=1)])
    values = objectives.values(pool)
    order = [int(index) for index in np.argsort(values[:, 0], kind="stable") if np.isfinite(values[index, 0])]
    if not order:
        return decisions[:0]
    starts = pool[order[:STARTS]]
    least = values[order[0]]
    centres = np.tile(least, (len(starts), 1))
    weights = np.tile(1.0 / np.maximum(np.abs(least), 1e-300), (len(starts), 1))
    found = pursued(objectives, starts, centres, weights, PACE)
    return _feasible(alone, np.concatenate([pool, problem.settable(found)]))


def _feasible(problem: DesignProblem, decisions: FloatArray) -> FloatArray:
    """Those of the designs that are within the robot's limits and the constraints of the laboratory."""
    poses, loads = problem.space.decode(decisions)
    usable = problem.loaded.robot.usable(poses).all(axis=1)
    if problem.constraints is not None:
        usable &= (problem.constraints.violations(problem.loaded, poses, loads) <= 0.0).all(axis=1)
    return decisions[usable]
