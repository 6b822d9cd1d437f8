"""Names of components in results (file-formats.md, diagnosis.json), and small pieces that several effects share."""

import casadi as ca

from expdesign.chain.row import Row
from expdesign.robots.parallel import ParallelRobot
from expdesign.robots.robot import Robot
from expdesign.robots.serial import SerialRobot

ALL_LEGS = "all legs"
ALL_JOINTS = "all joints"


def each_leg(robot: Robot) -> list[str]:
    """`leg 1`, `leg 2`, ... of a parallel robot, none of others, where legs' effects are not sought."""
    return list(robot.actuators) if isinstance(robot, ParallelRobot) else []


def legs_and_all(robot: Robot) -> list[str]:
    """Every leg, and all legs together with common parameters."""
    legs = each_leg(robot)
    return [*legs, ALL_LEGS] if len(legs) > 1 else legs


def each_joint(robot: Robot) -> list[str]:
    """`joint 1`, `joint 2`, ... of a serial robot, none of others."""
    return list(robot.actuators) if isinstance(robot, SerialRobot) else []


def joints_and_all(robot: Robot) -> list[str]:
    """Every joint, and all joints together with common parameters where they are of one kind."""
    joints = each_joint(robot)
    alike = isinstance(robot, SerialRobot) and len(set(robot.revolute)) == 1
    return [*joints, ALL_JOINTS] if len(joints) > 1 and alike else joints


def actuators_and_all(robot: Robot) -> list[str]:
    """Every leg or joint, and all of them together: for effects that both kinds of actuator have."""
    return legs_and_all(robot) or joints_and_all(robot)


def turning(robot: Robot, actuators: tuple[int, ...]) -> bool:
    """Whether the first of these actuators is a revolute joint, whose motion is in rad and whose force in N·m."""
    return isinstance(robot, SerialRobot) and robot.revolute[actuators[0]]


def reference_force(row: Row) -> ca.SX:
    """Actuator forces (N or N·m) in the reference state: by own weight and by what was carried there, (n_p,)."""
    return row.own + row.forward.T @ (row.absolute - row.wrench)


def symmetric(theta: ca.SX, size: int) -> ca.SX:
    """A symmetric matrix from its diagonal, followed by the rows of its upper triangle."""
    matrix = ca.diag(theta[:size])
    index = size
    for i in range(size):
        for j in range(i + 1, size):
            if index < theta.shape[0]:
                matrix[i, j] = theta[index]
                matrix[j, i] = theta[index]
            index += 1
    return matrix
