"""Where on a robot an effect acts: a kind of part and, where there are several of it, its number.

Components that a robot has, and pieces that several effects share: loads that turn, compliances, and of arms where
joints and links are and what a wrench at the tip does there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

import casadi as ca
import numpy as np

from expdesign.chain.row import Row
from expdesign.mechanics.loads.load import small_rotation
from expdesign.mechanics.robots.orientation import moment
from expdesign.mechanics.robots.robot import Robot


class Part(Enum):
    """Kinds of components with the words by which results name them."""

    LEG = "leg"
    JOINT = "joint"
    LINK = "link"
    ALL_LEGS = "all legs"
    ALL_JOINTS = "all joints"
    PLATFORM = "platform"
    BASE = "base"
    PAYLOAD = "payload"
    INSTRUMENT = "instrument"
    ENVIRONMENT = "environment"
    GEOMETRY = "geometry"


_NUMBERED = (Part.LEG, Part.JOINT, Part.LINK)
ACTUATORS = (Part.LEG, Part.JOINT, Part.ALL_LEGS, Part.ALL_JOINTS)


@dataclass(frozen=True)
class Component:
    """A part of the machine or of its surroundings, e.g. leg 3; `str` gives the text that files and results use.

    Attributes:
        part: its kind.
        number: which one, from 1, of legs, joints and links; 0 for parts of which there is one.

    Raises:
        ValueError: a number is missing, or there is one too many.
    """

    part: Part
    number: int = 0

    def __post_init__(self) -> None:
        if (self.part in _NUMBERED) != (self.number >= 1):
            raise ValueError(f"`{self}` is no component")

    def __str__(self) -> str:
        return f"{self.part.value} {self.number}" if self.number else self.part.value

    @property
    def index(self) -> int:
        """Index from 0 of a leg, joint or link."""
        return self.number - 1

    @property
    def several(self) -> bool:
        """Whether it stands for all legs or all joints."""
        return self.part in (Part.ALL_LEGS, Part.ALL_JOINTS)


def component_from_text(text: str) -> Component:
    """The component that a file names; raises `ValueError` for a text that names none."""
    word, _, number = text.rpartition(" ")
    numbered = {part.value: part for part in _NUMBERED}
    if word in numbered and number.isdecimal():
        return Component(numbered[word], int(number))
    return Component(Part(text))


PLATFORM = Component(Part.PLATFORM)
BASE = Component(Part.BASE)
PAYLOAD = Component(Part.PAYLOAD)
INSTRUMENT = Component(Part.INSTRUMENT)
ENVIRONMENT = Component(Part.ENVIRONMENT)
GEOMETRY = Component(Part.GEOMETRY)
ALL_LEGS = Component(Part.ALL_LEGS)
ALL_JOINTS = Component(Part.ALL_JOINTS)


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


def actuators_and_all(robot: Robot) -> list[Component]:
    """Every leg or joint, and all of them together where they are of one kind: for effects that both have."""
    joints = each_joint(robot)
    return legs_and_all(robot) or [*joints, *([ALL_JOINTS] if len(joints) > 1 and len(set(robot.units)) == 1 else [])]


def on(
    having: Callable[[Robot], object], *places: Component | Callable[[Robot], Sequence[Component]]
) -> Callable[[Robot], list[Component]]:
    """Components of the robots that have something: single ones, and those that a robot has several of."""

    def components(robot: Robot) -> list[Component]:
        listed = ([place] if isinstance(place, Component) else place(robot) for place in places)
        return [component for each in listed for component in each] if having(robot) else []

    return components


def on_any(*places: Component | Callable[[Robot], Sequence[Component]]) -> Callable[[Robot], list[Component]]:
    """`on` whatever a robot has."""
    return on(lambda robot: True, *places)


def turned_lever(rotation: ca.SX, row: Row, wrench: ca.SX) -> ca.SX:
    """What a payload's wrench (n,) gains where its lever turns with the platform from R of the row to `rotation`."""
    split = rotation.shape[0]
    none = ca.SX.zeros(split)
    if wrench.shape[0] == split:
        return none
    arm = rotation @ row.rotation.T @ row.lever - row.lever
    return ca.vertcat(none, row.payload * moment(arm, wrench[:split]))


def yielded(pose: ca.SX, elongation: ca.SX) -> ca.SX:
    """Coordinates (n_q,) at which an arm stands whose joints yield (n_p,): what is no joint is unchanged."""
    return pose + ca.vertcat(elongation, ca.SX.zeros(pose.shape[0] - elongation.shape[0]))


def tilted_load(wrench: ca.SX, row: Row, angles: ca.SX) -> ca.SX:
    """A wrench (n,) with its force turned by small angles about axes of O: a payload's moment follows from its lever,
    a free wrench turns as a whole.
    """
    split = row.gravity.shape[0]
    force = wrench[:split]
    turned = small_rotation(force, angles)
    if wrench.shape[0] == split:
        return turned
    turning = wrench[split:]
    as_payload = turning + moment(row.lever, turned - force)
    # About the normal of the plane a moment stays what it is.
    as_wrench = small_rotation(turning, angles) if split == 3 else turning
    return ca.vertcat(turned, row.payload * as_payload + (1.0 - row.payload) * as_wrench)


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


SHORTEST = 0.02
"""m; a shorter link neither bends nor grows noticeably."""
LIGHTEST = 0.1
"""kg; a lighter link's error is not looked for."""


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


def sprung_twist(robot: Robot, row: Row) -> ca.SX:
    """Twist (n,) of the platform by the actuators' springs alone under the load of the moment."""
    return row.forward @ ((row.forward.T @ row.wrench) / ca.SX(robot.stiffness))


def passive_joint_turns(robot: Robot, row: Row, leg: int) -> list[ca.SX]:
    """How the joints at the ends of a straight leg turn per twist of the platform.

    With the leg's direction u, its length q and the velocity ṗ of its upper end it turns by ω_l = u×ṗ/q: the base joint
    by ω_l and the platform joint by (I − u·uᵀ)·ω − ω_l, (3×n) each, and both together by u·ω about the leg, (1×n); in
    the plane the leg by ω_l, (1×n).
    """
    length = row.lengths[leg]
    if robot.coordinates.rotations == 0:
        u = row.inverse[leg, :].T
        return [ca.vertcat(-u[1], u[0]).T / length]
    u = row.inverse[leg, :3].T
    joint = row.rotation @ ca.SX(robot.straight_legs.platform_joints[leg])
    leg_turn = ca.skew(u) @ ca.horzcat(ca.SX.eye(3), -ca.skew(joint)) / length
    spin = ca.horzcat(ca.SX.zeros(3, 3), ca.SX.eye(3))
    return [leg_turn, (ca.SX.eye(3) - u @ u.T) @ spin - leg_turn, u.T @ spin]


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
