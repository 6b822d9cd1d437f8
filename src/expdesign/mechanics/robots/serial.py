"""Serial robots: everything from one expression, the tip's pose T(q; geometry).

The joints yield about (or along) their axes, Δq = c∘τ, and the tip moves by the twist J·Δq. Its deflection is that
twist, the last three components a rotation vector in the axes of the base link, so that J̌ = J. Unlike a
parallel robot's, the Jacobian is finite everywhere: a serial robot is never singular in the sense of the linear
deflection model, and the scaled condition number is 1 at every configuration.

Own weight. A deflection is the difference between the loaded and the unloaded tip at the same command, and the robot's
own weight acts in both: it cancels from the linear model. It is kept where it does not cancel: `own_weight` is the
torque about every joint by the links' masses, which decides on which side of its play a joint rests and where on its
characteristic a non-linear joint works, and which makes the sag that absolute positions show.
"""

from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from expdesign.arrays import FloatArray, IntArray
from expdesign.coordinates import SPATIAL
from expdesign.io.nearest import nearest
from expdesign.io.schema import Number, Positive, validate
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.differentiation import plain
from expdesign.mechanics.robots.common_normals import on_common_normals
from expdesign.mechanics.robots.drawing import Drawing, DrawnPart
from expdesign.mechanics.robots.kinematic_tree import PAYLOAD_COLUMNS, TIP_COLUMN, KinematicTree
from expdesign.mechanics.robots.robot import CommandedState, Jacobians, Robot, RobotSection, gravity_or_standard
from expdesign.mechanics.robots.urdf import CouplingSection, coupled, leading, read_urdf, require_joint
from expdesign.mechanics.symbolic import BatchFunction

Range = Annotated[list[Number], Field(min_length=2, max_length=2)]


class SerialSection(RobotSection):
    """A serial robot's file."""

    kind: str = Field(description="The word `serial`.")
    urdf: str = Field(
        description="URDF file with kinematics and masses. Origins of joints whose offsets cancel along parallel axes "
        "count at the common normals."
    )
    base_link: str = Field(description="Link that is fixed to the ground; its frame is O.")
    tip_link: str | Annotated[list[str], Field(min_length=1)] = Field(
        description="Link whose deflection counts; its frame is P. Where there are several, the column `tip` names "
        "the link of a row."
    )
    actuator_stiffness: list[Positive] | None = Field(
        default=None,
        description="Approximate stiffness apK of each joint that moves the tip, in the order of the chain (N·m/rad "
        "or N/m). Default: joints are rigid, only geometry is identified.",
    )
    limits: dict[str, Range] = Field(
        default_factory=dict,
        description="Limits `[low, high]` by joint coordinate (`q1_rad`, `q2_m`; rad or m). Default: those of the "
        "URDF.",
    )

    branch_joints: list[str] = Field(
        default_factory=list,
        description="Joints off the chain that are columns of recordings, `NAME_rad` or `NAME_m`. Others stand at "
        "zero, or at the nearest limit.",
    )
    payload_links: list[str] = Field(
        default_factory=list,
        description="Links that carry payloads in addition to the load on the tip, with columns `NAME_mass_kg`, "
        "`NAME_com_x_m`, `NAME_com_y_m`, `NAME_com_z_m` (in the link's frame).",
    )
    couplings: dict[str, CouplingSection] = Field(
        default_factory=dict,
        description="Joints that follow others linearly, by name: `elbow: {follows: {shoulder: -1.0, motor: 1.0}}`. "
        "They replace the URDF's `<mimic>`.",
    )


