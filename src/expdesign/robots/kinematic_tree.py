"""Kinematics of a serial robot as one symbolic expression of its joint coordinates and its geometric errors.

The tip's pose is a product of transforms, T = E₀·C₁·J₁(q₁)·... with the constant transforms C of the URDF (fixed joints
multiplied in), the motions J of the joints, and errors E that are zero nominally: an offset of every coordinate and six
small motions (x, y, z, then a rotation Rz·Ry·Rx) of every link. The error of link k moves the frame at the far end of
link k, where the next joint sits (after the last joint: the tip), in that frame's own axes; link 0 is the base.

Joints that mimic others have no coordinate of their own: theirs is multiplier·q + offset. A coordinate with several
joints on the chain has one link, the one that follows the last of them.

The links' own weight follows from the potential energy, τ_g = ∂/∂q Σ m·gᵀ·p (masses from the URDF); the
branches that hang on the chain (a gripper's fingers) ride along with their own joints at zero, or at the limit nearest
to it.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.robots.orientation import rotation_matrix
from expdesign.robots.urdf import Urdf, UrdfJoint, transform

FRAME_AXES = ("x", "y", "z", "rx", "ry", "rz")
_ROUNDING = 1e-15
_ROUNDED = 1e-3
"""Fraction of a mimicking joint's range by which its limits may be rounded."""


@dataclass(frozen=True)
class Motion:
    """What moves a joint: coordinate `index`, of which it takes `multiplier`·q + `offset`."""

    index: int
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Coordinate:
    """One coordinate of the chain: unit `rad` or `m`, and limits from all joints that it moves on the chain."""

    joint: str
    unit: str
    low: float
    high: float


