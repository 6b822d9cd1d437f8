"""The estimate on the exact chain: what is judged is what that predicts, which is what a file says.

Beside a calibrated geometry further physics is sought on a chain that is linear in the geometry and in the frames of
instrument and markers (`ChainBeside`). A step along what the recordings hardly determine may be long, and what it does
to second order is in no linear model: 37 mrad of a zero against the instrument are 0.4 mm at 0.6 m. So where the two
differ the exact chain is fitted from there, and the model is linear about that estimate.
"""

import numpy as np

from expdesign.arrays import FloatArray, rms
from expdesign.chain.chain import Chain
from expdesign.chain.declaration import LOOSELY
from expdesign.chain.identified import ChainBeside
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data, Fit, fit, summarise

AGREES = 1e-2
"""RMS of the difference between both chains in the rows that were fitted, in standard deviations of a reading."""

Prior = tuple[FloatArray, FloatArray]
"""Mean and standard deviation of all parameters, shape (p,) each."""


def difference(found: Fit, sample: Data, exact: Chain) -> float:
    """How far an exact chain is from what the fit says of the rows that count, RMS in standard deviations."""
    linear, true = (sample.residuals(chain, found.values) for chain in (found.chain, exact))
    return rms(true - linear, sample.counts)


def relinearised(found: Fit, sample: Data, prior: Prior | None = None) -> Fit:
    """The fit to the rows that count, linear about its own estimate; as it is where its chain is exact there.

    Args:
        found: the fit from which the exact one starts.
        sample: rows that count.
        prior: see `fit`; what is known of the parameters, and `proper` of the rest, if left out. The latter only
            chooses among equals: it is no knowledge.
    """
    chain = found.chain
    if not isinstance(chain, ChainBeside) or difference(found, sample, exact := chain.exact) <= AGREES:
        return found
    if (held := prior) is None:
        free = fit(exact, sample, found.values, chain.knowledge(), enough=OPTIONS.settled).values
        held = proper(summarise(chain.about(free), sample, free, chain.knowledge()))
    values = fit(exact, sample, found.values, held, enough=OPTIONS.settled).values
    about = chain.about(values)
    return summarise(about, sample, values, prior or about.knowledge(released=True))


def proper(free: Fit) -> Prior | None:
    """What is known of the parameters before anything is measured, also of physics of which nothing is.

    The size that an effect has on machines of its class (`Effect.size`) holds loosely what no reading determines, so
    that a step there is the shortest one. What readings determine is not pulled at: where they show more than that
    size, what they show is the size. None where nothing is known at all.

    Args:
        free: the fit that nothing of this holds.
    """
    chain = free.chain
    known = chain.knowledge()
    if known is None:
        return None
    mean, deviation = known[0], known[1].copy()
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        away, unsure = np.abs(free.values[part] - effect.neutral()), np.sqrt(np.diag(free.covariance)[part])
        sizes = [effect.size(parameter) for parameter in effect.parameters]
        typical = np.array([p.scale if s.of else s.value for p, s in zip(effect.parameters, sizes, strict=True)])
        loose = LOOSELY * np.maximum(typical, np.where(away > OPTIONS.noticeable * unsure, away, 0.0))
        linear = np.array([not parameter.shape for parameter in effect.parameters])
        deviation[part] = np.where(linear & ~np.isfinite(deviation[part]), loose, deviation[part])
    return mean, deviation
