"""Whether each effect of a model, by itself, improves the prediction of readings that were left out.

The penalised misfit trusts the stated noise and the independence of rows. Where a model leaves more than noise, neither
can be trusted: filtered readings are correlated, standard deviations are misstated, and any smooth effect gains
"significantly" on thousands of readings. Left-out rows do not care. The model, linear about its fit, is compared with
itself without the effect by the readings of blocks that neither was fitted to (`LeftOut`), and the effect stays where
these gain by it. So does what marked rows, or later ones, refute (`HeldOut.refuted`).

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
from expdesign.diagnosis.dispersion import dispersion, tested
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.names import NamedModel, Names, hierarchical
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.verdict import within_noise
from expdesign.estimation.fit import Fit


def gains(state: Present, blocks: IntArray) -> list[LeftOut]:
    """What every law of a state does for left-out readings, the others beside it resized.

    Args:
        state: the model, to first order.
        blocks: block of every reading, shape (M,).
    """
    own = state.left_out(blocks)
    return [LeftOut(state.without(k).refitted().left_out(blocks), own, blocks) for k in range(len(state.laws))]


def confirmed(names: Names, model: NamedModel, base: Fit, test: BoolArray) -> tuple[NamedModel, HeldOut]:
    """The model without the effects that rows which were not fitted speak against, and its errors there.

    Backward elimination, so that one effect that describes the fitted rows alone does not take the others with it.
    While held-out rows refute the model that effect goes without which they are predicted best. Where they do not, and
    the model does not bring independent rows to the stated noise, those go by which left-out readings do not gain,
    worst first.

    Args:
        names: of the model.
        model: with named effects alone.
        base: fit of the base model in all rows.
        test: rows that were not fitted (N,), see `held_out`.
    """

    def judged(one: NamedModel) -> HeldOut:
        return held_out(base, one.fit, names.sample, test, known_noise=names.known_noise)

    errors = judged(model)
    refuted = errors.refuted
    while model.candidates and errors.refuted == refuted:
        effects = model.effects
        removable = [k for k in range(len(effects)) if hierarchical(effects[:k] + effects[k + 1 :])]
        if refuted:
            trials = {k: judged(names.without(model, k)) for k in removable}
            worst = min(removable, key=lambda k: (trials[k].refuted, trials[k].test_after))
            reason = f"held-out rows are predicted worse with all effects than without any; `{effects[worst].key}` goes"
        else:
            # Where more than noise remains, or rows are alike, the penalised misfit trusts what is not so.
            alike = dispersion(model.fit.residuals, names.sample).correlation > OPTIONS.correlated
            if names.known_noise and within_noise(tested(model.fit, names.sample)) and not alike:
                break
            p_values = [gain.p_value for gain in gains(names.state(model), names.blocks)]
            worst = max(removable, key=lambda k: p_values[k])
            if p_values[worst] < OPTIONS.gain_level:
                break
            reason = f"left-out rows are predicted no better with `{effects[worst].key}` (p = {p_values[worst]:.2g})"
        model = names.without(model, worst)
        errors = judged(model)
        names.log.add("held out", reason, model)
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
