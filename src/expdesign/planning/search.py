"""The search for the Pareto front, which can be asked for what it has at any moment (theory.md 6).

A front is followed by predictions between its designs, of which those in the widest gaps alone are corrected. What is
written is pursued at last to where the optimality conditions hold; a design that is still rough then is left out where
the front can do without it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.errors import InfeasibleError, InputError
from expdesign.planning.criteria.criterion import Criterion, criterion_values, known_criteria
from expdesign.planning.evolution import Evolution, evolution, expected_gain
from expdesign.planning.front import (
    Front,
    drawn_with,
    gap_shares,
    hypervolume,
    knee,
    non_dominated,
    reference_point,
    spread,
)
from expdesign.planning.operators.operator import State
from expdesign.planning.optimality.kktpm import kktpm
from expdesign.planning.optimality.objectives import Pace, descended
from expdesign.planning.problem import DesignProblem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.sampling import require_identifiable, starting_designs
from expdesign.planning.scalarisation import at_points, spans
from expdesign.planning.start import every_design, relaxed_designs, repeated_designs, structured_designs


@dataclass(frozen=True)
class Progress:
    """State of the search.

    Attributes:
        generation: of the search, from 0.
        generations: how many there will be at most, where the configuration says so, else 0.
        front: objectives (d, k), minimised, of the best designs so far.
        hypervolume: of that front.
        note: what was done last.
    """

    generation: int
    generations: int
    front: FloatArray
    hypervolume: float
    note: str = ""


Follow = Callable[[Progress], bool | None]
"""Called with the state of a search; returns True to end it with the designs that are there."""


def search(problem: DesignProblem, report: Follow = lambda progress: None, start: FloatArray | None = None) -> Front:
    """The Pareto front of the problem's objectives.

    The same problem and seed give the same front, bit for bit, unless `report` ends the search.

    Args:
        problem: what can be measured, and by which criteria designs are judged.
        report: called after every generation.
        start: designs (d, m, g) that are known, for the first generation.

    Raises:
        InfeasibleError: no pose is within the robot's limits.
        NotIdentifiableError: no design identifies what the targets need.
        InputError: `report` ended the search before any design was known.
    """
    drawn = _drawn(problem)
    if problem.space.decisions == 0:
        return _front(problem, drawn[:1], DesignPopulation(problem), None, 0.0)
    found = evolution(DesignPopulation(problem), drawn if start is None else np.concatenate([drawn, start]))
    course = _Course(problem.optimiser.generations or 0, report)
    complete = _first_generation(found, course)
    while not complete and not course.ended and found.has_next():
        found.next()
        course.add(found, found.operators[found.asked].name)
    if course.point is None and course.ended:
        what = "the search was ended before any plan was known"
        raise InputError(what, where=problem.source, remedy="Give it more time.")
    missing, archive = 0.0 if complete else _missing(found), found.state.archive
    if not complete and not course.ended:
        settle(found.state, archive.designs[_chosen(problem, archive.values, len(problem.objectives))])
    return _front(problem, archive.designs, DesignPopulation(problem), course.point, missing, found)


def begun(problem: DesignProblem) -> Evolution:
    """A search after its first generation, for whoever wants to go on with it as he likes (`benchmarks`)."""
    found = evolution(DesignPopulation(problem), _drawn(problem))
    _first_generation(found, _Course(0, lambda progress: None))
    return found


def _drawn(problem: DesignProblem) -> FloatArray:
    """Designs (b, m, g) at random, of which some identify what the targets need, with finite objectives."""
    settings, space = problem.optimiser, problem.space
    drawn = starting_designs(problem, settings.population, np.random.default_rng(settings.seed))
    require_identifiable(problem, drawn)
    if space.decisions:
        _require_finite(problem, drawn)
    return drawn


def search_single(
    problem: DesignProblem,
    criterion: Criterion,
    *,
    seed: int,
    generations: int | None = None,
    start: FloatArray | None = None,
) -> Front:
    """The design that is best by one criterion, as a front; the problem's own objectives do not count.

    Args:
        problem: what can be measured.
        criterion: the only objective.
        seed: of the search.
        generations: at most; the problem's setting where left out.
        start: designs (d, m, g) that are known.
    """
    options = replace(problem.optimiser, seed=seed, generations=generations or problem.optimiser.generations)
    return search(replace(problem, objectives=(criterion,), optimiser=options), start=start)


def _first_generation(found: Evolution, course: "_Course") -> bool:
    """Designs at random, then roundings of the convex relaxation; whether they are all designs that there are."""
    problem = found.state.problem
    found.next()
    course.add(found, "random designs")
    if course.ended:
        return False
    every = every_design(problem)
    if every is not None:
        found.take(every)
        course.add(found, "every design there is")
        return True
    first = relaxed_designs(problem), repeated_designs(problem), structured_designs(problem)
    found.take(np.concatenate(first))
    course.add(found, "designs of the convex relaxation")
    return False


def _missing(found: Evolution) -> float:
    """Estimated share of the hypervolume that the front lacks: in the gaps between its designs, and what the search
    would have brought in a further second.
    """
    front, gaps = found.state.archive.front, 0.0
    front = front[non_dominated(front)] if len(front) else front
    if front.shape[1] == 2 and not found.state.problem.space.discrete.all():
        gaps = float(gap_shares(front[np.argsort(front[:, 0])]).sum())
    gain = expected_gain(found.history_of_work, len(found.operators))
    return min(1.0, gaps + gain)


def _require_finite(problem: DesignProblem, designs: FloatArray) -> None:
    """Raise where an objective is finite at none of the designs (b, m, g) that identify everything."""
    assessment = problem.assessed(designs)
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


class _Course:
    """What is reported: the front so far, and its hypervolume with respect to a point that stays.

    `ended` says whether somebody who was reported to wants no more.
    """

    def __init__(self, generations: int, report: Follow) -> None:
        self.ended, self.volume = False, 0.0
        self.point: FloatArray | None = None
        self._generations, self._report, self._generation = generations, report, -1

    def add(self, found: Evolution, note: str) -> None:
        """Report what a search knows."""
        self._generation = len(found.history_of_work)
        archive = found.state.archive
        front = archive.front[non_dominated(archive.front)] if len(archive) else archive.front
        if self.point is None and len(front):
            feasible = (found.pop.get("G") <= 0.0).all(axis=1)
            self.point = reference_point(found.pop.get("F").astype(float)[feasible])
        if self.point is not None:
            self.volume = max(self.volume, hypervolume(front, self.point))
        wanted = self._report(Progress(self._generation, self._generations, front, self.volume, note))
        self.ended = self.ended or bool(wanted)


def _front(
    problem: DesignProblem,
    decisions: FloatArray,
    population: DesignPopulation,
    point: FloatArray | None,
    missing: float,
    found: Evolution | None = None,
) -> Front:
    """What is kept of designs (d, m, g)."""
    evaluations = found.state.population.evaluations if found else 1
    values, violations = population.criteria(decisions)
    objectives = values[:, : len(problem.objectives)]
    feasible = np.flatnonzero((violations <= 0.0).all(axis=1))
    if feasible.size == 0:
        raise InfeasibleError(
            "the search met no design within the robot's limits that identifies what the targets need",
            where=problem.source,
            remedy="Widen `experiment.poses` or the loads, or allow more measurements.",
        )
    point = reference_point(objectives[feasible]) if point is None else point
    order = feasible[_chosen(problem, values[feasible], len(problem.objectives))]
    criteria = all_criteria(problem, decisions[order])
    return Front(
        decisions=decisions[order],
        criteria=criteria,
        objectives=tuple(criterion.name for criterion in problem.objectives),
        recommended=int(np.argmin(criteria["total"])),
        knee=knee(objectives[order]),
        kktpm=kktpm(problem, decisions[order]),
        hypervolume=hypervolume(objectives[order], point),
        reference_point=point,
        evaluations=evaluations,
        missing=missing,
    )


def _chosen(problem: DesignProblem, values: FloatArray, count: int) -> IntArray:
    """Indices of the designs that make the front, by their first `count` criteria (d, k), of which the last is `total`
    or stands for it; by rising first criterion.
    """
    options, front = problem.optimiser, values[:, :count]
    best = non_dominated(front)
    order = best[np.lexsort(front[best].T[::-1])]
    names = [criterion.name for criterion in problem.objectives]
    total = values[order, names.index("total") if "total" in names else -1]
    marked = [int(np.argmin(total)), knee(front[order])]
    number = drawn_with(front[order], options.population, options.gap, options.most_designs)
    found: IntArray = order[spread(front[order], marked, number)]
    return found


def all_criteria(problem: DesignProblem, decisions: FloatArray) -> dict[str, FloatArray]:
    """Every known criterion, and further ones of the problem, of designs (b, m, g), shape (b,) each."""
    assessment = problem.assessed(decisions)
    known = {**known_criteria(), **{criterion.name: criterion for criterion in problem.further}}
    return {name: criterion_values(criterion, assessment) for name, criterion in known.items()}


_PACE = Pace(steps=30, tolerance=1e-8, inner=1e-7)


def settle(state: State, chosen: FloatArray) -> None:
    """Pursue those of designs (d, m, g) that do not satisfy the optimality conditions to the end, in the archive."""
    space, archive = state.problem.space, state.archive
    # In coarse steps, or held by other constraints, an optimum does not satisfy the conditions of a continuous one.
    coarse = bool((space.grid.steps > state.options.settled * (space.upper - space.lower)).any())
    if not state.smooth or coarse or state.problem.constraints is not None or len(chosen) == 0:
        return
    proximity = kktpm(state.problem, chosen)
    rough = chosen[~(proximity <= state.options.settled)]
    if len(rough) == 0 or np.isnan(proximity).all():
        return
    values, _ = state.population.criteria(rough)
    aims = at_points(values[:, : archive.objectives], spans(archive.values)[: archive.objectives], values.shape[1])
    found, _ = descended(state.objectives, rough, aims, _PACE)
    archive.add(*state.evaluated(found))
    known = {design.tobytes(): place for place, design in enumerate(archive.designs)}
    left = [known[design.tobytes()] for design in rough if design.tobytes() in known]
    ends = set(np.argmin(archive.values, axis=0).tolist())
    drop: BoolArray = np.zeros(len(archive), dtype=bool)
    drop[[place for place in left if place not in ends]] = True
    if not drop.all():
        archive.designs, archive.values = archive.designs[~drop], archive.values[~drop]
