"""The best design by one criterion alone, as each criterion's own author would have chosen it.

A genetic search is followed by a local one in the continuous decision variables: perturbed copies of the best design
are evaluated all at once, and their size follows their success (Rechenberg's one-fifth rule). Both work on any
criterion, with or without derivatives, minimised or maximised.
"""

from dataclasses import dataclass, replace

import numpy as np
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.population import Population

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import Criterion
from expdesign.design.operators import CanonicalOrder, DesignCrossover, DesignMutation
from expdesign.design.problem import DesignProblem
from expdesign.design.pymoo_problem import DesignPopulation
from expdesign.design.start import require_identifiable, starting_designs
from expdesign.errors import InfeasibleError

_BROOD = 60
_SUCCESS = 0.2


@dataclass(frozen=True)
class BestDesign:
    """The best design found.

    Attributes:
        decisions: shape (m, g).
        value: of the criterion.
        evaluations: designs evaluated.
    """

    decisions: FloatArray
    value: float
    evaluations: int


def search_single(
    problem: DesignProblem,
    criterion: Criterion,
    *,
    seed: int,
    population: int | None = None,
    generations: int | None = None,
    refinements: int = 150,
) -> BestDesign:
    """The design that is best by `criterion`; the same arguments give the same design.

    Args:
        problem: what can be measured; its own objectives do not count.
        criterion: the only objective.
        seed: of the search.
        population: designs of a generation; the problem's setting if left out.
        generations: of the genetic search; the problem's setting if left out.
        refinements: steps of the local search.

    Raises:
        InfeasibleError: no design within the limits was found.
        NotIdentifiableError: no design identifies what the targets need.
    """
    space = problem.space
    settings = problem.optimiser
    generator = np.random.default_rng(seed)
    designs = DesignPopulation(replace(problem, objectives=(criterion,)))
    size = population or settings.population
    start = starting_designs(problem, size, generator)
    require_identifiable(problem, designs.decisions(start))
    best = designs.decisions(start)[:1]
    if space.decisions:
        algorithm = GA(
            pop_size=size,
            sampling=Population.new(X=np.unique(start, axis=0)),
            crossover=DesignCrossover(space),
            mutation=DesignMutation(space, merge=problem.noise.shared_reference or space.most_poses is not None),
            repair=CanonicalOrder(space),
        )
        algorithm.setup(designs, termination=("n_gen", generations or settings.generations), seed=seed)
        while algorithm.has_next():
            algorithm.next()
        best = _best_of(designs, designs.decisions(algorithm.pop.get("X").astype(float)))
        best = _refined(designs, best, generator, refinements)
    best = problem.settable(best)
    values, violations = designs.objectives(best)
    if (violations > 0.0).any():
        what = "the search met no design within the robot's limits that identifies what the targets need"
        remedy = "Widen `experiment.poses` or the loads, or allow more measurements."
        raise InfeasibleError(what, where=problem.source, remedy=remedy)
    sign = -1.0 if criterion.maximise else 1.0
    return BestDesign(best[0], sign * float(values[0, 0]), designs.evaluations)


def _scores(designs: DesignPopulation, decisions: FloatArray) -> FloatArray:
    """The objective, infinite where a constraint is violated, shape (b,)."""
    designs.evaluations += len(decisions)
    values, violations = designs.objectives(decisions)
    return np.where((violations <= 0.0).all(axis=1), values[:, 0], np.inf)


def _best_of(designs: DesignPopulation, decisions: FloatArray) -> FloatArray:
    return decisions[int(np.argmin(_scores(designs, decisions)))][None]


def _refined(designs: DesignPopulation, best: FloatArray, generator: np.random.Generator, steps: int) -> FloatArray:
    """The best design (1, m, g) after a local search in its continuous decisions."""
    space = designs.design_problem.space
    continuous = ~space.discrete
    if not continuous.any():
        return best
    score = float(_scores(designs, best)[0])
    span, size = space.upper - space.lower, 0.05
    for _ in range(steps):
        moves = generator.standard_normal((_BROOD, *best.shape[1:])) * size * span * continuous
        # Half of the brood moves one measurement only, which is what is left to do near an optimum.
        only = generator.integers(best.shape[1], size=_BROOD // 2)
        moves[: _BROOD // 2] *= (np.arange(best.shape[1]) == only[:, None])[..., None]
        # Genes that rest on a bound stay there, or else nearly every move leaves the box.
        brood = np.clip(best + moves, space.lower, space.upper)
        scores = _scores(designs, brood)
        better = float((scores < score).mean())
        size = float(np.clip(size * np.exp(0.8 * (better - _SUCCESS)), 1e-6, 0.3))
        index = int(np.argmin(scores))
        if scores[index] < score:
            best, score = brood[index][None], float(scores[index])
    return best
