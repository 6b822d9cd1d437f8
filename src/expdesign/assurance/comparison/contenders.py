"""The designs that are compared: the best by each criterion alone, random ones, and plans that are given."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import planned
from expdesign.planning.sampling import starting_designs
from expdesign.planning.search import search_single
from expdesign.planning.start import first_designs

Origin = Literal["optimised", "random", "given"]
Each = Callable[[Callable[..., Any], Sequence[tuple[Any, ...]]], Iterable[tuple[int, Any]]]
"""Index and result of `work(problem, *arguments)` for each of many arguments, in the order in which they are done."""
_RANDOM_STREAM = 7
"""Keeps the random designs apart from the searches' numbers of the same seed."""
_BRIEF = 3
"""Generations of a first search: each operator is asked once."""


@dataclass(frozen=True)
class Contender:
    """A design with its name and where it comes from."""

    name: str
    origin: Origin
    plan: Plan


def optimised(
    problem: DesignProblem,
    seed: int,
    generations: int | None,
    report: Callable[[str], None] = lambda text: None,
    each: Each | None = None,
) -> list[Contender]:
    """The best design by each known criterion alone, as its own author would have chosen it.

    Every criterion is searched by itself for one turn from the same first designs, and to its end from what all these
    searches found: a design that was sought by one criterion often lies in a better valley of another. Of all designs
    that were found, each criterion has the best. Criteria that are the same (DUIR and `total` without load errors) are
    searched once, and one that no design changes not at all. `each` does the searches of either kind, which do not need
    each other.

    Raises:
        InfeasibleError: no design within the limits was found.
        NotIdentifiableError: no design identifies what the targets need.
    """
    criteria, each = problem.criteria, each or here(problem)
    names = distinct_criteria(problem, seed)
    first = first_designs(replace(problem, optimiser=problem.optimiser.with_values(seed=seed)))
    brief = min(generations or problem.optimiser.generations or _BRIEF, _BRIEF)
    found = dict(each(_searched, [(name, seed, brief, first) for name in names]))
    report("searched")
    decisions = np.unique(np.concatenate([found[index] for index in range(len(names))]), axis=0)
    jobs = [(name, seed, generations, decisions) for name in names]
    better = {}
    for index, genes in each(_searched, jobs):
        better[index] = genes
        report(names[index])
    for name in criteria:
        if name not in names:
            report(name)
    designs = np.concatenate([decisions, *(better[index] for index in range(len(names)))])
    plans = [planned(problem, one) for one in designs]
    assessment = problem.assessed(designs)
    best = []
    for name, criterion in criteria.items():
        values = criterion.values(assessment) * (-1.0 if criterion.maximise else 1.0)
        best.append(Contender(name, "optimised", plans[int(np.nanargmin(values))]))
    return best


def here(problem: DesignProblem) -> Each:
    """One after another."""
    return lambda work, arguments: ((index, work(problem, *one)) for index, one in enumerate(arguments))


def _searched(problem: DesignProblem, name: str, seed: int, generations: int | None, start: FloatArray) -> FloatArray:
    """Genes (1, m, g) of the best design that the search by a criterion finds."""
    criterion = problem.criteria[name]
    return search_single(problem, criterion, seed=seed, generations=generations, start=start).decisions[:1]


def distinct_criteria(problem: DesignProblem, seed: int) -> list[str]:
    """Criteria that order designs, without those that are another one to within rounding, by designs at random."""
    assessment = problem.assessed(_random(problem, 8, seed))
    kept: dict[str, FloatArray] = {}
    for name, criterion in problem.criteria.items():
        values = criterion.values(assessment)
        varies = not np.allclose(values, values[0], rtol=1e-12, atol=0.0)
        if varies and not any(np.allclose(values, other, rtol=1e-12, atol=0.0) for other in kept.values()):
            kept[name] = values
    return list(kept) or list(problem.criteria)[:1]


def drawn(problem: DesignProblem, count: int, seed: int) -> list[Contender]:
    """Random designs of measurements within the robot's limits."""
    designs = enumerate(_random(problem, count, seed), start=1)
    return [Contender(f"random {index}", "random", planned(problem, one)) for index, one in designs]


def _random(problem: DesignProblem, count: int, seed: int) -> FloatArray:
    """Their decisions, shape (count, m, g)."""
    return starting_designs(problem, count, np.random.default_rng([seed, _RANDOM_STREAM]))
