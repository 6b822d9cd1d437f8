"""A pose from measured points: rigid registration, and the covariance of the pose (theory.md 9.A).

N ≥ 3 points of an artefact on the platform, known in the platform frame, are measured in the base frame. The pose
that fits them best is found by the singular value decomposition (Kabsch 1976). To first order a point moves by
δt + δθ × (R·p), so that with B_i = [I, −[R·p_i]ₓ] and noise σ on every coordinate

    Cov(δt, δθ) = σ²·(Σ B_iᵀ·B_i)⁻¹,        δX = T·(δt, δθ) in pose coordinates.

Where the platform frame is not at the centroid of the points, translation and rotation errors are correlated.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError


def registered(points: FloatArray, measured: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R (..., 3, 3) and position t of the platform frame (..., 3) that fit measured ≈ R·p + t in least squares.

    Args:
        points: in the platform frame (m), shape (N, 3).
        measured: in the base frame (m), shape (..., N, 3).
    """
    centre, middle = points.mean(axis=0), measured.mean(axis=-2)
    product = (points - centre).T @ (measured - middle[..., None, :])
    left, _, right = np.linalg.svd(product)
    # det = −1 would be a reflection: the least certain direction is turned round.
    flip = np.ones((*product.shape[:-2], 3))
    flip[..., 2] = np.sign(np.linalg.det(left @ right))
    rotation = (right.swapaxes(-1, -2) * flip[..., None, :]) @ left.swapaxes(-1, -2)
    position: FloatArray = middle - rotation @ centre
    return rotation, position


def twist_covariance(points: FloatArray, deviation: float, rotation: FloatArray) -> FloatArray:
    """Covariance of (δt, δθ) in base axes (m², m·rad, rad²), shape (6, 6).

    Args:
        points: in the platform frame (m), shape (N, 3).
        deviation: standard deviation of every measured coordinate (m).
        rotation: R of the platform, shape (3, 3).

    Raises:
        InputError: the points do not determine an orientation.
    """
    levers = points @ rotation.T
    rows = np.zeros((len(points), 3, 6))
    rows[:, :, :3] = np.eye(3)
    rows[:, :, 3:] = np.cross(np.eye(3), levers[:, None, :]).swapaxes(-1, -2)
    information = np.einsum("nij,nik->jk", rows, rows)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(points) < 3 or spread[1] < 1e-9 * max(float(spread[0]), 1e-300):
        remedy = "At least three points that do not lie on one line are needed."
        raise InputError("the points do not determine an orientation", remedy=remedy)
    covariance: FloatArray = deviation**2 * np.linalg.inv(information)
    return covariance


def pose_covariance(points: FloatArray, deviation: float, rotation: FloatArray, pose_rates: FloatArray) -> FloatArray:
    """Covariance of a measured pose in pose coordinates, shape (6, 6); `pose_rates` is T with Ẋ = T·η (6, 6)."""
    covariance: FloatArray = pose_rates @ twist_covariance(points, deviation, rotation) @ pose_rates.T
    return covariance
