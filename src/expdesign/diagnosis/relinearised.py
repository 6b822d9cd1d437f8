"""Gauss-Newton about the estimate: what is judged is what the exact chain predicts, which is what a file says.

Beside a calibrated geometry further physics is sought on a chain that is linear in the geometry and in the frames of
instrument and markers (`ChainBeside`). A step along what the recordings hardly determine may be long, and what it does
to second order is in no linear model: 37 mrad of a zero against the instrument are 0.4 mm at 0.6 m. So a fit is
repeated about its own estimate until both chains agree.
"""

import numpy as np

from expdesign.arrays import FloatArray, rms
from expdesign.chain.declaration import LOOSELY
from expdesign.chain.identified import ChainBeside
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data, Fit, fit, summarise

AGREES = 1e-2
"""RMS of the difference between both chains in the rows that were fitted, in standard deviations of a reading."""
_PASSES = 12

Prior = tuple[FloatArray, FloatArray]
"""Mean and standard deviation of all parameters, shape (p,) each."""


def difference(found: Fit, sample: Data) -> float:
    """How far the exact chain is from what the fit says of the rows that count, RMS in standard deviations."""
    if not isinstance(found.chain, ChainBeside):
        return 0.0
    linear, exact = (sample.residuals(chain, found.values) for chain in (found.chain, found.chain.exact))
    return rms(exact - linear, sample.counts)


def relinearised(found: Fit, sample: Data, prior: Prior | None = None) -> Fit:
    """The fit to the rows that count, linear about its own estimate; as it is where its chain is exact.

    Args:
        found: the fit from which the passes start.
        sample: rows that count.
        prior: see `fit`; what is known of the parameters, and `proper` of the rest, if left out.
    """
    for _ in range(_PASSES):
        if difference(found, sample) <= AGREES or not isinstance(found.chain, ChainBeside):
            break
        chain = found.chain.about(found.values)
        held = prior or proper(fit(chain, sample, found.values, enough=OPTIONS.settled))
        nearest = fit(chain, sample, found.values, held, enough=OPTIONS.settled)
        found = nearest if prior else _without_sizes(nearest, sample)
    return found


def _without_sizes(found: Fit, sample: Data) -> Fit:
    """With the covariance of what is known without `proper`: a size that chooses among equals is no knowledge."""
    known = summarise(found.chain, sample, found.values, found.chain.knowledge(released=True))
    return found.known_as(known.estimable)


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
