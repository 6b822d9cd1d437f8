"""Kinematics of a serial robot as one symbolic expression of its joint coordinates and its geometric errors.

The tip's pose is a product of transforms, T = E₀·C₁·J₁(q₁)·... with the constant transforms C of the URDF (fixed joints
multiplied in), the motions J of the joints, and errors E that are zero nominally: an offset of every coordinate and six
small motions (x, y, z, then a rotation Rz·Ry·Rx) of every link. The error of link k moves the frame at the far end of
link k, where the next joint sits (after the last joint: the tip), in that frame's own axes; link 0 is the base.

Joints that follow others have no coordinate of their own: theirs is Σ multiplier·q + offset (`urdf.py`). A
coordinate with several joints on the chain has one link, the one that follows the last of them.

Joints of branches (a gripper's fingers, a second arm) have coordinates after those of the chain where they are named:
they move masses and no tip, and do not yield. The others stand at zero, or at the limit nearest to it. The links' own
weight follows from the potential energy, τ_g = ∂/∂q Σ m·gᵀ·p (masses from the URDF).

With several tips the chain is a tree itself. Which tip is looked at is the last coordinate of a configuration (1 for
the first tip), so that whatever depends on the configuration is that tip's. A link from which several branches go on
has one far end, with six errors of its own, for each of them. What links carry beside the load on the tip (a payload in
the other hand) is four coordinates, mass and centre: it weighs as the link does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.mechanics.robots.orientation import chosen, constant, moved, rotation_matrix
from expdesign.mechanics.robots.urdf import Motion, Urdf, UrdfJoint, leading
from expdesign.mechanics.symbolic import remembered

FRAME_AXES = ("x", "y", "z", "rx", "ry", "rz")
TIP_COLUMN = "tip"
PAYLOAD_COLUMNS = ("mass_kg", "com_x_m", "com_y_m", "com_z_m")
_ROUNDED = 1e-3
"""Fraction of a mimicking joint's range by which its limits may be rounded."""


@dataclass(frozen=True)
class End:
    """Where a link of the chain ends: at the next joint (`name`), or at a tip (its link's name; `is_tip`)."""

    link: int
    name: str
    is_tip: bool


@dataclass(frozen=True)
class Coordinate:
    """One coordinate of the chain: unit `rad` or `m`, and limits from all joints that it moves on the chain."""

    joint: str
    unit: str
    low: float
    high: float


@dataclass(frozen=True)
class PlacedFrame:
    """A frame in the base link's: its axes (3×3), its origin (3,), and the steps that led to it, in base axes."""

    rotation: ca.SX
    position: ca.SX
    steps: tuple[ca.SX, ...] = ()

    def moved(self, by: ca.SX) -> "PlacedFrame":
        """The frame after a motion (4×4) in its own axes."""
        step = self.rotation @ by[:3, 3]
        return PlacedFrame(self.rotation @ by[:3, :3], self.position + step, (*self.steps, step))

    @cached_property
    def pose(self) -> ca.SX:
        """Homogeneous, 4×4."""
        return ca.blockcat([[self.rotation, self.position], [ca.SX.zeros(1, 3), ca.SX.ones(1)]])


