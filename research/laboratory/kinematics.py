"""Poses, rotation conventions and the controller's inverse kinematics.

A rotation convention is `fixed-xyz`, R = Rz(rz) Ry(ry) Rx(rx), or `moving-xyz`, R = Rx(rx) Ry(ry) Rz(rz).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, hypot, sin
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import LaboratoryError

Vector: TypeAlias = NDArray[np.floating[Any]]
Matrix: TypeAlias = NDArray[np.floating[Any]]

ORIENTATIONS = ("fixed-xyz", "moving-xyz")


@dataclass(frozen=True)
class Pose:
    """Place of a body: position of its origin (m, in O) and the rotation from its axes to those of O."""

    position: Vector
    rotation: Matrix

    def point(self, local: Vector) -> Vector:
        """Position in O (m) of a point given in the body's axes (m)."""
        return self.position + self.rotation @ local


def rotation_matrix(angles: ArrayLike, orientation: str) -> Matrix:
    """Rotation from the angles `[rx, ry, rz]` (rad) in the robot's convention."""
    rx, ry, rz = np.asarray(angles, dtype=float)
    cx, sx, cy, sy, cz, sz = cos(rx), sin(rx), cos(ry), sin(ry), cos(rz), sin(rz)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    if orientation == "fixed-xyz":
        return np.asarray(about_z @ about_y @ about_x)
    if orientation == "moving-xyz":
        return np.asarray(about_x @ about_y @ about_z)
    raise LaboratoryError(f"orientation must be one of {', '.join(ORIENTATIONS)}, not {orientation!r}")


def rotation_angles(rotation: Matrix, orientation: str) -> Vector:
    """Angles `[rx, ry, rz]` (rad) of a rotation; the inverse of `rotation_matrix` for |ry| < pi/2."""
    r = rotation
    if orientation == "fixed-xyz":
        return np.array([atan2(r[2, 1], r[2, 2]), atan2(-r[2, 0], hypot(r[0, 0], r[1, 0])), atan2(r[1, 0], r[0, 0])])
    return np.array([atan2(-r[1, 2], r[2, 2]), atan2(r[0, 2], hypot(r[0, 0], r[0, 1])), atan2(-r[0, 1], r[0, 0])])


def rotation_about(vector: ArrayLike) -> Matrix:
    """Rotation by the rotation vector (rad), Rodrigues' formula."""
    vector = np.asarray(vector, dtype=float)
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + sin(angle) * skew + (1 - cos(angle)) * skew @ skew)


def rotation_between(start: Vector, end: Vector) -> Matrix:
    """Smallest rotation that turns the unit vector `start` into the unit vector `end`."""
    axis = np.cross(start, end)
    sine = float(np.linalg.norm(axis))
    if sine == 0.0:
        return np.eye(3)
    return rotation_about(axis / sine * atan2(sine, float(start @ end)))


def leg_lengths(base_joints: Matrix, platform_joints: Matrix, platform: Pose) -> Vector:
    """Actuator lengths (m) q_i = |p + R b_i - a_i| that the controller commands for a platform pose."""
    ends = platform.position + platform_joints @ platform.rotation.T
    return np.asarray(np.linalg.norm(ends - base_joints, axis=1))


def leg_directions(base_joints: Matrix, platform_joints: Matrix, platform: Pose) -> Matrix:
    """Unit vectors of the legs from base to platform joint (in O; legs x 3)."""
    spans = platform.position + platform_joints @ platform.rotation.T - base_joints
    return np.asarray(spans / np.linalg.norm(spans, axis=1)[:, None])
