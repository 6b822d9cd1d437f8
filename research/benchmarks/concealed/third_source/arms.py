"""Arms of own kinematics, and their equilibrium with yielding joints, links, pedestals and cables, in numpy.

An arm is a chain of stations: the base, six joints, the flange. Each lies at a place in the frame before it, is
displaced by what yields there and turned by its joint. Forces pass from the flange to the base; displacements follow
from them and change them in turn, until both agree, for all rows of a campaign at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from ..arms import Arm, Link, States, load_of
from ..campaigns import GRAVITY, JOINTS
from ..case import UnsuitableError
from ..hexapods import Array

LOW = np.array([-1.5, -0.9, 0.3, -1.2, 0.5, -1.6])  # rad, of the joints in campaigns
HIGH = np.array([1.5, 0.8, 1.7, 1.2, 2.0, 1.6])
_ITERATIONS, _TOLERANCE = 60, 1e-11  # m, rad


def draw_arm(rng: np.random.Generator) -> Arm:
    """An arm with three parallel axes and an offset wrist, or with a forearm across and an in-line wrist."""
    size = float(rng.uniform(0.8, 1.3))
    upper, fore = (round(size * float(rng.uniform(*ends)), 4) for ends in ((0.42, 0.55), (0.38, 0.5)))
    side, wrist, column = (round(share * size * float(rng.uniform(0.9, 1.1)), 4) for share in (0.12, 0.1, 0.25))
    z = (0, 0, 1)
    if rng.random() < 0.5:
        flange = (0.0, round(0.8 * wrist, 4), 0.0)
        axes = (z, (0, 1, 0), (0, 1, 0), (0, 1, 0), z, (0, 1, 0))
        places: list[tuple[float, float, float]] = [
            (0, 0, column),
            (0, side, 0),
            (0, -side / 2, upper),
            (0, 0, fore),
            (0, wrist, 0),
            (0, 0, wrist),
        ]
    else:
        flange = (round(0.5 * wrist, 4), 0.0, 0.0)
        axes = (z, (0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0))
        places = [
            (0, 0, column),
            (side, 0, side),
            (0, 0, upper),
            (fore / 2, 0, side / 2),
            (fore / 2, 0, 0),
            (wrist, 0, 0),
        ]
    masses = np.array([8.0, 9.0, 4.5, 2.0, 1.6, 0.6]) * size * rng.uniform(0.85, 1.15, 6)
    links = []
    for place, axis, mass, (x, y, z_end) in zip(places, axes, masses, [*places[1:], flange], strict=True):
        links.append(Link(place, axis, float(f"{mass:.4g}"), (0.45 * x, 0.45 * y, 0.45 * z_end)))
    stiffness = np.array([5e4, 4.5e4, 2.5e4, 9e3, 7e3, 5e3]) * size**2 * rng.uniform(0.8, 1.25, 6)
    drawn = np.array([float(f"{value:.3g}") for value in stiffness * rng.uniform(0.75, 1.3, 6)])
    return Arm(tuple(links), flange, stiffness, drawn)


Yields = Callable[[Array, pd.DataFrame], Array]


@dataclass(frozen=True)
class Line:
    """A cable or spring from a point of one link (0: the base) to a point of another.

    `force`: on its second end (rows × 3, N; base axes) by the span from the first to the second (rows × 3, m).
    """

    links: tuple[int, int]
    points: tuple[Array, Array]
    force: Callable[[Array], Array]


@dataclass(frozen=True)
class Concealing:
    """What an arm conceals.

    `turns`: rotation of the joints (rows × 6, rad) by their torques and those without load (rows × 6, N m); `yields`:
    by station (0: base, 1 to 6: before a joint turns, 7: flange) the twist (rows × 6) by the wrench there (rows × 6),
    both in the frame before it; `lines`: what pulls.
    """

    turns: Callable[[Array, Array, pd.DataFrame], Array] | None = None
    yields: Mapping[int, Yields] = field(default_factory=dict)
    lines: tuple[Line, ...] = ()


class Chain:
    """An arm in equilibrium."""

    def __init__(self, arm: Arm, conceals: Concealing | None = None) -> None:
        self.arm, self.conceals = arm, conceals or Concealing()
        self._places = np.array([(0, 0, 0), *(link.place for link in arm.links), arm.flange], dtype=float)
        self._axes = np.array([link.axis for link in arm.links], dtype=float)
        self._masses = np.array([link.mass for link in arm.links])
        self._centres = np.array([link.centre for link in arm.links])
        self._frames: tuple[Array, Array] = np.zeros((0, 8, 3)), np.zeros((0, 8, 3, 3))

    def _stand(self, turned: Array, twists: Array) -> tuple[Array, Array, Array]:
        """Places (n × 8 × 3) and rotations (n × 8 × 3 × 3) of stations, and the rotations before them."""
        count = len(turned)
        place, rotation = np.zeros((count, 3)), np.tile(np.eye(3), (count, 1, 1))
        places, rotations, befores = [], [], []
        for station in range(8):
            befores.append(rotation)
            place = place + np.einsum("nij,nj->ni", rotation, self._places[station] + twists[:, station, :3])
            rotation = rotation @ Rotation.from_rotvec(twists[:, station, 3:]).as_matrix()
            if 1 <= station <= 6:
                about = np.outer(turned[:, station - 1], self._axes[station - 1])
                rotation = rotation @ Rotation.from_rotvec(about).as_matrix()
            places.append(place)
            rotations.append(rotation)
        return tuple(np.stack(each, axis=1) for each in (places, rotations, befores))  # type: ignore[return-value]

    def _wrenches(self, places: Array, rotations: Array, load: Array) -> Array:
        """Forces and moments (n × 8 × 6, base axes) that pass each station, at its place."""
        down = np.array([0.0, 0.0, -GRAVITY])
        acting = [(7, places[:, 7], load[:, :3], load[:, 3:])]
        for link in range(1, 7):
            centre = places[:, link] + rotations[:, link] @ self._centres[link - 1]
            acting.append((link, centre, np.tile(self._masses[link - 1] * down, (len(load), 1)), 0.0 * load[:, 3:]))
        for line in self.conceals.lines:
            one, other = (
                places[:, link] + rotations[:, link] @ point
                for link, point in zip(line.links, line.points, strict=True)
            )
            force = line.force(other - one)
            acting += [(line.links[0], one, -force, 0 * force), (line.links[1], other, force, 0 * force)]
        found = np.zeros((len(load), 8, 6))
        for holder, point, force, moment in acting:
            for station in range(holder + 1):
                found[:, station, :3] += force
                found[:, station, 3:] += moment + np.cross(point - places[:, station], force)
        return found

    def _equilibrium(self, commands: Array, load: Array, rows: pd.DataFrame, rest: Array | None) -> tuple[Array, ...]:
        """Places, rotations of the flange and torques of the joints."""
        turned, twists = commands, np.zeros((len(commands), 8, 6))
        for _ in range(_ITERATIONS):
            places, rotations, befores = self._stand(turned, twists)
            passing = self._wrenches(places, rotations, load)
            axes = np.einsum("nkij,kj->nki", rotations[:, 1:7], self._axes)
            torques = np.einsum("nki,nki->nk", axes, passing[:, 1:7, 3:])
            give = torques / self.arm.stiffness
            if self.conceals.turns:
                give = self.conceals.turns(torques, torques if rest is None else rest, rows)
            following, yielding = commands + give, np.zeros_like(twists)
            for station, yields in self.conceals.yields.items():
                local = np.einsum("nji,nkj->nki", befores[:, station], passing[:, station].reshape(-1, 2, 3))
                yielding[:, station] = yields(local.reshape(-1, 6), rows)
            change = max(np.abs(following - turned).max(), np.abs(yielding - twists).max())
            turned, twists = following, yielding
            if change < _TOLERANCE:
                return places[:, 7], rotations[:, 7], torques
        raise UnsuitableError("the arm finds no equilibrium")

    def states(self, rows: pd.DataFrame) -> States:
        """Where the flange stands in each row, without and with its load."""
        commands = rows[list(JOINTS)].to_numpy(dtype=float)
        *bare, rest = self._equilibrium(commands, np.zeros((len(rows), 6)), rows, None)
        load = np.array([load_of(row, rotation) for (_, row), rotation in zip(rows.iterrows(), bare[1], strict=True)])
        place, rotation, _ = self._equilibrium(commands, load, rows, rest)
        return States(bare[0], bare[1], place, rotation)

    def rigid(self, command: Array) -> tuple[Array, Array, Array]:
        """Place (m), rotation and Jacobian (6 × 6, base axes) of the flange."""
        places, rotations, _ = self._stand(np.asarray(command, dtype=float)[None], np.zeros((1, 8, 6)))
        self._frames = places[0], rotations[0]
        return places[0, 7], rotations[0, 7], self.jacobian(places[0, 7])

    def jacobian(self, point: Array) -> Array:
        """Twist at a point on the flange's link per rate of the joints, at the last command."""
        places, rotations = self._frames
        axes = np.einsum("kij,kj->ki", rotations[1:7], self._axes)
        return np.vstack([np.cross(axes, point - places[1:7]).T, axes.T])

    def weight(self) -> Array:
        """Torques (6, N m) that hold the arm's own weight, at the last command."""
        places, rotations = self._frames
        passing = Chain(self.arm)._wrenches(places[None], rotations[None], np.zeros((1, 6)))[0]
        axes = np.einsum("kij,kj->ki", rotations[1:7], self._axes)
        return np.asarray(-np.einsum("ki,ki->k", axes, passing[1:7, 3:]))
