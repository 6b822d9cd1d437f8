"""The search for the Pareto front, which can be ended at any moment with what it has (theory.md 15).

Random designs come first, then roundings of the convex relaxation; `loop.py` improves on them. What is written is
pursued at last to where the optimality conditions hold; a design that is still rough then is left out where the front
can do without it.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.callback import Callback
from pymoo.core.duplicate import DefaultDuplicateElimination
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population

from expdesign.arrays import FloatArray, IntArray
from expdesign.errors import InfeasibleError, InputError
from expdesign.planning.criteria.criterion import Criterion, criterion_values
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
from expdesign.planning.loop import InTurn, LittleGain, Settable
from expdesign.planning.operators.archive import Archive
from expdesign.planning.operators.children import Children
from expdesign.planning.operators.descent import FrontDescent
from expdesign.planning.operators.exchange import SingleExchange
from expdesign.planning.operators.repetitions import RepeatedPlans, repetitions_count
from expdesign.planning.operators.state import Operator, State
from expdesign.planning.operators.structures import Restarts
from expdesign.planning.optimality.kktpm import kktpm
from expdesign.planning.optimality.objectives import Pace, descended
from expdesign.planning.problem import DesignProblem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.sampling import require_identifiable, starting_designs
from expdesign.planning.scalarisation import at_points, spans
from expdesign.planning.schema import Effort
from expdesign.planning.start import every_design, first_designs

_EXPECTED_GAIN: dict[Effort, float] = {"quick": 5e-3, "normal": 1e-3, "thorough": 1e-4}
"""Share of the hypervolume (or ten times that of `total`) that a further turn of all operators has to bring."""
_GAP, _MOST_DESIGNS = 1e-3, 250
"""Share of the hypervolume in the gaps between neighbours at which a front counts as drawn; designs of one at most."""
_SETTLED = 1e-4
"""KKT proximity below which a design is not descended from again (Deb & Abouhawwash 2016)."""


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
MOST_GENERATIONS = 2000
"""Where the configuration names no number, so that every search ends."""
BY_HAND = "it was ended by hand"


class _EndedError(Exception):
    """The search has no more time."""


def search(
    problem: DesignProblem,
    report: Follow = lambda progress: None,
    start: FloatArray | None = None,
    ended: Callable[[], str] = lambda: "",
) -> Front:
    """The Pareto front of the problem's objectives.

    The same problem and seed give the same front, bit for bit, unless `report` or `ended` ends the search.

    Args:
        problem: what can be measured, and by which criteria designs are judged.
        report: called after every generation.
        start: designs (d, m, g) that are known, instead of those of the relaxation (`first_designs`).
        ended: why the search is to end now, in words; empty to go on. Asked before every evaluation, once a design is
            known.

    Raises:
        InfeasibleError: no pose is within the robot's limits.
        NotIdentifiableError: no design identifies what the targets need.
        InputError: the search was ended before any design was known.
    """
    if problem.space.decisions == 0:
        drawn = starting_designs(problem, 1, np.random.default_rng(problem.optimiser.seed))
        require_identifiable(problem, drawn)
        return _front(problem, _evaluated_alone(problem, drawn), None, "nothing is to be chosen", 0.0)
    course = _Course(problem, report, ended)
    population = DesignPopulation(replace(problem, interrupt=course.go_on))
    archive, missing = population.archive, 0.0
    course.archive = archive
    try:
        missing = _searched(population, course, start)
    except _EndedError:
        missing = _gaps(problem, archive)
    if not len(archive):
        what = "the search was ended before any plan was known"
        raise InputError(what, where=problem.source, remedy="Give it more time.")
    if not course.ended and missing > 0.0:
        with suppress(_EndedError):  # what is there is written
            settle(population, archive.designs[_chosen(problem, archive.values, len(problem.objectives))])
    found = _front(problem, population, course.point, course.why, missing)
    return replace(found, complete=course.complete)


def _searched(population: DesignPopulation, course: "_Course", start: FloatArray | None) -> float:
    """Search until it ends by itself; the estimated share of the hypervolume that the front lacks."""
    problem, archive = population.design_problem, population.archive
    options, evaluator = problem.optimiser, Evaluator()
    drawn = starting_designs(problem, options.population, np.random.default_rng(options.seed))
    sampled = _evaluated(population, evaluator, drawn)
    if not len(archive):
        require_identifiable(problem, drawn)
        _require_finite(problem, drawn)
    archive.brought()
    course.point = reference_point(archive.front) if len(archive) else None
    feasible = (sampled.get("G") <= 0.0).all(axis=1)
    if feasible.any():
        course.point = reference_point(sampled.get("F").astype(float)[feasible])
    course.add("random designs")
    every = every_design(problem)
    if every is not None:
        population.criteria(every)
        course.add("every design there is")
        course.why, course.complete = "every design was evaluated", True
        return 0.0
    relaxed = _evaluated(population, evaluator, first_designs(problem) if start is None else start)
    state = State(population, np.random.default_rng([options.seed, 1]))
    for made in (sampled, relaxed):  # the better ones last, so that their measurements are offered first
        _learn(state, made)
    if not len(archive):
        raise _none_found(problem)
    mating = InTurn(
        state, operators_of(state), repair=Settable(problem), eliminate_duplicates=DefaultDuplicateElimination()
    )
    most = options.generations or MOST_GENERATIONS
    termination = LittleGain(archive, mating, _EXPECTED_GAIN[options.effort], most)
    algorithm = NSGA2(
        pop_size=options.population,
        sampling=Population.merge(sampled, relaxed),
        mating=mating,
        repair=Settable(problem),
        evaluator=evaluator,
        callback=_Learn(state, course, mating, termination),
    )
    algorithm.setup(population, termination=termination, seed=options.seed)
    while algorithm.has_next():
        algorithm.next()
    course.why = termination.why
    return min(1.0, _gaps(problem, archive) + mating.expected)


def operators_of(state: State) -> list[Operator]:
    """The operators that have anything to do in a problem."""
    problem = state.problem
    found: list[Operator] = [SingleExchange(), Children()]
    if repetitions_count(state):
        found.append(RepeatedPlans())
    if state.sums and problem.budget is not None:
        found.append(Restarts())
    if state.smooth:
        found.append(FrontDescent())
    return found


def _evaluated(population: DesignPopulation, evaluator: Evaluator, designs: FloatArray) -> Population:
    """Distinct ones of designs (b, m, g) as they can be set, evaluated."""
    made = Population.new(X=designs.reshape(len(designs), population.n_var))
    if len(made):
        made = DefaultDuplicateElimination().do(Settable(population.design_problem).do(population, made))
        evaluator.eval(population, made)
    return made


def _learn(state: State, made: Population) -> None:
    """Keep what is feasible of evaluated designs."""
    if len(made):
        feasible = (made.get("G") <= 0.0).all(axis=1)
        designs = state.population.decisions(made.get("X").astype(float))
        state.learn(designs[feasible], made.get("criteria").astype(float)[feasible])


class _Learn(Callback):  # type: ignore[misc]
    """After every generation: what was evaluated is learnt from, and reported."""

    def __init__(self, state: State, course: "_Course", mating: InTurn, termination: LittleGain) -> None:
        super().__init__()
        self._state, self._course, self._mating, self._termination = state, course, mating, termination

    def notify(self, algorithm: NSGA2) -> None:
        if self._mating.asked >= 0 and algorithm.off is not None:
            _learn(self._state, algorithm.off)
        self._course.add(self._mating.name, self._termination.generations)


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
        start: designs (d, m, g) that are known, instead of those of the relaxation (`first_designs`).
    """
    options = problem.optimiser.with_values(seed=seed, generations=generations or problem.optimiser.generations)
    return search(replace(problem, objectives=(criterion,), optimiser=options), start=start)


