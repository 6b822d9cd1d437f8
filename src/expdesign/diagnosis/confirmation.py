"""Whether each effect of a model, by itself, improves the prediction of recordings that were not fitted.

The penalised misfit trusts the stated noise and the independence of rows. Where a model leaves more than noise, neither
can be trusted: filtered readings are correlated, standard deviations are misstated, and any smooth effect gains
"significantly" on thousands of readings. Held-out rows do not care. For every effect the model is refitted without it;
the squares of the held-out residuals are compared block by block of consecutive rows (rows within a block may be
correlated), and the effect stays where the mean difference exceeds zero by a one-sided t-test over blocks.

Names are judged by stability selection as well: how often the same effects are named when a tenth of the rows is left
out. For every tenth the model is fitted to the other nine, linear about its fit to all, and an effect is named where
its log evidence there is worth its price as in the search. Meinshausen and Bühlmann, Journal of the Royal Statistical
Society B 72 (2010) 417, judge names by such shares; they draw halves.
"""

from collections.abc import Hashable, Sequence, Set
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.diagnosis.cross_validation import LeftOut, blocks_of, readings_of
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.names import NamedModel, Names, hierarchical
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data, Fit


@dataclass(frozen=True)
class Gain:
    """What one effect does for held-out rows.

    Attributes:
        without, with_it: RMS of the held-out residuals, 1 being the noise.
        p_value: of no improvement.
    """

    without: float
    with_it: float
    p_value: float


def gains(names: Names, model: NamedModel, test: BoolArray) -> list[Gain] | None:
    """Gain of every effect of a model, in the order of its candidates; None where too few rows are held out."""
    sample = names.sample.counting(test)
    blocks = _blocks(sample)
    if blocks is None:
        return None
    of_readings = np.repeat(blocks, len(sample.recordings.axes))
    own = _errors(model.fit, sample)
    found = []
    for index in range(len(model.candidates)):
        both = LeftOut(_errors(names.without(model, index).fit, sample), own, of_readings)
        found.append(Gain(both.rms_before, both.rms_after, both.p_value))
    return found


def confirmed(names: Names, model: NamedModel, test: BoolArray) -> NamedModel:
    """The model without the effects that do not improve the prediction of held-out rows, worst first."""
    while True:
        found = gains(names, model, test)
        if not found:
            return model
        order = sorted(range(len(found)), key=lambda i: -found[i].p_value)
        dropped = False
        for index in order:
            if found[index].p_value < OPTIONS.gain_level:
                break
            smaller = names.without(model, index)
            if hierarchical(smaller.effects):
                reason = f"held-out rows do not gain by `{model.effects[index].key}` (p = {found[index].p_value:.2g})"
                names.log.add("held out", smaller, True, reason)
                model, dropped = smaller, True
                break
        if not dropped:
            return model


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


def _blocks(sample: Data) -> IntArray | None:
    """Block of every row that counts; None where there are too few."""
    most = min(OPTIONS.refits, int(sample.counts.sum()) // OPTIONS.groups)
    return blocks_of(sample, most)[sample.counts] if most >= OPTIONS.groups else None


def _errors(fitted: Fit, sample: Data) -> FloatArray:
    """Whitened residuals of the readings that count, shape (M,)."""
    return sample.residuals(fitted.chain, fitted.values)[sample.counts].ravel()


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
