"""Arms whose URDF files install from the package index (example-robot-data), with an independent library as oracle."""

from dataclasses import dataclass
from functools import cache
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
import pinocchio as pin

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.kinematic_tree import KinematicTree
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.mechanics.robots.urdf import read_urdf


@dataclass(frozen=True)
class Arm:
    """A chain of a published robot."""

    file: str
    base: str
    tip: str
    configuration: tuple[str, ...]

    @property
    def path(self) -> Path:
        folder = "cmeel.prefix/share/example-robot-data/robots"
        return Path(str(distribution("example-robot-data").locate_file(f"{folder}/{self.file}")))


def _names(units: str) -> tuple[str, ...]:
    return tuple(f"q{k + 1}_{'m' if unit == 'p' else 'rad'}" for k, unit in enumerate(units))


#: Revolute arms of six and seven joints, arms on prismatic columns, and a gripper whose fingers mimic each other.
ARMS = {
    "ur5": Arm("ur_description/urdf/ur5_robot.urdf", "base_link", "tool0", _names("r" * 6)),
    "panda": Arm("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand", _names("r" * 7)),
    "panda-finger": Arm("panda_description/urdf/panda.urdf", "panda_link0", "panda_rightfinger", _names("r" * 7 + "p")),
    "tiago": Arm("tiago_description/robots/tiago.urdf", "base_link", "arm_tool_link", _names("p" + "r" * 7)),
    "talos": Arm("talos_data/robots/talos_full_v2.urdf", "torso_2_link", "gripper_right_base_link", _names("r" * 7)),
    "pr2-finger": Arm(
        "pr2_description/urdf/pr2.urdf", "base_link", "l_gripper_l_finger_tip_link", _names("p" + "r" * 8)
    ),
}


@cache
def serial_robot(arm: Arm, stiffness: float = 2.0e4) -> SerialRobot:
    """The arm with joints of one stiffness."""
    tree = KinematicTree(read_urdf(arm.path), arm.base, [arm.tip])
    return SerialRobot(tree, np.full(len(tree.coordinates), stiffness), name=arm.file)


class Oracle:
    """The same chain in pinocchio: its own reader, its own kinematics, its own statics.

    Joints that mimic others are set from what they mimic, as their own tags say; joints off the chain stand at zero.
    """

    def __init__(self, robot: SerialRobot) -> None:
        self.robot = robot
        path = robot.tree.urdf.source
        self.model = pin.buildModelFromUrdf(path)
        self.data = self.model.createData()
        self.tip = self.model.getFrameId(robot.tree.tips[0], pin.FrameType.BODY)
        self.base = self.model.getFrameId(robot.tree.base, pin.FrameType.BODY)

    def full(self, q: FloatArray) -> FloatArray:
        """Configuration of all joints (n_pin,), continuous ones as cosine and sine."""
        full = pin.neutral(self.model)
        for joint in self.robot.tree.urdf.joints.values():
            motion = self.robot.tree.motion(joint)
            if motion is None and not (joint.moves and self.robot.tree.place(joint) != 0.0):
                continue
            value = self.robot.tree.place(joint)
            if motion is not None:
                value = motion.offset + sum(multiplier * q[index] for index, multiplier in motion.terms)
            entry = self.model.joints[self.model.getJointId(joint.name)]
            if entry.nq == 2:
                full[entry.idx_q : entry.idx_q + 2] = np.cos(value), np.sin(value)
            else:
                full[entry.idx_q] = value
        return full

    def mapping(self) -> FloatArray:
        """Velocities of all joints per velocity of the chain's coordinates, shape (n_v, n_q)."""
        matrix = np.zeros((self.model.nv, len(self.robot.configuration)))
        for joint in self.robot.tree.urdf.joints.values():
            motion = self.robot.tree.motion(joint)
            if motion is not None:
                for index, multiplier in motion.terms:
                    matrix[self.model.joints[self.model.getJointId(joint.name)].idx_v, index] = multiplier
        return matrix

    def placement(self, q: FloatArray) -> "pin.SE3":
        """Pose of the tip in the base link's frame."""
        pin.framesForwardKinematics(self.model, self.data, self.full(q))
        return self.data.oMf[self.base].inverse() * self.data.oMf[self.tip]

    def jacobian(self, q: FloatArray) -> FloatArray:
        """Twist of the tip in the axes of the base link per coordinate, shape (6, n_q)."""
        self.placement(q)
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        whole = pin.computeFrameJacobian(self.model, self.data, self.full(q), self.tip, aligned)
        turn = self.data.oMf[self.base].rotation.T
        jacobian: FloatArray = np.kron(np.eye(2), turn) @ whole @ self.mapping()
        return jacobian

    def own_weight(self, q: FloatArray, gravity: FloatArray) -> FloatArray:
        """Torques that the links' weight exerts about the joints (n_q,), gravity in the axes of the base link."""
        self.placement(q)
        self.model.gravity.linear = self.data.oMf[self.base].rotation @ gravity
        holding = pin.computeGeneralizedGravity(self.model, self.data, self.full(q))
        torques: FloatArray = -self.mapping().T @ holding
        return torques
