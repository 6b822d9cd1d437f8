"""Joints of an arm: beyond each, the arm may tilt and shift in every direction, not about the joint's axis only."""

from collections.abc import Iterator
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.chain.component import Component, at_tip, each_joint
from expdesign.chain.ports.families import after_temperature, guide_ends, of_effort, smooth_over
from expdesign.chain.ports.port import Entry, Names, Port, Prior, steady
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row


class Joints(Port):
    """u: motion (m) and turn (rad) of the arm beyond every joint along the joint's own axes, joint after joint.

    Laws of the moment that the joint carries, and, where positions are read, of where the joint stands (a bearing that
    wobbles).
    """

    name = "joints"
    at = each_joint
    adds: ClassVar[Names] = lambda robot: robot.coordinates.deflection * len(each_joint(robot))

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        tree, moved = self.robot.links.tree, ca.SX(deflection)
        for joint in range(len(self.robot.stiffness)):
            point, frame = tree.joint_frame(row.pose, joint)
            shift, turn = extra[6 * joint : 6 * joint + 3], extra[6 * joint + 3 : 6 * joint + 6]
            moved += at_tip(self.robot, joint, frame @ shift, frame @ turn, row, point)
        return moved

    def entries(self, sight: Sight) -> Iterator[Entry]:
        for joint, component in enumerate(self.components):
            place = Quantity("length", joint)
            every = [Quantity("joint_moment", 3 * joint + axis) for axis in range(3)]
            sight.look(every)
            moments = tuple(moment for moment in every if sight.spread(moment) > 0.0)
            motions = range(6 * joint, 6 * joint + 6)
            turns = motions[3:]
            if moments:
                pairs = [(a, moment) for a in turns for moment in moments]
                for prior in (steady("compliance", moments[0]), *smooth_over(sight, "compliance", (place,), 6)):
                    yield self.law(component, prior, pairs)
            for moment in moments:
                for prior in of_effort(sight, moment):
                    yield self.law(component, prior, turns, rank=8)
            if len(moments) > 1 and sight.positions:
                yield from self._guides(sight, joint, component, moments)
            if sight.positions and sight.varies(place):
                for prior in (*smooth_over(sight, "twist", (place,), 8), *self._turning(place)):
                    yield self.law(component, prior, motions)
            for prior in after_temperature(sight, "twist") if sight.positions else ():
                yield self.law(component, prior, motions)

    def _guides(self, sight: Sight, joint: int, component: Component, moments: tuple[Quantity, ...]) -> Iterator[Entry]:
        """Tilts of a guide under the moments that it carries, in proportion to 1/overlap: clearance and pads."""
        if self.robot.units[joint] != "m":
            return
        prior = Prior("guide", "matern", moments, tuple(sight.spread(moment) for moment in moments), 30)
        for overlap in guide_ends(sight, Quantity("pose", joint)):
            yield self.law(component, prior, [(6 * joint + 3 + axis, overlap) for axis in range(3)])

    def _turning(self, place: Quantity) -> Iterator[Prior]:
        """What repeats with every turn of a revolute joint."""
        if self.robot.units[place.index] == "rad":
            yield Prior("twist", "periodic", (place,), (2.0 * np.pi,), 4)
