"""What declared errors of the loads do to the parameters of a fit (theory.md 5.1).

With the gain K of the fit, an error that moves the readings by g moves the parameters by K·g. Errors that every row has
for itself add up in squares, one that rows share adds up as it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.estimation.fit import Fit
from expdesign.estimation.load_errors import LoadEffect, shared_parts
from expdesign.estimation.whitening import Whitening


def gain_of(fit: Fit, whitening: Whitening) -> FloatArray:
    """K of a fit of rows with their whitening, per standard deviation of the noise, shape (N, p, k)."""
    found: FloatArray = (whitening.scores(fit.sensitivities) @ fit.estimable.generalised).swapaxes(1, 2)
    return found / fit.inflation


@dataclass(frozen=True)
class Propagated:
    """Errors of the loads, and by how much they move the parameters.

    Attributes:
        effects: the errors.
        moved: of each the parameters per standard deviation: (1, p, d) where rows share it, else (N, p, d).
    """

    effects: tuple[LoadEffect, ...]
    moved: tuple[FloatArray, ...]

    @classmethod
    def of(
        cls,
        gain: FloatArray,
        deviations: FloatArray,
        effects: Sequence[LoadEffect],
        sizes: Sequence[float],
        own: FloatArray | None = None,
    ) -> "Propagated":
        """Of errors with `sizes`, in declared standard deviations.

        Args:
            gain: K per standard deviation of the noise, shape (N, p, k).
            deviations: of the noise, shape (N, k).
            effects: the errors.
            sizes: of each.
            own: what one declared standard deviation of every shared error moves beside what readings do, (p, d).
        """
        found = []
        for effect, size, place in zip(effects, sizes, shared_parts(effects), strict=True):
            rows = gain @ (size * effect.moved / deviations[..., None])
            if effect.shared:
                rows = rows.sum(axis=0)[None] + (0.0 if own is None else size * own[:, place])
            found.append(rows)
        return cls(tuple(effects), tuple(found))

    def scaled(self, factor: float) -> "Propagated":
        """With errors that are larger by a factor."""
        return replace(self, moved=tuple(factor * each for each in self.moved))

    def covariance(self, shares: Sequence[float]) -> FloatArray:
        """Of the parameters, shape (p, p); of each effect the share that is given."""
        parts = [share * np.einsum("npd,nqd->pq", each, each) for share, each in zip(shares, self.moved, strict=True)]
        found: FloatArray = np.sum(parts, axis=0)
        return found
