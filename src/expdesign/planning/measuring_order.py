"""The order in which a plan is measured: the shortest way through its poses and loads (a travelling-salesman path).

What has to stay together is one stop: in deflections everything measured at one pose, which begins without load; in
absolute poses one pose with one load. The cost of going from one stop to another is the same in both directions. Up to
`EXACT` stops the best path is found by dynamic programming over the sets of stops visited (Held and Karp, J. SIAM 10
(1962) 196); beyond, nearest neighbours from every stop and exchanges of two edges (2-opt, Croes, Oper. Res. 6 (1958)
791) and moves of single stops until none shortens the path.
"""

import numpy as np

from expdesign.arrays import FloatArray

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
