"""Six-axis arms as laboratories know them, whatever engine solves them: robot file and URDF, readings, base model.

Deflections are those of the flange against the unloaded arm at the same command, as a translation and a rotation
vector in base axes; positions are those of known markers in the frame of an instrument at a known place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from .campaigns import DEFLECTION, GRAVITY, JOINTS, PAYLOAD, POSITION, WRENCH, Campaign
from .concealment import Bench
from .hexapods import Array, turn


@dataclass(frozen=True)
class Link:
    """A link and the joint that moves it: place in the parent (m), axis, mass (kg), its centre (m)."""

    place: tuple[float, float, float]
    axis: tuple[int, int, int]
    mass: float
    centre: tuple[float, float, float]


@dataclass(frozen=True)
class Arm:
    """What the drawing says (links, flange, stiffness of joints) and the joints' true stiffness (6, N m/rad)."""

    links: tuple[Link, ...]
    flange: tuple[float, float, float]
    stiffness: Array
    drawn_stiffness: Array

    def file(self) -> dict[str, Any]:
        """The robot file's mapping."""
        names = {"name": "arm of six axes", "kind": "serial", "urdf": "arm.urdf", "base_link": "base"}
        return names | {"tip_link": "flange", "actuator_stiffness": self.drawn_stiffness.tolist()}

    def urdf(self) -> str:
        """The same arm for those who know no springs."""
        text = '<robot name="arm"><link name="base"/>'
        for number, link in enumerate(self.links, start=1):
            parent = "base" if number == 1 else f"link_{number - 1}"
            text += (
                f'<link name="link_{number}"><inertial><origin xyz="{words(link.centre)}" rpy="0 0 0"/>'
                f'<mass value="{link.mass:.6g}"/><inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/>'
                f'</inertial></link><joint name="joint_{number}" type="revolute"><origin xyz="{words(link.place)}" '
                f'rpy="0 0 0"/><parent link="{parent}"/><child link="link_{number}"/><axis xyz="{words(link.axis)}"/>'
                '<limit lower="-6.28" upper="6.28" effort="500" velocity="3"/></joint>'
            )
        return text + (
            f'<link name="flange"/><joint name="mount" type="fixed"><origin xyz="{words(self.flange)}" rpy="0 0 0"/>'
            '<parent link="link_6"/><child link="flange"/></joint></robot>\n'
        )


def load_of(row: pd.Series, rotation: Array) -> Array:
    """Assumed wrench on the flange (base axes) of a row with a wrench or a payload."""
    if "fx_N" in row:
        return np.asarray(row[list(WRENCH)].to_numpy(dtype=float))
    mass, *centre = (float(value) for value in row[list(PAYLOAD)])
    force = np.array([0.0, 0.0, -GRAVITY * mass])
    return np.concatenate([force, np.cross(rotation @ centre, force)])


def words(values: tuple[float, ...] | Array) -> str:
    """Numbers as URDF and the like write them."""
    return " ".join(f"{value:.9g}" for value in values)


class Rigid(Protocol):
    """The kinematics of an arm whose joints stand where they are commanded."""

    def rigid(self, command: Array) -> tuple[Array, Array, Array]:
        """Place (m), rotation and Jacobian (6 × 6, base axes) of the flange."""

    def jacobian(self, point: Array) -> Array:
        """Twist at a point on the flange's link per rate of the joints, at the last command."""

    def weight(self) -> Array:
        """Torques (6, N m) that hold the arm's own weight, at the last command."""


