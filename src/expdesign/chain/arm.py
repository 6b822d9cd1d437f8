"""Pieces that the effects of arms share: where joints and links are, and what a wrench at the tip does there."""

import casadi as ca
import numpy as np

from expdesign.chain.effect import Effect
from expdesign.chain.row import Row
from expdesign.robots.robot import Robot
from expdesign.robots.serial import SerialRobot


class ArmEffect(Effect):
    """An effect that only serial robots have.

    Raises:
        ValueError: the robot is of another kind.
    """

    def __init__(self, robot: Robot, component: str, variant: str = "") -> None:
        if not isinstance(robot, SerialRobot):
            raise ValueError(f"{self.physics} of this form is for serial robots")
        super().__init__(robot, component, variant)


SHORTEST = 0.02
"""m; a shorter link neither bends nor grows noticeably."""


def arm_of(robot: Robot) -> SerialRobot:
    """The robot as the serial robot that it is; raises `ValueError` for one that is no arm."""
    if not isinstance(robot, SerialRobot):
        raise ValueError(f"a {robot.kind} is no arm")
    return robot


def moment_at(wrench: ca.SX, row: Row, point: ca.SX) -> ca.SX:
    """Moment (3,) about a point of a wrench that acts at the tip."""
    return wrench[3:] + ca.cross(row.position - point, wrench[:3])


def with_links_beyond(robot: SerialRobot, wrench: ca.SX, row: Row, first: int) -> ca.SX:
    """The wrench at the tip together with the weight of links `first`, first + 1, ... (from 1) about the tip, (6,).

    Positions show what own weight does; in deflections it is there before and after, and the wrench is the tip's alone.
    """
    if row.marker.shape[0] == 0:
        return wrench
    carried = [float(number >= first) for number in range(1, len(robot.stiffness) + 1)]
    mass = float(np.dot(carried, robot.tree.masses()))
    lever = robot.tree.weight(row.pose, None, ca.SX(carried)) - mass * row.position
    return wrench + ca.vertcat(mass * row.gravity, ca.cross(lever, row.gravity))


def at_tip(velocity: ca.SX, turn: ca.SX, row: Row, point: ca.SX) -> ca.SX:
    """Twist (6,) of the tip when the arm beyond a point moves by `velocity` and turns by `turn` about that point."""
    return ca.vertcat(velocity + ca.cross(turn, row.position - point), turn)


def long_links(robot: Robot) -> list[str]:
    """`link k` of every link of a serial robot that has a length; nothing of other robots."""
    if not isinstance(robot, SerialRobot):
        return []
    q = ca.SX.sym("q", len(robot.configuration))
    spans = [link_span(robot, q, link) for link in range(len(robot.stiffness))]
    lengths = ca.Function("lengths", [q], [ca.norm_2(end - start) for start, end in spans])
    # Prismatic joints lie at the start of their link, so that its length does not depend on the configuration.
    found = lengths.call([np.zeros(len(robot.configuration))])
    return [f"link {k + 1}" for k, length in enumerate(found) if float(length) > SHORTEST]


def link_span(robot: SerialRobot, q: ca.SX, link: int) -> tuple[ca.SX, ca.SX]:
    """Where a link (index from 0) begins and ends, (3,) each."""
    pose = robot.tree.forward(q)[robot.tree.joints[link].child]
    return pose[:3, 3], robot.tree.far_end(q, link)
