"""Names of components as results speak of them (interfaces.md), and small pieces that several effects share."""

import casadi as ca

from expdesign.chain.row import Row
from expdesign.robots.robot import Robot

ALL_LEGS = "all legs"


def each_leg(robot: Robot) -> list[str]:
    """`leg 1`, `leg 2`, ..."""
    return list(robot.actuators)


def legs_and_all(robot: Robot) -> list[str]:
    """Every leg, and all legs together with common parameters."""
    return [*each_leg(robot), ALL_LEGS] if len(robot.stiffness) > 1 else each_leg(robot)


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
