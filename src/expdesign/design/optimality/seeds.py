"""First designs from the convex relaxation: its optimal weights, rounded to m measurements (theory.md 10.1, 10.4).

The relaxation is solved for DUIR² + s²·FEIR² with a ladder of factors s, so that the designs lie along the whole front.
The roundings are improved by exchanging measurements, which finds better plans than gradients do from the roundings.

FEIR is not convex, and no relaxation leads to where it is least: often one or two measurements, repeated. Those are
looked at among many drawn at random.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.additive import additive
from expdesign.design.optimality.certificate import Certificate
from expdesign.design.optimality.exchange import Exchange, rounded
from expdesign.design.optimality.measurement_pool import Effort
from expdesign.design.problem import DesignProblem
from expdesign.design.start import reachable_measurements

LADDER = (0.0, 10.0)
_ROUNDS, _DRAWS, _KEPT = 2, 400, 8
_BRIEF = Effort(samples=1000, starts=16, steps=15, passes=1)
_SAMPLES, _PAIRED, _BEST = 1000, 20, 4


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


def repeated_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) of one or two measurements, repeated, with the least FEIR and `total` of those drawn."""
    space = problem.space
    if not problem.loaded.sources or space.most_poses is not None or problem.constraints is not None:
        return np.zeros((0, space.measurements, space.decisions))
    generator = np.random.default_rng([problem.optimiser.seed, 2])
    drawn = reachable_measurements(problem, _SAMPLES, generator)
    ends = np.where(generator.random(drawn.shape) < 0.5, space.lower, space.upper)
    drawn = np.unique(np.where(space.of_pose | space.discrete, drawn, ends), axis=0)
    sums, m = additive(problem, 1.0), space.measurements
    parts = sums.parts(drawn)

    def least(options: FloatArray, count: int) -> IntArray:
        """The options with the least FEIR, then those with the least total."""
        with np.errstate(all="ignore"):
            noise, force = (part.max(axis=-1) for part in sums.variances(options))
        squares = [np.where(np.isfinite(value), value, np.inf) for value in (force, noise + force)]
        return np.concatenate([np.argsort(value, kind="stable")[:count] for value in squares])

    alone = least(sums.repeated(parts, m), _PAIRED // 4)
    chosen = np.unique(np.concatenate([alone, generator.permutation(len(drawn))[:_PAIRED]]))
    first, second = (chosen[index].ravel() for index in np.indices((len(chosen), len(chosen))))
    found = [np.repeat(drawn[alone[:, None]], m, axis=1)]
    for times in range(1, m // 2 + 1):
        pairs = sums.repeated(parts, times)[first] + sums.repeated(parts, m - times)[second]
        best = least(pairs, _BEST)
        both = np.where(np.arange(m) < times, first[best, None], second[best, None])
        found.append(drawn[both])
    return problem.settable(np.concatenate(found))
