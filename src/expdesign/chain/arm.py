"""Pieces that the effects of arms share: where joints and links are, and what a wrench at the tip does there."""

from functools import lru_cache

import casadi as ca
import numpy as np

from expdesign.chain.component import Component
from expdesign.chain.components import each_link
from expdesign.chain.row import Row
from expdesign.mechanics.robots.capabilities import Links
from expdesign.mechanics.robots.robot import Robot

SHORTEST = 0.02
"""m; a shorter link neither bends nor grows noticeably."""
LIGHTEST = 0.1
"""kg; a lighter link's error is not looked for."""


def links_of(robot: Robot) -> Links:
    """The links of a robot that has some."""
    return robot.links


def moment_at(wrench: ca.SX, row: Row, point: ca.SX) -> ca.SX:
    """Moment (3,) about a point of a wrench that acts at the tip."""
    return wrench[3:] + ca.cross(row.position - point, wrench[:3])


def with_links_beyond(robot: Robot, wrench: ca.SX, row: Row, joint: int, *, own: bool = True) -> ca.SX:
    """The wrench at the tip together with the weight of the links beyond a joint (from 1) about the tip, (6,).

    Positions show what own weight does; in deflections it is there before and after, and the wrench is the tip's alone.
    `own` says whether the link that begins at the joint counts.
    """
    if row.marker.shape[0] == 0:
        return wrench
    tree = robot.links.tree
    weight = tree.weight(row.pose, None, ca.SX(tree.beyond(joint, own=own)))
    lever = weight[1:] - weight[0] * row.position
    return wrench + ca.vertcat(weight[0] * row.gravity, ca.cross(lever, row.gravity))


def at_tip(robot: Robot, joint: int, velocity: ca.SX, turn: ca.SX, row: Row, point: ca.SX) -> ca.SX:
    """Twist (6,) of the tip when the arm beyond a joint (index from 0) moves by `velocity` and turns by `turn` about
    a point; 0 for a tip that the joint does not carry.
    """
    twist = ca.vertcat(velocity + ca.cross(turn, row.position - point), turn)
    return robot.links.tree.reaches(row.pose, joint) * twist


@lru_cache(maxsize=16)
def long_links(robot: Robot) -> tuple[Component, ...]:
    """Every link that has a length; nothing of robots without links."""
    if not robot.jointed:
        return ()
    q = ca.SX.sym("q", len(robot.configuration))
    spans = [link_span(robot, q, link.index) for link in each_link(robot)]
    lengths = ca.Function("lengths", [q], [ca.norm_2(end - start) for start, end in spans])
    # Prismatic joints lie at the start of their link, so that its length does not depend on the configuration.
    found = lengths.call([np.zeros(len(robot.configuration))])
    return tuple(link for link, length in zip(each_link(robot), found, strict=True) if float(length) > SHORTEST)


@lru_cache(maxsize=16)
def heavy_links(robot: Robot) -> tuple[Component, ...]:
    """Every link with a mass that could be noticeably wrong; nothing of robots without links."""
    if not robot.jointed:
        return ()
    masses = robot.links.tree.masses()
    return tuple(link for link, mass in zip(each_link(robot), masses, strict=True) if mass > LIGHTEST)


def link_span(robot: Robot, q: ca.SX, link: int) -> tuple[ca.SX, ca.SX]:
    """Where a link (index from 0) begins and ends, (3,) each."""
    tree = robot.links.tree
    pose = tree.forward(q)[tree.joints[link].child]
    return pose[:3, 3], tree.far_end(q, link)
