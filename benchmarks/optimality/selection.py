"""Choose m measurements out of very many candidates: relaxation, rounding, Fedorov exchange (theory.md 10.1)."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InfeasibleError
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.certificate import Certificate, LowerBound
from expdesign.planning.optimality.exchange import Exchange, rounded
from expdesign.planning.problem import DesignProblem
from expdesign.planning.scalarisation import Aims

_DRAWS, _STARTS, _CHEAP, _ROUNDS = 400, 4, 50000, 10


@dataclass(frozen=True)
class Selection:
    """A plan chosen from candidates.

    Attributes:
        variables: shape (m, g).
        value: DUIR, or `total` where load errors were counted.
        bound: what no plan from the candidates can beat.
    """

    variables: FloatArray
    value: float
    bound: LowerBound


def choose_measurements(
    problem: DesignProblem, candidates: FloatArray | None = None, *, with_load_errors: bool = False
) -> Selection:
    """The best plan that exchange finds, of as many measurements as the configuration has (repetitions allowed).

    Args:
        problem: the design problem.
        candidates: variables (j, g); all measurements of a space with finitely many where left out.
        with_load_errors: whether `total` is to be made small, and not DUIR.

    Raises:
        InfeasibleError: no candidate is within the robot's limits, or they identify too little.
    """
    factor = 1.0 if with_load_errors else 0.0
    certificate = Certificate(problem, factor, candidates=candidates)
    bound = certificate.bound(None)
    rounds = list(certificate.refine(None, 1 if certificate.pool.complete else _ROUNDS))
    if not rounds:
        remedy = "Widen `experiment.poses` or the loads."
        raise InfeasibleError(bound.certified_on, where=problem.source, remedy=remedy)
    last = rounds[-1]
    generator = np.random.default_rng(problem.optimiser.seed)
    exchange = Exchange(problem, ("total",), factor)
    plans = rounded(last.weights, problem.space.measurements, _DRAWS, generator)
    m, listed = problem.space.measurements, len(last.shortlist)
    # Where a sweep costs little, starts at random are worth their while.
    further = generator.integers(listed, size=(min(100, _CHEAP // (m * listed)), m))
    first = last.shortlist[plans]
    best = np.argsort(exchange.scores(first, _total(len(first))), kind="stable")[:_STARTS]
    starts = np.concatenate([first[best], last.shortlist[further]])
    designs = problem.space.canonical(exchange.singles(starts, _total(len(starts)), last.shortlist))
    name = "total" if with_load_errors else "duir"
    values = known_criteria()[name].values(problem.assessed(designs))
    if np.isnan(values).all():
        what = "no plan that was found among the candidates identifies what the targets need"
        raise InfeasibleError(what, where=problem.source, remedy="Allow more measurements, or more loads.")
    least = int(np.nanargmin(values))
    return Selection(designs[least], float(values[least]), bound)


def _total(count: int) -> Aims:
    return Aims(np.zeros((count, 1)), np.ones((count, 1)))
