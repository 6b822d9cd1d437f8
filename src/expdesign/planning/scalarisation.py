"""What a search aims at: directions in the space of the objectives (Pascoletti & Serafini 1984).

min max_k (f_k − z_k)·weight_k reaches convex and concave parts of a front alike; a weight of 0 leaves a criterion out,
so that an end of the front is an aim with one weight.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray


def achieved(values: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
    """max_k (f_k − centre_k)·weight_k over the criteria that have weight, of (..., k)."""
    with np.errstate(invalid="ignore"):  # a value of -∞ without weight
        found: FloatArray = np.where(weights > 0.0, (values - centres) * weights, -np.inf).max(axis=-1)
    return found


@dataclass(frozen=True)
class Aims:
    """Directions of b descents or exchanges.

    Attributes:
        centres: z, shape (b, k).
        weights: shape (b, k).
    """

    centres: FloatArray
    weights: FloatArray

    @classmethod
    def of_one(cls, count: int) -> "Aims":
        """So many that look at one criterion, which is the only one."""
        return cls(np.zeros((count, 1)), np.ones((count, 1)))

    def __len__(self) -> int:
        return len(self.centres)

    def __getitem__(self, index: IntArray | BoolArray | slice) -> "Aims":
        return Aims(self.centres[index], self.weights[index])

    def joined(self, other: "Aims") -> "Aims":
        """Both, one after the other."""
        return Aims(np.concatenate([self.centres, other.centres]), np.concatenate([self.weights, other.weights]))

    @property
    def single(self) -> BoolArray:
        """Which look at one criterion alone, shape (b,)."""
        found: BoolArray = (self.weights > 0.0).sum(axis=1) == 1
        return found

    def scores(self, values: FloatArray) -> FloatArray:
        """How far designs with criteria (d, k) are from every aim, shape (b, d); a large number without a value."""
        found = achieved(values[None], self.centres[:, None], self.weights[:, None])
        return np.where(np.isfinite(found), found, 1e30)


def spans(values: FloatArray) -> FloatArray:
    """Range of each criterion over designs (d, k), shape (k,); its size where they are a point."""
    finite = values[np.isfinite(values).all(axis=1)]
    if len(finite) == 0:
        return np.ones(values.shape[1])
    span = finite.max(axis=0) - finite.min(axis=0)
    size = np.abs(finite).max(axis=0)
    result: FloatArray = np.maximum(np.maximum(span, 1e-3 * size), 1e-300)
    return result


def ends(values: FloatArray) -> Aims:
    """Each criterion of designs (d, k) alone."""
    return Aims(np.tile(values.min(axis=0), (values.shape[1], 1)), np.eye(values.shape[1]) / spans(values))


def along(values: FloatArray, objectives: int, count: int, shift: float) -> Aims:
    """Points along the front of designs with criteria (d, k), of which the first are the objectives.

    Args:
        values: of non-dominated designs.
        objectives: how many of the criteria span the front.
        count: of points.
        shift: place of the first one, in parts of the distance between two.
    """
    span = spans(values)[:objectives]
    points = _evenly(values[:, :objectives] / span, count, shift) * span
    return at_points(points, span, values.shape[1])


def at_points(points: FloatArray, span: FloatArray, criteria: int) -> Aims:
    """Aims at points (b, objectives) of the space of the objectives, which have such spans."""
    centres, weights = np.zeros((2, len(points), criteria))
    centres[:, : points.shape[1]] = points
    weights[:, : points.shape[1]] = 1.0 / span
    return Aims(centres, weights)


def _evenly(front: FloatArray, count: int, shift: float) -> FloatArray:
    """Points (count, k) evenly spaced along a front (d, k) of two objectives; of more objectives, its own points."""
    if front.shape[1] != 2 or len(front) == 1:
        order = np.argsort(front[:, 0], kind="stable")
        chosen = np.unique(np.linspace(0, len(front) - 1, min(count, len(front))).round().astype(np.int64))
        return front[order][chosen]
    line = front[np.lexsort((-front[:, 1], front[:, 0]))]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = length[-1] * (np.arange(count) + shift) / count
    return np.stack([np.interp(at, length, line[:, k]) for k in (0, 1)], axis=1)
