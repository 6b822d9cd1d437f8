"""Branch and bound over a continuum: the boxes of a plan's measurements are halved, least bound first (theory.md 10.7).

Land & Doig 1960; for continuous variables Falk & Soland 1969.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from heapq import heappop, heappush
from itertools import groupby
from typing import TypeVar

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.planning.optimality.region_bound import Batch, Duals, Node, bounded, normalised
from expdesign.planning.optimality.regions import Axis, Box, Regions, Span
from expdesign.planning.optimality.weights import Relaxation
from expdesign.planning.options import HALVING

_Each = TypeVar("_Each")


@dataclass(order=True)
class _Open:
    """A node by its bound and number."""

    bound: float
    number: int
    node: Node = field(compare=False)


class RegionTree:
    """The tree.

    Args:
        regions: the boxes.
        relaxation: targets, prior and m.
        attempt: told the measurements (m, g) of a plan, gives the least value known, squared.

    Attributes:
        nodes: how many there were.
    """

    def __init__(self, regions: Regions, relaxation: Relaxation, attempt: Callable[[FloatArray], float]) -> None:
        self._regions, self._relaxation, self._attempt = regions, relaxation, attempt
        self._heap: list[_Open] = []
        self._tried: set[bytes] = set()
        # Of single plans: nothing of them is left to be cut.
        self._least = np.inf
        self.nodes, self._weighed, self._made = 0, 0, 0

    @property
    def seconds(self) -> float:
        """Of a processor, as estimated from the work."""
        weighed = self._weighed * len(self._regions.triangle[0]) / HALVING.rate
        return weighed + self._regions.work / HALVING.maps + self.nodes * HALVING.fixed

    def affordable(self, seconds: float) -> bool:
        """Whether so many seconds are enough to look at the corners of all that a measurement can be."""
        corners = float(np.prod(self._regions.lengths(self._regions.whole)))
        numbers = corners * self._relaxation.count * len(self._regions.triangle[0])
        return corners <= HALVING.maps * seconds and numbers <= HALVING.largest

    def run(self, best: float, gap: float, seconds: float) -> float:
        """What no plan goes below, the criterion squared.

        Args:
            best: value of the best plan known, squared.
            gap: relative distance from it, of the squares, at which it is near enough.
            seconds: of a processor, as estimated from the work.
        """
        whole = Node.whole(self._regions, self._relaxation.count, len(self._relaxation.targets))
        self._bound([whole], (1.0 - gap) * best, HALVING.first)
        level = 0
        while self._heap and self.seconds < seconds:
            levels = [*(best / (1.0 + distance) ** 2 for distance in HALVING.levels), best * (1.0 - gap)]
            while level < len(levels) - 1 and self._heap[0].bound >= levels[level]:
                level += 1
            if self._heap[0].bound >= levels[-1]:
                break
            taken = [heappop(self._heap)]
            while self._heap and len(taken) < HALVING.together and self._heap[0].bound < levels[level]:
                taken.append(heappop(self._heap))
            halves: list[Node] = []
            for nodes in _alike(self._regions, [each.node for each in taken]):
                batch = Batch.of(self._regions, nodes)
                for plan in self._heaviest(nodes, batch, best):
                    if plan.tobytes() not in self._tried:
                        self._tried.add(plan.tobytes())
                        best = min(best, self._attempt(plan))
                for node, cut in zip(nodes, self._cuts(nodes, batch), strict=True):
                    if cut is None:
                        self._least = min(self._least, node.bound)
                    else:
                        halves += self._halves(node, *cut)
            self._bound(halves, levels[level], HALVING.steps)
            self._regions.release()
        return min(best, self._least, self._heap[0].bound if self._heap else np.inf)

    def _bound(self, nodes: list[Node], enough: float, steps: int) -> None:
        self.nodes += len(nodes)
        reachable = [node for node in nodes if all(self._regions.region(box).reachable for box in node.boxes)]
        for batch in _alike(self._regions, reachable):
            found, weighed = bounded(self._regions, self._relaxation, batch, enough, steps)
            self._weighed += weighed
            for before, node in zip(batch, found, strict=True):
                resolved = all(self._regions.region(box).resolved for box in node.boxes)
                kept = node if resolved else replace(node, bound=before.bound)
                self._made += 1
                heappush(self._heap, _Open(kept.bound, self._made, kept))

    def _cuts(self, nodes: list[Node], batch: Batch) -> list[tuple[int, int] | None]:
        """Measurement and axis along which to cut nodes of equal shape; None where nothing can be cut.

        A measurement in parts on both sides of a cut, w and 1 − w of it with mean informations N₁ and N₂, lets the
        criterion fall below that of whole ones by about w·(1 − w)·tr(Qᵀ(N₁ − N₂)·M⁻¹·(N₁ − N₂)Q), its curvature
        in that direction. Short intervals count for less: parts along one axis may only follow those along another.
        """
        regions, duals = self._regions, Duals(self._regions, self._relaxation, batch)
        found: list[tuple[int, int] | None] = []
        for place, node in enumerate(nodes):
            most, chosen = 0.0, None
            for member, (box, parts) in enumerate(zip(node.boxes, node.parts, strict=True)):
                grams = batch.corners[place, member, : len(parts)]
                upper = _upper(regions, box)
                high, above = (upper * parts) @ grams, upper @ parts
                share = np.clip(np.stack([1.0 - above, above]), HALVING.least, 1.0)
                apart = regions.matrices(high / share[1, :, None] - (parts @ grams - high) / share[0, :, None])
                images = (apart @ duals.matrix[place]).swapaxes(1, 2)
                bend = ((images @ duals.inverse[place]) * images).sum(axis=(1, 2))
                scores = np.nan_to_num(share.prod(axis=0) * bend / duals.gain[place], nan=0.0, posinf=0.0)
                for number, (axis, span) in enumerate(zip(regions.axes, box, strict=True)):
                    length = 1.0 if axis.order is not None else span[1] - span[0]
                    # What is not resolved has no bound yet, whatever the others' scores.
                    score = (
                        np.inf if not axis.resolved(span) else scores[number] * np.sqrt(length) + HALVING.slack * length
                    )
                    if span[0] < span[1] and score > most:
                        most, chosen = float(score), (member, number)
            found.append(chosen)
        return found

    def _heaviest(self, nodes: list[Node], batch: Batch, best: float) -> list[FloatArray]:
        """The plans (m, g) at the corners with the largest parts that would be better than the best one known."""
        heaviest = batch.parts.argmax(axis=2)
        corners = np.take_along_axis(batch.corners, heaviest[..., None, None], axis=2)
        single = replace(batch, corners=corners, parts=np.ones(corners.shape[:3]))
        values = Duals(self._regions, self._relaxation, single).values.max(axis=1)
        return [self._plan(nodes[i], heaviest[i]) for i in np.flatnonzero(values < (1.0 - HALVING.better) * best)]

    def _plan(self, node: Node, corners: IntArray) -> FloatArray:
        """The measurements (m, g) at corners of a node's boxes."""
        regions = self._regions
        return regions.decisions(np.array([regions.corner(*each) for each in zip(node.boxes, corners, strict=True)]))

    def _halves(self, node: Node, member: int, number: int) -> Iterator[Node]:
        """The node in parts: of equal measurements so many take the one half and the rest the other."""
        alike = [each for each, box in enumerate(node.boxes) if box == node.boxes[member]]
        for low in range(len(alike) + 1):
            found = node
            for place, each in enumerate(alike):
                found = self._half(found, each, number, int(place >= low))
            yield found

    def _half(self, node: Node, member: int, number: int, side: int) -> Node:
        """A node with one measurement in one half of its box."""
        box, axis = node.boxes[member], self._regions.axes[number]
        span = axis.halves(box[number])[side]
        spread = node.parts[member].reshape(self._regions.lengths(box))
        kept = [spread.take(each, axis=number).sum(axis=number) for each in _columns(axis, box[number], span)]
        parts = normalised(np.stack(kept, axis=number).ravel())
        return replace(
            node,
            boxes=_replaced(node.boxes, member, (*box[:number], span, *box[number + 1 :])),
            parts=_replaced(node.parts, member, normalised((1.0 - HALVING.even) * parts + HALVING.even / len(parts))),
        )


