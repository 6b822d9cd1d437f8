"""Components that a robot has, and small pieces that several effects share."""

import casadi as ca

from expdesign.chain.component import ALL_JOINTS, ALL_LEGS, Component, Part
from expdesign.chain.row import Row
from expdesign.mechanics.moments import moment
from expdesign.mechanics.robots.robot import Robot


def each_leg(robot: Robot) -> list[Component]:
    """Every actuator of a robot that is commanded by a pose: legs, or other limbs with one actuator each."""
    count = len(robot.stiffness) if robot.on_legs else 0
    return [Component(Part.LEG, number) for number in range(1, count + 1)]


def legs_and_all(robot: Robot) -> list[Component]:
    """Every leg, and all legs together with common parameters."""
    legs = each_leg(robot)
    return [*legs, ALL_LEGS] if len(legs) > 1 else legs


def each_joint(robot: Robot) -> list[Component]:
    """Every joint of a robot that is commanded in its joints."""
    count = len(robot.stiffness) if robot.jointed else 0
    return [Component(Part.JOINT, number) for number in range(1, count + 1)]


def sliding_joints(robot: Robot) -> list[Component]:
    """Every prismatic joint of a robot that is commanded in its joints."""
    return [joint for joint in each_joint(robot) if robot.units[joint.index] == "m"]


def each_link(robot: Robot) -> list[Component]:
    """Link 1, ..., which follow joint 1, ...; link 0 is the base."""
    return [Component(Part.LINK, joint.number) for joint in each_joint(robot)]


def joints_and_all(robot: Robot) -> list[Component]:
    """Every joint, and all joints together with common parameters where they are of one kind."""
    joints = each_joint(robot)
    return [*joints, ALL_JOINTS] if len(joints) > 1 and len(set(robot.units)) == 1 else joints


def actuators_and_all(robot: Robot) -> list[Component]:
    """Every leg or joint, and all of them together: for effects that both kinds of actuator have."""
    return legs_and_all(robot) or joints_and_all(robot)


def turning(robot: Robot, actuators: tuple[int, ...]) -> bool:
    """Whether the first of these actuators turns: its motion is in rad and its force in N·m."""
    return robot.units[actuators[0]] == "rad"


def reference_force(row: Row) -> ca.SX:
    """Actuator forces (N or N·m) in the reference state: by own weight and by what was carried there, (n_p,)."""
    return row.own + row.forward.T @ (row.absolute - row.wrench)


def turned_lever(rotation: ca.SX, row: Row, wrench: ca.SX) -> ca.SX:
    """What a payload's wrench (n,) gains where its lever turns with the platform from R of the row to `rotation`."""
    split = rotation.shape[0]
    none = ca.SX.zeros(split)
    if wrench.shape[0] == split:
        return none
    arm = rotation @ row.rotation.T @ row.lever - row.lever
    return ca.vertcat(none, row.payload * moment(arm, wrench[:split]))


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
