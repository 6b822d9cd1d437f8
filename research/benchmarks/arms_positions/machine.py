"""Simulated arms: pinocchio is the machine, joints yield under the links' weight, and nothing is as drawn.

Zeros are off by 1 mrad, frames by 0.3 mm and 0.5 mrad (unless they are as drawn), stiffnesses by 20 % (standard
deviations); an instrument at an unknown place reads markers at unknown places with 30 µm of noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pinocchio as pin

Array = npt.NDArray[np.float64]
ZERO, LENGTH, ANGLE, SOFTNESS, NOISE = 1e-3, 3e-4, 5e-4, 0.2, 3e-5
GRAVITY = np.array([0.0, 0.0, -9.80665])
STAND = pin.SE3(pin.rpy.rpyToMatrix(0.01, -0.02, 2.4), np.array([2.3, 1.6, 0.4]))
PLACES = np.array([[0.08, 0.02, 0.12], [-0.07, 0.09, 0.10], [0.01, -0.11, 0.15]])
_ITERATIONS = 6


@dataclass(frozen=True)
class Kind:
    """A kind of arm: its URDF from `base` to `flange`, the joints' stiffness (N·m/rad) and ranges (rad)."""

    urdf: str
    joints: tuple[str, ...]
    stiffness: Array
    low: Array
    high: Array


