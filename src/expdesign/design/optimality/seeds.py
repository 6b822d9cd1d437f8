"""First designs from the convex relaxation: its optimal weights, rounded to m measurements (theory.md 10.1, 10.4).

The relaxation is solved for DUIR² + s²·FEIR² with a ladder of factors s, so that the designs lie along the whole front.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.certificate import Certificate
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.problem import DesignProblem

LADDER = (0.0, 0.3, 1.0, 3.0, 10.0)
_ROUNDS, _DRAWS, _KEPT = 2, 400, 8


def relaxed_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) rounded from optimal weights, the best few of many roundings for each factor."""
    space = problem.space
    objectives = Objectives(problem)
    found: list[FloatArray] = []
    known: FloatArray | None = None
    for factor in LADDER if problem.loaded.sources else LADDER[:1]:
        certificate = Certificate(problem, factor, samples=1500, starts=24)
        rounds = list(certificate.refine(known, _ROUNDS))
        if not rounds:
            break
        last = rounds[-1]
        known = last.candidates
        generator = np.random.default_rng([problem.optimiser.seed, int(100 * factor)])
        drawn = last.candidates[_rounded(last.weights, space.measurements, generator)]
        designs = np.unique(space.canonical(drawn), axis=0)
        squares = objectives.model.run(designs)
        values = _weighted_error(problem, squares.noise_variance, squares.force_variance, factor)
        found.append(designs[np.argsort(np.nan_to_num(values, nan=np.inf), kind="stable")[:_KEPT]])
    return np.concatenate(found) if found else np.zeros((0, space.measurements, space.genes))


def _rounded(weights: FloatArray, count: int, generator: np.random.Generator) -> IntArray:
    """Draws of `count` candidates each, every candidate as often as its weight says give or take one (systematic)."""
    order = np.argsort(generator.random((_DRAWS, len(weights))), axis=1)
    edges = np.cumsum(weights[order] / weights.sum(), axis=1)
    points = (np.arange(count) + generator.random((_DRAWS, 1))) / count
    places = (points[:, :, None] > edges[:, None, :]).sum(axis=2)
    chosen: IntArray = np.take_along_axis(order, np.minimum(places, len(weights) - 1), axis=1)
    return chosen


def _weighted_error(problem: DesignProblem, noise: FloatArray, force: FloatArray, factor: float) -> FloatArray:
    """DUIR² + factor²·FEIR² (b,), from variances (b, t, n), as the targets are aggregated."""
    targets = problem.targets
    squares = ((noise + factor**2 * force) * targets.importance).sum(axis=-1)
    largest: FloatArray = squares.max(axis=-1)
    return largest if targets.aggregate == "max" else squares @ targets.weights / targets.weights.sum()
