"""The tree of branch and bound over whole plans (Land & Doig 1960): best bound first, cuts shared by all nodes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from heapq import heappop, heappush

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.outer_approximation import Master, Program

_WHOLE = 1e-6
_CUTS, _GAIN = 4, 1e-4
"""Programs at a node, and the relative rise of its bound that is worth another."""
_ROUNDINGS, _ROOTS = 20, 30


@dataclass(frozen=True)
class Outcome:
    """How far a tree got.

    Attributes:
        bound: what no plan goes below, the criterion squared.
        nodes: of the tree.
    """

    bound: float
    nodes: int


@dataclass(order=True)
class _Node:
    """Part of the plans: least and most times and visits (J + p,), and its program, of a version of the columns."""

    bound: float
    order: int
    low: FloatArray = field(compare=False)
    high: FloatArray = field(compare=False)
    program: Program = field(compare=False)
    version: int = field(compare=False)


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
        self._order = 0
        self._origins: list[IntArray] = []

    def run(self, best: float, within: Callable[[], bool]) -> Outcome:
        """Search while `within` permits another node; `best` is the criterion squared of the best known plan."""
        master = self._master
        self._best, nodes = best, 0
        self._tighten()
        root = self._converged(np.zeros(len(master.highest)), master.highest)
        heap = (
            [] if root.times is None else [self._node(root.bound, np.zeros(len(master.highest)), master.highest, root)]
        )
        while heap and within() and heap[0].bound < (1.0 - self._gap) * self._best:
            node = heappop(heap)
            if node.version < len(self._origins):
                self._renewed(heap, node)
                continue
            assert node.program.times is not None
            place = self._fractional(node.program)
            if place is None:
                if not self._tightened(heap, node):
                    heappush(heap, node)
                    break
                continue
            value = np.concatenate([node.program.times, node.program.visits])[place]
            for below in (True, False):
                nodes += 1
                lower, upper = node.low.copy(), node.high.copy()
                if below:
                    upper[place] = np.floor(value)
                else:
                    lower[place] = np.ceil(value)
                self._push(heap, node.bound, lower, upper)
        lowest = min(heap[0].bound, self._best) if heap else self._best * (1.0 - self._gap)
        return Outcome(lowest, nodes)

    def _node(self, bound: float, low: FloatArray, high: FloatArray, program: Program) -> _Node:
        self._order += 1
        return _Node(bound, self._order, low, high, program, len(self._origins))

    def _push(self, heap: list[_Node], bound: float, low: FloatArray, high: FloatArray) -> float:
        """Put a part of the plans on the heap where it can hold a better one; its bound."""
        program = self._converged(low, high)
        if program.times is not None and program.bound < (1.0 - self._gap) * self._best:
            self._round(program.times)
            heappush(heap, self._node(max(bound, program.bound), low, high, program))
        return program.bound

    def _renewed(self, heap: list[_Node], node: _Node) -> None:
        """A node after columns were split: what was said of a column that is no more is left out."""
        low, high, highest = node.low, node.high, self._master.highest
        for origin in self._origins[node.version :]:
            poses = np.arange(len(low) - (len(highest) - len(self._origins[-1])), len(low))
            place = np.concatenate([origin, poses])
            low, high = np.where(place >= 0, low[place], 0.0), np.where(place >= 0, high[place], np.inf)
        self._push(heap, node.bound, low, np.minimum(high, highest))

    def _tightened(self, heap: list[_Node], node: _Node) -> bool:
        """Split the boxes of a node's whole plan, or add its cut; whether that changes anything."""
        assert node.program.times is not None
        self._round(node.program.times)
        origin = self._master.refine(node.program.times)
        if origin is not None:
            self._origins.append(origin)
            self._renewed(heap, node)
            return True
        return self._push(heap, node.bound, node.low, node.high) > node.bound * (1.0 + 0.1 * self._gap)

    def _tighten(self) -> None:
        """Cuts about the optimum in parts, by the method of Kelley (1960) with averaging, and plans near it."""
        step = self._master.solve()
        if step.times is None:
            return
        centre, least = step.times, self._master.cut_at(step.times)
        for _ in range(_ROOTS):
            step = self._master.solve()
            if step.times is None or step.bound > (1.0 - self._gap) * least:
                break
            middle = 0.5 * (centre + step.times)
            value = self._master.cut_at(middle)
            self._master.cut_at(step.times)
            if value < least:
                centre, least = middle, value
        for _ in range(_ROUNDINGS):
            self._round(centre)

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
