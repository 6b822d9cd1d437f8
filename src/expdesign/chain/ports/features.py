"""Finite features of a covariance function: Φ = k(·, Z)·U·Λ^(−1/2) with k(Z, Z) = U·Λ·Uᵀ, of limited rank.

A law f ~ GP(0, σ²·k) is then f(x) = Φ(x)·w with w ~ N(0, σ²·I) (Williams and Seeger 2001), which the chain takes as it
takes any other parameters.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.ports.kernels import KERNELS

_LEAST = 1e-6
"""Eigenvalues below this share of the largest are rounding."""


@dataclass(frozen=True)
class Basis:
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


def basis_of(kernel: str, scales: FloatArray, inputs: FloatArray, most: int) -> Basis | None:
    """Features of at most `most` functions for inputs (N, d); None where the kernel vanishes on all of them."""
    points = np.unique(np.round(inputs / scales, 9), axis=0)
    centres = points if len(points) <= 2 * most else _spread(points, 2 * most)
    values, vectors = np.linalg.eigh(_covariance(kernel, centres, centres))
    kept = np.flatnonzero(values > max(_LEAST * values.max(), 1e-14))[::-1][:most]
    if kept.size == 0:
        return None
    return Basis(kernel, scales, centres, vectors[:, kept] / np.sqrt(values[kept]))


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
