"""What deforms, or stands elsewhere, beside the legs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Body, Point
from ..kinematics import Matrix, Pose, Vector, rotation_between
from ..robot import Robot
from .element import Element, Stage, legs_of, require

if TYPE_CHECKING:
    from ..machine import Machine


def bushing_matrix(stiffness: Sequence[float] | Matrix) -> Matrix:
    """6 x 6 stiffness from six numbers or from a matrix; positive definite."""
    array = np.asarray(stiffness, dtype=float)
    matrix = np.diag(array) if array.ndim == 1 else array
    require(matrix.shape == (6, 6), "stiffness: needs six numbers or a 6 x 6 matrix")
    require(np.allclose(matrix, matrix.T), "stiffness: must be symmetric")
    require(bool(np.linalg.eigvalsh(matrix).min() > 0), "stiffness: must be positive definite")
    return matrix


@dataclass(frozen=True)
class PlatformCompliance(Element):
    """The payload mount is a body on a bushing on the joints' plate.

    It carries the load, and the instrument reads it.

    Bushing: three stiffnesses (N/m) and three rotational ones (N m/rad), or a 6 x 6 matrix, in platform axes
    at the point `at_m` (m, platform frame). Under a wrench at that point the mount moves by w/k against the
    plate.
    """

    identifier: ClassVar[str] = "platform_compliance"
    stage: ClassVar[Stage] = Stage.BODIES
    stiffness: Sequence[float] | Matrix
    at_m: Sequence[float] = (0.0, 0.0, 0.0)

    def build(self, machine: Machine) -> None:
        at = np.asarray(self.at_m, dtype=float)
        mount = machine.engine.add_body(machine.robot.home, lambda platform: platform)
        machine.engine.add_bushing(Point(machine.mount, at), Point(mount, at), bushing_matrix(self.stiffness))
        machine.mount = mount


@dataclass(frozen=True)
class BaseCompliance(Element):
    """The base plate, with all base joints, is a body on a bushing on the ground.

    The instrument stands on the ground.

    Bushing as for `PlatformCompliance`, in the axes of O at the point `at_m` (m, in O).
    """

    identifier: ClassVar[str] = "base_compliance"
    stage: ClassVar[Stage] = Stage.BODIES
    stiffness: Sequence[float] | Matrix
    at_m: Sequence[float] = (0.0, 0.0, 0.0)

    def build(self, machine: Machine) -> None:
        at = np.asarray(self.at_m, dtype=float)
        base = machine.engine.add_body(np.zeros(3), machine.engine.ground.placement)
        machine.engine.add_bushing(Point(machine.base, at), Point(base, at), bushing_matrix(self.stiffness))
        machine.base = base


@dataclass(frozen=True)
class LegCoupling(Element):
    """Neighbouring legs stand on one mount body, so that the force in one deflects all.

    The mount stands on the base on a bushing.

    `legs`: their numbers (1 ...). Bushing as for `BaseCompliance`, at the middle of the legs' base joints.
    """

    identifier: ClassVar[str] = "leg_coupling"
    stage: ClassVar[Stage] = Stage.CARRIERS
    legs: Sequence[int]
    stiffness: Sequence[float] | Matrix

    def build(self, machine: Machine) -> None:
        indices = [leg - 1 for leg in self.legs]
        count = len(machine.legs)
        require(len(set(indices)) >= 2, "legs: leg coupling needs two legs or more")
        require(all(0 <= index < count for index in indices), f"legs: the robot has legs 1 ... {count}")
        joints = machine.robot.base_joints
        middle = joints[indices].mean(axis=0)
        under = machine.base_ends[indices[0]].body
        carrier = machine.engine.add_body(np.zeros(3), machine.engine.ground.placement)
        machine.engine.add_bushing(Point(under, middle), Point(carrier, middle), bushing_matrix(self.stiffness))
        for index in indices:
            machine.base_ends[index] = Point(carrier, joints[index])


ENDS = ("base", "platform")


@dataclass(frozen=True)
class PassiveJointCompliance(Element):
    """The mount of a leg's joint is a block on a bushing that yields differently along three directions.

    `stiffness_N_per_m`: three numbers along `axes`: `radial` (radially from the frame's z axis, tangentially,
    along z) or `frame` (x, y, z) of O for the base end, of P for the platform end; or a 3 x 3 matrix in them.
    """

    identifier: ClassVar[str] = "passive_joint_compliance"
    stage: ClassVar[Stage] = Stage.JOINTS
    component: str
    stiffness_N_per_m: Sequence[float] | Matrix
    end: str = "platform"
    axes: str = "radial"

    def __post_init__(self) -> None:
        require(self.end in ENDS, f"end: must be base or platform, not {self.end!r}")
        require(self.axes in ("radial", "frame"), f"axes: must be radial or frame, not {self.axes!r}")

    def build(self, machine: Machine) -> None:
        on_base = self.end == "base"
        joints = machine.robot.base_joints if on_base else machine.robot.platform_joints
        ends = machine.base_ends if on_base else machine.platform_ends
        stiffness = np.zeros((6, 6))
        given = np.asarray(self.stiffness_N_per_m, dtype=float)
        stiffness[:3, :3] = np.diag(given) if given.ndim == 1 else given
        stiffness[3:, 3:] = 1e4 * np.eye(3)  # nothing turns the block: the leg pulls at its centre
        for index in legs_of(self.component, len(machine.legs)):
            block = _block(machine, joints[index], on_base)
            axes = _radial_axes(joints[index]) if self.axes == "radial" else np.eye(3)
            point = Point(block, np.zeros(3))
            machine.engine.add_bushing(ends[index], point, stiffness, axes)
            ends[index] = point


def _block(machine: Machine, joint: Vector, on_base: bool) -> Body:
    if on_base:
        return machine.engine.add_body(joint, lambda _: Pose(joint, np.eye(3)))
    origin = machine.robot.home + joint
    return machine.engine.add_body(origin, lambda platform: Pose(platform.point(joint), platform.rotation))


def _radial_axes(joint: Vector) -> Matrix:
    radius = np.hypot(joint[0], joint[1])
    require(bool(radius > 0), "axes: a joint on the z axis has no radial direction; use frame")
    c, s = joint[0] / radius, joint[1] / radius
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class PassiveJointStiffness(Element):
    """Flexures instead of free joints: each end of a leg resists rotation.

    The stiffness `joint_Nm_per_rad` is the same about every axis.

    The leg becomes a rigid, telescoping strut that is pinned to both of its ends and joined to them by
    rotational springs, free of moment at the home pose. Bending, shear forces and torsion of the strut follow
    from that.
    """

    identifier: ClassVar[str] = "passive_joint_stiffness"
    stage: ClassVar[Stage] = Stage.STRUTS
    joint_Nm_per_rad: float
    component: str = "all legs"

    def __post_init__(self) -> None:
        require(self.joint_Nm_per_rad > 0, "joint_Nm_per_rad: must be positive")

    def build(self, machine: Machine) -> None:
        engine, robot = machine.engine, machine.robot
        rotational = np.diag([0.0, 0.0, 0.0, *[self.joint_Nm_per_rad] * 3])
        for index in legs_of(self.component, len(machine.legs)):
            start, end = robot.base_joints[index], robot.platform_joints[index]
            home = _direction(robot.pose(np.zeros(6)), start, end)

            def placement(platform: Pose, start: Vector = start, end: Vector = end, home: Vector = home) -> Pose:
                return Pose(start, rotation_between(home, _direction(platform, start, end)))

            strut = engine.add_body(start, placement)
            foot = Point(strut, np.zeros(3))
            head = Point(strut, robot.home + end - start)
            along = rotation_between(np.array([0.0, 0.0, 1.0]), home)
            engine.add_joint(machine.base_ends[index], foot, (1, 1, 1), np.eye(3))
            engine.add_joint(head, machine.platform_ends[index], (1, 1, 0), along)
            engine.add_bushing(machine.base_ends[index], foot, rotational)
            engine.add_bushing(head, machine.platform_ends[index], rotational)


def _direction(platform: Pose, start: Vector, end: Vector) -> Vector:
    span = platform.point(end) - start
    return np.asarray(span / np.linalg.norm(span))


@dataclass(frozen=True)
class GeometricStiffness(Element):
    """The change of geometry under load; it is always there.

    Every equilibrium is one of the loaded geometry, with or without this element.

    It shows at loads of tonnes or with soft legs: the deflection is (K_C + K_G)^-1 F instead of K_C^-1 F.
    """

    identifier: ClassVar[str] = "geometric_stiffness"


@dataclass(frozen=True)
class JointPositionError(Element):
    """A joint is off its nominal place by `[dx_m, dy_m, dz_m]` (m; base end: in O, platform end: in P).

    The controller does not know: it computes the leg lengths with the nominal geometry.
    """

    identifier: ClassVar[str] = "joint_position_error"
    component: str
    end: str = "base"
    dx_m: float = 0.0
    dy_m: float = 0.0
    dz_m: float = 0.0

    def __post_init__(self) -> None:
        require(self.end in ENDS, f"end: must be base or platform, not {self.end!r}")

    def true_geometry(self, robot: Robot) -> Robot:
        base, platform = robot.base_joints.copy(), robot.platform_joints.copy()
        moved = base if self.end == "base" else platform
        moved[legs_of(self.component, robot.legs)] += [self.dx_m, self.dy_m, self.dz_m]
        return robot.with_joints(base, platform)
