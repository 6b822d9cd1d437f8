"""Follow a front of two objectives from design to design until it can be drawn without gaps.

Between two neighbours of one valley, whose discrete choices agree, designs in between are near the front to the fourth
order in their distance: the path of optimal designs is smooth, and what a design loses by being off it is of the second
order. They predict; a few steps of `sqp.py` correct (Allgower & Georg 1990 for predictor and corrector). Where two
neighbours are of different valleys, the gap is pursued from both of them.
"""

import numpy as np
from scipy.optimize import linear_sum_assignment

from expdesign.arrays import FloatArray
from expdesign.planning.front import gap_shares, non_dominated
from expdesign.planning.operators.operator import State
from expdesign.planning.options import CONTINUATION
from expdesign.planning.scalarisation import at_points, spans
from expdesign.planning.space import DesignSpace


class Continuation:
    """Predicts designs in the gaps of the front, and corrects those in the widest."""

    name = "continuation"

    def offspring(self, state: State) -> FloatArray:
        space, archive = state.problem.space, state.archive
        front = non_dominated(archive.front)
        front = front[np.argsort(archive.front[front, 0], kind="stable")]
        if archive.objectives != 2 or len(front) < 2:
            return archive.designs[:0]
        values = archive.front[front]
        shares = gap_shares(values)
        parts = _parts(shares, 0.25 * state.options.gap)
        designs, points, weights = [], [], []
        for gap in np.flatnonzero(parts > 1):
            first, second = archive.designs[front[gap]], archive.designs[front[gap + 1]]
            matched = _matched(space, first, second)
            if matched is None:
                # From either side, at the middle: whether there is anything in between shows there.
                designs += [first, second]
                points += [0.5 * (values[gap] + values[gap + 1])] * 2
                weights += [shares[gap]] * 2
                continue
            for part in np.arange(1, parts[gap]) / parts[gap]:
                designs.append((1.0 - part) * first + part * matched)
                points.append((1.0 - part) * values[gap] + part * values[gap + 1])
                weights.append(shares[gap] / parts[gap])
        if not designs:
            return archive.designs[:0]
        predicted = np.array(designs)
        if not state.smooth:
            return predicted
        chosen = np.argsort(-np.array(weights), kind="stable")[: state.scaled(state.options.corrected)]
        aims = at_points(np.array(points)[chosen], spans(archive.values)[:2], archive.values.shape[1])
        corrected = state.descended(predicted[chosen], aims, state.options.brief)
        return np.concatenate([predicted, corrected])


def _parts(shares: FloatArray, share: float) -> FloatArray:
    """Into how many parts gaps are divided, so that all together come down to a share with the least number."""
    roots = np.sqrt(shares)
    total = float(roots.sum())
    if shares.sum() <= share or total <= 0.0:
        return np.ones(len(shares))
    scale = min(total / share, CONTINUATION.most / total)
    parts: FloatArray = np.ceil(scale * roots - 1e-9)
    return parts


def _matched(space: DesignSpace, first: FloatArray, second: FloatArray) -> FloatArray | None:
    """The second design (m, g) in the order of the first one's measurements, or None where it is of another valley."""
    span = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
    distance = np.abs(first[:, None] - second[None]) / np.where(space.discrete, 1.0, span)
    order = linear_sum_assignment((distance**2).sum(axis=2))[1]
    matched: FloatArray = second[order]
    apart = np.abs(matched - first) / span
    same = (matched == first)[:, space.discrete].all() and bool((apart[:, ~space.discrete] <= CONTINUATION.same).all())
    return matched if same else None


class FrontDescent:
    """Pursues points along the front from the best designs known for them."""

    name = "gradients"

    def offspring(self, state: State) -> FloatArray:
        points, steps = state.options.along
        aims = state.aims(points)
        return state.descended(state.best(aims), aims, steps)
