"""A six-axis arm as a laser tracker sees it: zeros and links that are off, joints that yield, a tool nobody weighed.

Kinematics, torques and equilibria are pinocchio's; nothing of the library is used. Every joint stands at its command
plus its zero's error plus c·tau, with tau the torque of all weights at the place where the joint really stands.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import pinocchio as pin

Array = npt.NDArray[np.float64]
TIP = "flange"
STIFFNESS = np.array([24000.0, 24000.0, 12000.0, 4000.0, 4000.0, 4000.0])
INSTRUMENT = pin.SE3(pin.rpy.rpyToMatrix(0.01, -0.02, 2.4), np.array([2.3, 1.6, 0.4]))
PLACES = {
    "one": np.array([0.08, 0.02, 0.12]),
    "two": np.array([-0.07, 0.09, 0.10]),
    "three": np.array([0.01, -0.11, 0.15]),
}
NOISE = 3e-5
"""m, of positions."""
ROBOT = Path(__file__).parents[1] / "configs" / "robots" / "ur5.yaml"
JOINTS = [f"q{k}_rad" for k in range(1, 7)]
READ, STATED = ["px_m", "py_m", "pz_m"], ["spx_m", "spy_m", "spz_m"]
LOADS = ["fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"]
LOW, HIGH = np.array([-1.0, -2.2, 0.4, -2.6, -2.2, -1.5]), np.array([1.0, -0.5, 2.2, 0.0, -0.9, 1.5])
TARGETS = np.array(
    [[0.0, -1.3, 1.5, -1.8, -1.57, 0.0], [0.6, -0.9, 1.2, -1.9, -1.57, 0.5], [-0.6, -1.9, 2.0, -1.2, -1.2, -0.5]]
)
_ITERATIONS = 8
_TENSOR = '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'


@dataclass(frozen=True)
class Faults:
    """What is not as drawn.

    Attributes:
        zeros: rad, of the joints.
        placements: shift (m) and turn (rad) of every joint's frame in its parent, shape (6, 6).
        softness: joints' compliances in units of the robot file's.
        tool: mass (kg) and centre (m) in the tip's frame.
        periodic: amplitude (rad) and phase of an error of joint 3 that repeats with every turn.
        slip: rad, by which joint 4 is off beyond 0.7 rad: no library has it.
    """

    zeros: Array = field(default_factory=lambda: np.zeros(6))
    placements: Array = field(default_factory=lambda: np.zeros((6, 6)))
    softness: Array = field(default_factory=lambda: np.ones(6))
    tool: tuple[float, Array] = (0.0, np.zeros(3))
    periodic: tuple[float, float] = (0.0, 0.0)
    slip: float = 0.0


def usual_faults(seed: int, *, tool: float = 3.0) -> Faults:
    """Zeros off by 1 mrad, links by 0.3 mm and 0.5 mrad, stiffness by 20 %, a tool of `tool` kg, one runout."""
    generator = np.random.default_rng(seed)
    turns = generator.normal(0.0, 5e-4, (6, 3))
    return Faults(
        zeros=generator.normal(0.0, 1e-3, 6),
        placements=np.hstack([generator.normal(0.0, 3e-4, (6, 3)), turns]),
        softness=np.exp(generator.normal(0.0, 0.2, 6)),
        tool=(tool, np.array([0.02, -0.01, 0.08])),
        periodic=(3e-4, float(generator.uniform(0.0, 2.0 * np.pi))),
    )


PLAIN = replace(usual_faults(3, tool=0.0), periodic=(0.0, 0.0))
"""Zeros, links and compliances are off, and nothing else."""


class Arm:
    """The arm with its faults.

    Args:
        faults: what is not as drawn.
    """

    def __init__(self, faults: Faults) -> None:
        # Pinocchio reads no mass without an inertia tensor, which statics does not need.
        text = ROBOT.with_suffix(".urdf").read_text(encoding="utf-8").replace("</inertial>", f"{_TENSOR}</inertial>")
        self._model = pin.buildModelFromXML(text)
        self._model.gravity.linear = np.array([0.0, 0.0, -9.80665])
        for joint, moved in enumerate(faults.placements):
            error = pin.SE3(pin.exp3(moved[3:]), moved[:3])
            self._model.jointPlacements[joint + 1] = self._model.jointPlacements[joint + 1] * error
        mass, centre = faults.tool
        self._tip = self._model.getFrameId(TIP, pin.FrameType.BODY)
        tip = self._model.frames[self._tip]
        if mass:
            tool = pin.Inertia(mass, centre, 1e-3 * np.eye(3))
            self._model.appendBodyToJoint(tip.parentJoint, tool, tip.placement)
        self._data = self._model.createData()
        self._faults = faults

    def position(self, command: Array, place: Array) -> Array:
        """Of a marker at `place` (m, in the tip's frame) in the instrument's axes, with the arm at rest."""
        return np.array(INSTRUMENT.actInv(self.tip(command).act(place)))

    def tip(self, command: Array) -> pin.SE3:
        """Pose of the tip in the base's frame, with the arm at rest."""
        amplitude, phase = self._faults.periodic
        standing = command + self._faults.zeros
        standing[2] += amplitude * np.sin(command[2] + phase)
        standing[3] += self._faults.slip * float(command[3] > 0.7)
        q = standing
        for _ in range(_ITERATIONS):
            torque = -pin.computeGeneralizedGravity(self._model, self._data, q)
            q = standing + self._faults.softness / STIFFNESS * torque
        pin.framesForwardKinematics(self._model, self._data, q)
        return self._data.oMf[self._tip].copy()


def recordings(
    faults: Faults, rows: int, seed: int, *, held_out: float = 0.2, markers: int = 3, loads: bool = True
) -> pd.DataFrame:
    """Positions of markers at random commands with noise; a share `held_out` is marked `test`.

    Every pose is read at all markers before the next one; there is no payload, which columns of `loads` say.
    """
    generator, arm = np.random.default_rng(seed), Arm(faults)
    names = list(PLACES)[:markers]
    poses = -(-rows // len(names))
    low = np.array([-2.5, -2.4, -2.0, -2.5, -2.5, -2.8])
    commands = generator.uniform(low, [2.5, -0.7, 2.0, 2.5, 2.5, 2.8], (poses, 6))
    tests = generator.random(poses) < held_out
    table = []
    for number in range(rows):
        pose, name = number // len(names), names[number % len(names)]
        read = arm.position(commands[pose], PLACES[name]) + NOISE * generator.standard_normal(3)
        table.append([number + 1, 1, *commands[pose], name, *read, "test" if tests[pose] else "train"])
    frame = pd.DataFrame(table, columns=["sequence", "series", *JOINTS, "marker", *READ, "split"])
    return frame.assign(**dict.fromkeys(STATED, NOISE), **dict.fromkeys(LOADS if loads else (), 0.0))


def configuration(poses: int) -> dict[str, Any]:
    """Of the plans: three markers 0.1 m apart make rotations as exact as NOISE over that lever."""
    deviation = {f"d{axis}_m": NOISE / np.sqrt(3.0) for axis in "xyz"} | {f"dr{a}_rad": NOISE / 0.1 for a in "xyz"}
    return {
        "schema_version": 1,
        "robot": str(ROBOT),
        "experiment": {
            "calibration": "geometric",
            "frames": "unknown",
            "measurements": poses,
            "poses": {"bounds": {n: [a, b] for n, a, b in zip(JOINTS, LOW.tolist(), HIGH.tolist(), strict=True)}},
            "deflection_noise": {"std": deviation},
        },
        "targets": [
            {"pose": each.tolist(), "tolerance": dict.fromkeys(("dx_m", "dy_m", "dz_m"), 1e-4)} for each in TARGETS
        ],
        "objectives": ["duir", "o1"],
        "optimiser": {"population": 40, "generations": 40, "seed": 1, "polish": True},
    }


def measured(arm: Arm, commands: Array, seed: int) -> pd.DataFrame:
    """Positions of the three markers at commands (N, 6)."""
    random = np.random.default_rng(seed)
    rows: list[dict[str, object]] = []
    for command in commands:
        for name, place in PLACES.items():
            row: dict[str, object] = {"sequence": len(rows) + 1, "series": len(rows) + 1, "marker": name}
            row |= dict(zip(JOINTS, command, strict=True))
            read = arm.position(command, place) + NOISE * random.standard_normal(3)
            row |= dict(zip(READ, read, strict=True))
            rows.append(row | dict.fromkeys(STATED, NOISE))
    return pd.DataFrame(rows)
