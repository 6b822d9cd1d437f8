"""Hexapods of own geometry, and their equilibrium with yielding legs, plates, mounts and surroundings, in numpy.

Legs are pinned, so their forces follow from the wrench at the place where the platform stands; the platform stands
where the distances of the displaced joints are the lengths of the legs. Both are solved together, row by row of a
campaign, by the legs' own Jacobian.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from ..campaigns import POSE, wrenches
from ..case import UnsuitableError
from ..hexapods import Array, Hexapod, posture

_CLASSES = {  # radii (m), height (m), half angles of pairs (°), stiffness (N/m), payload (kg), scatter of joints
    "telescope": (0.95, 0.78, 0.75, 5.0, 6.0, 1.1e8, 650.0, 0.01),
    "cubic": (0.25, 0.25, 0.18, 4.0, 4.0, 2.6e7, 45.0, 0.01),
    "table": (0.28, 0.19, 0.24, 14.0, 17.0, 1.3e7, 32.0, 0.05),
}
_ITERATIONS, _TOLERANCE = 80, 1e-11  # m, rad


def draw_hexapod(rng: np.random.Generator) -> Hexapod:
    """A machine of one of three classes; joints lie off their circles by the class's scatter."""
    label = str(rng.choice(list(_CLASSES)))
    *sizes, stiffness, payload, scatter = _CLASSES[label]
    wide, narrow, height, near, far = (value * rng.uniform(0.9, 1.1) for value in sizes)
    foot = np.deg2rad([120.0 * k + side * near for k in range(3) for side in (-1, 1)])
    head = np.deg2rad([120.0 * k + side * (60.0 - far) for k in range(3) for side in (-1, 1)])
    turned = rng.uniform(0, 2 * np.pi)
    rings: list[Array] = []
    for radius, angles in ((wide, foot + turned), (narrow, head + turned)):
        ring = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(6)])
        rings.append((ring + scatter * radius * rng.normal(size=(6, 3))).round(5))
    true = stiffness * rng.uniform(0.85, 1.2, 6)
    drawn = np.array([float(f"{value:.3g}") for value in true * rng.uniform(0.75, 1.3)])
    travel = np.array([0.1 * wide] * 3 + [0.1, 0.1, 0.14]) * rng.uniform(0.8, 1.1)
    home = np.array([0.0, 0.0, round(height, 5)])
    return Hexapod(label, rings[0], rings[1], home, true, drawn, round(payload * rng.uniform(0.9, 1.1), 1), travel)


def _nothing(*_: object) -> float:
    return 0.0


@dataclass(frozen=True)
class Machine:
    """A hexapod and what it conceals; whatever is not given is as in the base model.

    `longer`: elongation (rows × 6, m) by the forces of the legs (rows × 6, N; pulled longer: positive) in the order of
    the rows; `feet`, `heads`: displacements (rows × 6 × 3, m) of the joints on the base in O by the forces of the legs
    on them, and of those on the platform in P; `spring`: stiffness (6 × 6) between platform and ground; `load`: what
    acts in place of the written wrench (rows × 6); `read`: what is read in place of the deflections.
    """

    hexapod: Hexapod
    longer: Callable[[Array, pd.DataFrame], Array] | None = None
    feet: Callable[[Array, pd.DataFrame], Array | float] = _nothing
    heads: Callable[[Array, pd.DataFrame], Array | float] = _nothing
    spring: Array | float = 0.0
    load: Callable[[Array], Array] | None = None
    read: Callable[[Array, pd.DataFrame], Array] | None = None

    def deflections(self, rows: pd.DataFrame) -> Array:
        """Noise-free readings of a campaign (rows × 6; m, rad).

        Raises:
            UnsuitableError: no equilibrium.
        """
        spring = self.spring * np.eye(6) if np.ndim(self.spring) == 0 else np.asarray(self.spring)
        own, poses = self.hexapod, rows[list(POSE)].to_numpy(dtype=float)
        places = [posture(own, pose) for pose in poses]
        lengths, turned = np.array([p.lengths for p in places]), np.array([p.rotation for p in places])
        origins, load = np.array([p.origin for p in places]), wrenches(own, rows)
        if self.load:
            load = self.load(load)
        moved, heads, feet = np.zeros((len(rows), 6)), np.zeros((len(rows), 6, 3)), np.zeros((len(rows), 6, 3))
        for _ in range(_ITERATIONS):
            rotations = Rotation.from_rotvec(moved[:, 3:]).as_matrix() @ turned
            lever = np.einsum("nij,nkj->nki", rotations, own.platform + heads)
            legs = (origins + moved[:, :3])[:, None] + lever - own.base - feet
            reached = np.linalg.norm(legs, axis=2)
            directions = legs / reached[:, :, None]
            jacobian = np.concatenate([directions, np.cross(lever, directions)], axis=2)
            upward = np.linalg.inv(jacobian.transpose(0, 2, 1))
            forces = np.einsum("nij,nj->ni", upward, load - moved @ spring.T)
            pulls = forces[:, :, None] * directions
            feet = feet * 0.0 + self.feet(pulls, rows)
            heads = heads * 0.0 + self.heads(-np.einsum("nji,nkj->nki", rotations, pulls), rows)
            longer = self.longer(forces, rows) if self.longer else forces / own.stiffness
            yielding = jacobian + upward @ spring / own.stiffness[:, None]
            step = np.linalg.solve(yielding, (lengths + longer - reached)[:, :, None])[:, :, 0]
            moved = moved + step
            if np.abs(step).max() < _TOLERANCE:
                break
        else:
            raise UnsuitableError("the hexapod finds no equilibrium")
        stands = (Rotation.from_rotvec(moved[:, 3:]) * Rotation.from_matrix(turned)).as_euler("xyz")
        found = np.hstack([moved[:, :3], stands - poses[:, 3:]])
        return self.read(found, rows) if self.read else found
