"""Poses freed of thermal deflection by a reference pose that is measured before each of them (theory.md 9.H).

The legs' thermal elongations Δq are seen at the reference pose X_R, ΔX_R = J̌(X_R)·Δq, and taken off where the pose
itself is measured, T·ΔX_R with T = J̌(X)·J̌(X_R)⁻¹. A deflection is a difference of two poses, each with its own
reference: the first reference of all cancels, and the covariance V of the deflection becomes V + p·T·V·Tᵀ. The price p
is 1 where each pose has one reference before it, and 1/4 where the reference is interpolated between one before and one
after each pose, the middle one serving both.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.instrument.deflection_noise import DeflectionNoise
from expdesign.errors import InputError
from expdesign.mechanics.differentiation import inverse_root, plain

PRICE = {False: 1.0, True: 0.25}
"""p without and with interpolation."""


class ReferencedNoise(DeflectionNoise):
    """Noise of deflections whose poses were corrected by reference poses; it depends on the pose.

    Args:
        noise: of the deflection without the correction; all pose coordinates are measured.
        reference: X_R, shape (n,).
        reference_map: J̌(X_R), shape (n, n).
        interpolated: whether the reference is interpolated between the one before and the one after.

    Raises:
        InputError: not all coordinates of the pose are measured, so that Δq is not seen.
    """

    def __init__(
        self, noise: DeflectionNoise, reference: FloatArray, reference_map: FloatArray, *, interpolated: bool = False
    ) -> None:
        if len(noise.axes) != len(reference_map):
            what = "a reference pose corrects only what is measured on all axes"
            raise InputError(what, remedy="Give the noise of every axis, or leave the reference pose out.")
        super().__init__(noise.axes, noise.covariance, noise.shared_reference)
        self._inverse = np.linalg.inv(reference_map)
        self.reference = reference
        self.interpolated = interpolated
        self.price = PRICE[interpolated]

    def transfer(self, pose_map: FloatArray) -> FloatArray:
        """T = J̌(X)·J̌(X_R)⁻¹, shape (..., n, n)."""
        transfer: FloatArray = pose_map @ self._inverse
        return transfer

    def covariance_at(self, pose_map: FloatArray) -> FloatArray:
        """V + p·T·V·Tᵀ of one deflection (m², m·rad, rad²), shape (..., n, n)."""
        transfer = self.transfer(pose_map)
        total: FloatArray = self.covariance + self.price * transfer @ self.covariance @ transfer.swapaxes(-1, -2)
        return total

    def deviations_at(self, pose_map: FloatArray) -> FloatArray:
        deviations: FloatArray = np.sqrt(np.diagonal(self.covariance_at(pose_map), axis1=-2, axis2=-1))
        return deviations

    def whitener_at(self, pose_map: FloatArray) -> FloatArray:
        exists = np.logical_and.reduce(np.isfinite(pose_map), axis=(-2, -1), keepdims=True)
        covariance = self.covariance_at(np.where(exists, pose_map, 0.0))
        # The scale is for the factorisation's sake and cancels, so that nothing depends on its derivative.
        scale = np.sqrt(np.diagonal(plain(covariance), axis1=-2, axis2=-1))
        scaled = covariance / (scale[..., :, None] * scale[..., None, :])
        whitener: FloatArray = inverse_root(scaled) / scale[..., None, :]
        return whitener


def pose_order(series: IntArray, *, shared_unloaded: bool, interpolated: bool) -> list[tuple[str, int]]:
    """The poses to measure for a plan, in order: what each is, and the row of the plan that it belongs to.

    Each loaded pose follows the unloaded one at the same command, and every pose follows a reference; with
    interpolation every pair ends with a reference of its own. Where the consecutive rows of a series share their
    unloaded pose, it is measured once.
    """
    order: list[tuple[str, int]] = []
    last: int | None = None
    for row, number in enumerate(series):
        if not (shared_unloaded and last == number):
            order += [("reference", row), ("unloaded", row)]
        order += [("reference", row), ("loaded", row)]
        if interpolated:
            order.append(("reference", row))
        last = int(number)
    return order