class SerialRobot(Robot):
    """A chain of revolute and prismatic joints; configuration `q1_rad` (or `q1_m`), `q2_rad`, ...

    Attributes:
        tree: the kinematics, with all geometric errors.
        low, high: limits of the joint coordinates (rad or m), infinite where there are none, shape (n_q,).
    """

    kind = "serial"
    jointed = True
    may_idle = True
    coordinates = SPATIAL

    def __init__(
        self,
        tree: KinematicTree,
        stiffness: FloatArray,
        *,
        gravity: ArrayLike | None = None,
        limits: dict[str, tuple[float, float]] | None = None,
        name: str = "serial robot",
    ) -> None:
        """See file-formats.md, Robot files; `stiffness` has one entry per coordinate (N·m/rad or N/m).

        `limits` (by column) narrow those of the URDF.
        """
        self.name = name
        self.tree = tree
        self.stiffness = np.asarray(stiffness, dtype=float)
        self.gravity = gravity_or_standard(gravity, 3)
        self.configuration = configuration_names(tree)
        whole = (*tree.coordinates, *tree.branch_coordinates)
        further = len(self.configuration) - len(whole)
        self.low = np.array([*(coordinate.low for coordinate in whole), *[-np.inf] * further])
        self.high = np.array([*(coordinate.high for coordinate in whole), *[np.inf] * further])
        for column, (low, high) in (limits or {}).items():
            index = self.configuration.index(column)
            self.low[index], self.high[index] = max(low, self.low[index]), min(high, self.high[index])

    @classmethod
    def from_document(cls, document: YamlDocument) -> Self:
        section = validate(SerialSection, document)
        tree = _tree(section, section.where("urdf").file)
        names = configuration_names(tree)
        stiffness = section.actuator_stiffness or [np.inf] * len(tree.coordinates)
        if len(stiffness) != len(tree.coordinates):
            joints = ", ".join(f"{n}: {c.joint}" for n, c in zip(names, tree.coordinates, strict=False))
            what = f"{len(tree.coordinates)} values are needed here, not {len(stiffness)}"
            raise section.where("actuator_stiffness").fault(what, f"Order: {joints}.")
        for column, (low, high) in section.limits.items():
            place = section.where("limits", column)
            if column not in names:
                raise place.fault("unknown coordinate", f"Known here: {', '.join(names)}.")
            if low >= high:
                raise place.fault(f"the limits are the wrong way round: {low:g} ≥ {high:g}", "Write `[low, high]`.")
        return cls(
            tree,
            np.array(stiffness),
            gravity=section.gravity_m_s2,
            limits={column: (low, high) for column, (low, high) in section.limits.items()},
            name=section.name,
        )

    @property
    def actuators(self) -> tuple[str, ...]:
        return tuple(f"joint {k + 1}" for k in range(len(self.stiffness)))

    @property
    def actuator_limits(self) -> tuple[FloatArray, FloatArray]:
        return self.low[: len(self.stiffness)], self.high[: len(self.stiffness)]

    @property
    def effort(self) -> FloatArray | None:
        limits = {joint.name: joint.effort for joint in self.tree.chain}
        return np.array([limits.get(coordinate.joint, np.inf) for coordinate in self.tree.coordinates])

    @property
    def units(self) -> tuple[str, ...]:
        return tuple(coordinate.unit for coordinate in self.tree.coordinates)

    @property
    def links(self) -> "SerialRobot":
        return self

    def actuator_coordinates(self, configurations: FloatArray) -> FloatArray:
        return configurations[..., : len(self.stiffness)]

    def tip_numbers(self, configurations: FloatArray) -> IntArray:
        several = len(self.tree.tips) > 1
        return configurations[..., -1].astype(np.int64) if several else super().tip_numbers(configurations)

    def frame(self, configuration: ca.SX, deflection: ca.SX, geometry: ca.SX | None = None) -> tuple[ca.SX, ca.SX]:
        """To second order in the rotation of the deflection, which is a twist."""
        position, rotation = self.tip(configuration, geometry)
        turn = ca.skew(deflection[3:])
        return position + deflection[:3], (ca.SX.eye(3) + turn + 0.5 * (turn @ turn)) @ rotation

    def tip(self, q: ca.SX, geometry: ca.SX | None = None) -> tuple[ca.SX, ca.SX]:
        """Position (3,) in m and orientation R (3×3) of the tip in the base link's frame.

        Args:
            q: coordinates (n_q,).
            geometry: geometric errors in the order of `tree.geometry_names`, or None for none.
        """
        pose = self.tree.tip_pose(q, geometry)
        return pose[:3, 3], pose[:3, :3]

    def jacobian_expressions(self, configuration: ca.SX, geometry: ca.SX | None = None) -> tuple[ca.SX, ca.SX, ca.SX]:
        """J, J̌ = J and R."""
        forward = self.tree.jacobian(configuration, geometry)
        return forward, forward, self.tip(configuration, geometry)[1]

    def commanded_state(self, configuration: ca.SX, gravity: ca.SX) -> CommandedState:
        position, _ = self.tip(configuration)
        own = self.own_weight_expression(configuration, gravity)
        return CommandedState(position, ca.SX.eye(self.coordinates.n), configuration[: len(self.stiffness)], own)

    def own_weight_expression(
        self, q: ca.SX, gravity: ca.SX, geometry: ca.SX | None = None, factors: ca.SX | None = None
    ) -> ca.SX:
        """Torques about the joints by the links' own weight, τ_g = ∂(gᵀ·Σ m·p)/∂q (N·m or N), shape (n_q,).

        Args:
            q: coordinates (n_q,).
            gravity: in the base link's axes (m/s²), shape (3,).
            geometry: geometric errors, or None.
            factors: true over nominal masses of link 1, ..., n_q, or None.
        """
        weight = self.tree.weight(q, geometry, factors, payloads=factors is None)[1:]
        return ca.gradient(ca.dot(gravity, weight), q)[: len(self.tree.coordinates)]

    def kinematics(self, configuration: ca.SX) -> list[ca.SX]:
        forward, _, rotation = self.jacobian_expressions(configuration)
        return [forward, rotation]

    @cached_property
    def _drawn(self) -> BatchFunction:
        q = ca.SX.sym("q", len(self.configuration))
        poses = self.tree.forward(q)
        names = [name for path in self.tree.paths for name in (self.tree.base, *(joint.child for joint in path))]
        axes = [poses[joint.child][:3, :3] @ ca.SX(joint.axis) for joint in self.tree.joints]
        points = ca.horzcat(*(poses[name][:3, 3] for name in names)).T
        return BatchFunction("serial_drawing", [q], [points, ca.horzcat(*axes).T])

    @cached_property
    def _place(self) -> BatchFunction:
        q = ca.SX.sym("q", len(self.configuration))
        return BatchFunction("serial_place", [q], [self.tip(q)[0]])

    @cached_property
    def _weights(self) -> BatchFunction:
        q, gravity = ca.SX.sym("q", len(self.configuration)), ca.SX.sym("g", 3)
        return BatchFunction("serial_weight", [q, gravity], [self.own_weight_expression(q, gravity)])

    def own_weight(self, configurations: FloatArray, gravity: FloatArray) -> FloatArray:
        (torques,) = self._weights(configurations, gravity)
        return torques

    @cached_property
    def _moments(self) -> BatchFunction:
        q = ca.SX.sym("q", len(self.configuration))
        position, _ = self.tip(q)
        weight = self.tree.weight(q)
        return BatchFunction("serial_moments", [q], [weight[0], weight[1:] - weight[0] * position])

    def weight_wrench(self, configurations: FloatArray, gravity: FloatArray) -> FloatArray:
        mass, lever = self._moments(configurations)
        force = np.broadcast_to(np.reshape(mass, (*lever.shape[:-1], 1)) * gravity, lever.shape)
        moment: FloatArray = np.cross(lever, np.broadcast_to(gravity, lever.shape))
        return np.concatenate([force, moment], axis=-1)

    def jacobians_of(self, *kinematics: FloatArray) -> Jacobians:
        forward, rotation = kinematics
        # The column of a single joint comes back as a vector.
        forward = forward.reshape(*rotation.shape[:-2], 6, len(self.stiffness))
        return Jacobians(forward, forward, rotation, partial(_condition, plain(forward)))

    def position(self, configurations: FloatArray) -> FloatArray:
        position: FloatArray = self._place(configurations)[0]
        return position

    def reference_configuration(self) -> FloatArray:
        """Zero, or the middle of the limits where they exclude it."""
        within = (self.low <= 0.0) & (self.high >= 0.0)
        reference: FloatArray = np.where(within, 0.0, 0.5 * (np.nan_to_num(self.low) + np.nan_to_num(self.high)))
        return reference

    def limited(self, configurations: FloatArray) -> FloatArray:
        return configurations

    @property
    def limits(self) -> tuple[FloatArray, FloatArray]:
        return self.low, self.high

    def _limited_by(self, index: int) -> tuple[str, str]:
        coordinate = (*self.tree.coordinates, *self.tree.branch_coordinates)[index]
        return f"joint {index + 1} (`{coordinate.joint}`) would stand", coordinate.unit

    def drawing(self, configurations: FloatArray) -> Drawing:
        points, axes = self._drawn(configurations)
        axes = axes.reshape(*points.shape[:-2], len(self.actuators), 3)  # that of a single joint comes back as a vector
        lines: tuple[list[tuple[int, ...]], ...] = ([], [], [])
        components: dict[str, tuple[int, ...]] = {}
        numbers = {joint.name: number for number, joint in enumerate(self.tree.joints, 1)}
        start = 0
        for path in self.tree.paths:
            moving = [start + i for i, joint in enumerate(path) if self.tree.motion(joint) is not None]
            ends = (start, moving[0] + 1, moving[-1] + 1, start + len(path))
            for line, first, last in zip(lines, ends, ends[1:], strict=False):
                line.append(tuple(range(first, last + 1)))
            at = {numbers[joint.name]: start + i for i, joint in enumerate(path, 1) if joint.name in numbers}
            for (number, first), last in zip(at.items(), (*list(at.values())[1:], start + len(path)), strict=True):
                components.setdefault(f"joint {number}", (first,))
                components.setdefault(f"link {number}", tuple(range(first, last + 1)))
            start += len(path) + 1
        base, links, tips = (tuple(line) for line in lines)
        parts = (
            DrawnPart("base", "base", base),
            DrawnPart("links", "actuator", links),
            DrawnPart("tip", "platform", tips),
        )
        directions = {name: axes[..., k, :] for k, name in enumerate(self.actuators)}
        return Drawing(points, self.position(configurations), parts, components, directions)


