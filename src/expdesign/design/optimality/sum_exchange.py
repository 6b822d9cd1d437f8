"""Exchange of measurements until none helps, where criteria are sums over them (Fedorov 1972; `additive.py`)."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.design.optimality.additive import Additive, additive
from expdesign.design.optimality.objectives import achieved
from expdesign.design.optimality.variants import variants
from expdesign.design.problem import DesignProblem

_ADDITIVE = ("duir", "feir", "total")
_SWEEPS = 8
_TOGETHER = 10_000_000
"""Largest number of entries of the sums that are formed at once."""


def exchanges_are_sums(problem: DesignProblem, names: tuple[str, ...]) -> bool:
    """Whether criteria with these names depend on sums over measurements, of which each may be exchanged by itself."""
    return not set(names) - set(_ADDITIVE) and problem.space.most_poses is None


def exchanged_by_sums(
    problem: DesignProblem,
    designs: FloatArray,
    centres: FloatArray,
    weights: FloatArray,
    names: tuple[str, ...],
    common: FloatArray,
    varied: bool = False,
    loaded: bool = False,
) -> FloatArray:
    """Designs (b, m, g) at which no exchange of one measurement helps, until which they are improved.

    Args:
        problem: the design problem.
        designs: shape (b, m, g).
        centres: of the aims, shape (b, k).
        weights: of the aims, shape (b, k).
        names: of the criteria, k.
        common: measurements for which any is exchanged, shape (l, g).
        varied: whether measurements are exchanged for their own variants too.
        loaded: whether, where references are shared, they are exchanged for others of their series with another load.
    """
    return _SumExchange(problem, names, varied, loaded).improved(designs, centres, weights, common)


def scores_of(
    sums: Additive, names: tuple[str, ...], options: FloatArray, centres: FloatArray, weights: FloatArray
) -> FloatArray:
    """How far designs are from their aims, (...), by their sums (..., c); centres and weights (..., k) of `names`."""
    with np.errstate(all="ignore"):
        noise, force = sums.variances(options)
        both = {"duir": noise, "feir": force, "total": noise + force}
        values = np.stack([np.sqrt(both[name].max(axis=-1)) for name in names], axis=-1)
        score = achieved(values, centres, weights)
    usable: FloatArray = np.where(np.isfinite(score), score, 1e30)
    return usable


class _SumExchange:
    def __init__(self, problem: DesignProblem, names: tuple[str, ...], varied: bool, loaded: bool) -> None:
        self._problem, self._space, self._names = problem, problem.space, names
        self._varied, self._loaded = varied, loaded
        self._sums = additive(problem, 1.0)

    def improved(self, designs: FloatArray, centres: FloatArray, weights: FloatArray, common: FloatArray) -> FloatArray:
        sums, designs = self._sums, designs.copy()
        (batch, m, g), count = designs.shape, len(common)
        shared, pose = sums.parts(common), self._space.of_pose
        own = self._varied or self._problem.noise.shared_reference
        there = sums.parts(designs.reshape(-1, g)).reshape(batch, m, -1)
        score = scores_of(sums, self._names, sums.sums(there, designs[..., pose]), centres, weights)
        moving = np.arange(len(designs))
        together = max(1, _TOGETHER // (count * shared.shape[1]))
        for _ in range(_SWEEPS):
            helped = np.zeros(len(designs), dtype=bool)
            for place in range(m):
                for start in range(0, len(moving), together):
                    part = moving[start : start + together]
                    # Sums of what remains, not differences, which would lose digits.
                    others, rest = np.delete(designs[part], place, axis=1), np.delete(there[part], place, axis=1)
                    options = sums.joined(rest, others[..., pose], shared[None], common[None][..., pose])
                    if own:
                        more = self._options(designs[part], place)
                        theirs = sums.parts(more.reshape(-1, g)).reshape(*more.shape[:2], -1)
                        joined = sums.joined(rest, others[..., pose], theirs, more[..., pose])
                        options = np.concatenate([options, joined], axis=1)
                    scores = scores_of(sums, self._names, options, centres[part, None], weights[part, None])
                    best = scores.argmin(axis=1)
                    found = scores[np.arange(len(part)), best]
                    better = found < score[part] - 1e-9 * (1.0 + np.abs(score[part]))
                    for row in np.flatnonzero(better):
                        index, chosen = part[row], best[row]
                        listed = chosen < count
                        designs[index, place] = common[chosen] if listed else more[row, chosen - count]
                        there[index, place] = shared[chosen] if listed else theirs[row, chosen - count]
                    score[part[better]], helped[part[better]] = found[better], True
            moving = np.flatnonzero(helped)
            if moving.size == 0:
                break
        return designs

    def _options(self, designs: FloatArray, place: int) -> FloatArray:
        """Alternatives (b, v, g) to the measurement of designs (b, m, g) at a place: where wanted, its variants; where
        references are shared, also a step away, and at the poses of the other ones with loads near theirs.
        """
        own, space = designs[:, place, None], self._space
        found = [variants(self._problem, own)[:, 0]] if self._varied else [space.inward(own, 1)]
        if self._problem.noise.shared_reference:
            others = np.delete(designs, place, axis=1)
            found.append(np.where(space.of_pose, others, own))
        if self._problem.noise.shared_reference and self._loaded:
            found.append(variants(self._problem, others, ~space.of_pose).reshape(len(designs), -1, space.decisions))
        return np.concatenate(found, axis=1)
