"""Follow a front of two objectives from design to design until it can be drawn without gaps.

Between two neighbours of one valley, whose discrete choices agree, designs in between are near the front to the fourth
order in their distance: the path of optimal designs is smooth, and what a design loses by being off it is of the second
order. They predict; a few steps of `sqp.py` correct (Allgower & Georg 1990 for predictor and corrector). Where two
neighbours are of different valleys, the gap is pursued from both of them.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from expdesign.arrays import BoolArray, FloatArray
from expdesign.design.front import gap_shares, non_dominated
from expdesign.design.space import DesignSpace

_SAME = 0.5
"""Part of a variable's range by which neighbours of one valley differ at most."""


@dataclass(frozen=True)
class Predictions:
    """Designs (p, m, g) in the gaps of a front, the objectives at which each is aimed (p, 2), whether it lies on the
    path between two designs of one valley (p,), and the share of the hypervolume in its gap (p,).
    """

    designs: FloatArray
    aims: FloatArray
    smooth: BoolArray
    shares: FloatArray

    def __len__(self) -> int:
        return len(self.designs)


def predictions(space: DesignSpace, pool: FloatArray, values: FloatArray, share: float, most: int) -> Predictions:
    """Designs with which the gaps of a front come down to a share of its hypervolume, were it straight in them.

    Args:
        space: the design space.
        pool: designs (d, m, g).
        values: their two objectives, minimised, shape (d, 2).
        share: of the hypervolume, of all gaps together.
        most: largest number of predictions.
    """
    front = non_dominated(values)
    front = front[np.argsort(values[front, 0], kind="stable")]
    areas = gap_shares(values[front])
    roots = np.sqrt(areas)
    # As many parts of a gap as make the sum of what is left least for their number.
    scale = roots.sum() / share
    if roots.sum() * scale > most:
        scale = most / roots.sum()
    parts = np.ceil(scale * roots - 1e-9).astype(np.int64)
    designs, aims, smooth, shares = [], [], [], []
    for gap in np.flatnonzero(parts > 1) if areas.sum() > share else ():
        first, second = pool[front[gap]], pool[front[gap + 1]]
        ends = values[front[gap]], values[front[gap + 1]]
        matched = _matched(space, first, second)
        fractions = np.arange(1, parts[gap]) / parts[gap]
        if matched is None:
            # From either side, at the middle: whether there is anything in between shows there.
            designs += [first, second]
            aims += [0.5 * (ends[0] + ends[1])] * 2
            smooth += [False, False]
            shares += [areas[gap]] * 2
            continue
        designs += [(1.0 - part) * first + part * matched for part in fractions]
        aims += [(1.0 - part) * ends[0] + part * ends[1] for part in fractions]
        smooth += [True] * len(fractions)
        shares += [areas[gap]] * len(fractions)
    if not designs:
        return Predictions(pool[:0], values[:0], np.zeros(0, dtype=bool), np.zeros(0))
    return Predictions(np.array(designs), np.array(aims), np.array(smooth), np.array(shares))


def _matched(space: DesignSpace, first: FloatArray, second: FloatArray) -> FloatArray | None:
    """The second design (m, g) in the order of the first one's measurements, or None where it is of another valley."""
    span = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
    distance = np.abs(first[:, None] - second[None]) / np.where(space.discrete, 1.0, span)
    order = linear_sum_assignment((distance**2).sum(axis=2))[1]
    matched = second[order]
    apart = np.abs(matched - first) / span
    same = (matched == first)[:, space.discrete].all() and bool((apart[:, ~space.discrete] <= _SAME).all())
    return matched if same else None
