"""What no plan with a measurement in each of some boxes goes below (theory.md 10.7).

The measurement of a box may be taken in parts at its corners, as long as the mean of the parts is within the robot's
limits. Any Q, with any multipliers of the limits, gives a bound by what a measurement anywhere in the box tells at
most; multiplicative steps towards the best parts give the Q, and Newton's on the mean excess the multipliers.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.planning.optimality.regions import SAFETY, Box, Regions, above_lines
from expdesign.planning.optimality.weights import Relaxation

_REGULARISATION = 1e-11
_ROUNDING = 1e-9
_PATIENCE, _WITHIN = (3, 6), 1e-3
"""Steps before a node that cannot be left out is given up, where its parts are within the limits on average and where
they are not; and what counts as within them."""
_NEWTON = 0.5


@dataclass(frozen=True)
class Node:
    """Plans of m measurements, each in a box.

    Attributes:
        boxes: of the measurements (m).
        units: which of them share a reference, by number (m); each by itself where none do.
        shares: parts at the corners of what measurements of a unit have in common, shape (c,) each; equal in a unit.
        within: parts at the other corners given those, shape (c, l) each.
        multipliers: of the robot's limits, shape (m, r).
        mixture: of the targets, shape (t,).
        bound: the criterion squared is nowhere less; infinite where no such plan can be measured.
    """

    boxes: tuple[Box, ...]
    units: tuple[int, ...]
    shares: tuple[FloatArray, ...]
    within: tuple[FloatArray, ...]
    multipliers: FloatArray
    mixture: FloatArray
    bound: float

    @classmethod
    def whole(cls, regions: Regions, sizes: Sequence[int], targets: int) -> "Node":
        """All plans of units of given sizes."""
        boxes = (regions.whole,) * sum(sizes)
        outer, inner = regions.region(regions.whole).corners.shape
        return cls(
            boxes,
            tuple(unit for unit, size in enumerate(sizes) for _ in range(size)),
            (np.full(outer, 1.0 / outer),) * len(boxes),
            (np.full((outer, inner), 1.0 / inner),) * len(boxes),
            np.zeros((len(boxes), regions.limits)),
            np.full(targets, 1.0 / targets),
            0.0,
        )


@dataclass
class Batch:
    """Nodes with what their boxes are looked at by, arrays that begin with (b, m); short ones are filled up by their
    last corner.

    Attributes:
        corners: grams, shape (b, m, c, l, p).
        excess: over the robot's limits at the corners, shape (b, m, c, l, r).
        lines: grams on the lines through the middle, shape (b, m, 1 + 2a, l', p).
        beyond: excess there, shape (b, m, 1 + 2a, l', r).
        parts: see `Region`, shape (b, m, a).
        units: which measurement (m) is in which unit (m), shape (b, m, m), units first.
        shares: shape (b, m, c).
        within: shape (b, m, c, l).
        multipliers: shape (b, m, r).
        mixture: shape (b, t).
    """

    corners: FloatArray
    excess: FloatArray
    lines: FloatArray
    beyond: FloatArray
    parts: FloatArray
    units: BoolArray
    shares: FloatArray
    within: FloatArray
    multipliers: FloatArray
    mixture: FloatArray

    @classmethod
    def of(cls, regions: Regions, nodes: Sequence[Node]) -> "Batch":
        found = [[regions.region(box) for box in node.boxes] for node in nodes]
        corners = _filled([[each.corners for each in row] for row in found], by_last=True)
        lines = _filled([[each.lines for each in row] for row in found], by_last=False)
        count = (lines.shape[2] - 1) // 2
        parts = np.full((*lines.shape[:2], count), 0.5)
        for place, row in enumerate(found):
            for member, each in enumerate(row):
                parts[place, member, : len(each.parts)] = each.parts
        units = np.array([[[each == unit for each in node.units] for unit in range(len(node.units))] for node in nodes])
        shares = _stacked([[each[:, None] for each in node.shares] for node in nodes], (corners.shape[2], 1))[..., 0]
        within = _stacked([list(node.within) for node in nodes], corners.shape[2:])
        return cls(
            regions.grams(corners),
            regions.excess(corners),
            regions.grams(lines),
            regions.excess(lines),
            parts,
            units,
            shares,
            within,
            np.array([node.multipliers for node in nodes]),
            np.array([node.mixture for node in nodes]),
        )

    def take(self, keep: BoolArray) -> "Batch":
        return Batch(**{name: value[keep] for name, value in vars(self).items()})

    @property
    def both(self) -> FloatArray:
        """Parts of every measurement at its corners, shape (b, m, c, l)."""
        return self.shares[..., None] * self.within


class Duals:
    """Q of some nodes at their parts, and how the references follow from it.

    Attributes:
        matrix: Q, shape (b, q, r).
        inverse: of the information, shape (b, q, q).
        values: of the targets, shape (b, t).
        gain: tr(L·Q), shape (b,).
        prior: tr(Qᵀ·P·Q), shape (b,).
        roots: Z of every measurement, [Q, −B] where it has a reference, shape (b, m, c, q + k, r).
        base: what the references of the units add, shape (b, m, c).
    """

    def __init__(self, regions: Regions, relaxation: Relaxation, batch: Batch) -> None:
        q, targets = len(relaxation.prior), relaxation.targets
        sums = (batch.within[..., None, :] @ batch.corners)[..., 0, :]
        units = batch.units.astype(float)
        together = np.einsum("bum,bmcp->bucp", units, sums)
        matrices = regions.matrices(together)
        # Of the measurements of a unit the first one's shares are those of the unit; of an empty unit they are zero.
        self._shares = np.take_along_axis(batch.shares, units.argmax(axis=2)[..., None], axis=1)
        self._shares = self._shares * units.max(axis=2)[..., None]
        information = np.einsum("buc,bucij->bij", self._shares, matrices[..., :q, :q])
        if regions.series:
            cross = matrices[..., q:, :q]
            reference = -np.linalg.solve(2.0 * np.eye(regions.readings) + matrices[..., q:, q:], cross)
            information = information + np.einsum("buc,bucki,buckj->bij", self._shares, cross, reference)
        information = information + relaxation.prior
        size = np.trace(information, axis1=1, axis2=2)[:, None, None] / q
        self.inverse = np.linalg.inv(information + _REGULARISATION * size * np.eye(q))
        self.values = ((targets @ self.inverse[:, None]) * targets).sum(axis=(2, 3))
        root = (np.sqrt(batch.mixture)[..., None, None] * targets).reshape(len(size), -1, q)
        self.matrix = self.inverse @ root.swapaxes(1, 2)
        self.gain = np.einsum("brq,bqr->b", root, self.matrix)
        self.prior = np.einsum("bqr,qs,bsr->b", self.matrix, relaxation.prior, self.matrix)
        roots = self.matrix[:, None, None]
        self.base = np.zeros(batch.shares.shape)
        if regions.series:
            answer = reference @ roots
            self.base = 2.0 * (answer**2).sum(axis=(3, 4))
            roots = np.concatenate(
                [np.broadcast_to(roots, (*answer.shape[:3], *self.matrix.shape[1:])), answer], axis=3
            )
            roots = np.einsum("bum,bucij->bmcij", units, roots)
        self.roots = roots

    def middle(self, batch: Batch) -> FloatArray:
        """Z of every measurement on average over what its unit has in common, shape (b, m, q + k, r)."""
        if self.roots.shape[1] == 1:
            return self.roots[:, :, 0]
        found: FloatArray = np.einsum("bmc,bmcij->bmij", batch.shares, self.roots)
        return found


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
        weighed += batch.corners.shape[0] * int(np.prod(batch.corners.shape[1:4]))
        duals = Duals(regions, relaxation, batch)
        forms = regions.forms(duals.roots)
        told = (batch.corners @ forms[..., None])[..., 0]
        charged = told - (batch.excess @ batch.multipliers[:, :, None, :, None])[..., 0]
        most = duals.base + np.einsum("bum,bmc->buc", batch.units.astype(float), charged.max(axis=3))
        total = most.max(axis=2).sum(axis=1) + _bends(regions, batch, duals)
        reached = (1.0 - _ROUNDING) * duals.gain**2 / (duals.prior + np.maximum(total, 1e-300))
        bounds[left] = np.maximum(bounds[left], reached)
        mean = np.einsum("bmcl,bmclr->bmr", batch.both, batch.excess)
        outside = (mean > _WITHIN).any(axis=(1, 2))
        hopeless = (duals.values.max(axis=1) < enough) & (step + 1 >= np.where(outside, _PATIENCE[1], _PATIENCE[0]))
        done = (bounds[left] >= enough) | hopeless | (step == steps - 1)
        for place in np.flatnonzero(done):
            found[left[place]] = _with(nodes[left[place]], batch, int(place), float(bounds[left[place]]))
        if done.all():
            break
        _step(batch, duals, told, charged, mean)
        if done.any():
            batch, left = batch.take(~done), left[~done]
    return found, weighed


def _bends(regions: Regions, batch: Batch, duals: Duals) -> FloatArray:
    """What second differences through the middles of the boxes allow for, shape (b,)."""
    if batch.parts.shape[2] == 0:
        return np.zeros(len(batch.parts))
    forms = regions.forms(duals.middle(batch))
    values = (batch.lines @ forms[:, :, None, :, None])[..., 0]
    values = values - (batch.beyond @ batch.multipliers[:, :, None, :, None])[..., 0]
    above = above_lines(np.moveaxis(values, 2, 0), np.moveaxis(batch.parts, 2, 0)[..., None])
    found: FloatArray = SAFETY * above.max(axis=2).sum(axis=1)
    return found


def _step(batch: Batch, duals: Duals, told: FloatArray, charged: FloatArray, mean: FloatArray) -> None:
    """Parts that tell more, and multipliers that take them within the limits."""
    kept = np.maximum(charged, 0.0)
    units = batch.units.astype(float)
    taken = np.einsum("bum,bmc->buc", units, (batch.within * kept).sum(axis=3)) + duals.base
    shares = _towards(batch.shares, np.einsum("bum,buc->bmc", units, taken))
    within = _towards(batch.within, kept)
    if mean.shape[2]:
        spread = np.einsum("bmcl,bmclr->bmr", batch.both, batch.excess**2)
        size = (batch.both * told).sum(axis=(2, 3))[..., None]
        change = 2.0 * _NEWTON * size * mean / np.maximum(spread, 1e-12)
        batch.multipliers = np.maximum(batch.multipliers + change, 0.0)
    batch.shares, batch.within = shares, within
    batch.mixture = normalised(batch.mixture * duals.values)


def _with(node: Node, batch: Batch, place: int, bound: float) -> Node:
    """A node with the parts that it has in a batch."""
    shares = tuple(batch.shares[place, member, : len(each)].copy() for member, each in enumerate(node.shares))
    within = tuple(
        normalised(batch.within[place, member, : each.shape[0], : each.shape[1]])
        for member, each in enumerate(node.within)
    )
    multipliers, mixture = batch.multipliers[place].copy(), batch.mixture[place].copy()
    return replace(node, shares=shares, within=within, multipliers=multipliers, mixture=mixture, bound=bound)


def _stacked(rows: list[list[Any]], shape: tuple[int, ...] | None = None) -> Any:
    """Arrays of two axes in one, shape (b, m, largest, largest), filled up by zeros."""
    largest = shape or tuple(np.array([[each.shape for each in row] for row in rows]).max(axis=(0, 1)))
    found = np.zeros((len(rows), len(rows[0]), *largest), dtype=rows[0][0].dtype)
    for place, row in enumerate(rows):
        for member, each in enumerate(row):
            found[place, member, : each.shape[0], : each.shape[1]] = each
    return found


def _filled(rows: list[list[IntArray]], *, by_last: bool) -> IntArray:
    """Arrays of two axes in one, filled up by their last rows and columns, or by their first rows and last columns."""
    found: IntArray = _stacked(rows)
    for place, row in enumerate(rows):
        for member, each in enumerate(row):
            found[place, member, : len(each), each.shape[1] :] = each[:, -1:]
            found[place, member, len(each) :] = found[place, member, len(each) - 1 if by_last else 0]
    return found


def _towards(parts: FloatArray, told: FloatArray) -> FloatArray:
    """Parts that tell more; as they were where none tells anything."""
    stepped = parts * np.sqrt(told)
    return np.where((stepped > 0.0).any(axis=-1, keepdims=True), normalised(stepped), parts)


def normalised(parts: FloatArray) -> FloatArray:
    """Parts that sum to one along the last axis; as they are where all are zero."""
    total = parts.sum(axis=-1, keepdims=True)
    found: FloatArray = parts / np.where(total > 0.0, total, 1.0)
    return found