class KinematicTree:
    """The chain from a base link to a tip link, and all that hangs on it.

    Args:
        urdf: the robot's description.
        base, tip: names of links.

    Attributes:
        chain: the joints from base to tip, fixed ones included.
        coordinates: in the order in which they move the chain.
        geometry_names: `joint k offset` for every coordinate, then `link k x` ... `link k rz` for k = 0, 1, ...

    Raises:
        InputError: the links are not there, nothing moves between them, or a joint is of a kind that has no place here.
    """

    def __init__(self, urdf: Urdf, base: str, tip: str) -> None:
        self.urdf, self.base, self.tip = urdf, base, tip
        self.chain = urdf.path(base, tip)
        for joint in self.chain:
            if joint.kind in ("floating", "planar"):
                what = f"joint `{joint.name}` on the way from `{base}` to `{tip}` is {joint.kind}"
                raise InputError(
                    what, where=urdf.source, remedy="Name links with revolute and prismatic joints between."
                )
        names: list[str] = []
        for joint in self.chain:
            if joint.moves:
                leader = self._leader(joint)[0]
                if leader not in names:
                    names.append(leader)
        if not names:
            what = f"no joint moves between `{base}` and `{tip}`"
            raise InputError(what, where=urdf.source, remedy="Name other links.")
        self._index = {name: index for index, name in enumerate(names)}
        self.coordinates = tuple(self._coordinate(name) for name in names)
        count = len(names)
        self.geometry_names = (
            *(f"joint {k + 1} offset" for k in range(count)),
            *(f"link {k} {axis}" for k in range(count + 1) for axis in FRAME_AXES),
        )

    def _leader(self, joint: UrdfJoint) -> tuple[str, float, float]:
        """The joint that leads a chain of mimics, and multiplier and offset with respect to it."""
        multiplier, offset = 1.0, 0.0
        seen = {joint.name}
        while joint.mimic is not None:
            offset += multiplier * joint.mimic.offset
            multiplier *= joint.mimic.multiplier
            joint = self.urdf.joints[joint.mimic.joint]
            if joint.name in seen:
                what = f"joint `{joint.name}` mimics itself"
                raise InputError(what, where=self.urdf.source, remedy="Correct <mimic>.")
            seen.add(joint.name)
        return joint.name, multiplier, offset

    def motion(self, joint: UrdfJoint) -> Motion | None:
        """What moves a joint, or None where no coordinate of the chain does."""
        if not joint.moves:
            return None
        leader, multiplier, offset = self._leader(joint)
        return Motion(self._index[leader], multiplier, offset) if leader in self._index else None

    def _coordinate(self, name: str) -> Coordinate:
        leader = self.urdf.joints[name]
        low, high = leader.low, leader.high
        for joint in self.chain:
            if not joint.moves or joint is leader:
                continue
            leads, multiplier, offset = self._leader(joint)
            if leads != name or multiplier == 0.0:
                continue
            ends = sorted(((joint.low - offset) / multiplier, (joint.high - offset) / multiplier))
            # Rounded figures of a mimicking joint must not cut off the ends of what it mimics.
            slack = _ROUNDED * (ends[1] - ends[0]) if np.isfinite(ends).all() else 0.0
            low, high = max(low, ends[0] - slack), min(high, ends[1] + slack)
        return Coordinate(name, "m" if leader.kind == "prismatic" else "rad", low, high)

    def place(self, joint: UrdfJoint) -> float:
        """Coordinate at which a joint that nothing moves stands: 0, or the limit nearest to it."""
        return float(np.clip(0.0, joint.low, joint.high)) if joint.moves else 0.0

    @cached_property
    def joints(self) -> tuple[UrdfJoint, ...]:
        """The joint at which link 1, 2, ... begins: the last one on the chain that each coordinate moves."""
        last = {motion.index: joint for joint in self.chain if (motion := self.motion(joint)) is not None}
        return tuple(last[index] for index in range(len(self.coordinates)))

    def joint_frame(self, q: ca.SX, joint: int) -> tuple[ca.SX, ca.SX]:
        """Place (3,) of `joints[joint]` and orientation (3×3) of its frame, as fixed to the link before it."""
        before = self.joints[joint]
        pose = self.forward(q)[before.parent] @ _constant(before.origin)
        return pose[:3, 3], pose[:3, :3]

    def far_end(self, q: ca.SX, link: int) -> ca.SX:
        """Place (3,) at which link 1, 2, ... (index from 0) ends: at the next joint of the chain, or at the tip."""
        poses = self.forward(q)
        chain = [joint for joint in self.chain if self.motion(joint) is not None]
        place = chain.index(self.joints[link]) + 1
        if place == len(chain):
            return poses[self.tip][:3, 3]
        return (poses[chain[place].parent] @ _constant(chain[place].origin))[:3, 3]

    @property
    def size(self) -> int:
        """Number of geometric errors."""
        return len(self.geometry_names)

    def link_frame(self, link: int, axis: str) -> int:
        """Index of an error of a link's frame."""
        return len(self.coordinates) + len(FRAME_AXES) * link + FRAME_AXES.index(axis)

    @cached_property
    def _links(self) -> dict[str, int]:
        """The link at whose far end a joint of the chain sits, or (empty name) the tip; none amid joints that mimic."""
        ends: dict[str, int] = {}
        link: int | None = 0
        for joint in self.chain:
            motion = self.motion(joint)
            if motion is None:
                continue
            if link is not None:
                ends[joint.name] = link
            link = motion.index + 1 if self.joints[motion.index] is joint else None
        assert link is not None
        ends[""] = link
        return ends

    @cached_property
    def _children(self) -> dict[str, list[UrdfJoint]]:
        children: dict[str, list[UrdfJoint]] = {}
        for joint in self.urdf.joints.values():
            children.setdefault(joint.parent, []).append(joint)
        return children

    def forward(self, q: ca.SX, geometry: ca.SX | None = None) -> dict[str, ca.SX]:
        """Poses (4×4) in the base link's frame of every link that the base carries; `geometry` holds the errors."""
        poses: dict[str, ca.SX] = {self.base: ca.SX.eye(4)}
        queue = [self.base]
        while queue:
            parent = queue.pop(0)
            for joint in self._children.get(parent, []):
                pose = poses[parent] @ _constant(joint.origin)
                motion = self.motion(joint)
                if joint.name in self._links:
                    pose = self._erred(pose, geometry, self._links[joint.name])
                if motion is not None:
                    value = q[motion.index] if geometry is None else q[motion.index] + geometry[motion.index]
                    pose = pose @ _moved(joint, motion.multiplier * value + motion.offset)
                elif joint.moves:
                    pose = pose @ _moved(joint, ca.SX(self.place(joint)))
                if joint.child == self.tip:
                    pose = self._erred(pose, geometry, self._links[""])
                poses[joint.child] = pose
                queue.append(joint.child)
        return poses

    def _erred(self, pose: ca.SX, geometry: ca.SX | None, link: int) -> ca.SX:
        if geometry is None:
            return pose
        start = self.link_frame(link, "x")
        error = ca.SX.eye(4)
        error[:3, :3] = rotation_matrix(geometry[start + 3 : start + 6], "fixed-xyz")
        error[:3, 3] = geometry[start : start + 3]
        return pose @ error

    def link_of(self, name: str) -> int:
        """Number of the link of the chain (0: the base) with which a link of the URDF moves first."""
        above = {joint.child: joint for joint in self.urdf.joints.values()}
        while name != self.base:
            joint = above[name]
            motion = self.motion(joint)
            if motion is not None:
                return motion.index + 1
            name = joint.parent
        return 0

    def weight(self, q: ca.SX, geometry: ca.SX | None = None, factors: ca.SX | None = None) -> ca.SX:
        """Σ m·p (kg·m, in the base link's axes), shape (3,): with gravity g the potential energy is −gᵀ·Σ m·p.

        Args:
            q: coordinates (n,).
            geometry: geometric errors, or None.
            factors: true over nominal mass of link 1, ..., n, or None.
        """
        poses = self.forward(q, geometry)
        total = ca.SX.zeros(3)
        for name, pose in poses.items():
            link = self.urdf.links[name]
            number = self.link_of(name)
            if link.mass == 0.0 or number == 0:
                continue
            factor = ca.SX(1.0) if factors is None else factors[number - 1]
            total += factor * link.mass * (pose[:3, :3] @ ca.SX(link.centre) + pose[:3, 3])
        return total

    def masses(self) -> FloatArray:
        """Mass of link 1, ..., n with what hangs on it (kg), shape (n,)."""
        masses = np.zeros(len(self.coordinates))
        symbols = ca.SX.sym("q", len(self.coordinates))
        for name in self.forward(symbols):
            number = self.link_of(name)
            if number:
                masses[number - 1] += self.urdf.links[name].mass
        return masses


def _constant(matrix: FloatArray) -> ca.SX:
    """A constant transform in which rounding of right angles leaves no entries behind."""
    return ca.sparsify(ca.SX(np.where(np.abs(matrix) < _ROUNDING, 0.0, matrix)))


def _moved(joint: UrdfJoint, value: ca.SX) -> ca.SX:
    """Motion of a joint along or about its axis: exp(q·ξ), by Rodrigues' formula for a rotation."""
    axis = np.where(np.abs(joint.axis) < _ROUNDING, 0.0, joint.axis)
    if joint.kind == "prismatic":
        motion = ca.SX(transform(np.eye(3), np.zeros(3)))
        motion[:3, 3] = ca.SX(axis) * value
        return motion
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    rotation = ca.SX(np.outer(axis, axis)) + ca.cos(value) * ca.SX(np.eye(3) - np.outer(axis, axis))
    motion = ca.SX.eye(4)
    motion[:3, :3] = rotation + ca.sin(value) * ca.SX(skew)
    return motion
