"""Orientation conventions: how three angles make a rotation matrix.

Source: theory.md section 2.2 (the Symétrie controllers use `fixed-xyz`), file-formats.md, Conventions (both).

Transforms of joints as symbolic expressions.

Moments of forces and velocities by rotations, in space (three components) and in the plane (about its normal).
"""

from collections.abc import Sequence
from typing import Literal

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray

Orientation = Literal["fixed-xyz", "moving-xyz"]
_GIMBAL = 1e-9
"""cos(ry) below which rx and rz are one angle."""


def rotation_matrix(angles: ca.SX, orientation: Orientation) -> ca.SX:
    """R (3×3), which turns platform axes into base axes, from `(rx, ry, rz)` in rad.

    `fixed-xyz` is R = Rz(rz)·Ry(ry)·Rx(rx); `moving-xyz` is R = Rx(rx)·Ry(ry)·Rz(rz).
    """
    about_x, about_y, about_z = (_about(axis, angles[axis]) for axis in range(3))
    if orientation == "fixed-xyz":
        return about_z @ about_y @ about_x
    return about_x @ about_y @ about_z


def rotations_of(angles: FloatArray) -> FloatArray:
    """R = Rz·Ry·Rx of angles (..., 3) in rad, shape (..., 3, 3)."""
    (sx, sy, sz), (cx, cy, cz) = np.moveaxis(np.sin(angles), -1, 0), np.moveaxis(np.cos(angles), -1, 0)
    rows = [
        [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
        [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
        [0.0 - sy, cy * sx, cy * cx],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def angles_of_matrix(rotation: FloatArray) -> FloatArray:
    """(rx, ry, rz) of R = Rz·Ry·Rx (3, 3), |ry| ≤ π/2; rx is 0 where it cannot be told from rz."""
    cosine = float(np.hypot(rotation[0, 0], rotation[1, 0]))
    pitch = np.arctan2(-rotation[2, 0], cosine)
    if cosine < _GIMBAL:
        return np.array([0.0, pitch, np.arctan2(-rotation[0, 1], rotation[1, 1])])
    return np.array([np.arctan2(rotation[2, 1], rotation[2, 2]), pitch, np.arctan2(rotation[1, 0], rotation[0, 0])])


def angles_of(rotation: ca.SX, orientation: Orientation) -> ca.SX:
    """The angles `(rx, ry, rz)` of a rotation matrix, |ry| < π/2: the inverse of `rotation_matrix`."""
    if orientation == "fixed-xyz":
        return ca.vertcat(
            ca.atan2(rotation[2, 1], rotation[2, 2]),
            -ca.asin(rotation[2, 0]),
            ca.atan2(rotation[1, 0], rotation[0, 0]),
        )
    return ca.vertcat(
        ca.atan2(-rotation[1, 2], rotation[2, 2]),
        ca.asin(rotation[0, 2]),
        ca.atan2(-rotation[0, 1], rotation[0, 0]),
    )


def rotation_vector(rotation: ca.SX) -> ca.SX:
    """Axis times angle (rad) of a rotation matrix, smooth at zero, for angles well below π."""
    axis = 0.5 * ca.vertcat(
        rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]
    )
    # |axis| = sin θ; θ/sin θ as a series in the versine is smooth at zero (relative error 1e-5 at 0.6 rad).
    versine = (3.0 - ca.trace(rotation)) / 2.0
    return axis * (1.0 + versine / 3.0 + 2.0 * versine**2 / 15.0 + 2.0 * versine**3 / 35.0)


def angular_velocity_map(rotation: ca.SX, variables: ca.SX) -> ca.SX:
    """E (3×k) with ω = E·v̇ for variables v (k,) of R, ω in base axes, from [ω]ₓ = Ṙ·Rᵀ (theory.md 2.2)."""
    columns = []
    for k in range(variables.shape[0]):
        rate = ca.reshape(ca.jacobian(ca.vec(rotation), variables[k]), 3, 3) @ rotation.T
        columns.append(ca.vertcat(rate[2, 1], rate[0, 2], rate[1, 0]))
    return ca.horzcat(*columns)


def _about(axis: int, angle: ca.SX) -> ca.SX:
    """Rotation about one coordinate axis by `angle` (rad)."""
    c, s = ca.cos(angle), ca.sin(angle)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    matrix = ca.SX.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def transform(rotation: FloatArray, position: FloatArray) -> FloatArray:
    """Homogeneous matrix (4, 4) of a rotation (3, 3) and a position (3,)."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, position
    return matrix


_ROUNDING = 1e-15


def constant(matrix: FloatArray) -> ca.SX:
    """A constant transform in which rounding of right angles leaves no entries behind."""
    return ca.sparsify(ca.SX(np.where(np.abs(matrix) < _ROUNDING, 0.0, matrix)))


def moved(axis: FloatArray, value: ca.SX, *, along: bool) -> ca.SX:
    """Motion exp(q·ξ) by a coordinate q, along a unit vector (3,), or about it by Rodrigues' formula."""
    axis = np.where(np.abs(axis) < _ROUNDING, 0.0, axis)
    if along:
        motion = ca.SX(transform(np.eye(3), np.zeros(3)))
        motion[:3, 3] = ca.SX(axis) * value
        return motion
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    rotation = ca.SX(np.outer(axis, axis)) + ca.cos(value) * ca.SX(np.eye(3) - np.outer(axis, axis))
    motion = ca.SX.eye(4)
    motion[:3, :3] = rotation + ca.sin(value) * ca.SX(skew)
    return motion


def chosen(options: Sequence[tuple[ca.SX, ca.SX]]) -> ca.SX:
    """The expression whose switch is 1; the first one where none is."""
    first = options[0][1]
    return first + sum(switch * (other - first) for switch, other in options[1:]) if options[1:] else first


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
