"""What is read off a set of non-dominated designs: the recommended one, the knee, the hypervolume."""

from dataclasses import dataclass

import numpy as np
from pymoo.indicators.hv import HV
from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting

from expdesign.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Front:
    """Non-dominated designs, ordered by their first objective.

    Attributes:
        decisions: shape (d, m, g).
        criteria: every known criterion of each design, shape (d,) each.
        objectives: names of the criteria that span the front.
        recommended: index of the design with the least `total`, of those expected to pass where acceptance was asked.
        knee: index of the compromise of the scaled front.
        kktpm: proximity of each design to the optimality conditions (0: satisfied), NaN where it has no gradient.
        hypervolume: dominated by the front, in the objectives' units with maximised ones negated.
        reference_point: of the hypervolume.
        evaluations: designs evaluated by the search.
        missing: estimated share of the hypervolume that the front lacks; None where nothing is known of it.
        ended: why the search ended, in words.
        complete: whether every design there is was evaluated, so that none is better than those on the front.
        passing: how many designs are expected to pass; None where that was not asked.
    """

    decisions: FloatArray
    criteria: dict[str, FloatArray]
    objectives: tuple[str, ...]
    recommended: int
    knee: int
    kktpm: FloatArray
    hypervolume: float
    reference_point: FloatArray
    evaluations: int
    missing: float | None = None
    ended: str = ""
    complete: bool = False
    passing: int | None = None

    def __len__(self) -> int:
        return len(self.decisions)


def non_dominated(values: FloatArray) -> IntArray:
    """Indices of the non-dominated rows of values (d, k), all minimised; of equal rows the first is kept."""
    _, unique = np.unique(values, axis=0, return_index=True)
    candidates = np.sort(unique)
    fronts = NonDominatedSorting().do(values[candidates], only_non_dominated_front=True)
    indices: IntArray = np.sort(candidates[np.asarray(fronts, dtype=np.int64)])
    return indices


def spread(values: FloatArray, kept: list[int], count: int) -> IntArray:
    """Indices of at most `count` rows of a front (d, k) that cover it evenly, those in `kept` among them.

    Each further row is the one farthest from those chosen, with every objective scaled to its range over the front.
    """
    if len(values) <= count:
        return np.arange(len(values))
    low, high = values.min(axis=0), values.max(axis=0)
    scaled = (values - low) / np.where(high > low, high - low, 1.0)
    chosen = list(dict.fromkeys([*np.argmin(values, axis=0).tolist(), *kept]))
    return np.sort(np.array([*chosen, *farthest(scaled, scaled[chosen], count - len(chosen))], dtype=np.int64))


def farthest(rows: FloatArray, known: FloatArray, count: int) -> list[int]:
    """Indices of `count` of some rows (d, k), each the farthest from the known ones (e, k) and those before it."""
    distance = np.linalg.norm(rows[:, None] - known, axis=-1).min(axis=1)
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(rows - rows[chosen[-1]], axis=1))
    return chosen


def knee(values: FloatArray) -> int:
    """Compromise of the scaled front: the row of values (d, k) nearest to the ideal point when every objective is
    scaled to [0, 1] over the front (theory.md 6, fig. 3.12).
    """
    low, high = values.min(axis=0), values.max(axis=0)
    scaled = (values - low) / np.where(high > low, high - low, 1.0)
    return int(np.argmin(np.linalg.norm(scaled, axis=1)))


def reference_point(values: FloatArray) -> FloatArray:
    """A point worse than every row of values (d, k): the largest of each objective and a tenth of its range more."""
    low, high = values.min(axis=0), values.max(axis=0)
    point: FloatArray = high + 0.1 * np.where(high > low, high - low, np.maximum(np.abs(high), 1e-12))
    return point


def hypervolume(values: FloatArray, point: FloatArray) -> float:
    """Hypervolume of values (d, k) with respect to `point`; rows that do not dominate it count nothing."""
    inside: BoolArray = np.logical_and.reduce(values <= point, axis=1)
    return float(HV(ref_point=point)(values[inside])) if inside.any() else 0.0


def gap_shares(values: FloatArray) -> FloatArray:
    """What the hypervolume of a front (d, 2), sorted, lacks between neighbours where it is straight, in its parts.

    Shape (d − 1,): half the rectangle between two neighbours, over the hypervolume that the front itself spans.
    """
    if len(values) < 2:
        return np.zeros(0)
    areas: FloatArray = 0.5 * np.abs(np.diff(values[:, 0]) * np.diff(values[:, 1]))
    return areas / hypervolume(values, reference_point(values))


def drawn_with(values: FloatArray, count: int, share: float, most: int) -> int:
    """How many designs of a front (d, k), at least `count`, draw it; `count` for others than two objectives.

    Args:
        values: of the front.
        count: fewest.
        share: of the hypervolume in the gaps between neighbouring designs that is let pass.
        most: largest number.
    """
    if values.shape[1] != 2:
        return count
    while count < min(len(values), most):
        chosen = values[spread(values, [], count)]
        if gap_shares(chosen[np.argsort(chosen[:, 0])]).sum() <= share:
            break
        count = 5 * count // 4 + 1
    return min(count, max(most, 2))
