"""Geometry of an arm as it is calibrated from absolute readings: zeros of all joints, and every joint's frame.

The frame of joint k is moved by six small motions from where the URDF has it: x, y, z along, then a rotation
Rz·Ry·Rx about, the axes that the joint's `<origin>` gives at coordinate zero. `link k` in the names is the link at
whose far end the frame lies, so that joint k + 1 sits there (`mechanics/robots/kinematic_tree.py`). In a URDF with the
motion E the `<origin>` is `origin·E` (`mechanics/robots/corrected_urdf.py`).

Weights and levers act on the true geometry, so that a robot whose file has the identified geometry predicts the same.
"""

from enum import StrEnum

import casadi as ca

from expdesign.chain.component import GEOMETRY, Component, each_joint
from expdesign.chain.effects.joints.geometric_error import GeometricError
from expdesign.chain.row import Row
from expdesign.mechanics.robots.kinematic_tree import FRAME_AXES
from expdesign.mechanics.robots.robot import Robot


class LinkFrames(StrEnum):
    """Whose frames count beside those of the joints.

    The first joint's frame in the base is that of an instrument of unknown pose, and the frame of a tip that of markers
    of unknown places: they count where these are known.
    """

    JOINTS = ""
    BASE = "with the base"
    TIPS = "with the tips"
    BASE_AND_TIPS = "with base and tips"


class CalibratedGeometryError(GeometricError):
    """`geometry`: all zeros and frames that a calibration of an arm identifies."""

    measurands = ()
    forms = tuple(LinkFrames)
    changes_geometry = True

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [GEOMETRY] if each_joint(robot) else []

    @property
    def _indices(self) -> list[int]:
        tree, count = self.robot.links.tree, len(self.robot.stiffness)
        indices = list(range(count))
        for number, end in enumerate(tree.ends):
            start = count + len(FRAME_AXES) * number
            # Other ends of the base than its first one (a second arm) are not the instrument's.
            base = start == tree.link_frames(0)[0]
            left_out = base and self.variant not in (LinkFrames.BASE, LinkFrames.BASE_AND_TIPS)
            left_out |= end.is_tip and self.variant not in (LinkFrames.TIPS, LinkFrames.BASE_AND_TIPS)
            if not left_out:
                indices += range(start, start + len(FRAME_AXES))
        return indices

    @property
    def indices(self) -> tuple[int, ...]:
        """Which geometric errors of the tree (`KinematicTree.geometry_names`) its parameters are."""
        return tuple(self._indices)

    def own_weight_change(self, row: Row, theta: ca.SX) -> ca.SX:
        robot = self.robot.links
        geometry = self.geometry(ca.SX.zeros(robot.tree.size), theta)
        nominal = robot.own_weight_expression(row.pose, row.gravity)
        return robot.own_weight_expression(row.pose, row.gravity, geometry) - nominal

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        return f"Zeros and frames of the joints differ from the URDF's: {len(values)} parameters were identified."
