"""What no plan with a measurement in each of some boxes goes below (theory.md 10.7).

The measurement of a box may be taken in parts at its corners, as long as the mean of the parts is within the robot's
limits. Any Q, with any multipliers of the limits, gives a bound by what a measurement anywhere in the box tells at
most; multiplicative steps towards the best parts give the Q, and Newton's on the mean excess the multipliers.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.planning.optimality.regions import Box, Regions, above_lines
from expdesign.planning.optimality.weights import Relaxation
from expdesign.planning.options import HALVING


@dataclass(frozen=True)
class Node:
    """Plans of m measurements, each in a box.

    Attributes:
        boxes: of the measurements (m).
        parts: of each measurement at the corners of its box, shape (l,) each.
        multipliers: of the robot's limits, shape (m, r).
        mixture: of the targets, shape (t,).
        bound: the criterion squared is nowhere less; infinite where no such plan can be measured.
    """

    boxes: tuple[Box, ...]
    parts: tuple[FloatArray, ...]
    multipliers: FloatArray
    mixture: FloatArray
    bound: float

    @classmethod
    def whole(cls, regions: Regions, count: int, targets: int) -> "Node":
        """All plans of so many measurements."""
        corners = len(regions.region(regions.whole).corners)
        return cls(
            (regions.whole,) * count,
            (np.full(corners, 1.0 / corners),) * count,
            np.zeros((count, regions.limits)),
            np.full(targets, 1.0 / targets),
            0.0,
        )


@dataclass
class Batch:
    """Nodes with what their boxes are looked at by, arrays that begin with (b, m); short ones are filled up by their
    last corner.

    Attributes:
        corners: grams, shape (b, m, l, p).
        excess: over the robot's limits at the corners, shape (b, m, l, r).
        lines: grams on the lines through the middle, shape (b, m, 1 + 2a, l', p).
        beyond: excess there, shape (b, m, 1 + 2a, l', r).
        middles: see `Region`, shape (b, m, a).
        parts: shape (b, m, l).
        multipliers: shape (b, m, r).
        mixture: shape (b, t).
    """

    corners: FloatArray
    excess: FloatArray
    lines: FloatArray
    beyond: FloatArray
    middles: FloatArray
    parts: FloatArray
    multipliers: FloatArray
    mixture: FloatArray

    @classmethod
    def of(cls, regions: Regions, nodes: Sequence[Node]) -> "Batch":
        found = [[regions.region(box) for box in node.boxes] for node in nodes]
        corners = _filled([[each.corners[None] for each in row] for row in found])[:, :, 0]
        lines = _filled([[each.lines for each in row] for row in found])
        middles = np.full((*lines.shape[:2], (lines.shape[2] - 1) // 2), 0.5)
        parts = np.zeros(corners.shape)
        for place, (row, node) in enumerate(zip(found, nodes, strict=True)):
            for member, (each, part) in enumerate(zip(row, node.parts, strict=True)):
                middles[place, member, : len(each.middles)] = each.middles
                parts[place, member, : len(part)] = part
        return cls(
            regions.grams(corners),
            regions.excess(corners),
            regions.grams(lines),
            regions.excess(lines),
            middles,
            parts,
            np.array([node.multipliers for node in nodes]),
            np.array([node.mixture for node in nodes]),
        )

    def take(self, keep: BoolArray) -> "Batch":
        return Batch(**{name: value[keep] for name, value in vars(self).items()})


class Duals:
    """Q of some nodes at their parts.

    Attributes:
        matrix: Q, shape (b, q, r).
        inverse: of the information, shape (b, q, q).
        values: of the targets, shape (b, t).
        gain: tr(L·Q), shape (b,).
        prior: tr(Qᵀ·P·Q), shape (b,).
    """

    def __init__(self, regions: Regions, relaxation: Relaxation, batch: Batch) -> None:
        q, targets = len(relaxation.prior), relaxation.targets
        sums = (batch.parts[..., None, :] @ batch.corners)[..., 0, :].sum(axis=1)
        information = regions.matrices(sums) + relaxation.prior
        size = np.trace(information, axis1=1, axis2=2)[:, None, None] / q
        self.inverse = np.linalg.inv(information + HALVING.regularisation * size * np.eye(q))
        self.values = ((targets @ self.inverse[:, None]) * targets).sum(axis=(2, 3))
        root = (np.sqrt(batch.mixture)[..., None, None] * targets).reshape(len(size), -1, q)
        self.matrix = self.inverse @ root.swapaxes(1, 2)
        self.gain = np.einsum("brq,bqr->b", root, self.matrix)
        self.prior = np.einsum("bqr,qs,bsr->b", self.matrix, relaxation.prior, self.matrix)


def bounded(
    regions: Regions, relaxation: Relaxation, nodes: Sequence[Node], enough: float, steps: int
) -> tuple[list[Node], int]:
    """Nodes of equal shape with their bounds, and how many maps were weighed.

    Args:
        regions: the boxes.
        relaxation: targets, prior and m.
        nodes: with the parts to begin with.
        enough: the bound at which steps end; a node of which plans in parts are below it is given up early.
        steps: the most of them.
    """
    batch = Batch.of(regions, nodes)
    found, bounds = list(nodes), np.array([node.bound for node in nodes])
    left, weighed = np.arange(len(nodes)), 0
    for step in range(steps):
        weighed += int(np.prod(batch.corners.shape[:3]))
        duals = Duals(regions, relaxation, batch)
        forms = regions.forms(duals.matrix)
        told = (batch.corners @ forms[:, None, :, None])[..., 0]
        charged = told - (batch.excess @ batch.multipliers[..., None])[..., 0]
        total = charged.max(axis=2).sum(axis=1) + _bends(batch, forms)
        reached = (1.0 - HALVING.rounding) * duals.gain**2 / (duals.prior + np.maximum(total, 1e-300))
        bounds[left] = np.maximum(bounds[left], reached)
        mean = np.einsum("bml,bmlr->bmr", batch.parts, batch.excess)
        outside = (mean > HALVING.within).any(axis=(1, 2))
        hopeless = (duals.values.max(axis=1) < enough) & (step + 1 >= np.where(outside, *reversed(HALVING.patience)))
        done = (bounds[left] >= enough) | hopeless | (step == steps - 1)
        for place in np.flatnonzero(done):
            found[left[place]] = _with(nodes[left[place]], batch, int(place), float(bounds[left[place]]))
        if done.all():
            break
        _step(batch, duals, told, charged, mean)
        if done.any():
            batch, left = batch.take(~done), left[~done]
    return found, weighed


def _bends(batch: Batch, forms: FloatArray) -> FloatArray:
    """What second differences through the middles of the boxes allow for, shape (b,)."""
    if batch.middles.shape[2] == 0:
        return np.zeros(len(batch.middles))
    values = (batch.lines @ forms[:, None, None, :, None])[..., 0]
    values = values - (batch.beyond @ batch.multipliers[:, :, None, :, None])[..., 0]
    above = above_lines(np.moveaxis(values, 2, 0), np.moveaxis(batch.middles, 2, 0)[..., None])
    found: FloatArray = HALVING.safety * above.max(axis=2).sum(axis=1)
    return found


def _step(batch: Batch, duals: Duals, told: FloatArray, charged: FloatArray, mean: FloatArray) -> None:
    """Parts that tell more, and multipliers that take them within the limits."""
    if mean.shape[2]:
        spread = np.einsum("bml,bmlr->bmr", batch.parts, batch.excess**2)
        size = (batch.parts * told).sum(axis=2)[..., None]
        change = 2.0 * HALVING.damping * size * mean / np.maximum(spread, 1e-12)
        batch.multipliers = np.maximum(batch.multipliers + change, 0.0)
    stepped = batch.parts * np.sqrt(np.maximum(charged, 0.0))
    moves = (stepped > 0.0).any(axis=-1, keepdims=True)  # else nothing there tells anything
    batch.parts = np.where(moves, normalised(stepped), batch.parts)
    batch.mixture = normalised(batch.mixture * duals.values)


def _with(node: Node, batch: Batch, place: int, bound: float) -> Node:
    """A node with the parts that it has in a batch."""
    parts = tuple(normalised(batch.parts[place, member, : len(each)]) for member, each in enumerate(node.parts))
    multipliers, mixture = batch.multipliers[place].copy(), batch.mixture[place].copy()
    return replace(node, parts=parts, multipliers=multipliers, mixture=mixture, bound=bound)


def _filled(rows: list[list[IntArray]]) -> IntArray:
    """Arrays of two axes in one, shape (b, m, largest, largest), filled up by their first rows and last columns."""
    largest = np.array([[each.shape for each in row] for row in rows]).max(axis=(0, 1))
    found = np.zeros((len(rows), len(rows[0]), *largest), dtype=np.int64)
    for place, row in enumerate(rows):
        for member, each in enumerate(row):
            count, width = each.shape
            found[place, member, :count, :width] = each
            found[place, member, :count, width:] = each[:, -1:]
            found[place, member, count:] = found[place, member, 0]
    return found


def normalised(parts: FloatArray) -> FloatArray:
    """Parts that sum to one along the last axis; as they are where all are zero."""
    total = parts.sum(axis=-1, keepdims=True)
    found: FloatArray = parts / np.where(total > 0.0, total, 1.0)
    return found
