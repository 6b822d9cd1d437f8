"""How the errors to expect at the targets lie: covariances of the attained pose and their principal axes.

U is the part of measurement noise (theory.md 4.2), Z·Σ_F·Zᵀ that of load errors (5.3); they are independent, so their
covariances add. Both are taken to be normal: U is, to the extent that the instrument's noise is, and Z·Σ_F·Zᵀ is to the
extent that the load errors are.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment


@dataclass(frozen=True)
class TargetCovariances:
    """Covariances of the attained pose (m², m·rad, rad²), shape (b, t, n, n) each; NaN where it is not estimable.

    Attributes:
        noise: U.
        load: Z·Σ_F·Zᵀ.
    """

    noise: FloatArray
    load: FloatArray

    @property
    def total(self) -> FloatArray:
        """Covariance of the error to expect."""
        return self.noise + self.load


def target_covariances(assessment: Assessment) -> TargetCovariances:
    """Covariances of the pose attained at every target."""
    noise, load = assessment.noise_root, assessment.force_root
    return TargetCovariances(noise @ noise.swapaxes(-1, -2), load @ load.swapaxes(-1, -2))


def principal_axes(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Standard deviations along the principal axes, falling, and the axes as columns.

    Args:
        covariance: of quantities of one unit, shape (..., k, k); NaN gives NaN.

    Returns:
        shapes (..., k) and (..., k, k).
    """
    known = np.logical_and.reduce(np.isfinite(covariance), axis=(-2, -1))
    values, vectors = np.linalg.eigh(np.where(known[..., None, None], covariance, 0.0))
    sigma = np.sqrt(np.maximum(values[..., ::-1], 0.0))
    # The sign of an axis means nothing; the largest component is made positive, so that it can be read.
    vectors = vectors[..., ::-1]
    largest = np.take_along_axis(vectors, np.abs(vectors).argmax(axis=-2)[..., None, :], axis=-2)
    vectors = vectors * np.where(largest < 0.0, -1.0, 1.0)
    missing = ~known
    return np.where(missing[..., None], np.nan, sigma), np.where(missing[..., None, None], np.nan, vectors)


def ellipse_scale(probability: float, dimension: int = 2) -> float:
    """Standard deviations from the centre of an ellipse (ellipsoid) that holds a normal error with `probability`."""
    return float(np.sqrt(chdtri(dimension, 1.0 - probability)))
