"""The closed loop of `closed_loop.py` for an arm, whose place an independent library takes.

    python -m benchmarks.closed_loop_arm configs/closed-loop-arm.yaml --out results/closed-loop/arm

The arm that is measured and commanded is pinocchio's: its own reader of the URDF, kinematics and statics. Its joints
stand in the full equilibrium of their springs with the links' weight and the load, at large displacements; the
reference of a deflection, and where the tip shall be, is the unloaded arm, which sags under its own weight.
"""

import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pinocchio as pin
from benchmarks.closed_loop import main

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.planning.problem import DesignProblem

_PASSES = 100
_SETTLED = 1e-13


def with_inertia(path: Path) -> str:
    """The URDF with an inertia tensor for every mass: pinocchio's reader asks for one, statics does not use it."""
    root = ElementTree.parse(path).getroot()
    zeros = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
    for inertial in root.iter("inertial"):
        if inertial.find("inertia") is None:
            ElementTree.SubElement(inertial, "inertia", {**dict.fromkeys(("ixx", "iyy", "izz"), "1e-3"), **zeros})
    return ElementTree.tostring(root, encoding="unicode")


class ArmBench:
    """A serial robot without joints that mimic others."""

    place = "with pinocchio in the arm's place"

    def __init__(self, problem: DesignProblem) -> None:
        robot = problem.loaded.robot
        assert isinstance(robot, SerialRobot)
        self.robot = robot
        self.model = pin.buildModelFromXML(with_inertia(Path(robot.tree.urdf.source)))
        self.model.gravity.linear = robot.gravity
        self.data = self.model.createData()
        self.tip = self.model.getFrameId(robot.tree.tips[0], pin.FrameType.BODY)

    def tip_pose(self, q: FloatArray) -> "pin.SE3":
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.tip].copy()

    def rest(self, command: FloatArray, stiffness: FloatArray, wrench: FloatArray, lever: FloatArray) -> FloatArray:
        """Joint coordinates in equilibrium under a wrench (6,) at the tip whose force acts at `lever` on the tip."""
        q = command.copy()
        for _ in range(_PASSES):
            jacobian = pin.computeFrameJacobian(
                self.model, self.data, q, self.tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            moment = wrench[3:] + np.cross(self.tip_pose(q).rotation @ lever, wrench[:3])
            torque = jacobian.T @ np.concatenate([wrench[:3], moment])
            torque -= pin.computeGeneralizedGravity(self.model, self.data, q)
            following = command + torque / stiffness
            if np.abs(following - q).max() < _SETTLED:
                return following
            q = following
        raise RuntimeError("the arm finds no equilibrium")

    def difference(self, q: FloatArray, reference: FloatArray) -> FloatArray:
        """Translation and rotation vector (6,) from the tip at `reference` to that at q."""
        here, there = self.tip_pose(q), self.tip_pose(reference)
        return np.concatenate([here.translation - there.translation, pin.log3(here.rotation @ there.rotation.T)])

    def measured(
        self, rows: pd.DataFrame, stiffness: FloatArray, deviations: dict[str, float], *, shared: bool, seed: int
    ) -> pd.DataFrame:
        if shared:
            raise ValueError("a shared reference is not simulated here")
        names = self.robot.coordinates
        none = np.zeros(3)
        deflections = []
        for command, wrench in zip(
            rows[list(self.robot.configuration)].to_numpy(), rows[list(names.wrench)].to_numpy(), strict=True
        ):
            unloaded = self.rest(command, stiffness, np.zeros(6), none)
            deflections.append(self.difference(self.rest(command, stiffness, wrench, none), unloaded))
        generator = np.random.default_rng(seed)
        found = pd.DataFrame(deflections, columns=list(names.deflection))[list(deviations)]
        found += generator.standard_normal(found.shape) * np.array(list(deviations.values()))
        for name, deviation in deviations.items():
            found[names.deviation[names.deflection.index(name)]] = deviation
        return found

    def errors(self, commands: FloatArray, targets: LoadedPoints, stiffness: FloatArray) -> FloatArray:
        assert targets.payload is not None
        none = np.zeros(3)
        found = []
        for command, wanted, (mass, *centre) in zip(commands, targets.configurations, targets.payload, strict=True):
            weight = np.concatenate([mass * self.robot.gravity, none])
            loaded = self.rest(command, stiffness, weight, np.array(centre))
            found.append(self.difference(loaded, self.rest(wanted, stiffness, np.zeros(6), none)))
        return np.array(found)


if __name__ == "__main__":
    main(sys.argv[1:], ArmBench)
