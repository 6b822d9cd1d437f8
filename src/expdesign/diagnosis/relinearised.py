"""Gauss-Newton about the estimate: what is judged is what the exact chain predicts, which is what a file says.

Beside a calibrated geometry further physics is sought on a chain that is linear in the geometry and in the frames of
instrument and markers (`ChainBeside`). A step along what the recordings hardly determine may be long, and what it does
to second order is in no linear model: 37 mrad of a zero against the instrument are 0.4 mm at 0.6 m. So a fit is
repeated about its own estimate until both chains agree.
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
_PASSES = 12
_SHORTEST = 1e-3
"""Part of a step that is made at least."""

Prior = tuple[FloatArray, FloatArray]
"""Mean and standard deviation of all parameters, shape (p,) each."""


def difference(found: Fit, sample: Data, exact: Chain) -> float:
    """How far an exact chain is from what the fit says of the rows that count, RMS in standard deviations."""
    linear, true = (sample.residuals(chain, found.values) for chain in (found.chain, exact))
    return rms(true - linear, sample.counts)


def relinearised(found: Fit, sample: Data, prior: Prior | None = None) -> Fit:
    """The fit to the rows that count, linear about its own estimate; as it is where its chain is exact.

    Whole steps lead there from far away. Where they swing about instead, every step goes as far as the exact chain fits
    better.

    Args:
        found: the fit from which the passes start.
        sample: rows that count.
        prior: see `fit`; what is known of the parameters, and `proper` of the rest, if left out.
    """
    if not isinstance(found.chain, ChainBeside):
        return found
    exact = found.chain.exact
    for shortest in (1.0, _SHORTEST):
        nearest, part = found, 1.0
        for _ in range(_PASSES):
            if part == 1.0 and difference(nearest, sample, exact) <= AGREES:
                return nearest
            nearest, part = _pass(nearest, sample, exact, prior, shortest)
    return nearest


def _pass(found: Fit, sample: Data, exact: Chain, prior: Prior | None, shortest: float) -> tuple[Fit, float]:
    """The fit linear about the present estimate, and the part of the step there that was made, `shortest` at least."""
    assert isinstance(found.chain, ChainBeside)
    chain = found.chain.about(found.values)
    held = prior or proper(fit(chain, sample, found.values, enough=OPTIONS.settled))
    nearest = fit(chain, sample, found.values, held, enough=OPTIONS.settled)
    before, step, part = _misfit(exact, sample, found.values, held), nearest.values - found.values, 1.0
    while part > shortest and _misfit(exact, sample, nearest.values, held) > before:
        part *= 0.5
        values = found.values + part * step
        nearest = summarise(chain.about(values), sample, values, held)
    return (nearest if prior else _without_sizes(nearest, sample)), part


def _misfit(exact: Chain, sample: Data, values: FloatArray, prior: Prior | None) -> float:
    """Squared residuals of the exact chain in the rows that count, and how far the prior is away."""
    left = sample.residuals(exact, values)[sample.counts]
    away = 0.0 if prior is None else (((values - prior[0]) / prior[1]) ** 2).sum()
    return float((left**2).sum() + away)


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
