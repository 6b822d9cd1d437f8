"""Orientation conventions: how three angles make a rotation matrix.

Source: theory.md section 2.2 (the Symétrie controllers use `fixed-xyz`), file-formats.md, Conventions (both).
"""

from typing import Literal

import casadi as ca

Orientation = Literal["fixed-xyz", "moving-xyz"]


def rotation_matrix(angles: ca.SX, orientation: Orientation) -> ca.SX:
    """R (3×3), which turns platform axes into base axes, from `(rx, ry, rz)` in rad.

    `fixed-xyz` is R = Rz(rz)·Ry(ry)·Rx(rx); `moving-xyz` is R = Rx(rx)·Ry(ry)·Rz(rz).
    """
    about_x, about_y, about_z = (_about(axis, angles[axis]) for axis in range(3))
    if orientation == "fixed-xyz":
        return about_z @ about_y @ about_x
    return about_x @ about_y @ about_z


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


def angular_velocity_map(rotation: ca.SX, angles: ca.SX) -> ca.SX:
    """E (3×3) with ω = E·(ṙx, ṙy, ṙz), ω in base axes, by differentiating R: [ω]ₓ = Ṙ·Rᵀ (theory.md 2.2)."""
    columns = []
    for k in range(3):
        rate = ca.reshape(ca.jacobian(ca.vec(rotation), angles[k]), 3, 3) @ rotation.T
        columns.append(ca.vertcat(rate[2, 1], rate[0, 2], rate[1, 0]))
    return ca.horzcat(*columns)


def _about(axis: int, angle: ca.SX) -> ca.SX:
    """Rotation about one coordinate axis by `angle` (rad)."""
    c, s = ca.cos(angle), ca.sin(angle)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    matrix = ca.SX.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix
