"""The first designs of a search beside those at random (`sampling`): rounded from the convex relaxation's optimal
weights (theory.md 10.1, 10.4), of every structure that a budget allows, or all that there are where the space is small
enough.

The relaxation is solved for DUIR² + s²·FEIR² with a ladder of factors s, so that the designs lie along the whole front.
The roundings are improved by exchanging measurements, which finds better plans than gradients do from the roundings.
"""

from collections.abc import Iterable
from itertools import combinations_with_replacement
from math import comb

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.front import non_dominated
from expdesign.planning.optimality.certificate import Certificate
from expdesign.planning.optimality.exchange import Exchange, rounded
from expdesign.planning.optimality.pool import BRIEF
from expdesign.planning.problem import DesignProblem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.sampling import extreme_measurements
from expdesign.planning.scalarisation import Aims

_LADDER, _ROUNDS = (0.0, 10.0), 2
"""Factors s of the load errors for which the relaxation is rounded, and its rounds."""
_ENUMERABLE, _TOGETHER = 40_000, 5000
"""Designs of a finite space that are all looked at, and how many of them together."""


def first_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) of the relaxation, of repetitions, and of every structure that a budget allows."""
    structured = structured_designs(problem, np.random.default_rng([problem.optimiser.seed, 3]), (40, 3))
    return np.concatenate([relaxed_designs(problem), repeated_designs(problem), structured])


def relaxed_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) rounded from optimal weights, the best few of many roundings for each factor."""
    space = problem.space
    found: list[FloatArray] = []
    known: FloatArray | None = None  # as designs of one measurement each
    # Where variables can be refined afterwards a short list will do.
    listed = 100 if (~space.discrete).any() else 2000
    for factor in _LADDER if problem.loaded.sources else _LADDER[:1]:
        certificate = Certificate(problem, factor, BRIEF, tolerance=1e-3)
        refined = list(certificate.refine(known, _ROUNDS))
        if not refined:
            break
        last = refined[-1]
        known = last.shortlist[last.weights > 0.0][:, None]
        generator = np.random.default_rng([problem.optimiser.seed, int(100 * factor)])
        exchange = Exchange(problem, ("total",), factor)
        plans = rounded(last.weights[:listed], space.measurements, 400, generator)
        designs = last.shortlist[np.unique(np.sort(plans, axis=1), axis=0)]
        best = np.argsort(exchange.scores(designs, Aims.of_one(len(designs))), kind="stable")[:8]
        better = exchange.singles(designs[best], Aims.of_one(len(best)), last.shortlist[:listed])
        # Rounding to what can be set must not take a measurement at the robot's limits beyond them.
        found.append(problem.settable(np.concatenate([designs[best], better])))
    return np.concatenate(found) if found else np.zeros((0, space.measurements, space.decisions))


def repeated_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) of one or two measurements, repeated, with the least FEIR and `total` of those drawn.

    Load errors of their own in every measurement average out over repetitions, so that such plans are the best towards
    FEIR's end, and among designs at random there are none.
    """
    space = problem.space
    if not problem.loaded.sources or problem.budget is not None or problem.constraints is not None:
        return np.zeros((0, space.measurements, space.decisions))
    generator = np.random.default_rng([problem.optimiser.seed, 2])
    drawn = extreme_measurements(problem, 1000, 0.5, generator)
    aims = Aims(np.zeros((2, 2)), np.eye(2))
    return problem.settable(Exchange(problem, ("feir", "total")).repeated(drawn, aims, 4, 20)[0])


def structured_designs(
    problem: DesignProblem, generator: np.random.Generator, drawn: tuple[int, int], poses: Iterable[int] | None = None
) -> FloatArray:
    """Designs (d, m, g) of structures that a budget allows: the most measurements at each number of settings, the best
    few of those drawn, at better poses and after exchanges of their measurements. Exchanges of a plan with another
    structure hardly ever come to them.

    Args:
        problem: the design problem.
        generator: of what is drawn.
        drawn: plans of each structure, and how many of them are improved.
        poses: numbers of settings; every one where left out.
    """
    space, budget, settings = problem.space, problem.budget, problem.space.settings
    m = space.measurements
    found: list[FloatArray] = [np.zeros((0, m, space.decisions))]
    if budget is None or settings is None:
        return found[0]
    exchange, (number, kept) = Exchange(problem, ("total",)), drawn
    offered, most = extreme_measurements(problem, 2 * number, 0.5, generator), min(m, budget.poses or m)
    counts = np.arange(1, m + 1)
    for p in range(1, most + 1) if poses is None else poses:
        fit = counts[(budget.minutes_of(counts, p) <= budget.minutes) & (counts >= p)]
        if not fit.size or not 1 <= p <= most:
            continue
        rows = extreme_measurements(problem, number * m, 0.5, generator).reshape(number, m, -1)
        designs = np.where(space.of_pose, rows[:, np.arange(m) % p], rows)
        designs[..., settings.gene] = np.where(np.arange(m) < fit.max(), settings.first, 0.0)
        designs = problem.settable(designs)
        best = designs[np.argsort(exchange.scores(designs, Aims.of_one(number)), kind="stable")[:kept]]
        best = exchange.moved(best, Aims.of_one(len(best)), offered)
        found.append(problem.settable(exchange.singles(best, Aims.of_one(len(best)), offered)))
    return np.concatenate(found)


def every_design(problem: DesignProblem) -> FloatArray | None:
    """The designs (d, m, g) that no other one dominates, in a space of finitely many; None where they are too many."""
    space = problem.space
    if (
        not space.discrete.all()
        or (space.settings is not None and space.settings.budget is not None)
        or space.required.poses
        or space.required.masses
    ):
        return None
    levels = [int(high) + 1 for high in space.upper]
    count, m = int(np.prod(levels, dtype=np.float64)), space.measurements
    if comb(count + m - 1, m) > _ENUMERABLE:
        return None
    axes = np.meshgrid(*(np.arange(number, dtype=float) for number in levels), indexing="ij")
    measurements = np.stack([axis.ravel() for axis in axes], axis=1)
    measurements = measurements[problem.loaded.robot.usable(space.decode(measurements)[0])]
    plans = np.array(list(combinations_with_replacement(range(len(measurements)), m)), dtype=np.int64)
    population, best = DesignPopulation(problem), np.zeros((0, m, space.decisions))
    for start in range(0, len(plans), _TOGETHER):
        listed = np.unique(space.canonical(measurements[plans[start : start + _TOGETHER]]), axis=0)
        designs = np.concatenate([best, listed])
        values, violations = population.objectives(designs)
        feasible = (violations <= 0.0).all(axis=1)
        designs, values = designs[feasible], values[feasible]
        best = designs[non_dominated(values)] if len(designs) else best
    return best
