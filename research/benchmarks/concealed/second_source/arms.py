"""A six-axis arm in MuJoCo: elastic joints, and what may be added: springs with a dead band, hoses, links that bend.

The arm stands still under its weight and a load: the equilibrium of the engine's own forces (springs of joints and
tendons, gravity, applied wrench) is found by Newton's method on its positions.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from .campaigns import GRAVITY, JOINTS, PAYLOAD, POSITION, WRENCH
from .frames import EngineError
from .hexapods import Array

_STEP, _TOLERANCE, _ITERATIONS = 1e-7, 1e-8, 60  # rad, N m


@cache
def engine() -> Any:
    """MuJoCo."""
    import mujoco  # noqa: PLC0415 - an extra

    return mujoco


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
                f'<link name="link_{number}"><inertial><origin xyz="{_words(link.centre)}" rpy="0 0 0"/>'
                f'<mass value="{link.mass:.6g}"/><inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/>'
                f'</inertial></link><joint name="joint_{number}" type="revolute"><origin xyz="{_words(link.place)}" '
                f'rpy="0 0 0"/><parent link="{parent}"/><child link="link_{number}"/><axis xyz="{_words(link.axis)}"/>'
                '<limit lower="-6.28" upper="6.28" effort="500" velocity="3"/></joint>'
            )
        return text + (
            f'<link name="flange"/><joint name="mount" type="fixed"><origin xyz="{_words(self.flange)}" rpy="0 0 0"/>'
            '<parent link="link_6"/><child link="flange"/></joint></robot>\n'
        )


@dataclass(frozen=True)
class Spring:
    """A torsional spring at joint `joint` that acts outside `low` … `high` (rad; of the joint, or from its command)."""

    joint: int
    stiffness: float
    low: float
    high: float
    from_command: bool


@dataclass(frozen=True)
class Hose:
    """A tendon from a point of one link (0: base) to a point of another that pulls beyond its length (m, N/m)."""

    links: tuple[int, int]
    points: tuple[tuple[float, float, float], tuple[float, float, float]]
    length: float
    stiffness: float


@dataclass(frozen=True)
class Parts:
    """What an arm conceals. `own`: stiffness of joints that is another; `bends`: of the middle of links (N m/rad);
    `tilt`: of the base about x, y, z; `tool`: mass (kg) and centre (m, flange) of what rides on it undeclared."""

    own: dict[int, float] = field(default_factory=dict)
    springs: tuple[Spring, ...] = ()
    hoses: tuple[Hose, ...] = ()
    bends: dict[int, float] = field(default_factory=dict)
    tilt: tuple[float, float, float] | None = None
    tool: tuple[float, tuple[float, float, float]] | None = None


def _words(values: tuple[float, ...] | Array) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def draw_arm(rng: np.random.Generator) -> Arm:
    """An arm of 0.9 to 1.5 m reach."""
    size = float(rng.uniform(0.85, 1.4))
    upper, fore = (round(size * float(rng.uniform(*ends)), 4) for ends in ((0.4, 0.52), (0.36, 0.46)))
    side, column, wrist = round(0.07 * size, 4), round(0.2 * size, 4), round(0.1 * size, 4)
    drawn_links = (
        Link((0, 0, column), (0, 0, 1), 7.0 * size, (0.0, 0.0, 0.03)),
        Link((side, 0, 0.06), (0, 1, 0), 10.0 * size, (0.0, 0.02, round(0.45 * upper, 4))),
        Link((0, 0, upper), (0, 1, 0), 5.0 * size, (0.02, 0.0, round(0.4 * fore, 4))),
        Link((0, 0, fore), (0, 0, 1), 1.8 * size, (0.0, 0.0, 0.03)),
        Link((0, 0, wrist), (0, 1, 0), 1.4 * size, (0.0, 0.01, 0.03)),
        Link((0, 0, wrist), (0, 0, 1), 0.5 * size, (0.0, 0.0, 0.01)),
    )
    links = tuple(Link(each.place, each.axis, float(f"{each.mass:.4g}"), each.centre) for each in drawn_links)
    stiffness = np.array([4e4, 4e4, 2e4, 7e3, 7e3, 5e3]) * size**2 * rng.uniform(0.8, 1.25, 6)
    drawn = np.array([float(f"{value:.3g}") for value in stiffness * rng.uniform(0.75, 1.3, 6)])
    return Arm(links, (0.0, 0.0, round(0.06 * size, 4)), stiffness, drawn)


class Stand:
    """An arm with its concealed parts in the engine."""

    def __init__(self, arm: Arm, parts: Parts | None = None) -> None:
        self.arm, self.parts = arm, parts or Parts()
        self._mujoco = engine()
        self._model = self._mujoco.MjModel.from_xml_string(self._xml())
        self._data = self._mujoco.MjData(self._model)
        kinds = self._mujoco.mjtObj
        self._tip = self._mujoco.mj_name2id(self._model, kinds.mjOBJ_SITE, "flange")
        self._body = int(self._model.site_bodyid[self._tip])
        joints = [self._mujoco.mj_name2id(self._model, kinds.mjOBJ_JOINT, f"joint_{n}") for n in range(1, 7)]
        self._at = np.array([int(self._model.jnt_qposadr[joint]) for joint in joints])
        names = [f"spring_{n}" for n in range(len(self.parts.springs))]
        self._springs = [self._mujoco.mj_name2id(self._model, kinds.mjOBJ_TENDON, name) for name in names]

    def _xml(self) -> str:
        parts, text = self.parts, '<mujoco><compiler angle="radian" autolimits="false"/>'
        text += f'<option gravity="0 0 {-GRAVITY}"><flag contact="disable"/></option><worldbody>'
        sites: dict[int, str] = dict.fromkeys(range(7), "")
        for number, hose in enumerate(parts.hoses):
            for end, (holder, point) in enumerate(zip(hose.links, hose.points, strict=True)):
                sites[holder] += f'<site name="hose_{number}_{end}" pos="{_words(point)}"/>'
        text += sites[0] + '<body name="stand"><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>'
        for axis, stiffness in zip(("1 0 0", "0 1 0", "0 0 1"), parts.tilt or (), strict=False):
            text += f'<joint type="hinge" axis="{axis}" stiffness="{stiffness:.12g}"/>'
        depth = 1
        for number, link in enumerate(self.arm.links, start=1):
            place = np.array(link.place)
            if number - 1 in parts.bends:  # the middle of the link before this joint
                text += f'<body pos="{_words(place / 2)}"><inertial pos="0 0 0" mass="1e-6" '
                text += 'diaginertia="1e-6 1e-6 1e-6"/>'
                stiffness = parts.bends[number - 1]
                for axis in ("1 0 0", "0 1 0"):
                    text += f'<joint type="hinge" axis="{axis}" stiffness="{stiffness:.12g}"/>'
                place, depth = place / 2, depth + 1
            stiffness = parts.own.get(number - 1, float(self.arm.stiffness[number - 1]))
            text += (
                f'<body name="link_{number}" pos="{_words(place)}"><inertial pos="{_words(link.centre)}" '
                f'mass="{link.mass:.9g}" diaginertia="0.05 0.05 0.05"/>'
                f'<joint name="joint_{number}" type="hinge" axis="{_words(link.axis)}" stiffness="{stiffness:.12g}"/>'
                f"{sites[number]}"
            )
            depth += 1
        text += f'<site name="flange" pos="{_words(self.arm.flange)}"/>'
        if parts.tool:
            centre = np.array(self.arm.flange) + parts.tool[1]
            text += (
                f'<body name="tool" pos="{_words(centre)}"><inertial pos="0 0 0" mass="{parts.tool[0]:.9g}" '
                'diaginertia="1e-3 1e-3 1e-3"/></body>'
            )
        text += "</body>" * depth + "</worldbody><tendon>"
        for number, spring in enumerate(parts.springs):
            text += (
                f'<fixed name="spring_{number}" stiffness="{spring.stiffness:.12g}" springlength="0 0.1">'
                f'<joint joint="joint_{spring.joint + 1}" coef="1"/></fixed>'
            )
        for number, hose in enumerate(parts.hoses):
            text += (
                f'<spatial name="hose_{number}" stiffness="{hose.stiffness:.12g}" springlength="0 {hose.length:.12g}">'
                f'<site site="hose_{number}_0"/><site site="hose_{number}_1"/></spatial>'
            )
        return text + "</tendon></mujoco>"

    def rigid(self, command: Array) -> tuple[Array, Array, Array]:
        """Place (m), rotation and Jacobian (6 × 6, base axes) of the flange where joints stand at their command."""
        self._command(command)
        self._mujoco.mj_fwdPosition(self._model, self._data)
        place, rotation = self._flange()
        return place, rotation, self.jacobian(place)

    def jacobian(self, point: Array) -> Array:
        """Twist at a point on the flange's link per rate of the six joints, where the arm now stands."""
        translation, turning = np.zeros((3, self._model.nv)), np.zeros((3, self._model.nv))
        self._mujoco.mj_jac(self._model, self._data, translation, turning, point, self._body)
        return np.vstack([translation, turning])[:, self._at]

    def weight(self) -> Array:
        """Torques (6, N m) that hold the arm's own weight, where it now stands."""
        self._mujoco.mj_fwdVelocity(self._model, self._data)
        return np.array(self._data.qfrc_bias[self._at])

    def _command(self, command: Array) -> None:
        self._data.qpos[:] = 0.0
        self._data.qvel[:] = 0.0
        self._data.qpos[self._at] = command
        self._model.qpos_spring[self._at] = command
        for tendon, spring in zip(self._springs, self.parts.springs, strict=True):
            middle = float(command[spring.joint]) if spring.from_command else 0.0
            self._model.tendon_lengthspring[tendon] = [middle + spring.low, middle + spring.high]

    def _flange(self) -> tuple[Array, Array]:
        return np.array(self._data.site_xpos[self._tip]), np.array(self._data.site_xmat[self._tip]).reshape(3, 3)

    def _unbalanced(self, positions: Array, wrench: Array) -> Array:
        self._data.qpos[:] = positions
        self._mujoco.mj_fwdPosition(self._model, self._data)
        self._mujoco.mj_fwdVelocity(self._model, self._data)
        applied = np.zeros(self._model.nv)
        self._mujoco.mj_applyFT(
            self._model, self._data, wrench[:3], wrench[3:], self._data.site_xpos[self._tip], self._body, applied
        )
        return np.asarray(self._data.qfrc_passive + applied - self._data.qfrc_bias)

    def stand(self, command: Array, wrench: Array) -> tuple[Array, Array]:
        """Place and rotation of the flange in equilibrium under a wrench (N, N m; base axes, at the flange)."""
        self._command(command)
        positions = np.array(self._data.qpos)
        left = self._unbalanced(positions, wrench)
        for _ in range(_ITERATIONS):
            if np.abs(left).max() < _TOLERANCE:
                return self._flange()
            slopes = np.empty((len(left), len(left)))
            for axis in range(len(left)):
                moved = positions.copy()
                moved[axis] += _STEP
                slopes[:, axis] = (self._unbalanced(moved, wrench) - left) / _STEP
            step, share = np.linalg.solve(slopes, -left), 1.0
            while True:  # Newton's step, shortened where a spring comes into or out of its dead band
                following = positions + share * step
                after = self._unbalanced(following, wrench)
                if np.linalg.norm(after) < (1.0 - 0.1 * share) * np.linalg.norm(left) or share < 1e-5:
                    break
                share /= 2.0
            positions, left = following, after
        raise EngineError("the arm finds no equilibrium")


