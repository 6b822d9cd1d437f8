"""The search for the Pareto front: exact gradients, NSGA-II on whole populations (theory.md 6), gradients again.

Gradients from the designs of the convex relaxation find most of the front in a few seconds. The genetic search, from
designs at random, finds the valleys that they missed. What both found is then refined together.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import criterion_values, known_criteria
from expdesign.design.front import Front, hypervolume, knee, non_dominated, reference_point, spread
from expdesign.design.operators import CanonicalOrder, DesignCrossover, DesignMutation
from expdesign.design.optimality.kktpm import kktpm
from expdesign.design.optimality.polish import coarse_rounds, fine_rounds
from expdesign.design.problem import DesignProblem
from expdesign.design.pymoo_problem import DesignPopulation
from expdesign.design.start import require_identifiable, starting_designs
from expdesign.errors import InfeasibleError, InputError

_REVIEW = 20
"""Generations after which objectives that look at a part of what counts are checked against the whole."""
_AGREEMENT, _REFINEMENTS = 0.01, 2
"""Relative difference from the whole that is let pass, and how often designs are refined to get there."""


@dataclass(frozen=True)
class Progress:
    """State of the search.

    Attributes:
        generation: of the genetic search; 0 before it.
        generations: how many there will be.
        front: objectives (d, k), minimised, of the best designs so far.
        hypervolume: of that front.
        note: what is done before and after the genetic search.
    """

    generation: int
    generations: int
    front: FloatArray
    hypervolume: float
    note: str = ""


Follow = Callable[[Progress], bool | None]
"""Called with the state of a search; returns True to end it with the designs that are there."""


def search(problem: DesignProblem, report: Follow = lambda progress: None) -> Front:
    """The Pareto front of the problem's objectives.

    The same problem and seed give the same front, bit for bit, unless `report` ends the search.

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
    # Exact gradients are of estimators without redundant parameters.
    polished = settings.polish and not problem.loaded.regressor.redundant
    known = _Known(settings.generations, report)
    first = early = population.genes(start)
    working = problem.working(first)
    population = DesignPopulation(working)
    values, violations = population.objectives(first)
    _require_finite(problem, first)
    known.add(values, violations)
    if polished and not known.ended:
        for number, early in enumerate(coarse_rounds(working, first), start=1):
            known.add(*population.objectives(early), note=f"gradients, round {number}")
            if known.ended:
                break
        working = population.design_problem = working.working(early)
    algorithm = NSGA2(
        pop_size=settings.population,
        sampling=Population.new(X=np.unique(start, axis=0)),
        crossover=DesignCrossover(space),
        mutation=DesignMutation(space, merge=problem.noise.shared_reference or space.most_poses is not None),
        repair=CanonicalOrder(space),
        evaluator=Evaluator(),
    )
    algorithm.setup(population, termination=("n_gen", settings.generations), seed=settings.seed)
    while algorithm.has_next():
        algorithm.next()
        known.generation += 1
        if known.generation % _REVIEW == 0:
            working = _reviewed(population, algorithm.pop)
        known.add(algorithm.pop.get("F"), algorithm.pop.get("G"))
        if known.ended:
            break
    genes = problem.settable(population.genes(algorithm.pop.get("X").astype(float)))
    if polished:
        refined = None
        for _ in range(0 if known.ended else _REFINEMENTS):
            working = population.design_problem = working.working(np.concatenate([genes, early]))
            for number, refined in enumerate(fine_rounds(working, early, genes), start=1):
                known.add(*population.objectives(refined), note=f"refinement, round {number}: {len(refined)} designs")
                if known.ended:
                    break
            if refined is None or known.ended or _agree(problem, working, refined):
                break
            early = refined
        # What the refinement left out as rough, the others would bring back.
        genes = np.concatenate([genes, early]) if refined is None or len(refined) == 0 else refined
    genes = problem.settable(genes)
    values, violations = DesignPopulation(problem).objectives(genes)
    return _front(problem, genes, values, violations, known.point, population.evaluations)


def _reviewed(population: DesignPopulation, designs: Population) -> DesignProblem:
    """The problem with objectives that are right at these designs, which are evaluated again where they change."""
    genes = population.genes(designs.get("X").astype(float))
    working = population.design_problem.working(genes)
    if working is not population.design_problem:
        population.design_problem = working
        values, violations = population.objectives(genes)
        designs.set("F", values, "G", violations)
    return working


def _agree(problem: DesignProblem, working: DesignProblem, designs: FloatArray) -> bool:
    """Whether the objectives of a search are those of the problem at designs (b, m, g)."""
    if working is problem:
        return True
    whole, part = (DesignPopulation(each).objectives(designs)[0] for each in (problem, working))
    return bool((np.abs(whole - part) <= _AGREEMENT * np.abs(whole)).all())


def _require_finite(problem: DesignProblem, designs: FloatArray) -> None:
    """Raise where an objective is finite at none of the designs (b, m, g) that identify everything."""
    assessment = problem.assess(*problem.space.decode(designs))
    regular = assessment.differentiable
    for criterion in problem.objectives:
        values = criterion_values(criterion, assessment)
        if regular.any() and not np.isfinite(values[regular]).any():
            what = (
                f"the criterion `{criterion.name}` is not finite at any of {int(regular.sum())} random designs that "
                f"identify everything ({values[regular][0]:g} at the first)"
            )
            remedy = "Correct its `values`, or leave it out of `objectives`."
            raise InputError(what, where=f"{problem.source}, objectives", remedy=remedy)


class _Known:
    """The best front met so far, for reports, and the reference point of its hypervolume.

    `ended` says whether somebody who was reported to wants no more.
    """

    def __init__(self, generations: int, report: Follow) -> None:
        self.generation, self.ended = 0, False
        self.point: FloatArray | None = None
        self._generations, self._report = generations, report
        self._best: FloatArray | None = None

    def add(self, values: FloatArray, violations: FloatArray, note: str = "") -> None:
        """Take designs into account, objectives (d, k) and constraints (d, c), and report."""
        values = values[(violations <= 0.0).all(axis=1)]
        if len(values) == 0:
            return
        if self.point is None:
            self.point = reference_point(values)
        values = values if self._best is None else np.concatenate([self._best, values])
        self._best = values[non_dominated(values)]
        volume = hypervolume(self._best, self.point)
        wanted = self._report(Progress(self.generation, self._generations, self._best, volume, note))
        self.ended = self.ended or bool(wanted)


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
    total = criterion_values(known_criteria()["total"], problem.assess(*problem.space.decode(genes[order])))
    marked = [int(np.argmin(total)), knee(values[order])]
    order = order[spread(values[order], marked, problem.optimiser.population)]
    criteria = all_criteria(problem, genes[order])
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


def all_criteria(problem: DesignProblem, genes: FloatArray) -> dict[str, FloatArray]:
    """Every known criterion, and further ones of the problem, of designs (b, m, g), shape (b,) each."""
    assessment = problem.assess(*problem.space.decode(genes))
    known = {**known_criteria(), **{criterion.name: criterion for criterion in problem.further}}
    return {name: criterion_values(criterion, assessment) for name, criterion in known.items()}
