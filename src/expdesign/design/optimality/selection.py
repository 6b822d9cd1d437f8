"""Choose m measurements out of very many candidates: relaxation, rounding, Fedorov exchange (theory.md 10.1)."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality.certificate import Certificate
from expdesign.design.optimality.exchange import Exchange, rounded
from expdesign.design.optimality.refinement import LowerBound
from expdesign.design.problem import DesignProblem
from expdesign.errors import InfeasibleError

_DRAWS, _STARTS, _CHEAP = 400, 4, 50000


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
    result = certificate.result(None)
    if result.last is None:
        remedy = "Widen `experiment.poses` or the loads."
        raise InfeasibleError(result.bound.certified_on, where=problem.source, remedy=remedy)
    last = result.last
    generator = np.random.default_rng(problem.optimiser.seed)
    exchange = Exchange(problem, last.shortlist, factor)
    first = rounded(last.weights, problem.space.measurements, _DRAWS, generator)
    m, listed = problem.space.measurements, len(last.shortlist)
    # Where a sweep costs little, starts at random are worth their while.
    further = generator.integers(listed, size=(min(100, _CHEAP // (m * listed)), m))
    starts = np.concatenate([exchange.best(first, _STARTS), further])
    designs = problem.space.canonical(last.shortlist[exchange.improve(starts)])
    name = "total" if with_load_errors else "duir"
    values = known_criteria()[name].values(problem.assess(*problem.space.decode(designs)))
    if np.isnan(values).all():
        what = "no plan that was found among the candidates identifies what the targets need"
        raise InfeasibleError(what, where=problem.source, remedy="Allow more measurements, or more loads.")
    best = int(np.nanargmin(values))
    return Selection(designs[best], float(values[best]), result.bound)