def load_of(row: pd.Series, rotation: Array) -> Array:
    """Assumed wrench on the flange (base axes) of a row with a wrench or a payload."""
    if "fx_N" in row:
        return np.asarray(row[list(WRENCH)].to_numpy(dtype=float))
    mass, *centre = (float(value) for value in row[list(PAYLOAD)])
    force = np.array([0.0, 0.0, -GRAVITY * mass])
    return np.concatenate([force, np.cross(rotation @ centre, force)])


def deflections(stand: Stand, rows: pd.DataFrame) -> Array:
    """Noise-free deflections of the flange against the unloaded arm at the same command (rows × 6; m, rad)."""
    found = np.zeros((len(rows), 6))
    for index, (_, row) in enumerate(rows.iterrows()):
        command = row[list(JOINTS)].to_numpy(dtype=float)
        place, rotation = stand.stand(command, np.zeros(6))
        wrench = load_of(row, rotation)
        moved, turned = stand.stand(command, wrench)
        found[index] = [*(moved - place), *Rotation.from_matrix(turned @ rotation.T).as_rotvec()]
    return found


def positions(stand: Stand, rows: pd.DataFrame, markers: dict[str, Array], instrument: tuple[Array, Array]) -> Array:
    """Noise-free positions of the rows' markers in the instrument's frame (rows × 3, m), payloads on the flange."""
    found = np.zeros((len(rows), 3))
    for index, (_, row) in enumerate(rows.iterrows()):
        command = row[list(JOINTS)].to_numpy(dtype=float)
        place, rotation = stand.stand(command, np.zeros(6))
        place, rotation = stand.stand(command, load_of(row, rotation))
        found[index] = instrument[1].T @ (place + rotation @ markers[str(row["marker"])] - instrument[0])
    return found