def _arm(rows: list[tuple[str, str, float, float]], flange: str, low: list[float], high: list[float]) -> Kind:
    """From origin, axis, mass and stiffness of every joint; the centre of mass lies halfway to the next joint."""
    ends = [*(row[0] for row in rows[1:]), flange]
    text = '<robot name="arm"><link name="base"/>'
    for number, ((origin, axis, mass, _), end) in enumerate(zip(rows, ends, strict=True), start=1):
        centre = " ".join(f"{0.5 * float(each):g}" for each in end.split())
        above = "base" if number == 1 else f"l{number - 1}"
        text += (
            f'<link name="l{number}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/>'
            '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
            f'<joint name="j{number}" type="revolute"><origin xyz="{origin}"/><parent link="{above}"/>'
            f'<child link="l{number}"/><axis xyz="{axis}"/>'
            '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        )
    text += f'<link name="flange"/><joint name="end" type="fixed"><origin xyz="{flange}"/>'
    text += f'<parent link="l{len(rows)}"/><child link="flange"/></joint></robot>'
    names = tuple(f"j{number}" for number in range(1, len(rows) + 1))
    return Kind(text, names, np.array([row[3] for row in rows]), np.array(low), np.array(high))


KINDS = {
    "UR10": _arm(
        [
            ("0 0 0.1273", "0 0 1", 7.778, 45000.0), ("0 0.220941 0", "0 1 0", 12.93, 45000.0),
            ("0.612 -0.1719 0", "0 1 0", 3.87, 22000.0), ("0.5723 0 0", "0 1 0", 1.96, 7000.0),
            ("0 0.1149 0", "0 0 1", 1.96, 7000.0), ("0 0 -0.1157", "0 1 0", 0.202, 7000.0),
        ], "0 0.0922 0", [-2.5, -2.4, -2.0, -2.5, -2.5, -2.8], [2.5, -0.7, 2.0, 2.5, 2.5, 2.8],
    ),
    "UR10e": _arm(
        [
            ("0 0 0.1807", "0 0 1", 7.369, 45000.0), ("0 0.176 0", "0 1 0", 13.051, 45000.0),
            ("0.6127 -0.137 0", "0 1 0", 3.989, 22000.0), ("0.57155 0 0", "0 1 0", 2.1, 7000.0),
            ("0 0.13515 0", "0 0 1", 1.98, 7000.0), ("0 0 -0.11985", "0 1 0", 0.615, 7000.0),
        ], "0 0.11655 0", [-2.5, -2.4, -2.0, -2.5, -2.5, -2.8], [2.5, -0.7, 2.0, 2.5, 2.5, 2.8],
    ),
    "IRB 120": _arm(
        [
            ("0 0 0.19", "0 0 1", 6.2, 20000.0), ("0 0 0.1", "0 1 0", 4.0, 20000.0),
            ("0 0 0.27", "0 1 0", 4.0, 12000.0),
            ("0.15 0 0.07", "1 0 0", 1.5, 4000.0), ("0.152 0 0", "0 1 0", 1.2, 4000.0),
            ("0.072 0 0", "1 0 0", 0.3, 3000.0),
        ], "0.02 0 0", [-2.6, -1.2, -1.2, -2.5, -1.8, -2.8], [2.6, 1.4, 0.9, 2.5, 1.8, 2.8],
    ),
    "seven axes": _arm(
        [
            ("0 0 0.1575", "0 0 1", 4.0, 12000.0), ("0 0 0.2025", "0 1 0", 4.0, 12000.0),
            ("0 0 0.2045", "0 0 1", 3.0, 10000.0), ("0 0 0.2155", "0 1 0", 2.7, 10000.0),
            ("0 0 0.1845", "0 0 1", 1.7, 8000.0), ("0 0 0.2155", "0 1 0", 1.8, 6000.0),
            ("0 0 0.081", "0 0 1", 0.3, 6000.0),
        ], "0 0 0.045", [-2.5, -1.8, -2.5, -1.8, -2.5, -1.8, -2.5], [2.5, 1.8, 2.5, 1.8, 2.5, 1.8, 2.5],
    ),
}  # fmt: skip
"""Axes that point backwards are turned round, since not every tool reads them."""


class Machine:
    """An arm of a kind with errors of its own, those of its frames included, and an instrument that reads markers."""

    def __init__(self, kind: Kind, markers: int, random: np.random.Generator, *, frames: bool = True) -> None:
        n = len(kind.joints)
        places = random.normal(0.0, 0.02, (markers, 3)) + PLACES[:markers]
        made = frames * np.tile([LENGTH] * 3 + [ANGLE] * 3, n)
        sizes = [np.full(n, ZERO), made, np.full(n, SOFTNESS)]
        drawn = random.standard_normal(8 * n + 6 + places.size)[: 8 * n]  # instrument and places are as they are
        self._zeros, placed, softness = np.split(np.concatenate(sizes) * drawn, [n, 7 * n])
        self._compliance, self._places = np.exp(softness) / kind.stiffness, places
        self._model = pin.buildModelFromXML(kind.urdf)
        self._model.gravity.linear = GRAVITY
        self._numbers = numbers = [self._model.getJointId(name) for name in kind.joints]
        for number, error in zip(numbers, placed.reshape(n, 6), strict=True):
            placement = self._model.jointPlacements[number].copy()
            self._model.jointPlacements[number] = placement * pin.SE3(pin.rpy.rpyToMatrix(error[3:]), error[:3])
        self._columns = [self._model.joints[number].idx_q for number in numbers]
        self._data, self._tip = self._model.createData(), self._model.getFrameId("flange", pin.FrameType.BODY)

    @property
    def places(self) -> Array:
        """Of the markers on the flange, shape (markers, 3)."""
        return self._places

    def readings(self, commands: Array, payloads: Array | None = None) -> Array:
        """Positions of every marker at commands (N, n) in the instrument's axes, (N, markers, 3), without noise.

        `payloads` (N,) are masses (kg) at the origin of the flange.
        """
        poses = self.tips(commands, payloads)
        return np.array([self._places @ pose.rotation.T + pose.translation for pose in poses])

    def tips(self, commands: Array, payloads: Array | None = None) -> list[pin.SE3]:
        """Poses of the flange at commands (N, n) in the instrument's axes."""
        found = []
        bare, last = self._model.inertias[self._numbers[-1]].copy(), self._model.frames[self._tip].placement
        for command, payload in zip(commands, np.zeros(len(commands)) if payloads is None else payloads, strict=True):
            carried = pin.Inertia(float(payload), last.translation, np.zeros((3, 3)))
            self._model.inertias[self._numbers[-1]] = bare + carried if payload else bare
            standing, q = np.zeros(self._model.nq), np.zeros(self._model.nq)
            standing[self._columns] = command + self._zeros
            q[:] = standing
            for _ in range(_ITERATIONS):
                torque = -pin.computeGeneralizedGravity(self._model, self._data, q)
                q[self._columns] = standing[self._columns] + self._compliance * torque[self._columns]
            pin.framesForwardKinematics(self._model, self._data, q)
            found.append(STAND.actInv(self._data.oMf[self._tip]))
        self._model.inertias[self._numbers[-1]] = bare
        return found
