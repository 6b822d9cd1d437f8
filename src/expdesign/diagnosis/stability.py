"""How often the same effects are named when a tenth of the rows is left out (stability selection).

For every tenth the model is fitted to the other nine, linear about its fit to all, and an effect is named where its log
evidence there is worth its price as in the search. Meinshausen and Bühlmann, Journal of the Royal Statistical Society
B 72 (2010) 417, judge names by such shares; they draw halves.
"""

from collections.abc import Hashable, Sequence, Set
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import IntArray
from expdesign.diagnosis.cross_validation import blocks_of, readings_of
from expdesign.diagnosis.evidence.options import EVIDENCE
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.names import Model, Names
from expdesign.diagnosis.options import OPTIONS


@dataclass(frozen=True)
class Stability:
    """Shares of the refits.

    Attributes:
        refits: their number.
        same: share that names all the effects.
        shares: of each effect of the model, in its order: that it is named.
    """

    refits: int
    same: float
    shares: tuple[float, ...]


def stability(names: Names, model: Model) -> Stability | None:
    """Shares of the refits that name the effects of a model; None where it has none, or a tenth holds no row."""
    if not model.candidates:
        return None
    sample = names.sample.restricted(~model.outliers)
    blocks = blocks_of(sample, OPTIONS.refits)
    if len(np.unique(blocks[sample.counts])) < OPTIONS.refits:
        return None
    prices = [names.price(candidate) + EVIDENCE.alarm for candidate in model.candidates]
    refits = named_without_tenths(names.state(model), readings_of(blocks, names.sample), prices)
    return shares_of(range(len(model.candidates)), refits)


def named_without_tenths(state: Present, owner: IntArray, prices: Sequence[float]) -> list[frozenset[int]]:
    """Laws of a state that bring their price in log evidence on the readings of all blocks but one, for every block.

    Args:
        state: the model, to first order.
        owner: block of every reading, shape (M,).
        prices: of each law.
    """
    found = []
    for tenth in np.unique(owner):
        rest = state.of_rows(owner != tenth).refitted()
        gains = [rest.log_evidence - rest.without(k).refitted().log_evidence for k in range(len(rest.laws))]
        found.append(frozenset(k for k, (gain, price) in enumerate(zip(gains, prices, strict=True)) if gain > price))
    return found


def shares_of(names: Sequence[Hashable], refits: Sequence[Set[Hashable]]) -> Stability:
    """Shares of refits that name each of some names, and all of them."""
    shares = tuple(float(np.mean([name in refit for refit in refits])) for name in names)
    return Stability(len(refits), float(np.mean([set(names) <= refit for refit in refits])), shares)
