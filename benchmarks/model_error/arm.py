"""Arms whose place pinocchio takes, that hide one effect of the size that MEIR assumes.

The joints stand in the full equilibrium of their springs with the links' weight and the load, at large displacements:
pinocchio reads the URDF and has kinematics and statics. A bearing that tilts is a turn of the link at its joint, a base
or a tool mount that yields a displacement of the whole. What an effect does is counted from the unloaded arm.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio as pin
from numpy.random import Generator

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.planning.problem import DesignProblem

from ..urdf_inertia import with_inertia
from .machine import Concealed
from .prior import Prior, compliance

_PASSES, _SETTLED = 200, 1e-13
_SLACK = 1e-3
"""N·m; a joint with less torque than this rests in the middle of its play."""
_TURNS = (1, 2, 4, 8)
"""Periods of an encoder's error per turn of its joint."""

Law = Callable[[float, float, float], float]
"""Angle (rad) beyond the linear spring's from torque, torque of the unloaded arm (N·m) and command (rad)."""


@dataclass(frozen=True)
class Hidden:
    """One effect.

    `load`: mass (kg), centre (m, tip axes) and gravity (m/s²) as they are, from those assumed. `laws`: by joint.
    `tilts`: rad/(N·m) across the axis of a joint, by joint. `base`, `tool`: compliances (6, 6) about the origins of
    base and tip, in their axes. `reading`: what the instrument makes of a deflection (6,).
    """

    load: Callable[[float, FloatArray, FloatArray], tuple[float, FloatArray, FloatArray]] | None = None
    laws: dict[int, Law] = field(default_factory=dict)
    tilts: dict[int, float] = field(default_factory=dict)
    base: FloatArray | None = None
    tool: FloatArray | None = None
    reading: Callable[[FloatArray], FloatArray] | None = None


class ArmFactory:
    """Arms as a design problem describes them."""

    kinds: tuple[str, ...] = (
        "payload_com_offset", "payload_mass_error", "load_direction_tilt", "platform_compliance", "base_compliance",
        "joint_compliance", "joint_backlash", "leg_nonlinear_stiffness", "friction_hysteresis",
        "encoder_periodic_error", "instrument_misalignment", "instrument_scale",
    )  # fmt: skip
    place = "with pinocchio in the arm's place"

    def __init__(self, problem: DesignProblem, prior: Prior) -> None:
        self.problem, self.prior = problem, prior

    def machine(self, physics: str, stiffness: FloatArray, generator: Generator) -> ArmMachine:
        if not physics:
            return ArmMachine(self.problem, stiffness, Hidden(), Concealed())
        hidden, components = self._drawn(physics, stiffness, generator)
        return ArmMachine(self.problem, stiffness, hidden, Concealed(physics, components))

    def _drawn(self, physics: str, stiffness: FloatArray, rng: Generator) -> tuple[Hidden, tuple[str, ...]]:
        if physics in ("platform_compliance", "base_compliance"):
            component = physics.split("_", maxsplit=1)[0]
            matrix = compliance(self.prior.sizes(physics, component, "compliance_")[:6], rng)
            return (Hidden(tool=matrix) if component == "platform" else Hidden(base=matrix)), (component,)
        if physics == "instrument_misalignment":
            turn = pin.exp3(self.prior.normal(physics, "instrument", "", rng)).T
            return Hidden(reading=lambda d: np.concatenate([turn @ d[:3], turn @ d[3:]])), ("instrument",)
        if physics == "instrument_scale":
            scale = np.concatenate([1.0 + self.prior.normal(physics, "instrument", "", rng), np.ones(3)])
            return Hidden(reading=lambda d: scale * d), ("instrument",)
        if physics.startswith(("payload_", "load_")):
            return Hidden(load=self._load(physics, rng)), ("payload",)
        joint = int(rng.integers(6))
        name = f"joint {joint + 1}"
        if physics == "joint_compliance":
            return Hidden(tilts={joint: self.prior.positive(physics, name, "lateral_rad", rng)}), (name,)
        return Hidden(laws={joint: self.law(physics, name, 1.0 / stiffness[joint], rng)}), (name,)

    def _load(
        self, physics: str, rng: Generator
    ) -> Callable[[float, FloatArray, FloatArray], tuple[float, FloatArray, FloatArray]]:
        if physics == "payload_com_offset":
            offset = self.prior.normal(physics, "payload", "com_", rng)
            return lambda mass, centre, gravity: (mass, centre + offset, gravity)
        if physics == "load_direction_tilt":
            x, y = self.prior.normal(physics, "payload", "tilt_", rng)
            turn = pin.rpy.rpyToMatrix(x, y, 0.0)
            return lambda mass, centre, gravity: (mass, centre, turn @ gravity)
        wrong = float(rng.choice(self.problem.config["experiment"]["load"]["mass_kg"]["choices"]))
        relative = float(self.prior.normal(physics, "payload", "relative_", rng)[0])
        return lambda mass, centre, gravity: (mass * (1.0 + relative * (mass == wrong)), centre, gravity)

    def law(self, physics: str, name: str, spring: float, rng: Generator) -> Law:
        """An angle beyond the spring's; `spring` is the compliance of the joint, rad/(N·m)."""
        if physics == "joint_backlash":
            gap = self.prior.positive(physics, name, "gap", rng)

            def side(torque: float) -> float:
                return 0.5 * float(np.sign(torque)) if abs(torque) > _SLACK else 0.0

            return lambda torque, before, command: gap * (side(torque) - side(before))
        if physics == "friction_hysteresis":
            most = self.prior.positive(physics, name, "friction", rng)
            return lambda torque, before, command: -spring * float(np.clip(torque - before, -most, most))
        if physics == "leg_nonlinear_stiffness":
            if rng.random() < 0.5:
                beyond = self.prior.positive(physics, name, "hertz", rng)
                return lambda torque, before, command: beyond * (_hertz(torque) - _hertz(before))
            beyond = float(self.prior.normal(physics, name, "asymmetric", rng)[0])
            return lambda torque, before, command: beyond * (abs(torque) - abs(before)) / 100.0
        size, phase = float(np.linalg.norm(self.prior.normal(physics, name, "", rng))), rng.uniform(0.0, 2.0 * np.pi)
        turns = int(rng.choice(_TURNS))
        return lambda torque, before, command: size * float(np.sin(turns * command + phase))


