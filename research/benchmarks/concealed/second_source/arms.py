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

from ..arms import Arm, Link, States, load_of, words
from ..campaigns import GRAVITY, JOINTS
from ..hexapods import Array
from .frames import EngineError

_STEP, _TOLERANCE, _ITERATIONS = 1e-7, 1e-8, 60  # rad, N m


@cache
def engine() -> Any:
    """MuJoCo."""
    import mujoco  # noqa: PLC0415 - an extra

    return mujoco


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
                sites[holder] += f'<site name="hose_{number}_{end}" pos="{words(point)}"/>'
        text += sites[0] + '<body name="stand"><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>'
        for axis, stiffness in zip(("1 0 0", "0 1 0", "0 0 1"), parts.tilt or (), strict=False):
            text += f'<joint type="hinge" axis="{axis}" stiffness="{stiffness:.12g}"/>'
        depth = 1
        for number, link in enumerate(self.arm.links, start=1):
            place = np.array(link.place)
            if number - 1 in parts.bends:  # the middle of the link before this joint
                text += f'<body pos="{words(place / 2)}"><inertial pos="0 0 0" mass="1e-6" '
                text += 'diaginertia="1e-6 1e-6 1e-6"/>'
                stiffness = parts.bends[number - 1]
                for axis in ("1 0 0", "0 1 0"):
                    text += f'<joint type="hinge" axis="{axis}" stiffness="{stiffness:.12g}"/>'
                place, depth = place / 2, depth + 1
            stiffness = parts.own.get(number - 1, float(self.arm.stiffness[number - 1]))
            text += (
                f'<body name="link_{number}" pos="{words(place)}"><inertial pos="{words(link.centre)}" '
                f'mass="{link.mass:.9g}" diaginertia="0.05 0.05 0.05"/>'
                f'<joint name="joint_{number}" type="hinge" axis="{words(link.axis)}" stiffness="{stiffness:.12g}"/>'
                f"{sites[number]}"
            )
            depth += 1
        text += f'<site name="flange" pos="{words(self.arm.flange)}"/>'
        if parts.tool:
            centre = np.array(self.arm.flange) + parts.tool[1]
            text += (
                f'<body name="tool" pos="{words(centre)}"><inertial pos="0 0 0" mass="{parts.tool[0]:.9g}" '
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


def states(stand: Stand, rows: pd.DataFrame) -> States:
    """Where the flange stands in each row, without and with its load."""
    bare, loaded = [], []
    for _, row in rows.iterrows():
        command = row[list(JOINTS)].to_numpy(dtype=float)
        bare.append(stand.stand(command, np.zeros(6)))
        loaded.append(stand.stand(command, load_of(row, bare[-1][1])))
    return States.of(bare, loaded)
