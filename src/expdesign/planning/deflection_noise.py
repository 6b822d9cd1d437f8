"""Noise of measured deflections and the scaling G that makes it white (theory.md 3; thesis 1.22-1.24)."""

import copy
from typing import Self

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.errors import InputError
from expdesign.mechanics.differentiation import inverse_root, plain

_INDEPENDENT = 1e-12
"""Correlation that is rounding."""


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

    def covariance_at(self, pose_map: FloatArray) -> FloatArray:
        """V of one deflection (m², m·rad, rad²) where J̌ is `pose_map`, shape (..., k, k)."""
        return np.broadcast_to(self.covariance, (*pose_map.shape[:-2], *self.covariance.shape))

    def deviations_at(self, pose_map: FloatArray) -> FloatArray:
        """Standard deviations of the measured components (m, rad) where J̌ is `pose_map`, shape (..., k)."""
        deviations: FloatArray = np.sqrt(np.diagonal(self.covariance_at(pose_map), axis1=-2, axis2=-1))
        return deviations

    def within(self, axes: IntArray, pose_map: FloatArray) -> FloatArray | None:
        """Inverse root of the correlation matrix of readings of some axes (k,), symmetric, shape (N, k, k).

        Of axes without a stated noise the readings are independent. None where all are.

        Args:
            axes: that are read.
            pose_map: J̌ of every measurement, shape (N, n, n_a).
        """
        covariance = np.linalg.inv(self.whitener_at(pose_map))
        covariance = covariance @ covariance.swapaxes(-1, -2)
        scale = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
        stated = covariance / (scale[..., :, None] * scale[..., None, :])
        known = [(i, self.axes.tolist().index(axis)) for i, axis in enumerate(axes.tolist()) if axis in self.axes]
        here, there = ([pair[side] for pair in known] for side in (0, 1))
        correlation = np.broadcast_to(np.eye(len(axes)), (len(pose_map), len(axes), len(axes))).copy()
        correlation[:, np.array(here)[:, None], np.array(here)] = stated[..., np.array(there)[:, None], np.array(there)]
        if np.abs(correlation - np.eye(len(axes))).max(initial=0.0) < _INDEPENDENT:
            return None
        values, vectors = np.linalg.eigh(correlation)
        root: FloatArray = (vectors / np.sqrt(values)[..., None, :]) @ vectors.swapaxes(-1, -2)
        return root

    def series(self, configurations: FloatArray) -> IntArray | None:
        """Series (..., m) of configurations (..., m, n_q) that share an unloaded measurement; None where none do."""
        return series_by_pose(configurations) if self.shared_reference else None

    def alone(self) -> Self:
        """The same of measurements that share no unloaded measurement."""
        other = copy.copy(self)
        other.shared_reference = False
        return other

    def drawn(self, series: IntArray, count: int, generator: np.random.Generator, pose_map: FloatArray) -> FloatArray:
        """Noise of the k measured components (m, rad) of `count` repetitions, shape (count, m, k).

        With a shared reference half its variance is common to the measurements of a series (`series`, shape (m,)).
        `pose_map` is J̌ of each measurement, shape (m, n, n_a), on which the noise may depend.
        """
        root = np.linalg.inv(self.whitener_at(pose_map))
        own = generator.standard_normal((count, len(series), root.shape[-1]))
        if self.shared_reference:
            _, index = np.unique(series, return_inverse=True)
            common = generator.standard_normal((count, int(index.max()) + 1, root.shape[-1]))
            own = np.sqrt(0.5) * (own + common[:, index])
        drawn: FloatArray = own @ root.T if root.ndim == 2 else np.einsum("skj,kij->ski", own, root)
        return drawn

    @classmethod
    def from_deviations(cls, axes: IntArray, deviations: FloatArray, shared_reference: bool = False) -> Self:
        """Uncorrelated noise (G_U) with the given standard deviations of the measured components."""
        return cls(axes, np.diag(np.asarray(deviations, dtype=float) ** 2), shared_reference)


class ReferencedNoise(DeflectionNoise):
    """Noise of deflections, each pose freed of thermal deflection by a reference pose before it (theory.md 9.H).

    The legs' thermal elongations Δq are seen at the reference pose X_R, ΔX_R = J̌(X_R)·Δq, and taken off where the pose
    itself is measured, T·ΔX_R with T = J̌(X)·J̌(X_R)⁻¹. A deflection is a difference of two poses, each with its own
    reference: the first reference of all cancels, and the covariance V of the deflection becomes V + p·T·V·Tᵀ. The
    price p is 1 where each pose has one reference before it, and 1/4 where the reference is interpolated between one
    before and one after each pose, the middle one serving both. It depends on the pose.

    Args:
        noise: of the deflection without the correction; all pose coordinates are measured.
        reference: X_R, shape (n,).
        reference_map: J̌(X_R), shape (n, n).
        interpolated: whether the reference is interpolated between the one before and the one after.
    """

    def __init__(
        self, noise: DeflectionNoise, reference: FloatArray, reference_map: FloatArray, *, interpolated: bool
    ) -> None:
        super().__init__(noise.axes, noise.covariance, noise.shared_reference)
        self.reference, self._inverse = reference, np.linalg.inv(reference_map)
        self.interpolated = interpolated

    def covariance_at(self, pose_map: FloatArray) -> FloatArray:
        """V + p·T·V·Tᵀ of one deflection (m², m·rad, rad²), shape (..., n, n)."""
        transfer, price = pose_map @ self._inverse, 0.25 if self.interpolated else 1.0
        total: FloatArray = self.covariance + price * transfer @ self.covariance @ transfer.swapaxes(-1, -2)
        return total

    def whitener_at(self, pose_map: FloatArray) -> FloatArray:
        exists = np.logical_and.reduce(np.isfinite(pose_map), axis=(-2, -1), keepdims=True)
        covariance = self.covariance_at(np.where(exists, pose_map, 0.0))
        # The scale is for the factorisation's sake and cancels, so that nothing depends on its derivative.
        scale = np.sqrt(np.diagonal(plain(covariance), axis1=-2, axis2=-1))
        scaled = covariance / (scale[..., :, None] * scale[..., None, :])
        whitener: FloatArray = inverse_root(scaled) / scale[..., None, :]
        return whitener


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
