"""The search for the Pareto front: exact gradients, NSGA-II on whole populations (theory.md 6), gradients again.

Gradients from the designs of the convex relaxation find most of the front in a few seconds. The genetic search, from
designs at random, finds the valleys that they missed. What both found is then refined together.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import criterion_values, known_criteria
from expdesign.design.front import Front, drawn_with, hypervolume, knee, non_dominated, reference_point, spread
from expdesign.design.operators import CanonicalOrder, DesignCrossover, DesignMutation
from expdesign.design.optimality.enumeration import every_design
from expdesign.design.optimality.kktpm import kktpm
from expdesign.design.optimality.polish import GAIN, Polishing
from expdesign.design.optimality.repetitions import repeated_designs
from expdesign.design.optimality.seeds import relaxed_designs
from expdesign.design.parts import Executor, one_after_another
from expdesign.design.problem import DesignProblem
from expdesign.design.pymoo_problem import DesignPopulation
from expdesign.design.start import require_identifiable, starting_designs
from expdesign.errors import InfeasibleError, InputError

_REVIEW = 20
"""Generations after which objectives that look at a part of what counts are checked against the whole."""
_PATIENCE = 8
"""Generations without a gain after which the genetic search ends where gradients have found a front."""
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


def search(
    problem: DesignProblem, report: Follow = lambda progress: None, executor: Executor = one_after_another
) -> Front:
    """The Pareto front of the problem's objectives.

    The same problem and seed give the same front, bit for bit, whatever executes it, unless `report` ends the search.

    Raises:
        InfeasibleError: no pose is within the robot's limits.
        NotIdentifiableError: no design identifies what the targets need.
        InputError: `report` ended the search before any design was known.
    """
    settings, space = problem.optimiser, problem.space
    generator = np.random.default_rng(settings.seed)
    population = DesignPopulation(problem)
    if space.decisions == 0:
        only = np.zeros((1, space.measurements, 0))
        starting_designs(problem, 1, generator)
        require_identifiable(problem, only)
        values, violations = population.objectives(only)
        return _front(problem, only, values, violations, reference_point(values), 1, 0.0)
    start = starting_designs(problem, settings.population, generator)
    require_identifiable(problem, population.decisions(start))
    # Exact gradients are of estimators without redundant parameters.
    polished = settings.polish and not problem.loaded.regressor.redundant
    known = _Known(settings.generations, report)
    first = population.decisions(start)
    working = problem.working(first)
    population = DesignPopulation(working)
    _require_finite(problem, first)
    known.add(*population.objectives(first))
    polishing = Polishing(working, executor=executor)
    if polished:
        for note in _coarse(polishing, first):
            known.add_front(polishing.front, note)
            if known.ended:
                break
        population.design_problem = polishing.problem
    decisions = _genetic(population, start, polishing, known)
    if polished:
        for again in range(0 if known.ended else _REFINEMENTS):
            for note in _corrected(polishing) if again else _fine(polishing, decisions):
                known.add_front(polishing.front, note)
                if known.ended:
                    break
            if known.ended or len(polishing.pool) == 0 or _agree(problem, polishing.problem, polishing.pool):
                break
        # What the refinement left out as rough, the others would bring back.
        whole = len(polishing.pool) > 0 and not known.ended
        decisions = polishing.pool if whole else np.concatenate([decisions, polishing.pool])
    if known.ended and known.point is None:
        what = "the search was ended before any plan was known"
        raise InputError(what, where=problem.source, remedy="Give it more time.")
    decisions = problem.settable(decisions)
    values, violations = DesignPopulation(problem).objectives(decisions)
    missing = polishing.missing() if polished and len(polishing.pool) else None
    return _front(problem, decisions, values, violations, known.point, population.evaluations, missing)


def _coarse(polishing: Polishing, first: FloatArray) -> Iterator[str]:
    """Where the front lies, by exact gradients and exchanges; what was done, in words, after each step."""
    every = every_design(polishing.problem)
    polishing.take(np.concatenate([first, relaxed_designs(polishing.problem), repeated_designs(polishing.problem)]))
    yield "designs of the convex relaxation"
    if every is not None:
        polishing.take(every)
        polishing.complete = True
        yield "every design there is"
        return
    if len(polishing.pool) == 0:
        return
    polishing.valleys()
    yield f"descents from random designs: {len(polishing.pool)} designs"
    polishing.along()
    polishing.review()
    yield "gradients along the front"
    for number, _ in enumerate(polishing.exchanges(), start=1):
        yield f"exchanges, round {number}: {len(polishing.pool)} designs"
    polishing.review()


def _fine(polishing: Polishing, decisions: FloatArray) -> Iterator[str]:
    """The front followed to the end, with what the genetic search found."""
    if polishing.complete:
        return
    if polishing.descend(decisions) > GAIN:
        yield "gradients from the genetic search's designs"
        for number, _ in enumerate(polishing.exchanges(), start=1):
            yield f"further exchanges, round {number}: {len(polishing.pool)} designs"
    polishing.review()
    for number, _ in enumerate(polishing.finish(), start=1):
        yield f"refinement, round {number}: {len(polishing.pool)} designs"


def _corrected(polishing: Polishing) -> Iterator[str]:
    """Designs at which the objectives turned out not to be right, refined by right ones."""
    polishing.review()
    polishing.settle()
    yield f"checked: {len(polishing.pool)} designs"


def _genetic(population: DesignPopulation, start: FloatArray, polishing: Polishing, known: "_Known") -> FloatArray:
    """Designs (b, m, g) of NSGA-II from a start (b, m·g) and from the pool of a refinement; where it adds nothing to
    that, it ends early.
    """
    pool, known_values = polishing.pool, polishing.front
    problem = population.design_problem
    space, settings = problem.space, problem.optimiser
    # Half of what is known, evenly along the front, and designs at random.
    known_designs = pool[spread(known_values, [], settings.population // 2)] if len(pool) else pool
    start = np.concatenate([known_designs.reshape(-1, start.shape[1]), start])[: settings.population]
    algorithm = NSGA2(
        pop_size=settings.population,
        sampling=Population.new(X=np.unique(start, axis=0)),
        crossover=DesignCrossover(space),
        mutation=DesignMutation(space, merge=problem.noise.shared_reference or space.most_poses is not None),
        repair=CanonicalOrder(space),
        evaluator=Evaluator(),
    )
    algorithm.setup(population, termination=("n_gen", settings.generations), seed=settings.seed)
    volume, stale = known.volume, 0
    if known.ended and len(pool):
        return pool
    while algorithm.has_next():
        algorithm.next()
        known.generation += 1
        if known.generation % _REVIEW == 0:
            _review(population, algorithm.pop)
        known.add(algorithm.pop.get("F"), algorithm.pop.get("G"))
        if known.ended:
            break
        if len(pool):
            stale = 0 if known.volume > (1.0 + GAIN) * volume else stale + 1
            volume = max(volume, known.volume)
            if stale == _PATIENCE:
                break
    return problem.settable(population.decisions(algorithm.pop.get("X").astype(float)))


def _review(population: DesignPopulation, designs: Population) -> None:
    """Go on with objectives that are right at these designs, which are evaluated again where they change."""
    decisions = population.decisions(designs.get("X").astype(float))
    working = population.design_problem.working(decisions)
    if working is not population.design_problem:
        population.design_problem = working
        values, violations = population.objectives(decisions)
        designs.set("F", values, "G", violations)


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
        self.volume = 0.0
        self._generations, self._report = generations, report
        self._best: FloatArray | None = None

    def add(self, values: FloatArray, violations: FloatArray, note: str = "") -> None:
        """Take designs into account, objectives (d, k) and constraints (d, c), and report."""
        values = values[(violations <= 0.0).all(axis=1)]
        if len(values) == 0:
            if self.point is None:
                self._ask(values, note)
            return
        if self.point is None:
            self.point = reference_point(values)
        values = values if self._best is None else np.concatenate([self._best, values])
        self._best = values[non_dominated(values)]
        self.volume = hypervolume(self._best, self.point)
        self._ask(self._best, note)

    def _ask(self, front: FloatArray, note: str) -> None:
        wanted = self._report(Progress(self.generation, self._generations, front, self.volume, note))
        self.ended = self.ended or bool(wanted)

    def add_front(self, values: FloatArray, note: str) -> None:
        """Take feasible designs into account."""
        self.add(values, np.zeros((len(values), 1)), note)


def _front(
    problem: DesignProblem,
    decisions: FloatArray,
    values: FloatArray,
    violations: FloatArray,
    point: FloatArray | None,
    evaluations: int,
    missing: float | None = None,
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
    total = criterion_values(known_criteria()["total"], problem.assess(*problem.space.decode(decisions[order])))
    marked = [int(np.argmin(total)), knee(values[order])]
    count = problem.optimiser.population
    order = order[spread(values[order], marked, count if missing is None else drawn_with(values[order], count))]
    criteria = all_criteria(problem, decisions[order])
    return Front(
        decisions=decisions[order],
        criteria=criteria,
        objectives=tuple(criterion.name for criterion in problem.objectives),
        recommended=int(np.argmin(criteria["total"])),
        knee=knee(values[order]),
        kktpm=kktpm(problem, decisions[order]),
        hypervolume=hypervolume(values[order], point),
        reference_point=point,
        evaluations=evaluations,
        missing=missing,
    )


def joined(problem: DesignProblem, front: Front, designs: Sequence[FloatArray | None]) -> Front:
    """A front with further designs (m, g), as far as there are any and none of the others dominates them."""
    further = [design for design in designs if design is not None]
    if not further:
        return front
    decisions = np.concatenate([front.decisions, np.stack(further)])
    population = DesignPopulation(problem)
    values, violations = population.objectives(decisions)
    evaluations = front.evaluations + len(further)
    return _front(problem, decisions, values, violations, front.reference_point, evaluations, front.missing)


def all_criteria(problem: DesignProblem, decisions: FloatArray) -> dict[str, FloatArray]:
    """Every known criterion, and further ones of the problem, of designs (b, m, g), shape (b,) each."""
    assessment = problem.assess(*problem.space.decode(decisions))
    known = {**known_criteria(), **{criterion.name: criterion for criterion in problem.further}}
    return {name: criterion_values(criterion, assessment) for name, criterion in known.items()}