def _replaced(values: tuple[_Each, ...], place: int, value: _Each) -> tuple[_Each, ...]:
    return (*values[:place], value, *values[place + 1 :])


def _columns(axis: Axis, before: Span, after: Span) -> list[list[int]]:
    """Which corners of a span along an axis each corner of its half has the parts of."""
    now = axis.corners(after)
    if axis.listed:
        first = int(after[0] - before[0])
        return [[first + place] for place in range(len(now))]
    return [[0], [1]] if len(now) == 2 else [[0, 1]]


def _upper(regions: Regions, box: Box) -> BoolArray:
    """Which corners of a box are in the upper half along every axis, shape (a, l)."""
    lengths = np.array(regions.lengths(box))
    found: BoolArray = np.indices(tuple(lengths)).reshape(len(lengths), -1) >= ((lengths + 1) // 2)[:, None]
    return found


def _alike(regions: Regions, nodes: list[Node]) -> Iterator[list[Node]]:
    """Nodes of equal shape together, as many as a batch may have."""

    def size(node: Node) -> int:
        return max(len(each) for each in node.parts)

    entries = len(regions.triangle[0])
    for largest, alike in groupby(sorted(nodes, key=size), key=size):
        listed = list(alike)
        together = max(1, HALVING.numbers // (largest * entries * len(listed[0].boxes)))
        for start in range(0, len(listed), together):
            yield listed[start : start + together]
