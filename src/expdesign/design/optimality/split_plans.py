"""What of the distance to a bound is the price of whole measurements.

The convex relaxation may take a measurement 0.7 times; a plan takes it once or not at all. If each of the m
measurements could be split into s, each with an s-th of the information, a plan could follow the weights more closely.
How near the bound such a plan comes tells how much of the distance is due to the bound itself and to the search for the
weights; what else a plan of whole measurements lacks is the price of their being whole.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.design.optimality.exchange import Exchange, rounded
from expdesign.design.problem import DesignProblem

PARTS = 3
_LISTED, _DRAWS, _STARTS, _MOST = 200, 200, 4, 60


def split_duir(problem: DesignProblem, candidates: FloatArray, weights: FloatArray) -> float | None:
    """DUIR of the best plan found with every measurement split into `PARTS`; None where that is not attempted.

    Args:
        problem: the design problem.
        candidates: variables (j, g), the likeliest first.
        weights: optimal ones of the relaxation, shape (j,).
    """
    count = PARTS * problem.space.measurements
    if problem.noise.shared_reference or count > _MOST or not (weights[:_LISTED] > 0.0).any():
        return None
    exchange = Exchange(problem, candidates[:_LISTED], 0.0)
    generator = np.random.default_rng(problem.optimiser.seed)
    plans = exchange.best(rounded(weights[:_LISTED], count, _DRAWS, generator), _STARTS)
    value = PARTS * float(exchange.values(exchange.sums(exchange.improve(plans))).min())
    return float(np.sqrt(value)) if np.isfinite(value) else None
