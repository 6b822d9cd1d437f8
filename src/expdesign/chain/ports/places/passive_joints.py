"""Joints at the ends of legs that resist being turned: flexures, preloaded bearings, and dry ones that stick."""

from collections.abc import Iterator, Sequence

import casadi as ca

from expdesign.chain.component import Component, each_leg, legs_and_all, passive_joint_turns, sprung_twist
from expdesign.chain.effects.legs.passive_joints import PassiveJoints, PassiveJointStiffness
from expdesign.chain.ports.families import SHARES, Prior, over_time, smooth_over
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row


class PassiveJointsPort(Port):
    """u: stiffness (N·m/rad) against rotation at every end of every leg, base ends first, of joints relaxed wherever.

    The wrench that turns the joints as the legs' own springs deflect, −Σ u·K·J·Δq with K of unit stiffness
    (`PassiveJointStiffness.relaxed`), is missing from what the legs carry. To first order in u, as all laws are.
    """

    name = "passive joints"

    def components_of_motion(self) -> int:
        return len(self._ends) * len(each_leg(self.robot)) if self.robot.on_straight_legs else 0

    @property
    def _ends(self) -> tuple[PassiveJoints, ...]:
        several = self.robot.coordinates.rotations == 3
        return (PassiveJoints.BASE, PassiveJoints.PLATFORM) if several else (PassiveJoints.CARDAN,)

    @property
    def outputs(self) -> Sequence[str]:
        return tuple(f"{end or 'both'}_{leg}_Nm_per_rad" for end in self._ends for leg in self.robot.actuators)

    @property
    def components(self) -> Sequence[Component]:
        return legs_and_all(self.robot)

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        kinds = [(end, leg) for end in self._ends for leg in each_leg(self.robot)]
        moved = sprung_twist(self.robot, row)
        for index, (end, leg) in enumerate(kinds):
            wrench = wrench - extra[index] * (PassiveJointStiffness(self.robot, leg, end).relaxed(row) @ moved)
        return wrench

    def entries(self, sight: Sight) -> Iterator[Entry]:
        """All legs alike, all legs each its own, and single legs: the same always, or with time and length."""
        legs, ends = each_leg(self.robot), len(self._ends)
        if not self.width:
            return
        for leg, component in enumerate(legs):
            for prior in (_ALWAYS, *smooth_over(sight, "joints", (Quantity("length", leg),), 6)):
                channels = tuple(Channel(e * len(legs) + leg, e, prior.inputs) for e in range(ends))
                yield Entry(self.name, component, prior.form, channels, prior.kernel, prior.scales, prior.rank)
        for prior in (_ALWAYS, *over_time(sight, "joints")) if len(legs) > 1 else ():
            channels = tuple(Channel(i, i // len(legs), prior.inputs) for i in range(self.width))
            yield Entry(self.name, self.components[-1], prior.form, channels, prior.kernel, prior.scales, 6)


class StickingJoints(Port):
    """u: moments (N·m) with which the joints at the ends of the legs resist being turned, about every axis of O.

    Dry joints stick. A leg between them bends with the platform, as a beam does, until the moments exceed what friction
    holds, and a part of the bending stays when the load is taken off: stop operators of the moments at its ends, both
    alike, and others of its torsion. The wrench −Σ turnᵀ·u is missing from what the legs carry (`passive_joint_turns`).
    """

    name = "sticking joints"

    def components_of_motion(self) -> int:
        if not self.robot.on_straight_legs:
            return 0
        return len(each_leg(self.robot)) * self._of_each

    @property
    def _of_each(self) -> int:
        """Components of u for one leg: three axes at either end and that of the leg, or one in the plane."""
        return 7 if self.robot.coordinates.rotations == 3 else 1

    @property
    def outputs(self) -> Sequence[str]:
        axes = [f"{end}_{axis}" for end in ("base", "platform") for axis in "xyz"]
        axes = [*axes, "torsion"] if self._of_each > 1 else ["both"]
        return tuple(f"{axis}_{leg}_Nm" for leg in self.robot.actuators for axis in axes)

    @property
    def components(self) -> Sequence[Component]:
        return legs_and_all(self.robot)

    def actuator(self, elongation: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        turns = [turn for leg in range(len(each_leg(self.robot))) for turn in passive_joint_turns(self.robot, row, leg)]
        forces = row.forward.T @ (ca.vertcat(*turns).T @ extra)
        return elongation - forces / ca.SX(self.robot.stiffness)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        """Of single legs, and of all legs alike."""
        if not self.width or int(sight.rows.position.max()) < 1:
            return
        sight.look(Quantity("bend", index) for index in range(self.width))
        largest = max(sight.largest(Quantity("bend", index)) for index in range(self.width))
        bounds = [round(share * largest, 12) for share in SHARES]
        slips = [tuple(Quantity("slip", index, (bound,)) for bound in bounds) for index in range(self.width)]
        sight.look(slip for several in slips for slip in several)
        scales = tuple(max(sight.spread(several[i]) for several in slips) for i in range(len(bounds)))
        if min(scales) == 0.0:
            return
        for component in self.components:
            legs = range(len(each_leg(self.robot))) if component.several else (component.index,)
            own = [(leg * self._of_each + axis, axis // 6) for leg in legs for axis in range(self._of_each)]
            channels = tuple(Channel(index, torsion, slips[index]) for index, torsion in own)
            yield Entry(self.name, component, "sticking", channels, "linear", scales, len(bounds))


class Flexures(Port):
    """u: stiffness (N·m/rad) of the flexures at the base ends of all legs and of those at their platform ends, relaxed
    at the zero pose.

    At any other pose they are bent. The forces with which the legs hold them shift the unloaded platform, and change
    with the pose (`PassiveJointStiffness.bent`): −Σ u·K·J·Δq is missing from what the legs carry.
    """

    name = "flexures"

    def components_of_motion(self) -> int:
        legs = each_leg(self.robot) if self.robot.on_straight_legs else []
        return 2 if len(legs) > 1 and self.robot.coordinates.rotations == 3 else 0

    @property
    def outputs(self) -> Sequence[str]:
        return ("base_Nm_per_rad", "platform_Nm_per_rad")

    @property
    def components(self) -> Sequence[Component]:
        return legs_and_all(self.robot)[-1:]

    @property
    def _of_ends(self) -> list[PassiveJointStiffness]:
        ends = (PassiveJoints.BASE, PassiveJoints.PLATFORM)
        return [PassiveJointStiffness(self.robot, self.components[0], end) for end in ends]

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
            channels = tuple(Channel(i, i, _ALWAYS.inputs) for i in range(self.width))
            yield Entry(self.name, self.components[0], "joints", channels, "constant", (1.0,), 1)


_ALWAYS = Prior("joints", "constant", (Quantity("clock"),), (1.0,), 1)