@dataclass(frozen=True)
class States:
    """Places (rows × 3, m) and rotations (rows × 3 × 3) of the flange without and with the load of each row."""

    bare_places: Array
    bare_rotations: Array
    places: Array
    rotations: Array

    @staticmethod
    def of(bare: Sequence[tuple[Array, Array]], loaded: Sequence[tuple[Array, Array]]) -> States:
        """From place and rotation of each row."""
        return States(*(np.array(part) for both in (bare, loaded) for part in zip(*both, strict=True)))

    def deflections(self) -> Array:
        """Noise-free deflections of the flange (rows × 6; m, rad)."""
        turned = Rotation.from_matrix(self.rotations @ self.bare_rotations.transpose(0, 2, 1)).as_rotvec()
        return np.hstack([self.places - self.bare_places, turned])

    def positions(self, markers: Sequence[Array], instrument: tuple[Array, Array]) -> Array:
        """Noise-free positions of each row's marker in the instrument's frame (rows × 3, m)."""
        seen = self.places + np.einsum("nij,nj->ni", self.rotations, np.array(markers))
        return np.asarray((seen - instrument[0]) @ instrument[1])


def base_deflections(stand: Rigid, rows: pd.DataFrame) -> tuple[Array, Array]:
    """The base model of deflections: what it says without any compliance (0), and per compliance (rows × 6 × 6)."""
    found = []
    for _, row in rows.iterrows():
        _, rotation, jacobian = stand.rigid(row[list(JOINTS)].to_numpy(dtype=float))
        found.append(jacobian * (jacobian.T @ load_of(row, rotation)))
    return np.zeros((len(rows), 6)), np.array(found)


def base_positions(
    stand: Rigid, rows: pd.DataFrame, markers: Sequence[Array], instrument: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Likewise of markers' positions: the rigid arm's, and per compliance under load and own weight (rows × 3 × 6)."""
    rigid, found = np.zeros((len(rows), 3)), []
    for index, (_, row) in enumerate(rows.iterrows()):
        place, rotation, jacobian = stand.rigid(row[list(JOINTS)].to_numpy(dtype=float))
        marker = place + rotation @ markers[index]
        torque = jacobian.T @ load_of(row, rotation) - stand.weight()
        rigid[index] = instrument[1].T @ (marker - instrument[0])
        found.append(instrument[1].T @ (stand.jacobian(marker)[:3] * torque))
    return rigid, np.array(found)


def torques(stand: Rigid, rows: pd.DataFrame) -> Array:
    """Torques of the joints under the loads alone (rows × 6, N m)."""
    found = []
    for _, row in rows.iterrows():
        _, rotation, jacobian = stand.rigid(row[list(JOINTS)].to_numpy(dtype=float))
        found.append(jacobian.T @ load_of(row, rotation))
    return np.array(found)


def arm_bench(
    arm: Arm, campaign: Campaign, stand: Rigid, states: Callable[[Any], States], rng: np.random.Generator
) -> Bench:
    """An arm's campaign as judge and laboratory see it; where rows have markers, these and an instrument are drawn.

    `states(None)` are those of the arm in which nothing is hidden.
    """
    robot, rows, files = arm.file(), campaign.rows, {"arm.urdf": arm.urdf()}
    if "marker" not in rows:
        rigid, matrices = base_deflections(stand, rows)

        def deflections(parts: Any) -> Array:
            return states(parts).deflections()

        return Bench(campaign, DEFLECTION, deflections, rigid, matrices, robot, files, arm.stiffness, "arm")
    low, high = [-0.09, -0.09, -0.03], [0.09, 0.09, 0.15]
    places = {name: rng.uniform(low, high).round(4) for name in ("red", "green", "blue")}
    at, yaw = (rng.uniform([1.4, -1.0, 0.1], [2.4, 1.0, 0.9])).round(4), round(float(rng.uniform(-3, 3)), 4)
    robot |= {"markers": {name: place.tolist() for name, place in places.items()}}
    robot |= {"instrument": [*at.tolist(), 0.0, 0.0, yaw]}
    instrument, markers = (at, turn(2, yaw)), [places[str(name)] for name in rows["marker"]]
    rigid, matrices = base_positions(stand, rows, markers, instrument)

    def positions(parts: Any) -> Array:
        return states(parts).positions(markers, instrument)

    return Bench(campaign, POSITION, positions, rigid, matrices, robot, files, arm.stiffness, "arm, positions")
