"""What a plan leaves of a budget of time is spent on further readings of its own measurements.

The search chooses among as many measurements as fit with a load each. A reading more at a pose and a load that a
plan has takes the reading alone, or with a reference of its own the load's two changes as well. Which measurements are
read how often is a convex question where criteria are those of generalised least squares (theory.md 10.1): readings go
one by one where `total` falls most.
"""

from copy import copy
from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.counted import counted
from expdesign.planning.budget import LARGEST, Budget
from expdesign.planning.front import Front
from expdesign.planning.optimality.exchange import Exchange
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import design_minutes
from expdesign.planning.scalarisation import Aims
from expdesign.planning.search import kept


def spent(problem: DesignProblem, front: Front) -> tuple[DesignProblem, Front]:
    """The plans of a front with further readings, as far as the budget reaches, and the problem with room for them.

    They are the same where there is no budget, or where its time is spent.
    """
    budget, minutes = problem.budget, design_minutes(problem, front)
    if budget is None or minutes is None:
        return problem, front
    taken = problem.space.taken(front.decisions)
    least = taken.sum(axis=1)
    most = LARGEST if budget.most is None else budget.most
    left = np.floor((budget.minutes - minutes) / _reading(budget) + 1e-9).astype(np.int64)
    left = np.clip(left, 0, np.maximum(most - least, 0))
    if not left.any():
        return problem, front
    counts = _shared_out(problem, front.decisions, taken.astype(np.int64), left)
    further = copy(problem.space)
    further.measurements = max(int(counts.sum(axis=1).max()), problem.space.measurements)
    wider = replace(problem, space=further)
    plans = zip(front.decisions, counts, strict=True)
    designs = np.concatenate([_repeated(problem, *each, further.measurements) for each in plans])
    return wider, kept(wider, designs, front)


def what_ends(problem: DesignProblem, front: Front) -> str | None:
    """What keeps the recommended plan from having a reading more, as a sentence; None without a budget."""
    budget, minutes = problem.budget, design_minutes(problem, front)
    if budget is None or minutes is None:
        return None
    taken = float(minutes[front.recommended])
    count = int(problem.space.taken(front.decisions[front.recommended]).sum())
    said = (
        f"The plan of {counted(count, 'measurement')} takes {taken:.4g} of the {budget.minutes:.4g} min of the budget"
    )
    if count == budget.most:
        return f"{said}; it ends at `measurements`, the largest number allowed."
    if count == LARGEST:
        return f"{said}; it ends at {LARGEST} measurements, the most that are planned without `measurements`."
    more = f"; a further reading of a measurement takes {_reading(budget):.4g} min"
    return f"{said}{more if taken + _reading(budget) > budget.minutes + 1e-9 else ''}."


def _reading(budget: Budget) -> float:
    """Minutes that a reading more of a measurement takes."""
    if not budget.referenced or budget.shared:
        return max(float(budget.costs.minutes(0, 0, 1)), 1e-9)
    return max(float(budget.costs.minutes(0, 2, 2)), 1e-9)


def _repeated(problem: DesignProblem, design: FloatArray, counts: IntArray, room: int) -> FloatArray:
    """A design (1, room, g) with each measurement of one (m, g) so many times, and the rest of the room left out."""
    settings = problem.space.settings
    assert settings is not None
    rows = np.repeat(design, counts, axis=0)
    nothing = np.repeat(rows[:1], room - len(rows), axis=0)
    nothing[:, settings.gene] = 0.0
    return np.concatenate([rows, nothing])[None]


def _shared_out(problem: DesignProblem, designs: FloatArray, counts: IntArray, left: IntArray) -> IntArray:
    """How often each measurement of designs (b, m, g) is read, (b, m), with so many further readings (b,)."""
    exchange, aims, everyone = Exchange(problem, ("total",)), Aims.of_one(len(designs)), np.arange(len(designs))
    told, possible, counts = exchange.told(designs), counts > 0, counts.copy()
    for given in range(int(left.max())):
        once_more = exchange.with_one(told * counts[..., None, None], designs, designs, told)
        best = np.where(possible, exchange.distances(once_more, aims), np.inf).argmin(axis=1)
        counts[everyone, best] += given < left
    return counts