def _hertz(torque: float) -> float:
    return float(np.sign(torque) * abs(torque / 100.0) ** (2.0 / 3.0))


class ArmMachine:
    """One arm."""

    def __init__(self, problem: DesignProblem, stiffness: FloatArray, hidden: Hidden, concealed: Concealed) -> None:
        robot = problem.loaded.robot
        assert isinstance(robot, SerialRobot)
        self.problem, self.robot, self.compliance, self.hidden = problem, robot, 1.0 / stiffness, hidden
        self.concealed = concealed
        self.model = pin.buildModelFromXML(with_inertia(Path(robot.tree.urdf.source)))
        self.model.gravity.linear = robot.gravity
        self.data = self.model.createData()
        self.tip = self.model.getFrameId(robot.tree.tips[0], pin.FrameType.BODY)
        self.placements = [placement.copy() for placement in self.model.jointPlacements]
        self.axes = [np.asarray(joint.axis, dtype=float) for joint in robot.tree.joints]

    def measured(self, rows: pd.DataFrame, seed: int) -> pd.DataFrame:
        noise, coordinates = self.problem.noise, self.robot.coordinates
        found = np.zeros((len(rows), 6))
        commands = rows[list(self.robot.configuration)].to_numpy(dtype=float)
        payloads = rows[["mass_kg", "com_x_m", "com_y_m", "com_z_m"]].to_numpy(dtype=float)
        for index, (command, (mass, *centre)) in enumerate(zip(commands, payloads, strict=True)):
            deflection = difference(self.loaded(command, mass, np.array(centre)), self.unloaded(command))
            found[index] = deflection if self.hidden.reading is None else self.hidden.reading(deflection)
        written = rows.copy()
        deviations = np.sqrt(np.diag(noise.covariance))
        drawn = np.random.default_rng(seed).standard_normal((len(rows), len(noise.axes))) * deviations
        for place, axis in enumerate(noise.axes):
            written[coordinates.deflection[axis]] = found[:, axis] + drawn[:, place]
            written[coordinates.deviation[axis]] = deviations[place]
        return written

    def errors(self, commands: FloatArray, targets: LoadedPoints) -> FloatArray:
        assert targets.payload is not None
        found = []
        for command, wanted, (mass, *centre) in zip(commands, targets.configurations, targets.payload, strict=True):
            found.append(difference(self.loaded(command, mass, np.array(centre)), self.unloaded(wanted)))
        return np.array(found)

    def unloaded(self, command: FloatArray) -> pin.SE3:
        """The tip of the arm that carries its own weight alone."""
        return self._place(self._rest(command, 0.0, np.zeros(3), np.zeros(3), None))

    def loaded(self, command: FloatArray, mass: float, centre: FloatArray) -> pin.SE3:
        """The tip under a payload that is assumed to be this one."""
        gravity = self.robot.gravity
        if self.hidden.load is not None:
            mass, centre, gravity = self.hidden.load(mass, centre, gravity)
        before = self._torque(self._rest(command, 0.0, np.zeros(3), np.zeros(3), None), np.zeros(6), np.zeros(3))
        q = self._rest(command, mass, centre, gravity, before)
        tip = self._place(q)
        wrench = self._wrench(tip, mass * gravity, centre)
        if self.hidden.tool is not None:
            turn = np.kron(np.eye(2), tip.rotation)
            motion = turn @ self.hidden.tool @ turn.T @ wrench
            tip = pin.SE3(pin.exp3(motion[3:]) @ tip.rotation, tip.translation + motion[:3])
        if self.hidden.base is not None:
            about_base = np.concatenate([wrench[:3], wrench[3:] + np.cross(tip.translation, wrench[:3])])
            motion = self.hidden.base @ about_base
            tip = pin.SE3(pin.exp3(motion[3:]), motion[:3]) * tip
        return tip

    def _rest(
        self, command: FloatArray, mass: float, centre: FloatArray, gravity: FloatArray, before: FloatArray | None
    ) -> FloatArray:
        """Joint coordinates in equilibrium; `before` are the torques of the unloaded arm, None where that is meant."""
        q = command.copy()
        for _ in range(_PASSES):
            self._tilt(q, mass, centre, gravity)
            torque = self._torque(q, np.concatenate([mass * gravity, np.zeros(3)]), centre)
            following = command + self.compliance * torque
            if before is not None:
                for joint, law in self.hidden.laws.items():
                    following[joint] += law(float(torque[joint]), float(before[joint]), float(command[joint]))
            if np.abs(following - q).max() < _SETTLED:
                return following
            q = following
        raise RuntimeError("the arm finds no equilibrium")

    def _tilt(self, q: FloatArray, mass: float, centre: FloatArray, gravity: FloatArray) -> None:
        """Turn every link whose bearing yields about its joint, as the load's moment there asks for."""
        if not self.hidden.tilts:
            return
        for index, placement in enumerate(self.placements):
            self.model.jointPlacements[index] = placement
        tip = self._place(q)
        wrench = self._wrench(tip, mass * gravity, centre)
        for joint, tilt in self.hidden.tilts.items():
            frame, axis = self.data.oMi[joint + 1], self.axes[joint]
            moment = wrench[3:] + np.cross(tip.translation - frame.translation, wrench[:3])
            local = frame.rotation.T @ moment
            # In the axes of the link before the joint, where the bearing sits.
            across = pin.exp3(pin.exp3(axis * q[joint]) @ (tilt * (local - axis * (axis @ local))))
            self.model.jointPlacements[joint + 1] = self.placements[joint + 1] * pin.SE3(across, np.zeros(3))

    def _torque(self, q: FloatArray, force: FloatArray, centre: FloatArray) -> FloatArray:
        """Joint torques from a force (the first three of six) at `centre` on the tip and from the links' weight."""
        jacobian = pin.computeFrameJacobian(self.model, self.data, q, self.tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        wrench = self._wrench(self._place(q), force[:3], centre)
        torque: FloatArray = jacobian.T @ wrench - pin.computeGeneralizedGravity(self.model, self.data, q)
        return torque

    @staticmethod
    def _wrench(tip: pin.SE3, force: FloatArray, centre: FloatArray) -> FloatArray:
        return np.concatenate([force, np.cross(tip.rotation @ centre, force)])

    def _place(self, q: FloatArray) -> pin.SE3:
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.tip].copy()


def difference(here: pin.SE3, there: pin.SE3) -> FloatArray:
    """Translation and rotation vector (6,) from one place of the tip to another."""
    return np.concatenate([here.translation - there.translation, pin.log3(here.rotation @ there.rotation.T)])
