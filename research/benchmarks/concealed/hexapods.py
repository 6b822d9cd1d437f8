"""Hexapods as they are drawn: geometry, rigid-body maps and the elastostatic base model, in a few lines of numpy.

Frames and pose coordinates are those of the file formats: R = Rz(rz) Ry(ry) Rx(rx), wrench on the platform at its
origin in base axes, deflections as differences of pose coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Hexapod:
    """Joints (6 × 3, m; base in O, platform in P), home (m), true stiffness (6, N/m) and that of the drawing."""

    label: str
    base: Array
    platform: Array
    home: Array
    stiffness: Array
    drawn_stiffness: Array
    payload_kg: float
    travel: Array  # half ranges of the pose (m, rad)

    def file(self) -> dict[str, Any]:
        """The robot file's mapping: what the laboratory knows of the machine."""
        return {
            "name": f"hexapod {self.label}",
            "kind": "hexapod",
            "orientation": "fixed-xyz",
            "home": self.home.tolist(),
            "base_joints": self.base.tolist(),
            "platform_joints": self.platform.tolist(),
            "actuator_stiffness": self.drawn_stiffness.tolist(),
        }


@dataclass(frozen=True)
class Posture:
    """A hexapod at one pose: origin of P (m), rotation, platform joints in O (6 × 3, m)."""

    hexapod: Hexapod
    origin: Array
    rotation: Array
    joints: Array
    rates: Array  # E: angular velocity = E · rates of (rx, ry, rz)

    @property
    def lengths(self) -> Array:
        """Lengths of the legs (6, m)."""
        return np.asarray(np.linalg.norm(self.joints - self.hexapod.base, axis=1))

    @property
    def inverse_jacobian(self) -> Array:
        """Rates of the legs per twist of the platform (6 × 6)."""
        direction = (self.joints - self.hexapod.base) / self.lengths[:, None]
        return np.hstack([direction, np.cross(self.joints - self.origin, direction)])

    def coordinates(self, twist: Array) -> Array:
        """Change of the pose coordinates (m, rad) by a small twist (translation, rotation vector)."""
        return np.concatenate([twist[:3], np.linalg.solve(self.rates, twist[3:])])

    def base_matrix(self, wrench: Array) -> Array:
        """Deflection per compliance of each leg (6 × 6, thesis equation 1.17): the base model's observation matrix."""
        forces = np.linalg.solve(self.inverse_jacobian.T, wrench)
        forward = np.linalg.inv(self.inverse_jacobian)
        return np.column_stack([self.coordinates(forward[:, leg] * forces[leg]) for leg in range(6)])


def turn(axis: int, angle: float) -> Array:
    """Rotation about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def posture(hexapod: Hexapod, pose: Array) -> Posture:
    """The machine at a commanded pose."""
    about_x, about_y, about_z = (turn(axis, float(pose[3 + axis])) for axis in range(3))
    rotation, origin = about_z @ about_y @ about_x, hexapod.home + pose[:3]
    rates = np.column_stack([about_z @ about_y @ [1.0, 0, 0], about_z @ [0, 1.0, 0], [0, 0, 1.0]])
    return Posture(hexapod, origin, rotation, origin + hexapod.platform @ rotation.T, rates)


CLASSES = {  # base radius, platform radius, height (m), stiffness (N/m), payload (kg)
    "bench": (0.21, 0.14, 0.27, 7e6, 18.0),
    "mirror": (0.32, 0.24, 0.36, 2.2e7, 75.0),
    "heavy": (0.46, 0.36, 0.52, 6e7, 320.0),
}


def draw_hexapod(rng: np.random.Generator) -> Hexapod:
    """A machine of one of three classes, standing or (one in four) hanging, its dimensions varied."""
    label = str(rng.choice(list(CLASSES)))
    wide, narrow, height, stiffness, payload = (value * rng.uniform(0.88, 1.12) for value in CLASSES[label])
    near, far, turned = rng.uniform(7, 14), rng.uniform(8, 16), rng.uniform(0, 120)
    foot = np.deg2rad(turned + np.array([k * 120.0 + side * near for k in range(3) for side in (-1, 1)]))
    # Leg 2k + 1 and leg 2k + 2 stand on one foot and part to the neighbouring corners of the platform.
    corner = [120.0 * k + side * (60.0 - far) for k in range(3) for side in (-1, 1)]
    head = np.deg2rad(turned + np.array(corner))
    drop = 0.08 * height * rng.uniform(0.5, 1.5)
    up = -1.0 if rng.random() < 0.25 else 1.0
    base = np.column_stack([wide * np.cos(foot), wide * np.sin(foot), np.zeros(6)]).round(5)
    platform = np.column_stack([narrow * np.cos(head), narrow * np.sin(head), np.full(6, -up * drop)]).round(5)
    true = stiffness * rng.uniform(0.88, 1.15, 6)
    drawn = np.array([float(f"{value:.3g}") for value in true * rng.uniform(0.8, 1.25)])
    travel = np.array([0.11 * wide] * 3 + [0.12, 0.12, 0.16]) * rng.uniform(0.8, 1.1)
    label = label if up > 0 else f"{label}, hanging"
    home = np.array([0.0, 0.0, round(up * height, 5)])
    return Hexapod(label, base, platform, home, true, drawn, round(payload, 1), travel)
