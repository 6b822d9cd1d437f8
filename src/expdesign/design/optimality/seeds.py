"""First designs from the convex relaxation: its optimal weights, rounded to m measurements (theory.md 10.1, 10.4).

The relaxation is solved for DUIR² + s²·FEIR² with a ladder of factors s, so that the designs lie along the whole front.
The roundings are improved by exchanging measurements, which finds better plans than gradients do from the roundings.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.design.optimality.certificate import Certificate
from expdesign.design.optimality.exchange import Exchange, rounded
from expdesign.design.optimality.measurement_pool import Effort
from expdesign.design.problem import DesignProblem

LADDER = (0.0, 10.0)
_ROUNDS, _DRAWS, _KEPT = 2, 400, 8
_BRIEF = Effort(samples=1000, starts=16, steps=15, passes=1)


def relaxed_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) rounded from optimal weights, the best few of many roundings for each factor."""
    space = problem.space
    found: list[FloatArray] = []
    known: FloatArray | None = None  # as designs of one measurement each
    # Where variables can be refined afterwards a short list will do.
    listed = 100 if (~space.discrete).any() else 2000
    for factor in LADDER if problem.loaded.sources else LADDER[:1]:
        certificate = Certificate(problem, factor, _BRIEF, tolerance=1e-3)
        rounds = list(certificate.refine(known, _ROUNDS))
        if not rounds:
            break
        last = rounds[-1]
        known = last.shortlist[last.weights > 0.0][:, None]
        generator = np.random.default_rng([problem.optimiser.seed, int(100 * factor)])
        exchange = Exchange(problem, last.shortlist[:listed], factor)
        plans = exchange.best(rounded(last.weights[:listed], space.measurements, _DRAWS, generator), _KEPT)
        plans = np.concatenate([plans, np.unique(np.sort(exchange.improve(plans), axis=1), axis=0)])
        # Rounding to what can be set must not take a measurement at the robot's limits beyond them.
        found.append(problem.settable(last.shortlist[plans]))
    return np.concatenate(found) if found else np.zeros((0, space.measurements, space.decisions))
