"""Published curves: contacts, films, rubber, presliding, creep, gears and cables, as functions of loads and times.

References stand with the kinds. Forces and torques are relative to the largest of a campaign unless units are given.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.special import erf

from ..hexapods import Array


def inverse(curve: Callable[[Array], Array], most: float) -> Callable[[Array], Array]:
    """The inverse of a growing odd curve, between −`most` and `most` of its argument."""
    at = most * np.linspace(0, 1, 4001) ** 2
    reached = curve(at)
    return lambda values: np.sign(values) * np.interp(np.abs(values), reached, at)


def bearing_pair(unloads_at: float) -> Callable[[Array], Array]:
    """Displacement of two preloaded ball bearings by force; one has no load beyond `unloads_at` (2.83 preloads)."""
    preload = unloads_at / 2**1.5

    def force(x: Array) -> Array:
        return np.asarray(preload * ((1 + x) ** 1.5 - np.maximum(1 - x, 0) ** 1.5))

    return inverse(force, 40.0)


def hydrostatic(ratio: float, used: float) -> Callable[[Array], Array]:
    """Eccentricity (over the gap) of two opposed pads by force; the largest force is `used` of what they carry.

    `ratio`: pressure in the centred pads over that of the supply; restrictors are capillaries.
    """
    resistance = (1 - ratio) / ratio

    def load(x: Array) -> Array:
        return np.asarray(1 / (1 + resistance * (1 - x) ** 3) - 1 / (1 + resistance * (1 + x) ** 3))

    carried, eccentricity = float(load(np.array(1.0))), inverse(load, 1.0)
    return lambda force: eccentricity(force * used * carried)


def dahl(path: Array, limit: float, presliding: float, steps: int = 40) -> Array:
    """Friction in the rows of a series whose force grows along `path`, beside a spring of unit stiffness.

    dF/dx = (limit/presliding)·(1 − sgn(dx)·F/limit) with x the displacement: path = x + F. Relaxed at first.
    """
    friction, found, before, steepness = 0.0, np.zeros(len(path)), 0.0, limit / presliding
    for row, now in enumerate(path):
        change = (now - before) / steps
        for _ in range(steps):
            slope = steepness * max(1 - np.sign(change) * friction / limit, 0.0)
            friction += slope / (1 + slope) * change
        found[row], before = friction, now
    return found


def findley(loads: Array, times: Array, exponent: float) -> Array:
    """Creep Σ ΔF·((t − t')/60 s)ⁿ of loads (rows × any) that changed at times t' before their rows (s)."""
    changes = np.diff(loads, axis=0, prepend=np.zeros((1, *loads.shape[1:])))
    since = np.concatenate([[times[0] - 60.0], times[:-1] + 0.1 * np.diff(times)])
    ages = np.maximum(times[:, None] - since[None, :], 0.0)
    weights = np.where(np.arange(len(times))[:, None] >= np.arange(len(times))[None, :], (ages / 60.0) ** exponent, 0.0)
    return np.asarray(weights @ changes)


def rubber(forces: Array, softens: float, damage: float) -> Array:
    """Displacement of a mount by a history of forces: softer with amplitude, and after the largest displacement.

    Kraus: the secant stiffness falls by `softens`·a/(1 + a), a = (2|x|)^1.2. Ogden and Roxburgh: below its largest
    displacement X it is 1 − `damage`·erf(1.5·(X − |x|)/X) of that.
    """

    def virgin(x: Array) -> Array:
        amplitude = (2 * np.abs(x)) ** 1.2
        return np.asarray(x * (1 - softens * amplitude / (1 + amplitude)))

    first, found, largest = inverse(virgin, 20.0), np.zeros(len(forces)), 1e-12
    for row, force in enumerate(forces):
        largest = max(largest, float(first(np.abs(force))))
        at = largest * np.linspace(0, 1, 201)
        softened = (1 - damage * erf(1.5 * (largest - at) / largest)) * virgin(at)
        found[row] = np.sign(force) * np.interp(abs(force), softened, at)
    return found


def windup(knee: float, second: float) -> Callable[[Array], Array]:
    """Windup of a strain-wave gear by torque: stiffness 1, then `second` from `knee` on, then a quarter more."""
    at = np.array([0.0, knee, 2.5 * knee, 10.0])
    turned = np.concatenate([[0.0], np.cumsum(np.diff(at) / [1.0, second, 1.25 * second])])
    return lambda torque: np.sign(torque) * np.interp(np.abs(torque), at, turned)


def mesh_compliance(phase: Array, ratio: float, double: float = 0.6, edge: float = 0.06) -> Array:
    """Compliance of a mesh over tooth periods: 1 with one pair of teeth, 1/`ratio` over the share `double` with two."""
    inside = double / 2 - np.abs((phase + 0.5) % 1.0 - 0.5)
    return np.asarray(1 + (1 / ratio - 1) * 0.5 * (1 + np.tanh(inside / edge)))


def catenary(span: Array, length: float, weight: float) -> Array:
    """Force (rows × 3, N) of a hanging cable on its end at `span` (rows × 3, m) from its other end.

    `length` (m) without strain, `weight` (N/m). With H = w·a the cable is z = a·cosh(x/a) about its lowest point.
    """
    across, rise = np.hypot(span[:, 0], span[:, 1]), span[:, 2]
    slack = np.sqrt(length**2 - rise**2) / across  # = sinh(u)/u with u = across/2a
    grid = np.linspace(1e-4, 12.0, 40001)
    u = np.interp(np.log(slack), np.log(np.sinh(grid) / grid), grid)
    for _ in range(3):
        u -= (np.sinh(u) / u - slack) / (np.cosh(u) / u - np.sinh(u) / u**2)
    a = across / (2 * u)
    hanging = a * np.sinh(np.arctanh(rise / length) + u)  # length between the lowest point and the end
    pull = np.concatenate([span[:, :2] / across[:, None] * a[:, None], hanging[:, None]], axis=1)
    return np.asarray(-weight * pull)
