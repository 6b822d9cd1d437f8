"""Whether each effect of a model, by itself, improves the prediction of readings that were left out.

The penalised misfit trusts the stated noise and the independence of rows. Where a model leaves more than noise, neither
can be trusted: filtered readings are correlated, standard deviations are misstated, and any smooth effect gains
"significantly" on thousands of readings. Left-out rows do not care. The model, linear about its fit, is compared with
itself without the effect by the readings of blocks that neither was fitted to (`LeftOut`), and the effect stays where
these gain by it.

Names are judged by stability selection as well: how often the same effects are named when a tenth of the rows is left
out. For every tenth the model is fitted to the other nine, linear about its fit to all, and an effect is named where
its log evidence there is worth its price as in the search. Meinshausen and Bühlmann, Journal of the Royal Statistical
Society B 72 (2010) 417, judge names by such shares; they draw halves.
"""

from collections.abc import Hashable, Sequence, Set
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, IntArray
from expdesign.diagnosis.cross_validation import LeftOut, blocks_of, readings_of
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.names import NamedModel, Names, hierarchical
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Fit


def gains(state: Present, blocks: IntArray) -> list[LeftOut]:
    """What every law of a state does for left-out readings, the others beside it resized.

    Args:
        state: the model, to first order.
        blocks: block of every reading, shape (M,).
    """
    own = state.left_out(blocks)
    return [LeftOut(state.without(k).refitted().left_out(blocks), own, blocks) for k in range(len(state.laws))]


def confirmed(names: Names, model: NamedModel) -> NamedModel:
    """The model without the effects that do not improve the prediction of left-out readings, worst first."""
    while True:
        p_values = [gain.p_value for gain in gains(names.state(model), names.blocks)]
        doubtful = [
            index
            for index, p_value in enumerate(p_values)
            if p_value >= OPTIONS.gain_level and hierarchical(model.effects[:index] + model.effects[index + 1 :])
        ]
        if not doubtful:
            return model
        worst = max(doubtful, key=lambda index: p_values[index])
        reason = f"left-out rows do not gain by `{model.effects[worst].key}` (p = {p_values[worst]:.2g})"
        model = names.without(model, worst)
        names.log.add("held out", model, True, reason)


def pruned(names: Names, model: NamedModel, base: Fit, test: BoolArray) -> tuple[NamedModel, HeldOut]:
    """A model that predicts rows that were not fitted better than the base model does, with its errors.

    Where it predicts them worse, the effect goes without which they are predicted best, then the next one: backward
    elimination, so that one effect that describes the fitted rows alone does not take the others with it.
    """
    errors = held_out(base, model.fit, names.sample, test, known_noise=names.known_noise)
    worse = errors.refuted
    while worse and model.candidates:
        smaller = [names.without(model, index) for index in range(len(model.candidates))]
        trials = [
            (held_out(base, other.fit, names.sample, test, known_noise=names.known_noise), other)
            for other in smaller
            if hierarchical(other.effects)
        ]
        best = min(trials, key=lambda trial: (trial[0].refuted, trial[0].test_after))
        if not errors.refuted and best[0].test_after > OPTIONS.better * errors.test_after:
            break
        gone = next(iter(set(model.keys) - set(best[1].keys)))
        errors, model = best
        reason = f"held-out rows are predicted worse with all effects than without any; `{gone}` goes first"
        names.log.add("held out", model, True, reason)
    if worse and not model.candidates:
        model = names.base
        errors = held_out(base, model.fit, names.sample, test, known_noise=names.known_noise)
    return model, errors


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


def stability(names: Names, model: NamedModel) -> Stability | None:
    """Shares of the refits that name the effects of a model; None where it has none, or a tenth holds no row."""
    if not model.candidates:
        return None
    blocks = blocks_of(names.sample, OPTIONS.refits)
    if len(np.unique(blocks[names.sample.counts])) < OPTIONS.refits:
        return None
    prices = [names.price(candidate) + OPTIONS.alarm for candidate in model.candidates]
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
