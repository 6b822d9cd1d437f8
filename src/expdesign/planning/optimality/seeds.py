"""First designs from the convex relaxation: its optimal weights, rounded to m measurements (theory.md 10.1, 10.4).

The relaxation is solved for DUIR² + s²·FEIR² with a ladder of factors s, so that the designs lie along the whole front.
The roundings are improved by exchanging measurements, which finds better plans than gradients do from the roundings.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.optimality.certificate import Certificate
from expdesign.planning.optimality.exchange import Exchange, rounded
from expdesign.planning.optimality.measurement_pool import BRIEF
from expdesign.planning.problem import DesignProblem
from expdesign.planning.scalarisation import Aims
from expdesign.planning.start import extreme_measurements

LADDER = (0.0, 10.0)
_ROUNDS, _DRAWS, _KEPT = 2, 400, 8
_REPEATED = (1000, 20, 4)
"""Measurements drawn and paired, and plans of each kind, of repeated measurements."""


def relaxed_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) rounded from optimal weights, the best few of many roundings for each factor."""
    space = problem.space
    found: list[FloatArray] = []
    known: FloatArray | None = None  # as designs of one measurement each
    # Where variables can be refined afterwards a short list will do.
    listed = 100 if (~space.discrete).any() else 2000
    for factor in LADDER if problem.loaded.sources else LADDER[:1]:
        certificate = Certificate(problem, factor, BRIEF, tolerance=1e-3)
        rounds = list(certificate.refine(known, _ROUNDS))
        if not rounds:
            break
        last = rounds[-1]
        known = last.shortlist[last.weights > 0.0][:, None]
        generator = np.random.default_rng([problem.optimiser.seed, int(100 * factor)])
        exchange = Exchange(problem, ("total",), factor)
        plans = rounded(last.weights[:listed], space.measurements, _DRAWS, generator)
        designs = last.shortlist[np.unique(np.sort(plans, axis=1), axis=0)]
        best = np.argsort(exchange.scores(designs, _total(len(designs))), kind="stable")[:_KEPT]
        better = exchange.singles(designs[best], _total(len(best)), last.shortlist[:listed])
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
    number, paired, kept = _REPEATED
    drawn = extreme_measurements(problem, number, 0.5, generator)
    aims = Aims(np.zeros((2, 2)), np.eye(2))
    return problem.settable(Exchange(problem, ("feir", "total")).repeated(drawn, aims, kept, paired)[0])


def _total(count: int) -> Aims:
    return Aims(np.zeros((count, 1)), np.ones((count, 1)))
