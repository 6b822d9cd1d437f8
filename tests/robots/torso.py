"""A torso with two arms: its robot file, and the same machine in pinocchio with joints that yield."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio as pin

from expdesign.mechanics.robots.serial import SerialRobot
from tests.oracle import Array
from tests.robots.urdf import joint_text, link_text, robot_of

HANDS = ("right_hand", "left_hand")
JOINTS = ("lean", "turn", *(f"{side}_{name}" for side in ("right", "left") for name in ("shoulder", "elbow", "wrist")))
STIFFNESS = np.array([60000.0, 50000.0, 15000.0, 9000.0, 5000.0, 14000.0, 10000.0, 5000.0])
INSTRUMENT = pin.SE3(pin.rpy.rpyToMatrix(0.02, -0.03, 2.0), np.array([2.5, 0.4, 0.3]))
PLACES = {"right": np.array([0.05, 0.03, -0.04]), "left": np.array([0.06, -0.04, 0.02])}
LIFTED = ("left_hand_mass_kg", "left_hand_com_x_m", "left_hand_com_y_m", "left_hand_com_z_m")

URDF = (
    '<robot name="torso"><link name="ground"/>'
    + link_text("hips", 12.0)
    + joint_text("lean", "ground", "hips", "0 0 0.4", "0 1 0")
    + link_text("chest", 15.0)
    + joint_text("turn", "hips", "chest", "0.02 0 0.3", "1 0 0.6")
    + "".join(
        link_text(f"{side}_upper", 3.0)
        + link_text(f"{side}_fore", 2.0, "0.12 0.01 0")
        + link_text(f"{side}_hand", 0.8, "0.05 0 0")
        + joint_text(f"{side}_shoulder", "chest", f"{side}_upper", f"0 {y} 0.35", "0 1 0")
        + joint_text(f"{side}_elbow", f"{side}_upper", f"{side}_fore", "0.3 0 0.02", "0 0.6 0.8")
        + joint_text(f"{side}_wrist", f"{side}_fore", f"{side}_hand", "0.25 0 0", "1 0 0")
        for side, y in (("right", -0.2), ("left", 0.2))
    )
    + "</robot>"
)
FILE = (
    "name: torso\nkind: serial\nurdf: robot.urdf\nbase_link: ground\ntip_link: [right_hand, left_hand]\n"
    f"actuator_stiffness: {STIFFNESS.tolist()}\npayload_links: [left_hand]\n"
)


def read_torso(folder: Path, text: str = FILE) -> SerialRobot:
    return robot_of(folder, URDF, text)


@dataclass(frozen=True)
class Torso:
    """The torso in pinocchio.

    Attributes:
        zeros: of the joints (rad), in the order of `JOINTS`.
        tool: mass (kg) and centre (m) of what nobody weighed in the right hand.
    """

    zeros: Array = field(default_factory=lambda: np.zeros(8))
    tool: tuple[float, Array] = (0.0, np.zeros(3))

    def model(self, lifted: tuple[float, Array]) -> pin.Model:
        """With a payload in the left hand."""
        model = pin.buildModelFromXML(URDF)
        model.gravity.linear = np.array([0.0, 0.0, -9.80665])
        for hand, (mass, centre) in zip(HANDS, (self.tool, lifted), strict=True):
            if mass:
                frame = model.frames[model.getFrameId(hand, pin.FrameType.BODY)]
                inertia = pin.Inertia(mass, centre, 1e-3 * np.eye(3))
                model.appendBodyToJoint(frame.parentJoint, inertia, frame.placement)
        return model

    def torques(self, q: Array, lifted: tuple[float, Array]) -> Array:
        """Of all weights about the joints at coordinates in the order of `JOINTS`, (8,)."""
        model = self.model(lifted)
        columns = [model.joints[model.getJointId(name)].idx_q for name in JOINTS]
        full = np.zeros(model.nq)
        full[columns] = q
        found: Array = -pin.computeGeneralizedGravity(model, model.createData(), full)[columns]
        return found

    def pose(self, q: Array, hand: str) -> pin.SE3:
        """Of a hand, without any deflection."""
        model = self.model((0.0, np.zeros(3)))
        data, full = model.createData(), np.zeros(model.nq)
        full[[model.joints[model.getJointId(name)].idx_q for name in JOINTS]] = q
        pin.framesForwardKinematics(model, data, full)
        return data.oMf[model.getFrameId(hand, pin.FrameType.BODY)].copy()

    def reading(self, command: Array, side: str, lifted: tuple[float, Array]) -> Array:
        """Of the marker of a hand in the instrument's axes, joints yielding under the weights where they stand (3,)."""
        q = command + self.zeros
        for _ in range(4):
            q = command + self.zeros + self.torques(q, lifted) / STIFFNESS
        return np.array(INSTRUMENT.actInv(self.pose(q, f"{side}_hand").act(PLACES[side])))

    def recordings(self, count: int, seed: int, deviation: float) -> pd.DataFrame:
        """Positions of both hands' markers, one after the other; the left hand lifts up to 6 kg in half of the rows."""
        generator, rows = np.random.default_rng(seed), []
        for number in range(count):
            side = ("right", "left")[number % 2]
            command = generator.uniform(-0.9, 0.9, 8)
            mass, centre = 6.0 * generator.random() * float(number % 4 < 2), generator.uniform(-0.1, 0.1, 3)
            read = self.reading(command, side, (mass, centre)) + deviation * generator.standard_normal(3)
            rows.append([number + 1, number + 1, *command, mass, *centre, f"{side}_hand", side, *read])
        columns = ["sequence", "series", *(f"{name}_rad" for name in JOINTS), *LIFTED, "tip", "marker"]
        frame = pd.DataFrame(rows, columns=[*columns, "px_m", "py_m", "pz_m"])
        frame = frame.assign(**dict.fromkeys(("spx_m", "spy_m", "spz_m"), deviation))
        return frame.assign(**dict.fromkeys(("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"), 0.0))
