"""The search for the Pareto front: NSGA-II on whole populations (theory.md 6), then refinement by exact gradients."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population

from expdesign.arrays import FloatArray
from expdesign.criteria.assessment import Assessment
from expdesign.criteria.criterion import known_criteria
from expdesign.design.front import Front, hypervolume, knee, non_dominated, reference_point, spread
from expdesign.design.operators import CanonicalOrder, DesignCrossover, DesignMutation
from expdesign.design.optimality.kktpm import kktpm
from expdesign.design.optimality.polish import polish
from expdesign.design.problem import DesignProblem
from expdesign.design.pymoo_problem import DesignPopulation
from expdesign.design.start import require_identifiable, starting_designs
from expdesign.errors import InfeasibleError


@dataclass(frozen=True)
class Progress:
    """State of the search after a generation; `note` says what is done after the last one."""

    generation: int
    generations: int
    front_size: int
    hypervolume: float
    note: str = ""


def search(problem: DesignProblem, report: Callable[[Progress], None] = lambda progress: None) -> Front:
    """The Pareto front of the problem's objectives.

    The same problem and seed give the same front, bit for bit.

    Raises:
        InfeasibleError: no pose is within the robot's limits.
        NotIdentifiableError: no design identifies what the targets need.
    """
    settings, space = problem.optimiser, problem.space
    generator = np.random.default_rng(settings.seed)
    population = DesignPopulation(problem)
    if space.genes == 0:
        only = np.zeros((1, space.measurements, 0))
        starting_designs(problem, 1, generator)
        require_identifiable(problem, only)
        values, violations = population.objectives(only)
        return _front(problem, only, values, violations, reference_point(values), 1)
    start = starting_designs(problem, settings.population, generator)
    require_identifiable(problem, population.genes(start))
    algorithm = NSGA2(
        pop_size=settings.population,
        sampling=Population.new(X=np.unique(start, axis=0)),
        crossover=DesignCrossover(space),
        mutation=DesignMutation(space),
        repair=CanonicalOrder(space),
        evaluator=Evaluator(),
    )
    algorithm.setup(population, termination=("n_gen", settings.generations), seed=settings.seed)
    point: FloatArray | None = None
    generation = 0
    while algorithm.has_next():
        algorithm.next()
        generation += 1
        values, violations = algorithm.pop.get("F"), algorithm.pop.get("G")
        feasible = (violations <= 0.0).all(axis=1)
        if feasible.any():
            if point is None:
                point = reference_point(values[feasible])
            best = values[feasible][non_dominated(values[feasible])]
            state = Progress(generation, settings.generations, len(best), hypervolume(best, point))
            report(state)
    genes = space.canonical(population.genes(algorithm.pop.get("X").astype(float)))
    values, violations = population.objectives(genes)
    feasible = (violations <= 0.0).all(axis=1)
    if settings.polish and feasible.any() and not problem.loaded.regressor.redundant:
        chosen = genes[feasible][non_dominated(values[feasible])]
        genes = np.concatenate([genes, polish(problem, chosen, lambda text: report(replace(state, note=text)))])
        values, violations = population.objectives(genes)
    return _front(problem, genes, values, violations, point, population.evaluations)


def _front(
    problem: DesignProblem,
    genes: FloatArray,
    values: FloatArray,
    violations: FloatArray,
    point: FloatArray | None,
    evaluations: int,
) -> Front:
    feasible = np.flatnonzero((violations <= 0.0).all(axis=1))
    if feasible.size == 0 or point is None:
        raise InfeasibleError(
            "the search met no design within the robot's limits that identifies what the targets need",
            where=problem.source,
            remedy="Widen `experiment.poses` or the loads, or allow more measurements.",
        )
    best = feasible[non_dominated(values[feasible])]
    order = best[np.lexsort(values[best].T[::-1])]
    total = all_criteria(problem.assess(*problem.space.decode(genes[order])))["total"]
    marked = [int(np.argmin(total)), knee(values[order])]
    order = order[spread(values[order], marked, problem.optimiser.population)]
    criteria = all_criteria(problem.assess(*problem.space.decode(genes[order])))
    return Front(
        genes=genes[order],
        criteria=criteria,
        objectives=tuple(criterion.name for criterion in problem.objectives),
        recommended=int(np.argmin(criteria["total"])),
        knee=knee(values[order]),
        kktpm=kktpm(problem, genes[order]),
        hypervolume=hypervolume(values[order], point),
        reference_point=point,
        evaluations=evaluations,
    )


def all_criteria(assessment: Assessment) -> dict[str, FloatArray]:
    """Every known criterion of the designs of an assessment, shape (b,) each."""
    return {name: criterion.values(assessment) for name, criterion in known_criteria().items()}
