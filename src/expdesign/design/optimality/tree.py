"""The tree of branch and bound over whole plans (Land & Doig 1960): best bound first, cuts shared by all nodes."""

from collections.abc import Callable
from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.design.optimality.outer_approximation import Master, Program

_WHOLE = 1e-6
_CUTS, _GAIN = 4, 1e-4
"""Programs at a node, and the relative rise of its bound that is worth another."""
_ROUNDINGS = 20


@dataclass(frozen=True)
class Outcome:
    """How far a tree got.

    Attributes:
        bound: what no plan goes below, the criterion squared.
        loose: a whole plan (J,) at which the cuts end below the criterion, which keeps the bound from rising; None
            where there is none.
        nodes: of the tree.
    """

    bound: float
    loose: FloatArray | None
    nodes: int


class Tree:
    """Branch and bound over the columns of a master program.

    Args:
        master: the columns and cuts.
        attempt: called with whole plans (J,); gives the least criterion squared of any plan known by then.
        gap: relative, of the criterion squared, at which it ends.
        generator: for roundings.
    """

    def __init__(
        self, master: Master, attempt: Callable[[FloatArray], float], gap: float, generator: np.random.Generator
    ) -> None:
        self._master, self._attempt, self._gap, self._generator = master, attempt, gap, generator
        self._tried: set[bytes] = set()
        self._best = np.inf

    def run(self, best: float, within: Callable[[], bool]) -> Outcome:
        """Search while `within` permits another node; `best` is the criterion squared of the best known plan."""
        master = self._master
        self._best, nodes = best, 0
        root = self._converged(np.zeros(len(master.highest)), master.highest)
        if root.times is None:
            return Outcome(best, None, 0)
        for _ in range(_ROUNDINGS):
            self._round(root.times)
        order = 0
        heap = [(root.bound, order, np.zeros(len(master.highest)), master.highest, root)]
        while heap and within():
            bound, _, low, high, program = heap[0]
            if bound >= (1.0 - self._gap) * self._best:
                break
            assert program.times is not None
            place = self._fractional(program)
            if place is None:
                return Outcome(min(bound, self._best), program.times, nodes)
            heappop(heap)
            value = np.concatenate([program.times, program.visits])[place]
            for below in (True, False):
                nodes += 1
                lower, upper = low.copy(), high.copy()
                if below:
                    upper[place] = np.floor(value)
                else:
                    lower[place] = np.ceil(value)
                child = self._converged(lower, upper)
                if child.times is not None and child.bound < (1.0 - self._gap) * self._best:
                    order += 1
                    self._round(child.times)
                    heappush(heap, (max(bound, child.bound), order, lower, upper, child))
        lowest = min(heap[0][0], self._best) if heap else self._best * (1.0 - self._gap)
        return Outcome(lowest, None, nodes)

    def _converged(self, low: FloatArray, high: FloatArray) -> Program:
        """The program of a node, with the cuts that its own solutions call for."""
        program = self._master.solve(low, high)
        for _ in range(_CUTS):
            if program.times is None or program.bound >= (1.0 - self._gap) * self._best:
                break
            value = self._master.cut_at(program.times)
            if program.bound >= (1.0 - 0.2 * self._gap) * value:
                break
            again = self._master.solve(low, high)
            rise = again.bound - program.bound
            program = again
            if rise < _GAIN * program.bound:
                break
        return program

    def _fractional(self, program: Program) -> int | None:
        """What to branch on: the visits of the pose farthest from whole, else the column; None for a whole plan."""
        assert program.times is not None
        number = len(program.times)
        for values, first in ((program.visits, number), (program.times, 0)):
            apart = np.abs(values - np.rint(values))
            if apart.max(initial=0.0) > _WHOLE:
                return first + int(apart.argmax())
        return None

    def _round(self, times: FloatArray) -> None:
        plan = self._master.rounded(times, self._generator)
        if plan is None or plan.tobytes() in self._tried:
            return
        self._tried.add(plan.tobytes())
        better = self._master.exchanged(plan)
        if better.tobytes() not in self._tried or np.array_equal(better, plan):
            self._tried.add(better.tobytes())
            self._best = min(self._best, self._attempt(better))
