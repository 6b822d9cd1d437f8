"""What is done in the laboratory, step by step: a plan in the order that saves changes, with its unloaded references.

Deflections are differences to the unloaded platform at the same command (file-formats.md, Conventions). Where the noise
model has a shared reference it is measured once, at the beginning of a series; else before every loaded measurement,
which is what makes their noise independent. Absolute poses need none.

The order is the shortest way through poses and loads (a travelling-salesman path). What has to stay together is one
stop: in deflections everything measured at one pose, which begins without load; in absolute poses one pose with one
load. The cost of going from one stop to another is the same in both directions. Up to `EXACT` stops the best path is
found by dynamic programming over the sets of stops visited (Held and Karp, J. SIAM 10 (1962) 196); beyond, nearest
neighbours from every stop and exchanges of two edges (2-opt, Croes, Oper. Res. 6 (1958) 791) and moves of single stops
until none shortens the path.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.errors import InputError
from expdesign.planning.plan import Plan
from expdesign.planning.schema import CostsSection

TRAVEL = 1e-6
"""Weight of the way between two poses, in parts of the plan's ranges: it decides between orders of the same cost."""


@dataclass(frozen=True)
class Steps:
    """What is done, in order.

    Attributes:
        rows: row of the plan that each step belongs to, shape (s,).
        reference: steps without load, shape (s,).
        exact: whether no other order costs less.
        pose_changes: how often the pose is set.
        load_changes: how often the load is put on, changed or taken off.
    """

    rows: IntArray
    reference: IntArray
    exact: bool
    pose_changes: int
    load_changes: int

    def minutes(self, costs: CostsSection) -> float:
        """The time it takes."""
        return float(costs.minutes(self.pose_changes, self.load_changes, len(self.rows)))


def in_plan_order(plan: Plan, *, referenced: bool, shared: bool) -> Steps:
    """The steps of a plan row by row as it stands, with the references that it needs."""
    return _steps(plan, [list(range(len(plan)))], referenced=referenced, shared=shared, exact=False)


def ordered(plan: Plan, costs: CostsSection, *, referenced: bool, shared: bool, travel: bool = True) -> Steps:
    """The steps of a plan in the order that costs least.

    With deflections every order of the poses costs the same, and only the way between them decides.

    Args:
        plan: what is measured.
        costs: of changes; where none is stated they count alike.
        referenced: whether deflections are measured, which need references without load.
        shared: whether the measurements of a series share their reference.
        travel: whether the way between poses matters where costs are equal.

    Raises:
        InputError: a series mixes poses.
    """
    _require_one_pose(plan)
    _, pose = np.unique(plan.configurations, axis=0, return_inverse=True)
    _, load = np.unique(plan.loads, axis=0, return_inverse=True)
    key = np.stack([pose, np.zeros_like(load) if referenced else load], axis=1)
    groups = [np.flatnonzero((key == one).all(axis=1)) for one in dict.fromkeys(map(tuple, key.tolist()))]
    # Within a stop: series stay together, and equal loads follow each other.
    stops = [sorted(group.tolist(), key=lambda row: (plan.series[row], load[row], row)) for group in groups]
    first = np.array([stop[0] for stop in stops])
    path = list(range(len(stops)))
    if travel or not referenced:
        path = best_path(*_costs(plan, pose[first], load[first], first, costs, referenced=referenced))
    return _steps(plan, [stops[k] for k in path], referenced=referenced, shared=shared, exact=len(stops) <= EXACT)


def _costs(
    plan: Plan, pose: IntArray, load: IntArray, first: IntArray, costs: CostsSection, *, referenced: bool
) -> tuple[FloatArray, FloatArray]:
    """Cost between stops (n, n) and of going to each one first (n,)."""
    weights = (costs.pose_change, costs.mass_change) if costs.known else (1.0, 1.0)
    where = plan.configurations[first]
    span = np.ptp(where, axis=0)
    scaled = where / np.where(span > 0.0, span, 1.0)
    travel = np.abs(scaled[:, None] - scaled[None]).max(axis=-1)
    cost = weights[0] * (pose[:, None] != pose[None]) + TRAVEL * max(weights) * travel
    if not referenced:
        cost = cost + weights[1] * (load[:, None] != load[None])
    # Among equal ones the order of the plan is kept.
    return cost, weights[0] + (0.0 if referenced else weights[1]) + 1e-6 * TRAVEL * np.arange(len(first))


