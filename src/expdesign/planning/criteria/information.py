"""What measurements say about the parameters, as something that can be added, taken away and asked for accuracy.

With whitened readings Ã_j, and G·D_j·L_j their change per standard deviation of each load error, measurements add

    M = Σ Ã_jᵀÃ_j , S = Σ Ã_jᵀ·G·D_jL_j of the shared and N = Σ Ã_jᵀ·G·D_jL_j·(…)ᵀ of the independent load errors,

and the parameters estimated by least squares have the covariance M⁻¹ due to noise and M⁻¹·(N + S·Sᵀ)·M⁻¹ due to load
errors (theory.md 4.2, 5.3). DUIR² and FEIR² are what these give along the axes of the targets.

The readings of a series share the one of its unloaded reference. That one is a nuisance parameter ρ with the prior
information 2·I in whitened units, of which every reading of the series has a row; eliminated, it leaves
2·(Σ a_iᵀa_i − āᵀΣa_i) with ā = Σa_i/(n + 1) of n rows (theory.md 10.6).
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray

RANK = 1e-9
"""Singular values below this fraction of the largest are zero."""
LOST = 1e-6
"""Part of a target's row that may lie along lost directions, as rounding."""


def propagated(
    targets: FloatArray, inverse: FloatArray, shared: FloatArray, own: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Variances along the axes of targets (t, r, p) due to noise and to load errors, shape (..., t, r) each.

    Args:
        targets: error of each axis per error of the parameters.
        inverse: M⁻¹, shape (..., p, p).
        shared: S, shape (..., p, d).
        own: N, shape (..., p, p).
    """
    gain = targets @ inverse[..., None, :, :]
    noise: FloatArray = np.einsum("...trp,trp->...tr", gain, targets)
    force: FloatArray = ((gain @ own[..., None, :, :]) * gain).sum(axis=-1)
    return noise, force + ((gain @ shared[..., None, :, :]) ** 2).sum(axis=-1)


@dataclass(frozen=True)
class Information:
    """Of measurements, with any batch dimensions in front.

    Attributes:
        root: rows R with RᵀR = M, so that the condition is not squared, shape (..., r, p).
        shared: S, shape (..., p, d).
        own: N, shape (..., p, p).
    """

    root: FloatArray
    shared: FloatArray
    own: FloatArray

    @classmethod
    def of_rows(cls, rows: FloatArray, errors: FloatArray, shared: BoolArray) -> "Information":
        """Of whitened rows (..., r, p) with whitened deflections per load error (..., r, d), some shared (d,)."""
        seen = rows.swapaxes(-1, -2) @ errors
        own = seen[..., ~shared]
        return cls(rows, seen[..., shared], own @ own.swapaxes(-1, -2))

    @classmethod
    def beside(cls, rows: FloatArray, nuisance: FloatArray, prior: FloatArray) -> "Information":
        """Of whitened rows (..., r, p) whose readings change with nuisance parameters too, which are eliminated.

        Args:
            rows: change of the readings with the parameters.
            nuisance: with the nuisance parameters, shape (..., r, s).
            prior: one over the standard deviation of each of those, as it is known beforehand, shape (s,).
        """
        (count,), parameters = prior.shape, rows.shape[-1]
        known = np.concatenate([np.diag(prior), np.zeros((count, parameters))], axis=1)
        known = np.broadcast_to(known, (*rows.shape[:-2], *known.shape))
        together = np.concatenate([known, np.concatenate([nuisance, rows], axis=-1)], axis=-2)
        root = np.asarray(np.linalg.qr(together, mode="r"))[..., count:, count:]
        none = np.zeros((*rows.shape[:-2], parameters, parameters))
        return cls(root, none[..., :0], none)

    def plus(self, other: "Information") -> "Information":
        """Both together; the rows are reduced to a triangle, which keeps the condition."""
        batch = np.broadcast_shapes(self.root.shape[:-2], other.root.shape[:-2])
        rows = [np.broadcast_to(part, (*batch, *part.shape[-2:])) for part in (self.root, other.root)]
        stacked: FloatArray = np.concatenate(rows, axis=-2)
        if stacked.shape[-2] > stacked.shape[-1]:
            stacked = np.asarray(np.linalg.qr(stacked, mode="r"))
        return Information(stacked, self.shared + other.shared, self.own + other.own)

    def minus(self, other: "Information") -> "Information":
        """Without what another one, which is part of it, has added; half of the digits of the root are lost."""
        matrix = self.root.swapaxes(-1, -2) @ self.root - other.root.swapaxes(-1, -2) @ other.root
        values, vectors = np.linalg.eigh(matrix)
        root = np.sqrt(np.maximum(values, 0.0))[..., None] * vectors.swapaxes(-1, -2)
        return Information(root, self.shared - other.shared, self.own - other.own)

    def part(self, index: int) -> "Information":
        """One member of a batch."""
        return Information(self.root[index], self.shared[index], self.own[index])

    def variances(self, targets: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Variances along the axes of targets (t, r, p) due to noise and to load errors, and which of them can be
        told, shape (..., t, r) each.
        """
        root = self.root
        missing = root.shape[-1] - root.shape[-2]
        if missing > 0:
            root = np.concatenate([root, np.zeros((*root.shape[:-2], missing, root.shape[-1]))], axis=-2)
        _, singular, right = np.linalg.svd(root, full_matrices=False)
        kept = singular > RANK * singular[..., :1]
        inverse = right.swapaxes(-1, -2) / np.where(kept, singular, np.inf)[..., None, :]
        # What a target needs and the measurements leave out: its part along the directions that are lost.
        lost = np.linalg.norm(np.einsum("trp,...kp->...trk", targets, right * ~kept[..., None]), axis=-1)
        known: BoolArray = lost <= LOST * np.linalg.norm(targets, axis=-1)
        noise, force = propagated(targets, inverse @ inverse.swapaxes(-1, -2), self.shared, self.own)
        return noise, force, known
