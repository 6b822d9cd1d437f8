"""Finite features of a covariance function: Φ = k(·, Z)·U·Λ^(−1/2) with k(Z, Z) = U·Λ·Uᵀ, of limited rank.

A law f ~ GP(0, σ²·k) is then f(x) = Φ(x)·w with w ~ N(0, σ²·I) (Williams and Seeger 2001), which the chain takes as it
takes any other parameters.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray

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


_LEAST = 1e-6
"""Eigenvalues below this share of the largest are rounding."""


@dataclass(frozen=True)
class FeatureBasis:
    """Features of a kernel.

    Attributes:
        kernel: a key of `KERNELS`.
        scales: of the inputs, in their units, shape (d,).
        centres: points Z in scaled units, shape (m, d).
        weights: U·Λ^(−1/2), shape (m, r).
    """

    kernel: str
    scales: FloatArray
    centres: FloatArray
    weights: FloatArray

    @property
    def rank(self) -> int:
        """Number of features."""
        return self.weights.shape[1]

    def values(self, inputs: FloatArray) -> FloatArray:
        """Features at inputs (N, d), shape (N, r)."""
        covariance: FloatArray = _covariance(self.kernel, inputs / self.scales, self.centres)
        return covariance @ self.weights

    def expression(self, inputs: list[ca.SX]) -> ca.SX:
        """Features (r, 1) of one point as an expression."""
        scaled = [value / float(scale) for value, scale in zip(inputs, self.scales, strict=True)]
        against = [ca.SX(ca.DM(column.reshape(1, -1))) for column in self.centres.T]
        return ca.SX(ca.DM(self.weights.T)) @ KERNELS[self.kernel](scaled, against).T


def basis_of(kernel: str, scales: FloatArray, inputs: FloatArray, most: int) -> FeatureBasis | None:
    """Features of at most `most` functions for inputs (N, d); None where the kernel vanishes on all of them."""
    points = np.unique(np.round(inputs / scales, 9), axis=0)
    centres = points if len(points) <= 2 * most else _spread(points, 2 * most)
    values, vectors = np.linalg.eigh(_covariance(kernel, centres, centres))
    kept = np.flatnonzero(values > max(_LEAST * values.max(), 1e-14))[::-1][:most]
    if kept.size == 0:
        return None
    return FeatureBasis(kernel, scales, centres, vectors[:, kept] / np.sqrt(values[kept]))


def _covariance(kernel: str, left: FloatArray, right: FloatArray) -> FloatArray:
    result: FloatArray = KERNELS[kernel]([c[:, None] for c in left.T], [c[None, :] for c in right.T])
    return result


def _spread(points: FloatArray, count: int) -> FloatArray:
    """A subset that covers all points: every next one is the farthest from those chosen (Gonzalez 1985)."""
    if points.shape[1] == 1:
        return points[np.unique(np.linspace(0, len(points) - 1, count).round().astype(int))]
    chosen = [int(np.argmin(((points - points.mean(axis=0)) ** 2).sum(axis=1)))]
    nearest = ((points - points[chosen[0]]) ** 2).sum(axis=1)
    for _ in range(count - 1):
        chosen.append(int(np.argmax(nearest)))
        nearest = np.minimum(nearest, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
    return points[chosen]
