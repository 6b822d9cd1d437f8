"""Exchange of two measurements of a plan at once, where that of one does not help: for plans whose load errors cancel.

What errors that all measurements share do to the compliances is M⁻¹·S, with S the sum over the measurements
(`additive.py`). In a plan of little FEIR the S_j cancel, and whichever measurement is exchanged alone, they no longer
do: such plans are valleys from which no single exchange leads. Of two exchanged at once there are l² for l
alternatives, too many to be judged one by one. With the gain g = T·M⁻¹ of the plan as it is,

    FEIR² ≈ |g·S|² + tr(g·N·gᵀ) , DUIR² ≈ tr(g·(2·M_plan − M)·gᵀ)

of all pairs is one product of matrices; the most promising alternative for each first partner is then judged exactly.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.additive import additive
from expdesign.design.optimality.sum_exchange import scores_of
from expdesign.design.problem import DesignProblem

_JUDGED = 60
"""Pairs that are judged exactly."""
_LEAST = 0.05
"""Part of DUIR² that remains at least: the linear estimate may come to less than nothing."""


def exchanged_in_pairs(
    problem: DesignProblem,
    designs: FloatArray,
    centres: FloatArray,
    weights: FloatArray,
    places: IntArray,
    names: tuple[str, ...],
    offered: FloatArray,
) -> FloatArray:
    """Designs (b, m, g) after exchanges of two measurements at once, as far as they help.

    Args:
        problem: the design problem, in which measurements do not share their reference.
        designs: shape (b, m, g).
        centres: of the aims, shape (b, k).
        weights: of the aims, shape (b, k).
        places: which two measurements are exchanged, one pair after the other, shape (b, p, 2).
        names: of the criteria, k, of those in `additive.py`.
        offered: measurements for any two of which they are exchanged, shape (l, g).
    """
    exchange = PairExchange(problem, names, offered)
    improved = [exchange.improved(*each) for each in zip(designs, centres, weights, places, strict=True)]
    return np.stack(improved) if improved else designs.copy()


class PairExchange:
    """Pairs out of some measurements.

    Args:
        problem: see `exchanged_in_pairs`.
        names: see there.
        offered: see there.
    """

    def __init__(self, problem: DesignProblem, names: tuple[str, ...], offered: FloatArray) -> None:
        self._names, self._offered = names, offered
        self._sums = additive(problem, 1.0)
        self._parts = self._sums.parts(offered)
        self._terms = self._sums.terms(self._parts)

    def improved(self, design: FloatArray, centre: FloatArray, weight: FloatArray, places: IntArray) -> FloatArray:
        """A design (m, g) after the exchanges at `places` (p, 2) that help, for an aim (k,), (k,)."""
        design, parts = design.copy(), self._sums.parts(design)
        score = self._score(parts.sum(axis=0), centre, weight)
        for pair in places:
            first, second = self._promising(parts, pair, centre, weight)
            # Sums of what remains, not differences, which would lose digits.
            rest = np.delete(parts, pair, axis=0).sum(axis=0)
            found = self._score(rest + self._parts[first] + self._parts[second], centre, weight)
            best = int(found.argmin())
            if found[best] < score - 1e-9 * (1.0 + abs(float(score))):
                chosen = [first[best], second[best]]
                design[pair], parts[pair], score = self._offered[chosen], self._parts[chosen], found[best]
        return design

    def _score(self, sums: FloatArray, centre: FloatArray, weight: FloatArray) -> FloatArray:
        return scores_of(self._sums, self._names, sums, centre, weight)

    def _promising(
        self, parts: FloatArray, pair: IntArray, centre: FloatArray, weight: FloatArray
    ) -> tuple[IntArray, IntArray]:
        """Alternatives (c,), (c,), by index, for the two measurements of a plan with parts (m, c)."""
        with np.errstate(all="ignore"):  # of a plan that identifies nothing
            noise, force = self.estimates(parts, pair)
        squares = {"duir": noise, "feir": force, "total": noise + force}
        aimed = [k for k in range(len(self._names)) if weight[k] > 0.0]
        parted = [(np.sqrt(squares[self._names[k]]) - centre[k]) * weight[k] for k in aimed]
        score = np.maximum.reduce(parted)
        partner = score.argmin(axis=1)
        first = np.argsort(score[np.arange(len(score)), partner], kind="stable")[:_JUDGED]
        return first, partner[first]

    def estimates(self, parts: FloatArray, pair: IntArray) -> tuple[FloatArray, FloatArray]:
        """DUIR² and FEIR² (l, l) of a plan with parts (m, c) for every two alternatives of a pair of its measurements.

        By the gain of the plan as it is, and at the target that is worst now.
        """
        whole = parts.sum(axis=0)
        noise, force = self._sums.variances(whole)
        worst = int((noise + force).argmax())
        gain = self._sums.gains(self._sums.terms(whole)[0])[worst]

        def squares(terms: FloatArray) -> FloatArray:
            found: FloatArray = ((gain @ terms) * gain).sum(axis=(-2, -1))
            return found

        information, own, common = self._terms
        _, rest_own, rest = self._sums.terms(np.delete(parts, pair, axis=0).sum(axis=0))
        told, lost = squares(information), squares(self._sums.terms(parts[pair])[0]).sum()
        reach, own = (gain @ common).reshape(len(common), -1), squares(own)
        along = (gain @ rest).ravel() + reach
        both = 2.0 * along @ reach.T
        both += ((along**2).sum(axis=1) + own + squares(rest_own))[:, None]
        both += (reach**2).sum(axis=1) + own
        found = noise[worst] + lost - told[:, None] - told
        return np.maximum(found, _LEAST * noise[worst]), np.maximum(both, 0.0)
