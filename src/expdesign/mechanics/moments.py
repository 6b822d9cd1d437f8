"""Moments of forces and velocities by rotations, in space (three components) and in the plane (about its normal)."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray


def moment(arm: ca.SX, force: ca.SX) -> ca.SX:
    """Moment (N·m) of a force (N) with an arm (m): arm × force in space, its component along the normal in the plane.

    Args:
        arm: shape (3,) or (2,).
        force: likewise.
    """
    if arm.shape[0] == 3:
        return ca.cross(arm, force)
    return arm[0] * force[1] - arm[1] * force[0]


def moments(arms: FloatArray, forces: FloatArray) -> FloatArray:
    """`moment` of many arms and forces (..., d), shape (..., 3) or, in the plane, (..., 1)."""
    if arms.shape[-1] == 3:
        crossed: FloatArray = np.cross(arms, forces)
        return crossed
    return arms[..., :1] * forces[..., 1:2] - arms[..., 1:2] * forces[..., :1]


def velocities(turns: FloatArray, lever: FloatArray) -> FloatArray:
    """ω × lever of many rotations (..., 3, k) or (..., 1, k) and one lever per batch (..., 1, d), shape (..., d, k)."""
    if lever.shape[-1] == 3:
        crossed: FloatArray = np.cross(turns, lever.swapaxes(-1, -2), axis=-2)
        return crossed
    return np.concatenate([-turns * lever[..., 1:2], turns * lever[..., :1]], axis=-2)


def lever_map(arm: ca.SX) -> ca.SX:
    """A with v = A·ω, the velocity of a point at `arm` (m) from the axis of a rotation ω: (3, 3), or (2, 1)."""
    if arm.shape[0] == 3:
        return -ca.skew(arm)
    return ca.vertcat(-arm[1], arm[0])


def frame_turn(rotation: ca.SX, n: int) -> ca.SX:
    """diag(R, R) in space, n×n: twists and wrenches along the axes of O from those along the axes of a frame in it.

    In the plane the only rotation is about the normal, which R does not change; n is the number of coordinates of
    a pose, and a point (n = d) has no rotation.
    """
    d = rotation.shape[0]
    turns = n - d
    return ca.diagcat(rotation, rotation if turns == d else ca.SX.eye(turns))


def twist_transfer(arm: ca.SX, n: int) -> ca.SX:
    """T, n×n, with t_P = T·t_O, the twist at a point at `arm` (m) of what moves about O by t_O, and F_O = Tᵀ·F_P.

    n is the number of coordinates of a pose; where a point has no rotation, T is the identity.
    """
    transfer, d = ca.SX.eye(n), arm.shape[0]
    if n > d:
        transfer[:d, d:] = lever_map(arm)
    return transfer


def in_space(position: ca.SX, rotation: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Position (3,) and orientation (3, 3) of a frame that may be known in the x-y plane only."""
    if position.shape[0] == 3:
        return position, rotation
    return ca.vertcat(position, 0.0), ca.diagcat(rotation, 1.0)


def arrays_in_space(positions: FloatArray, rotations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """`in_space` of many frames, (N, 3) and (N, 3, 3)."""
    if positions.shape[-1] == 3:
        return positions, rotations
    frames = np.zeros((*rotations.shape[:-2], 3, 3))
    frames[..., :2, :2], frames[..., 2, 2] = rotations, 1.0
    return np.concatenate([positions, np.zeros((*positions.shape[:-1], 1))], axis=-1), frames