def base_deflections(arm: Arm, rows: pd.DataFrame) -> tuple[Array, Array]:
    """The base model of deflections: what it says without any compliance (0), and per compliance (rows × 6 × 6)."""
    stand, found = Stand(arm), []
    for _, row in rows.iterrows():
        _, rotation, jacobian = stand.rigid(row[list(JOINTS)].to_numpy(dtype=float))
        found.append(jacobian * (jacobian.T @ load_of(row, rotation)))
    return np.zeros((len(rows), 6)), np.array(found)


def base_positions(
    arm: Arm, rows: pd.DataFrame, markers: dict[str, Array], instrument: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Likewise of markers' positions: the rigid arm's, and per compliance under load and own weight (rows × 3 × 6)."""
    stand, rigid, found = Stand(arm), np.zeros((len(rows), 3)), []
    for index, (_, row) in enumerate(rows.iterrows()):
        place, rotation, jacobian = stand.rigid(row[list(JOINTS)].to_numpy(dtype=float))
        marker = place + rotation @ markers[str(row["marker"])]
        torque = jacobian.T @ load_of(row, rotation) - stand.weight()
        rigid[index] = instrument[1].T @ (marker - instrument[0])
        found.append(instrument[1].T @ (stand.jacobian(marker)[:3] * torque))
    return rigid, np.array(found)


__all__ = ["POSITION", "Arm", "Hose", "Parts", "Spring", "Stand", "deflections", "draw_arm", "positions"]