def _gaps(problem: DesignProblem, archive: Archive) -> float:
    """Estimated share of the hypervolume that a front of two objectives lacks in the gaps between its designs."""
    front = archive.front
    if front.shape[1] != 2 or problem.space.discrete.all():
        return 0.0
    return float(gap_shares(front[np.argsort(front[:, 0])]).sum())


def kept(problem: DesignProblem, decisions: FloatArray, front: Front) -> Front:
    """What is kept of designs (d, m, g) that were made of those of a front."""
    found = _front(problem, _evaluated_alone(problem, decisions), None, front.ended, front.missing or 0.0)
    return replace(found, evaluations=front.evaluations + len(decisions), missing=front.missing)


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

    Attributes:
        archive: of the search, once there is one.
        point: of the hypervolume.
        ended: whether somebody wants no more.
        why: the search ended, in words.
    """

    def __init__(self, problem: DesignProblem, report: Follow, ended: Callable[[], str]) -> None:
        self.archive: Archive | None = None
        self.point: FloatArray | None = None
        self.ended, self.complete, self.why, self._volume = False, False, "", 0.0
        self._generations, self._report, self._ended = problem.optimiser.generations or 0, report, ended

    def go_on(self) -> None:
        """Raise where a design is known and somebody wants no more."""
        if self.archive is not None and len(self.archive) and (why := self._ended()):
            self._end(why)

    def _end(self, why: str) -> None:
        self.ended, self.why = True, why
        raise _EndedError

    def add(self, note: str, generation: int = 0) -> None:
        """Report what a search knows."""
        assert self.archive is not None
        front = self.archive.front
        if self.point is None and len(front):
            self.point = reference_point(front)
        if self.point is not None:
            self._volume = max(self._volume, hypervolume(front, self.point))
        if self._report(Progress(generation, self._generations, front, self._volume, note)):
            self._end(self._ended() or BY_HAND)


def _evaluated_alone(problem: DesignProblem, decisions: FloatArray) -> DesignPopulation:
    """A population of nothing but some designs (d, m, g)."""
    population = DesignPopulation(problem)
    population.criteria(decisions)
    return population


def _front(
    problem: DesignProblem, population: DesignPopulation, point: FloatArray | None, why: str, missing: float
) -> Front:
    """What is kept of the designs that were evaluated; what a search knows of them is not computed again."""
    archive, wanted = population.archive, population.wanted
    if not len(archive):
        raise _none_found(problem)
    order = _chosen(problem, archive.values, archive.objectives)
    decisions, values = archive.designs[order], archive.values[order]
    objectives = values[:, : archive.objectives]
    point = reference_point(archive.values[:, : archive.objectives]) if point is None else point
    criteria = all_criteria(problem, decisions, wanted.plain(values))
    return Front(
        decisions=decisions,
        criteria=criteria,
        objectives=tuple(criterion.name for criterion in problem.objectives),
        recommended=int(np.argmin(criteria["total"])),
        knee=knee(objectives),
        kktpm=kktpm(problem, decisions),
        hypervolume=hypervolume(objectives, point),
        reference_point=point,
        evaluations=population.evaluations,
        missing=missing,
        ended=why,
    )


def _none_found(problem: DesignProblem) -> InfeasibleError:
    what = "the search met no design within the robot's limits that identifies what the targets need"
    remedy = "Widen `experiment.poses` or the loads, or allow more measurements."
    return InfeasibleError(what, where=problem.source, remedy=remedy)


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
    number = drawn_with(front[order], options.population, _GAP, _MOST_DESIGNS)
    found: IntArray = order[spread(front[order], marked, number)]
    return found


def all_criteria(
    problem: DesignProblem, decisions: FloatArray, given: Mapping[str, FloatArray] | None = None
) -> dict[str, FloatArray]:
    """Every known criterion, and further ones of the problem, of designs (b, m, g), shape (b,) each.

    Args:
        problem: by which they are judged.
        decisions: the designs.
        given: values that are known already, by names.
    """
    assessment, given = problem.assessed(decisions), given or {}
    return {
        name: given[name] if name in given else criterion_values(criterion, assessment)
        for name, criterion in problem.criteria.items()
    }


_PACE = Pace(steps=30, tolerance=1e-8, inner=1e-7)


def settle(population: DesignPopulation, chosen: FloatArray) -> None:
    """Pursue those of designs (d, m, g) that do not satisfy the optimality conditions to the end, in the archive."""
    problem, archive, objectives = population.design_problem, population.archive, population.wanted
    space, enough = problem.space, _SETTLED
    # In coarse steps, or held by other constraints, an optimum does not satisfy the conditions of a continuous one.
    coarse = bool((space.grid.steps > enough * (space.upper - space.lower)).any())
    smooth = objectives.smooth and problem.optimiser.polish
    if not smooth or coarse or problem.constraints is not None or len(chosen) == 0:
        return
    proximity = kktpm(problem, chosen)
    rough = chosen[~(proximity <= enough)]
    if len(rough) == 0 or np.isnan(proximity).all():
        return
    values, _ = population.criteria(rough)
    aims = at_points(values[:, : archive.objectives], spans(archive.values)[: archive.objectives], values.shape[1])
    population.criteria(problem.settable(descended(objectives, rough, aims, _PACE)))
    archive.leave_out(rough)
