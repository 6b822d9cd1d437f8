"""Minimal complete sets of parameters: which columns of the sensitivities are combinations of others, and of which.

A kinematic chain has more parameters than its readings can show: a shift along the axis of a revolute joint is one of
the next joint's frame, a turn about it is the joint's zero, the first joint's zero is a turn of the base. As in
Gautier's base parameters (J. Robotic Systems 8, 1991, 485) an orthogonal factorisation finds them, here in an order of
preference instead of by pivoting on norms: what people know by name (instrument, markers, zeros) is kept before frames,
and two sets of recordings of one machine name the same parameters.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray

_SLIGHT = 0.01
"""Part of a column's norm; with more left it comes in its turn."""


@dataclass(frozen=True)
class MinimalSet:
    """A choice among p parameters.

    Attributes:
        kept: indices of the parameters that are identified, in increasing order.
        dropped: of those that stay as drawn.
        combinations: what a unit of every dropped parameter adds to every kept one, shape (len(dropped), len(kept)).
    """

    kept: IntArray
    dropped: IntArray
    combinations: FloatArray

    def standing_in(self, kept: slice) -> IntArray:
        """Indices of the dropped parameters that those within `kept` stand for, among others."""
        own = (self.kept >= kept.start) & (self.kept < kept.stop)
        found: IntArray = self.dropped[self.combinations[:, own].any(axis=1)]
        return found

    def unseen(self, count: int) -> FloatArray:
        """Steps of all `count` parameters that no reading shows: a dropped one, and those that stand for it back.

        Columns of the sensitivities S fulfil s_d = Σ s_k·c_dk, so that S·N = 0 with N = [1; −cᵀ]; shape (count, d).
        """
        steps = np.zeros((count, len(self.dropped)))
        steps[self.dropped, np.arange(len(self.dropped))] = 1.0
        steps[self.kept] = -self.combinations.T
        return steps

    def widened(self, deviations: FloatArray) -> FloatArray:
        """Deviations (p,) of the kept parameters with the part of the dropped ones that these stand for.

        One of which nothing is known (∞) adds nothing to those that do not stand for it.
        """
        result = deviations.copy()
        spread = np.broadcast_to(deviations[self.dropped][:, None], self.combinations.shape)
        added = np.zeros(self.combinations.shape)
        np.multiply(self.combinations, spread, out=added, where=self.combinations != 0.0)
        result[self.kept] = np.sqrt(deviations[self.kept] ** 2 + (added**2).sum(axis=0))
        return result


def minimal_set(matrix: FloatArray, order: IntArray, tolerance: float) -> MinimalSet:
    """The first parameters in `order` (p,) whose columns of `matrix` (M, p) are independent of those before them.

    Args:
        matrix: sensitivities, columns in comparable units.
        order: indices of the parameters, the preferred ones first; others are neither kept nor dropped.
        tolerance: part of a column's norm that has to be left. A column of which only a slight part is left waits for
            all others, or between nearly parallel axes it would stand for one of them a thousandfold.
    """
    reduced: FloatArray = np.asarray(np.linalg.qr(matrix, mode="r"))
    norms = np.linalg.norm(reduced, axis=0)
    basis, kept, waiting = np.zeros((len(reduced), 0)), [], order.tolist()
    for least in (max(_SLIGHT, tolerance), tolerance):
        slight = []
        for index in waiting:
            left = reduced[:, index] / norms[index] if norms[index] > 0.0 else np.zeros(len(reduced))
            for _ in range(2):  # twice is enough (Kahan, in Parlett, The Symmetric Eigenvalue Problem, 1980, 6.9)
                left = left - basis @ (basis.T @ left)
            size = float(np.linalg.norm(left))
            if norms[index] > tolerance * norms.max() and size > least:
                basis = np.column_stack([basis, left / size])
                kept.append(index)
            else:
                slight.append(index)
        waiting = slight
    chosen, others = np.array(sorted(kept), dtype=np.int64), np.array(waiting, dtype=np.int64)
    scale = np.where(norms > 0.0, norms, 1.0)
    solved = np.linalg.lstsq(reduced[:, chosen] / scale[chosen], reduced[:, others] / scale[others], rcond=None)[0]
    combinations = (solved * scale[others] / scale[chosen][:, None]).T
    return MinimalSet(chosen, others, np.where(np.abs(combinations) < tolerance, 0.0, combinations))