def configuration_names(tree: KinematicTree) -> tuple[str, ...]:
    """Columns of the joint coordinates: `q1_rad` or `q1_m`, ... of the chain, then those of branches by their names.

    What links carry follows, and `tip` where there are several.
    """
    chain = tuple(f"q{k + 1}_{coordinate.unit}" for k, coordinate in enumerate(tree.coordinates))
    branches = tuple(f"{coordinate.joint}_{coordinate.unit}" for coordinate in tree.branch_coordinates)
    payloads = tuple(f"{carrier}_{column}" for carrier in tree.carriers for column in PAYLOAD_COLUMNS)
    return (*chain, *branches, *payloads, *((TIP_COLUMN,) if len(tree.tips) > 1 else ()))


def _tree(section: SerialSection, path: Path) -> KinematicTree:
    """The kinematics that a robot file describes."""
    urdf = coupled(read_urdf(path), section.couplings)
    for index, name in enumerate(section.branch_joints):
        place = section.where("branch_joints", index)
        joint = require_joint(urdf, name, str(place))
        if joint.mimics:
            leaders = " and ".join(f"`{leader}`" for leader in leading(urdf, joint).multipliers)
            raise place.fault(f"joint `{name}` follows {leaders}", f"Name {leaders} instead.")
    tips = [section.tip_link] if isinstance(section.tip_link, str) else section.tip_link
    for key, names in (("tip_link", tips), ("payload_links", section.payload_links)):
        twice = next((name for index, name in enumerate(names) if name in names[:index]), None)
        if twice is not None:
            raise section.where(key).fault(f"link `{twice}` is named twice", "Take it out.")
    tree = KinematicTree(urdf, section.base_link, tips, section.branch_joints, section.payload_links)
    for index, name in enumerate(section.payload_links):
        if not tree.carries(name):
            remedy = nearest(name, [link for link in urdf.links if tree.carries(link)])
            raise section.where("payload_links", index).fault(f"no joint of the robot moves a link `{name}`", remedy)
    chain = {coordinate.joint for coordinate in tree.coordinates}
    for index, name in enumerate(section.branch_joints):
        if name in chain or name in section.branch_joints[:index]:
            what = f"joint `{name}` is " + ("on the chain from base to tip" if name in chain else "named twice")
            raise section.where("branch_joints", index).fault(what, "Take it out.")
    near = on_common_normals(urdf, section.base_link, [*tips, *section.payload_links])
    if near is urdf:
        return tree
    return KinematicTree(near, section.base_link, tips, section.branch_joints, section.payload_links)


def _condition(forward: FloatArray) -> FloatArray:
    """1 where the kinematics are numbers: an arm has no pose at which its chain fails."""
    return np.where(np.isfinite(forward).all(axis=(-2, -1)), 1.0, np.inf)