class KinematicTree:
    """The chain from a base link to one or several tip links, and all that hangs on it.

    Args:
        urdf: the robot's description.
        base, tips: names of links.
        branches: joints off the chain that have coordinates.
        carriers: links that carry payloads beside the load on the tip.

    Attributes:
        paths: the joints from base to every tip, fixed ones included.
        chain: all of them, those of the first tip first.
        coordinates: in the order in which they move the chain.
        branch_coordinates: of the joints of `branches`, in their order.
        ends: far ends of link 0 (the base), 1, ..., in this order.
        geometry_names: `joint k offset` for every coordinate, then `link k x` ... `link k rz` for k = 0, 1, ...; of
            further far ends of a link `link k NAME x`, with the joint or tip there.

    Raises:
        InputError: the links are not there, nothing moves between them, or a joint is of a kind that has no place here.
    """

    def __init__(
        self, urdf: Urdf, base: str, tips: Sequence[str], branches: Sequence[str] = (), carriers: Sequence[str] = ()
    ) -> None:
        self.urdf, self.base, self.tips, self.carriers = urdf, base, tuple(tips), tuple(carriers)
        self.paths = [urdf.path(base, tip) for tip in self.tips]
        self.chain = list({joint.name: joint for path in self.paths for joint in path}.values())
        for joint in self.chain:
            if joint.kind in ("floating", "planar"):
                what = f"joint `{joint.name}` on the way from `{base}` to {self._named_tips} is {joint.kind}"
                raise InputError(
                    what, where=urdf.source, remedy="Name links with revolute and prismatic joints between."
                )
        names: list[str] = []
        for joint in self.chain:
            if joint.moves:
                names += [name for name in leading(urdf, joint).multipliers if name not in names]
        if not names:
            what = f"no joint moves between `{base}` and {self._named_tips}"
            raise InputError(what, where=urdf.source, remedy="Name other links.")
        others = [name for name in branches if name not in names]
        self._index = {name: index for index, name in enumerate((*names, *others))}
        self.coordinates = tuple(self._coordinate(name) for name in names)
        self.branch_coordinates = tuple(self._coordinate(name) for name in others)
        self.ends = sorted(self._ends(), key=lambda end: end.link)
        labels = [self._label(index) for index in range(len(self.ends))]
        self.geometry_names = (
            *(f"joint {k + 1} offset" for k in range(len(names))),
            *(f"{label} {axis}" for label in labels for axis in FRAME_AXES),
        )

    def carries(self, name: str) -> bool:
        """Whether a link of the URDF is one that coordinates move."""
        return name in self._carried and self.moves(name)

    @property
    def _named_tips(self) -> str:
        return " and ".join(f"`{tip}`" for tip in self.tips)

    @property
    def size_of_configuration(self) -> int:
        """Number of coordinates: of the chain, of branches, of payloads, and the tip's number where there are two."""
        return len(self._index) + len(PAYLOAD_COLUMNS) * len(self.carriers) + int(len(self.tips) > 1)

    def looked_at(self, q: ca.SX) -> list[ca.SX]:
        """For every tip 1 where a configuration is of it, else 0; of the first one where it says nothing."""
        if len(self.tips) == 1:
            return [ca.SX(1.0)]
        others = [q[-1] == number for number in range(2, len(self.tips) + 1)]
        return [1.0 - sum(others[1:], others[0]), *others]

    def reaches(self, q: ca.SX, joint: int) -> ca.SX:
        """1 where `joints[joint]` moves the tip that is looked at, else 0."""
        name = self.joints[joint].name
        carried = (seen for seen, path in zip(self.looked_at(q), self.paths, strict=True) if name in _names(path))
        return ca.SX(1.0) if len(self.tips) == 1 else sum(carried, ca.SX(0.0))

    def beyond(self, number: int, *, own: bool = True) -> FloatArray:
        """1 for the links that joint `number` moves (its own link only if `own`), 0 for the others, shape (n,)."""
        paths = [_names(path) for path in self.paths if self.joints[number - 1].name in _names(path)]
        return np.array(
            [
                float(link >= number + (not own) and any(joint.name in path for path in paths))
                for link, joint in enumerate(self.joints, start=1)
            ]
        )

    @remembered
    def tip_pose(self, q: ca.SX, geometry: ca.SX | None = None) -> ca.SX:
        """Pose (4×4) in the base link's frame of the tip that is looked at."""
        poses = [self._tip(tip, q, geometry).pose for tip in self.tips]
        return chosen(list(zip(self.looked_at(q), poses, strict=True)))

    def _tip(self, tip: str, q: ca.SX, geometry: ca.SX | None) -> PlacedFrame:
        link = self._placed(q, geometry)[0][tip]
        return link.moved(self._error(geometry, (tip, True))) if geometry is not None and self.is_passed(tip) else link

    @remembered
    def jacobian(self, q: ca.SX, geometry: ca.SX | None = None) -> ca.SX:
        """Velocity and angular velocity of the tip that is looked at per coordinate of the chain, base axes, (6, n).

        A joint with axis z moves a tip at a distance r from it by [z×r; z], or by [z; 0] along z: a third of the
        operations that derivatives of the tip's pose take. What lies before the joint is no part of r.
        """
        frames, options = self._placed(q, geometry)[1], []
        for path, tip, seen in zip(self.paths, self.tips, self.looked_at(q), strict=True):
            steps, columns = [*self._tip(tip, q, geometry).steps], [ca.SX.zeros(6) for _ in self.coordinates]
            reach = ca.SX.zeros(3)
            for joint in reversed(path):
                frame, motion = frames[joint.name], self.motion(joint)
                while len(steps) > len(frame.steps):
                    reach += steps.pop()
                axis = frame.rotation @ constant(joint.axis)
                twist = ca.vertcat(axis, ca.SX.zeros(3)) if joint.slides else ca.vertcat(ca.cross(axis, reach), axis)
                for index, multiplier in () if motion is None else motion.terms:
                    if index < len(columns):
                        columns[index] += multiplier * twist
            options.append((seen, ca.horzcat(*columns)))
        return chosen(options)

    def motion(self, joint: UrdfJoint) -> Motion | None:
        """What moves a joint, or None where no coordinate does."""
        return self._motions.get(joint.name)

    @cached_property
    def _motions(self) -> dict[str, Motion]:
        """Motions of all joints that a coordinate moves; a new coordinate's link begins where it appears first."""
        motions: dict[str, Motion] = {}
        begun: set[int] = set()
        on_chain = [joint.name for joint in self.chain]
        for joint in (*self.chain, *(each for each in self.urdf.joints.values() if each.name not in on_chain)):
            if not joint.moves:
                continue
            led = leading(self.urdf, joint)
            terms = tuple((self._index[name], value) for name, value in led.multipliers.items() if name in self._index)
            standing = sum(
                value * self.place(self.urdf.joints[name])
                for name, value in led.multipliers.items()
                if name not in self._index
            )
            if not terms:
                continue
            new = [index for index, _ in terms if index not in begun]
            begun.update(new)
            motions[joint.name] = Motion(new[0] if new else max(terms)[0], terms, led.offset + standing)
        return motions

    def _coordinate(self, name: str) -> Coordinate:
        leader = self.urdf.joints[name]
        low, high = leader.low, leader.high
        for joint in self.chain:
            if not joint.moves or joint is leader:
                continue
            led = leading(self.urdf, joint)
            if list(led.multipliers) != [name] or led.multipliers[name] == 0.0:
                continue
            multiplier, offset = led.multipliers[name], led.offset
            ends = sorted(((joint.low - offset) / multiplier, (joint.high - offset) / multiplier))
            # Rounded figures of a mimicking joint must not cut off the ends of what it mimics.
            slack = _ROUNDED * (ends[1] - ends[0]) if np.isfinite(ends).all() else 0.0
            low, high = max(low, ends[0] - slack), min(high, ends[1] + slack)
        return Coordinate(name, "m" if leader.slides else "rad", low, high)

    def place(self, joint: UrdfJoint) -> float:
        """Coordinate at which a joint that no coordinate moves stands: 0, or the limit nearest to it."""
        return float(np.clip(0.0, joint.low, joint.high)) if joint.moves else 0.0

    @cached_property
    def joints(self) -> tuple[UrdfJoint, ...]:
        """The joint at which link 1, 2, ... begins: the last one on the chain that each coordinate moves."""
        moved = [(motion, joint) for joint in self.chain if (motion := self.motion(joint)) is not None]
        last = {index: joint for motion, joint in moved for index, _ in motion.terms}
        last |= {motion.index: joint for motion, joint in moved}
        return tuple(last[index] for index in range(len(self.coordinates)))

    def joint_frame(self, q: ca.SX, joint: int) -> tuple[ca.SX, ca.SX]:
        """Place (3,) of `joints[joint]` and orientation (3×3) of its frame, as fixed to the link before it."""
        frame = self._placed(q, None)[1][self.joints[joint].name]
        return frame.position, frame.rotation

    def far_end(self, q: ca.SX, link: int) -> ca.SX:
        """Place (3,) at which link 1, 2, ... (index from 0) ends: at the next joint of the chain, or at the tip.

        Of several ends it is the one on the way to the tip that is looked at, if it is on one.
        """
        (links, joints), options = self._placed(q, None), []
        for path, tip, seen in zip(self.paths, self.tips, self.looked_at(q), strict=True):
            moving = [joint for joint in path if self.motion(joint) is not None]
            if self.joints[link] in moving:
                following = moving[moving.index(self.joints[link]) + 1 :]
                end = joints[following[0].name] if following else links[tip]
                options.append((seen, end.position))
        return chosen(options)

    @property
    def size(self) -> int:
        """Number of geometric errors."""
        return len(self.geometry_names)

    def link_frames(self, link: int) -> list[int]:
        """Indices of the first error (x) of the frame at every far end of a link (0: the base)."""
        first = len(self.coordinates)
        return [first + len(FRAME_AXES) * index for index, end in enumerate(self.ends) if end.link == link]

    def _ends(self) -> list[End]:
        """Where links end: at joints of the chain and at tips; none amid joints that mimic."""
        ends: dict[tuple[str, bool], End] = {}
        for path, tip in zip(self.paths, self.tips, strict=True):
            link: int | None = 0
            for joint in path:
                motion = self.motion(joint)
                if motion is None:
                    continue
                if link is not None:
                    ends.setdefault((joint.name, False), End(link, joint.name, is_tip=False))
                link = motion.index + 1 if self.joints[motion.index] is joint else None
            assert link is not None
            ends[tip, True] = End(link, tip, is_tip=True)
        return list(ends.values())

    def _label(self, index: int) -> str:
        end = self.ends[index]
        further = any(other.link == end.link for other in self.ends[:index])
        return f"link {end.link} {end.name}" if further else f"link {end.link}"

    @cached_property
    def _number_of(self) -> dict[tuple[str, bool], int]:
        """Index in `ends` by name, and whether it is a tip."""
        return {(end.name, end.is_tip): index for index, end in enumerate(self.ends)}

    def is_passed(self, tip: str) -> bool:
        """Whether a tip is on the way to another one."""
        return any(joint.parent == tip for joint in self.chain)

    @cached_property
    def _children(self) -> dict[str, list[UrdfJoint]]:
        children: dict[str, list[UrdfJoint]] = {}
        for joint in self.urdf.joints.values():
            children.setdefault(joint.parent, []).append(joint)
        return children

    @remembered
    def forward(self, q: ca.SX, geometry: ca.SX | None = None) -> dict[str, ca.SX]:
        """Poses (4×4) in the base link's frame of every link that the base carries; `geometry` holds the errors."""
        return {name: frame.pose for name, frame in self._placed(q, geometry)[0].items()}

    @remembered
    def _placed(self, q: ca.SX, geometry: ca.SX | None) -> tuple[dict[str, PlacedFrame], dict[str, PlacedFrame]]:
        """Frames of the links, and of the joints as fixed to the link before them."""
        links, joints = {self.base: PlacedFrame(ca.SX.eye(3), ca.SX.zeros(3))}, {}
        queue = [self.base]
        while queue:
            parent = queue.pop(0)
            for joint in self._children.get(parent, []):
                frame = links[parent].moved(constant(joint.origin))
                motion = self.motion(joint)
                if geometry is not None and (joint.name, False) in self._number_of:
                    frame = frame.moved(self._error(geometry, (joint.name, False)))
                joints[joint.name] = frame
                if joint.moves:
                    at = ca.SX(self.place(joint)) if motion is None else self._value(motion, q, geometry)
                    frame = frame.moved(moved(joint.axis, at, along=joint.slides))
                if geometry is not None and joint.child in self.tips and not self.is_passed(joint.child):
                    frame = frame.moved(self._error(geometry, (joint.child, True)))
                links[joint.child] = frame
                queue.append(joint.child)
        return links, joints

    def _value(self, motion: Motion, q: ca.SX, geometry: ca.SX | None) -> ca.SX:
        value = ca.SX(motion.offset)
        for index, multiplier in motion.terms:
            value += multiplier * q[index]
            if geometry is not None and index < len(self.coordinates):
                value += multiplier * geometry[index]
        return value

    def _error(self, geometry: ca.SX, end: tuple[str, bool]) -> ca.SX:
        """Motion (4×4) from where the far end of a link is nominally."""
        start = len(self.coordinates) + len(FRAME_AXES) * self._number_of[end]
        error = ca.SX.eye(4)
        error[:3, :3] = rotation_matrix(geometry[start + 3 : start + 6], "fixed-xyz")
        error[:3, 3] = geometry[start : start + 3]
        return error

    def link_of(self, name: str) -> int:
        """Number of the link of the chain (0: the base) with which a link of the URDF moves first."""
        motions = (self.motion(joint) for joint in reversed(self.urdf.path(self.base, name)))
        numbers = (motion.index + 1 for motion in motions if motion and motion.index < len(self.coordinates))
        return next(numbers, 0)

    def moves(self, name: str) -> bool:
        """Whether any coordinate, of the chain or of a branch, moves a link of the URDF."""
        return any(self.motion(joint) for joint in self.urdf.path(self.base, name))

    def weight(
        self, q: ca.SX, geometry: ca.SX | None = None, factors: ca.SX | None = None, *, payloads: bool = True
    ) -> ca.SX:
        """Mass (kg) and Σ m·p (kg·m, in the base link's axes), shape (4,): the potential energy is −gᵀ·Σ m·p.

        Args:
            q: coordinates (n,).
            geometry: geometric errors, or None.
            factors: true over nominal mass of link 1, ..., n, or None; with them, branches of the base do not count.
            payloads: whether what links carry counts with them.
        """
        total = ca.SX.zeros(4)
        for number, of_link, of_payload in self._weights(q, geometry):
            if number == 0 and factors is not None:
                continue
            factor = ca.SX(1.0) if factors is None else factors[number - 1]
            total += factor * (of_link + of_payload if payloads else of_link)
        return total

    @remembered
    def _weights(self, q: ca.SX, geometry: ca.SX | None) -> list[tuple[int, ca.SX, ca.SX]]:
        """Number of the link, m·(1, p) of itself and of what it carries (4,), of every link of the URDF that moves."""
        found = []
        for name, pose in self.forward(q, geometry).items():
            link, carries = self.urdf.links[name], name in self.carriers
            if not self.moves(name) or not (link.mass or carries):
                continue
            own, payload = ca.SX.zeros(4), ca.SX.zeros(4)
            if link.mass:
                own = link.mass * ca.vertcat(1.0, pose[:3, :3] @ ca.SX(link.centre) + pose[:3, 3])
            if carries:
                mass, centre = self._payload(q, name)
                payload = mass * ca.vertcat(1.0, pose[:3, :3] @ centre + pose[:3, 3])
            found.append((self.link_of(name), own, payload))
        return found

    def _payload(self, q: ca.SX, carrier: str) -> tuple[ca.SX, ca.SX]:
        """Mass (kg) and centre (3,) in the link's frame (m) of what a link carries."""
        start = len(self._index) + len(PAYLOAD_COLUMNS) * self.carriers.index(carrier)
        return q[start], q[start + 1 : start + 4]

    def masses(self) -> FloatArray:
        """Mass of link 1, ..., n with what hangs on it (kg), shape (n,)."""
        masses = np.zeros(len(self.coordinates))
        for name in self._carried:
            number = self.link_of(name)
            if number:
                masses[number - 1] += self.urdf.links[name].mass
        return masses

    @cached_property
    def _carried(self) -> list[str]:
        """Links that the base carries."""
        return list(self.forward(ca.SX.sym("q", self.size_of_configuration)))


def _names(path: Sequence[UrdfJoint]) -> list[str]:
    return [joint.name for joint in path]
