"""Joints of an arm: beyond each, the arm may tilt and shift in every direction, not about the joint's axis only."""

from collections.abc import Iterator, Sequence

import casadi as ca
import numpy as np

from expdesign.chain.component import Component, at_tip, each_joint
from expdesign.chain.ports.families import Prior, guide_ends, of_effort, smooth_over
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class Joints(Port):
    """u: motion (m) and turn (rad) of the arm beyond every joint along the joint's own axes, joint after joint.

    Laws of the moment that the joint carries, and, where positions are read, of where the joint stands (a bearing that
    wobbles).
    """

    name = "joints"

    def components_of_motion(self) -> int:
        return 6 * len(each_joint(self.robot))

    @property
    def outputs(self) -> Sequence[str]:
        return self.robot.coordinates.deflection * len(each_joint(self.robot))

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        tree, moved = self.robot.links.tree, ca.SX(deflection)
        for joint in range(len(self.robot.stiffness)):
            point, frame = tree.joint_frame(row.pose, joint)
            shift, turn = extra[6 * joint : 6 * joint + 3], extra[6 * joint + 3 : 6 * joint + 6]
            moved += at_tip(self.robot, joint, frame @ shift, frame @ turn, row, point)
        return moved

    @property
    def components(self) -> Sequence[Component]:
        return each_joint(self.robot)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        for joint, component in enumerate(each_joint(self.robot)):
            place = Quantity("length", joint)
            every = [Quantity("joint_moment", 3 * joint + axis) for axis in range(3)]
            sight.look(every)
            moments = [moment for moment in every if sight.spread(moment) > 0.0]
            turns = [6 * joint + 3 + axis for axis in range(3)]
            if moments:
                steady = Prior("compliance", "constant", (moments[0],), (1.0,), 1)
                for prior in (steady, *smooth_over(sight, "compliance", (place,), 6)):
                    pairs = [(a, moment) for a in turns for moment in moments]
                    channels = tuple(Channel(a, i, prior.inputs, q) for i, (a, q) in enumerate(pairs))
                    yield Entry(self.name, component, prior.form, channels, prior.kernel, prior.scales, prior.rank)
                for moment in moments:
                    for prior in of_effort(sight, moment):
                        channels = tuple(Channel(a, i, prior.inputs) for i, a in enumerate(turns))
                        yield Entry(self.name, component, prior.form, channels, prior.kernel, prior.scales, 8)
            if len(moments) > 1 and sight.positions:
                yield from self._guides(sight, joint, component, tuple(moments))
            if sight.positions and sight.varies(place):
                motions = [6 * joint + axis for axis in range(6)]
                for prior in (*smooth_over(sight, "twist", (place,), 8), *_turning(self.robot, place)):
                    channels = tuple(Channel(a, i, prior.inputs) for i, a in enumerate(motions))
                    yield Entry(self.name, component, prior.form, channels, prior.kernel, prior.scales, prior.rank)

    def _guides(self, sight: Sight, joint: int, component: Component, moments: tuple[Quantity, ...]) -> Iterator[Entry]:
        """Tilts of a guide under the moments that it carries, in proportion to 1/overlap: clearance and pads."""
        if self.robot.units[joint] != "m":
            return
        scales = tuple(sight.spread(moment) for moment in moments)
        for overlap in guide_ends(sight, Quantity("pose", joint)):
            channels = tuple(Channel(6 * joint + 3 + axis, axis, moments, overlap) for axis in range(3))
            yield Entry(self.name, component, "guide", channels, "matern", scales, 30)


def _turning(robot: Robot, place: Quantity) -> Iterator[Prior]:
    """What repeats with every turn of a revolute joint."""
    if robot.units[place.index] == "rad":
        yield Prior("twist", "periodic", (place,), (2.0 * np.pi,), 4)
