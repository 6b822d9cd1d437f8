"""The search under a budget: which number of measurements, at how many poses, and then which measurements.

Each structure that the budget allows is searched briefly; the one that reaches the least total error is searched in
full.
"""

from dataclasses import replace

import numpy as np

from expdesign.design.budget import Structure
from expdesign.design.front import Front
from expdesign.design.parts import Executor, one_after_another
from expdesign.design.problem import DesignProblem
from expdesign.design.search import Follow, search
from expdesign.errors import ExpdesignError, InfeasibleError, NotIdentifiableError

TRIALS = 8
"""Structures that are tried; of more, so many are taken evenly."""
_POPULATION, _GENERATIONS = 12, 8


def search_within_budget(
    problem: DesignProblem, report: Follow = lambda progress: None, executor: Executor = one_after_another
) -> tuple[DesignProblem, Front]:
    """The Pareto front of the structure that serves the targets best, and the problem with that structure.

    Without a budget, the problem's own front. The same problem and seed give the same front.

    Raises:
        InfeasibleError: no structure has a design within the limits.
        NotIdentifiableError: no structure identifies what the targets need.
    """
    if problem.budget is None:
        return problem, search(problem, report, executor)
    structures = problem.budget.structures()
    if len(structures) > TRIALS:
        chosen = np.unique(np.linspace(0, len(structures) - 1, TRIALS).round().astype(int))
        structures = [structures[index] for index in chosen]
    best = structures[0] if len(structures) == 1 else _best(problem, structures)
    fitted = with_structure(problem, best)
    return fitted, search(fitted, report, executor)


def with_structure(problem: DesignProblem, structure: Structure) -> DesignProblem:
    """The problem with so many measurements at no more than so many distinct poses, said in its configuration too."""
    config = {**problem.config, "experiment": dict(problem.config["experiment"])}
    config["experiment"]["measurements"] = structure.measurements
    config["experiment"]["budget"] = {**config["experiment"]["budget"], "distinct_poses": structure.poses}
    space = problem.space.with_structure(structure.measurements, structure.poses)
    return replace(problem, space=space, config=config)


def _best(problem: DesignProblem, structures: list[Structure]) -> Structure:
    settings = problem.optimiser
    brief = replace(
        settings,
        population=min(_POPULATION, settings.population),
        generations=min(_GENERATIONS, settings.generations),
    )
    reached: list[tuple[float, int]] = []
    failure: ExpdesignError | None = None
    for index, structure in enumerate(structures):
        try:
            front = search(with_structure(replace(problem, optimiser=brief), structure))
        except (InfeasibleError, NotIdentifiableError) as error:
            failure = error
            continue
        reached.append((float(front.criteria["total"].min()), index))
    if not reached and failure is not None:
        raise failure
    return structures[min(reached)[1]]