def _steps(plan: Plan, stops: list[list[int]], *, referenced: bool, shared: bool, exact: bool) -> Steps:
    rows: list[int] = []
    reference: list[bool] = []
    for stop in stops:
        last: int | None = None
        for row in stop:
            if referenced and not (shared and last == plan.series[row]):
                rows.append(row)
                reference.append(True)
            rows.append(row)
            reference.append(False)
            last = int(plan.series[row])
    poses = load_changes = 0
    before_pose: tuple[float, ...] | None = None
    before_load: tuple[float, ...] | None = None
    for row, empty in zip(rows, reference, strict=True):
        # Where series share references, each is a setting of its own.
        pose = (*plan.configurations[row].tolist(), float(plan.series[row]) if referenced and shared else 0.0)
        load = None if empty else tuple(plan.loads[row].tolist())
        poses += pose != before_pose
        load_changes += load != before_load
        before_pose, before_load = pose, load
    return Steps(np.array(rows), np.array(reference), exact, poses, load_changes)


def _require_one_pose(plan: Plan) -> None:
    _, first, index = np.unique(plan.series, return_index=True, return_inverse=True)
    other = np.flatnonzero(np.any(plan.configurations != plan.configurations[first[index]], axis=1))
    if other.size:
        what = f"series {plan.series[other[0]]} has measurements at different poses (measurement {other[0] + 1})"
        remedy = "Rows of one series share one command; give every pose a series of its own."
        raise InputError(what, where="plan, column series", remedy=remedy)


EXACT = 12
"""Stops up to which the path is the best one."""


def best_path(cost: FloatArray, start: FloatArray) -> list[int]:
    """An order of n stops of nearly (up to `EXACT`: exactly) least cost; it may end anywhere.

    Args:
        cost: of going between two stops, symmetric, shape (n, n).
        start: of going to each stop from where the robot is first, shape (n,).
    """
    if len(start) == 1:
        return [0]
    return _held_karp(cost, start) if len(start) <= EXACT else _improved_neighbours(cost, start)


def path_cost(order: list[int], cost: FloatArray, start: FloatArray) -> float:
    """Cost of visiting the stops in an order."""
    return float(start[order[0]] + cost[order[:-1], order[1:]].sum())


def _held_karp(cost: FloatArray, start: FloatArray) -> list[int]:
    count = len(start)
    best = np.full((1 << count, count), np.inf)
    before = np.full((1 << count, count), -1, dtype=np.int64)
    best[1 << np.arange(count), np.arange(count)] = start
    for visited in range(1, 1 << count):
        ends = [k for k in range(count) if visited >> k & 1]
        for new in (k for k in range(count) if not visited >> k & 1):
            ways = best[visited, ends] + cost[ends, new]
            least = int(np.argmin(ways))
            if ways[least] < best[visited | 1 << new, new]:
                best[visited | 1 << new, new] = ways[least]
                before[visited | 1 << new, new] = ends[least]
    visited, order = (1 << count) - 1, [int(np.argmin(best[-1]))]
    while (previous := int(before[visited, order[-1]])) >= 0:
        visited ^= 1 << order[-1]
        order.append(previous)
    return order[::-1]


def _improved_neighbours(cost: FloatArray, start: FloatArray) -> list[int]:
    paths = [_nearest(cost, first) for first in range(min(len(start), 20))]
    shortest = min(paths, key=lambda path: path_cost(path, cost, start))
    return _exchanged(shortest, cost, start)


def _nearest(cost: FloatArray, first: int) -> list[int]:
    order, left = [first], set(range(len(cost))) - {first}
    while left:
        order.append(min(left, key=lambda stop: (cost[order[-1], stop], stop)))
        left.remove(order[-1])
    return order


def _exchanged(order: list[int], cost: FloatArray, start: FloatArray) -> list[int]:
    """The path after all 2-opt exchanges and moves of single stops that shorten it."""
    best, improved = path_cost(order, cost, start), True
    while improved:
        improved = False
        for i in range(len(order)):
            for j in range(i + 1, len(order)):
                moved = [stop for k, stop in enumerate(order) if k != i]
                moved.insert(j, order[i])
                for other in ([*order[:i], *order[i : j + 1][::-1], *order[j + 1 :]], moved):
                    value = path_cost(other, cost, start)
                    if value < best - 1e-12:
                        order, best, improved = other, value, True
    return order
