"""Transforms of joints as symbolic expressions."""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.urdf import UrdfJoint, transform

_ROUNDING = 1e-15


def constant(matrix: FloatArray) -> ca.SX:
    """A constant transform in which rounding of right angles leaves no entries behind."""
    return ca.sparsify(ca.SX(np.where(np.abs(matrix) < _ROUNDING, 0.0, matrix)))


def moved(joint: UrdfJoint, value: ca.SX) -> ca.SX:
    """Motion of a joint along or about its axis: exp(q·ξ), by Rodrigues' formula for a rotation."""
    axis = np.where(np.abs(joint.axis) < _ROUNDING, 0.0, joint.axis)
    if joint.kind == "prismatic":
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
