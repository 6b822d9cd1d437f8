"""A hexapod with errors, solved exactly and without the library: poses that an ideal instrument would read.

The controller computes lengths with the nominal joints; the machine has others, adds an error to each length and gives
way under load. The equilibrium pose solves |p + R·b − a| = q + δl + c∘τ(p, R), Jᵀτ = w, by Newton's method on the
rotation matrix itself (R ← exp([ω]ₓ)·R), with SciPy's rotations and no linearisation left at the solution.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

Array = npt.NDArray[np.floating[Any]]
_STEPS = 30
_SETTLED = 1e-14


@dataclass(frozen=True)
class Geometry:
    """Joints on the base (6, 3) and on the platform (6, 3), and the platform's position at zero pose (3,), in m."""

    base: Array
    platform: Array
    home: Array

    def legs(self, position: Array, rotation: Array) -> tuple[Array, Array, Array]:
        """Lengths (N, 6), unit vectors (N, 6, 3) and levers R·b (N, 6, 3) at N poses."""
        levers = np.einsum("nij,kj->nki", rotation, self.platform)
        vectors = position[:, None, :] + levers - self.base
        lengths = np.linalg.norm(vectors, axis=2)
        return lengths, vectors / lengths[..., None], levers


@dataclass(frozen=True)
class Machine:
    """A hexapod as it is.

    Attributes:
        nominal: geometry in the controller.
        true: geometry of the machine.
        length_errors: true minus commanded lengths (m), shape (6,).
        compliance: of the legs (m/N), shape (6,).
    """

    nominal: Geometry
    true: Geometry
    length_errors: Array
    compliance: Array

    def poses(self, commands: Array, wrenches: Array) -> Array:
        """True poses (N, 6) in m and rad (fixed x, y, z axes) at commands (N, 6) under wrenches (N, 6) at P."""
        position = self.nominal.home + commands[:, :3]
        rotation = Rotation.from_euler("xyz", commands[:, 3:]).as_matrix()
        commanded = self.nominal.legs(position, rotation)[0] + self.length_errors
        for _ in range(_STEPS):
            lengths, directions, levers = self.true.legs(position, rotation)
            rates = np.concatenate([directions, np.cross(levers, directions)], axis=2)
            forces = np.linalg.solve(rates.swapaxes(1, 2), wrenches[..., None])[..., 0]
            missing = commanded + self.compliance * forces - lengths
            twist = np.linalg.solve(rates, missing[..., None])[..., 0]
            position = position + twist[:, :3]
            rotation = Rotation.from_rotvec(twist[:, 3:]).as_matrix() @ rotation
            if np.abs(twist).max() < _SETTLED:
                break
        angles = Rotation.from_matrix(rotation).as_euler("xyz")
        return np.hstack([position - self.nominal.home, angles])


def with_errors(nominal: Geometry, compliance: Array, errors: Array) -> Machine:
    """The machine with 48 errors: base joints (18) and platform joints (18) in m, lengths (6) in m, compliances (6)
    relative to `compliance`.
    """
    base = nominal.base + errors[:18].reshape(6, 3)
    platform = nominal.platform + errors[18:36].reshape(6, 3)
    return Machine(nominal, Geometry(base, platform, nominal.home), errors[36:42], compliance * (1.0 + errors[42:]))
