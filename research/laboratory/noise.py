"""The instrument's noise on deflections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from .errors import LaboratoryError
from .kinematics import Matrix, Vector


@dataclass(frozen=True)
class Noise:
    """Gaussian noise of a deflection: covariance (m^2, m rad, rad^2).

    With `shared_reference` half of it comes from the unloaded measurement, which the rows of a series share.
    """

    covariance: Matrix
    shared_reference: bool = False

    @classmethod
    def of(
        cls,
        std: Mapping[str, float] | Sequence[float] | Vector | None,
        covariance: Matrix | None,
        columns: Sequence[str],
        shared_reference: bool,
    ) -> Self:
        """Noise from standard deviations (by column or in order) or a covariance, or none."""
        size = len(columns)
        if covariance is not None:
            if std is not None:
                raise LaboratoryError("noise: give std or covariance, not both")
            matrix = np.asarray(covariance, dtype=float)
        elif std is None:
            matrix = np.zeros((size, size))
        elif isinstance(std, Mapping):
            unknown = set(std) - set(columns)
            if unknown:
                raise LaboratoryError(f"noise: unknown component {sorted(unknown)[0]}; known: {', '.join(columns)}")
            matrix = np.diag([float(std.get(column, 0.0)) ** 2 for column in columns])
        else:
            matrix = np.diag(np.asarray(std, dtype=float) ** 2)
        if matrix.shape != (size, size) or np.linalg.eigvalsh((matrix + matrix.T) / 2).min() < -1e-30:
            raise LaboratoryError(f"noise: needs {size} standard deviations or a positive covariance {size} x {size}")
        return cls(matrix, shared_reference)

    @property
    def std(self) -> Vector:
        """Standard deviation of each component (m, rad)."""
        return np.sqrt(np.diag(self.covariance))

    def draw(self, series: Sequence[Sequence[int]], rng: np.random.Generator) -> Matrix:
        """Noise of all rows (rows x components), given the rows of each series."""
        root = _root(self.covariance)
        rows = sum(len(each) for each in series)
        noise = rng.standard_normal((rows, len(root))) @ root.T
        if self.shared_reference:
            noise *= np.sqrt(0.5)
            for each in series:
                noise[list(each)] += np.sqrt(0.5) * (root @ rng.standard_normal(len(root)))
        return noise


def _root(covariance: Matrix) -> Matrix:
    # Scaled first: metres and radians differ by orders of magnitude, and a component may have no noise.
    scale = np.sqrt(np.diag(covariance))
    unit = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    return np.asarray(unit[:, None] * vectors * np.sqrt(np.clip(values, 0.0, None)))
