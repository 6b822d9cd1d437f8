"""Covariance functions of unknown laws, for numbers and for expressions of the chain alike.

Inputs are scaled: a length scale of 1 is meant. Sources: Rasmussen and Williams (2006) chapter 4 for the stationary
ones and the (integrated) Wiener process, Cho and Saul (2009) for the arc-cosine kernel of first order.
"""

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

Inputs = Sequence[Any]
"""Scaled inputs: arrays (n, 1) against (1, m), or expressions against (1, m)."""


def _of(name: str, value: Any) -> Any:
    """An elementary function of numbers or of an expression."""
    return getattr(ca if isinstance(value, ca.SX) else np, name)(value)


def _square(x: Inputs, z: Inputs) -> Any:
    total: Any = 0.0
    for a, b in zip(x, z, strict=True):
        total = total + (a - b) ** 2
    return total


def constant(x: Inputs, z: Inputs) -> Any:
    """Covariance k = 1: an unknown factor."""
    return 1.0 + 0.0 * (x[0] - z[0])


def linear(x: Inputs, z: Inputs) -> Any:
    """Covariance k = x·z: an unknown coefficient for every input."""
    total: Any = 0.0
    for a, b in zip(x, z, strict=True):
        total = total + a * b
    return total


def squared_exponential(x: Inputs, z: Inputs) -> Any:
    """Covariance k = exp(−½|x − z|²): smooth."""
    return _of("exp", -0.5 * _square(x, z))


def matern(x: Inputs, z: Inputs) -> Any:
    """Covariance k = (1 + √3·r)·exp(−√3·r): continuous with a continuous slope (Matérn 3/2)."""
    distance = np.sqrt(3.0) * _of("sqrt", _square(x, z) + 1e-12)
    return (1.0 + distance) * _of("exp", -distance)


def pinned(x: Inputs, z: Inputs) -> Any:
    """Squared exponential that is known to vanish at 0: smooth, nothing without an input."""
    origin = [0.0 for _ in x]
    return squared_exponential(x, z) - squared_exponential(x, origin) * squared_exponential(origin, z)


def wiener(x: Inputs, z: Inputs) -> Any:
    """Covariance k = ½(|x| + |z| − |x − z|), in one dimension: steps and corners, nothing at 0."""
    return 0.5 * (_of("fabs", x[0]) + _of("fabs", z[0]) - _of("fabs", x[0] - z[0]))


def integrated_wiener(x: Inputs, z: Inputs) -> Any:
    """Covariance k = m²(3M − m)/6 for x and z on one side of 0 (m, M: their moduli), else 0: a changing slope."""
    one, other = _of("fabs", x[0]), _of("fabs", z[0])
    least = 0.5 * (one + other - _of("fabs", one - other))
    most = one + other - least
    same = 0.5 * (1.0 + _of("sign", x[0]) * _of("sign", z[0]))
    return same * least**2 * (3.0 * most - least) / 6.0


def arc_cosine(x: Inputs, z: Inputs) -> Any:
    """Covariance k = |x̃||z̃|(sin θ + (π − θ)·cos θ)/π with x̃ = (1, x): sums of max(0, a·x + b)."""
    a, b, dot = 1.0 + _square(x, [0.0 for _ in x]), 1.0 + _square([0.0 for _ in z], z), 1.0 + linear(x, z)
    size = _of("sqrt", a * b)
    cosine = (1.0 - 1e-9) * dot / size
    angle = _of("acos" if isinstance(cosine, ca.SX) else "arccos", cosine)
    return size * (_of("sqrt", 1.0 - cosine**2) + (np.pi - angle) * cosine) / np.pi


def step_cosine(x: Inputs, z: Inputs) -> Any:
    """Covariance k = 1 − θ/π with x̃ = (b, x), b small: sums of steps at planes (order 0)."""
    bias = 1e-2
    a, b = bias + _square(x, [0.0 for _ in x]), bias + _square([0.0 for _ in z], z)
    cosine = (1.0 - 1e-9) * (bias + linear(x, z)) / _of("sqrt", a * b)
    return 1.0 - _of("acos" if isinstance(cosine, ca.SX) else "arccos", cosine) / np.pi


def periodic(x: Inputs, z: Inputs) -> Any:
    """Covariance k = cos 2πΔ + ½·cos 4πΔ, in one dimension: two harmonics of an error that repeats with the scale."""
    difference = 2.0 * np.pi * (x[0] - z[0])
    return _of("cos", difference) + 0.5 * _of("cos", 2.0 * difference)


KERNELS: dict[str, Callable[[Inputs, Inputs], Any]] = {
    function.__name__: function
    for function in (
        constant, linear, squared_exponential, matern, pinned, wiener, integrated_wiener, arc_cosine,
        step_cosine, periodic,
    )
}  # fmt: skip
"""By the names that stand in model files."""
