"""Noise of measured deflections and the scaling G that makes it white (theory.md 3; thesis 1.22-1.24)."""

from typing import Self

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.errors import InputError


class DeflectionNoise:
    """Covariance of the measured components of one deflection, the same for every measurement.

    Attributes:
        axes: indices of the measured components, shape (k,).
        covariance: V of those components (m², m·rad, rad²), shape (k, k).
        whitener: G with GᵀG = V⁻¹, the inverse Cholesky factor, shape (k, k). Only GᵀG matters (theory.md 3), and
            unlike the eigenvector root this one does not depend on the system of units.
        shared_reference: whether the measurements of one series share their unloaded measurement, which carries half
            of each deflection's covariance.
    """

    def __init__(self, axes: IntArray, covariance: FloatArray, shared_reference: bool = False) -> None:
        self.axes = np.asarray(axes, dtype=np.int64)
        self.covariance = np.asarray(covariance, dtype=float)
        self.shared_reference = shared_reference
        scale = np.sqrt(np.diag(self.covariance))
        try:
            factor = np.linalg.cholesky(self.covariance / np.outer(scale, scale))
        except np.linalg.LinAlgError:
            remedy = "A covariance is symmetric and positive definite; check its entries and units."
            raise InputError("the covariance is not positive definite", remedy=remedy) from None
        self.whitener = np.linalg.solve(factor, np.diag(1.0 / scale))

    def whitener_at(self, pose_map: FloatArray) -> FloatArray:
        """G of measurements where J̌ is `pose_map` (..., n, n_a): here the same for all, shape (k, k)."""
        return self.whitener

    def deviations_at(self, pose_map: FloatArray) -> FloatArray:
        """Standard deviations of the measured components (m, rad) where J̌ is `pose_map`, shape (..., k)."""
        deviations = np.sqrt(np.diag(self.covariance))
        return np.broadcast_to(deviations, (*pose_map.shape[:-2], len(deviations)))

    @classmethod
    def from_deviations(cls, axes: IntArray, deviations: FloatArray, shared_reference: bool = False) -> Self:
        """Uncorrelated noise (G_U) with the given standard deviations of the measured components."""
        return cls(axes, np.diag(np.asarray(deviations, dtype=float) ** 2), shared_reference)


def series_by_pose(configurations: FloatArray) -> IntArray:
    """Series numbers (from 1) when consecutive measurements at the same pose form one; (..., m, n) to (..., m)."""
    new = np.any(configurations[..., 1:, :] != configurations[..., :-1, :], axis=-1)
    first = np.ones((*new.shape[:-1], 1), dtype=bool)
    series: IntArray = np.cumsum(np.concatenate([first, new], axis=-1), axis=-1, dtype=np.int64)
    return series


def reference_whitener(series: IntArray) -> FloatArray:
    """S^(-1/2) across measurements that share their unloaded reference.

    Each deflection is a difference of two readings with half its covariance each, so that measurements i and j of one
    series have covariance V·S_ij with S = ½(I + [same series]) (theory.md 3, noise structure of a deflection).

    Args:
        series: series numbers, shape (..., m).

    Returns:
        The inverse Cholesky factor of S, shape (..., m, m).
    """
    same = series[..., :, None] == series[..., None, :]
    root = np.linalg.cholesky(0.5 * (np.eye(series.shape[-1]) + same))
    return np.linalg.inv(root)
