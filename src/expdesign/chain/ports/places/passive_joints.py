"""Joints at the ends of legs that resist being turned: flexures, preloaded bearings, and dry ones that stick."""

from collections.abc import Callable, Iterator, Sequence
from typing import ClassVar

import casadi as ca

from expdesign.chain.component import Component, each_leg, legs_and_all, passive_joint_turns, sprung_twist
from expdesign.chain.effects.legs.passive_joints import PassiveJoints, PassiveJointStiffness
from expdesign.chain.ports.families import SHARES, over_time, smooth_over
from expdesign.chain.ports.port import Channel, Entry, Port, Prior, steady
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


def _ends(robot: Robot) -> tuple[PassiveJoints, ...]:
    """Ends of a leg whose joints show each for itself."""
    several = robot.coordinates.rotations == 3
    return (PassiveJoints.BASE, PassiveJoints.PLATFORM) if several else (PassiveJoints.CARDAN,)


def _stiffnesses(robot: Robot) -> Sequence[str]:
    legs = robot.actuators if robot.on_straight_legs else ()
    return [f"{end or 'both'}_{leg}_Nm_per_rad" for end in _ends(robot) for leg in legs]


class PassiveJointsPort(Port):
    """u: stiffness (N·m/rad) against rotation at every end of every leg, base ends first, of joints relaxed wherever.

    The wrench that turns the joints as the legs' own springs deflect, −Σ u·K·J·Δq with K of unit stiffness
    (`PassiveJointStiffness.resisting`), is missing from what the legs carry. To first order in u, as all laws are.
    """

    name = "passive joints"
    at = legs_and_all
    adds = _stiffnesses

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        kinds = [(end, leg) for end in _ends(self.robot) for leg in each_leg(self.robot)]
        moved = sprung_twist(self.robot, row)
        for index, (end, leg) in enumerate(kinds):
            joints = PassiveJointStiffness(self.robot, leg, end)
            wrench = wrench - extra[index] * joints.resisting(row, moved)
        return wrench

    def entries(self, sight: Sight) -> Iterator[Entry]:
        """All legs alike, all legs each its own, and single legs: the same always, or with time and length."""
        legs, always = each_leg(self.robot), steady("joints")
        if not self.width:
            return
        for leg, component in enumerate(legs):
            for prior in (always, *smooth_over(sight, "joints", (Quantity("length", leg),), 6)):
                yield self.law(component, prior, range(leg, self.width, len(legs)))
        for prior in (always, *over_time(sight, "joints")) if len(legs) > 1 else ():
            ends = [Channel(i, i // len(legs), prior.inputs) for i in range(self.width)]
            yield self.law(self.components[-1], prior, ends, rank=6)


def _moments(robot: Robot) -> Sequence[str]:
    """Three axes at either end of a leg and that of the leg itself, or one in the plane."""
    axes = [f"{end}_{axis}" for end in ("base", "platform") for axis in "xyz"]
    axes = [*axes, "torsion"] if robot.coordinates.rotations == 3 else ["both"]
    return [f"{axis}_{leg}_Nm" for leg in robot.actuators for axis in axes] if robot.on_straight_legs else []


class StickingJoints(Port):
    """u: moments (N·m) with which the joints at the ends of the legs resist being turned, about every axis of O.

    Dry joints stick. A leg between them bends with the platform, as a beam does, until the moments exceed what friction
    holds, and a part of the bending stays when the load is taken off: stop operators of the moments at its ends, both
    alike, and others of its torsion. The wrench −Σ turnᵀ·u is missing from what the legs carry (`passive_joint_turns`).
    """

    name = "sticking joints"
    at = legs_and_all
    adds = _moments

    def actuator(self, elongation: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        turns = [turn for leg in range(len(each_leg(self.robot))) for turn in passive_joint_turns(self.robot, row, leg)]
        forces = row.forward.T @ (ca.vertcat(*turns).T @ extra)
        return elongation - forces / ca.SX(self.robot.stiffness)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        """Of single legs, and of all legs alike."""
        if not self.width or not sight.remembers:
            return
        sight.look(Quantity("bend", index) for index in range(self.width))
        largest = max(sight.largest(Quantity("bend", index)) for index in range(self.width))
        bounds = [round(share * largest, 12) for share in SHARES]
        slips = [tuple(Quantity("slip", index, (bound,)) for bound in bounds) for index in range(self.width)]
        sight.look(slip for several in slips for slip in several)
        scales = tuple(max(sight.spread(several[i]) for several in slips) for i in range(len(bounds)))
        if min(scales) == 0.0:
            return
        prior = Prior("sticking", "linear", slips[0], scales, len(bounds))
        of_each = self.width // len(each_leg(self.robot))
        for component in self.components:
            legs = range(len(each_leg(self.robot))) if component.several else (component.index,)
            own = [(leg * of_each + axis, axis // 6) for leg in legs for axis in range(of_each)]
            yield self.law(component, prior, [Channel(index, torsion, slips[index]) for index, torsion in own])


def _flexures(robot: Robot) -> Sequence[str]:
    several = robot.on_straight_legs and len(each_leg(robot)) > 1 and robot.coordinates.rotations == 3
    return ("base_Nm_per_rad", "platform_Nm_per_rad") if several else ()


class Flexures(Port):
    """u: stiffness (N·m/rad) of the flexures at the base ends of all legs and of those at their platform ends, relaxed
    at the zero pose.

    At any other pose they are bent. The forces with which the legs hold them shift the unloaded platform, and change
    with the pose (`PassiveJointStiffness.bent`): −Σ u·K·J·Δq is missing from what the legs carry.
    """

    name = "flexures"
    at: ClassVar[Callable[[Robot], Sequence[Component]]] = lambda robot: legs_and_all(robot)[-1:]
    adds = _flexures

    @property
    def _of_ends(self) -> list[PassiveJointStiffness]:
        return [PassiveJointStiffness(self.robot, self.components[0], end) for end in _ends(self.robot)]

    def unloaded(self, pose: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        for index, joints in enumerate(self._of_ends):
            pose = pose + extra[index] * (row.pose_map @ (joints.preload(row) / ca.SX(self.robot.stiffness)))
        return pose

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        moved = sprung_twist(self.robot, row)
        for index, joints in enumerate(self._of_ends):
            wrench = wrench - extra[index] * (joints.bent(row) @ moved)
        return wrench

    def entries(self, sight: Sight) -> Iterator[Entry]:
        """The same always, at the ends of all legs alike."""
        if not sight.positions:
            yield self.law(self.components[0], steady("joints"), range(self.width))
