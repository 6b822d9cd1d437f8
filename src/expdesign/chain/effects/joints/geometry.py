"""Geometry of an arm: zeros of joints and frames of links that are not in place, and its change under load."""

from enum import StrEnum
from typing import ClassVar

import casadi as ca

from expdesign.chain.component import (
    ALL_JOINTS,
    GEOMETRY,
    Component,
    Part,
    each_joint,
    each_link,
    on,
    on_any,
    turned_lever,
    yielded,
)
from expdesign.chain.declaration import LOOSELY, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter, Values
from expdesign.chain.effects.legs.geometry import GeometricStiffness
from expdesign.chain.form import Form
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSITIONS, LoadedPoints, Measurand
from expdesign.chain.row import Row
from expdesign.mechanics.robots.kinematic_tree import FRAME_AXES
from expdesign.mechanics.robots.orientation import rotation_vector
from expdesign.mechanics.robots.robot import Robot

ANGLE, LENGTH = 2e-3, 5e-4
"""rad, m; how well joints are zeroed and links are made (standard deviation), before anything is measured."""
MADE = "assumed: zeros set by marks and castings machined to 2 mrad and 0.5 mm, not calibrated"


class GeometricError(Effect):
    """Geometry of an arm, as its positions show it: zeros of joints, and frames of links that are not in place.

    Components: `joint k` (its zero), `all joints` (all zeros), `link k` (the frame at its far end, six motions),
    `geometry` (all zeros and all links). What the pose of the instrument or the place of a marker can stand for does
    not show and costs nothing; what remains loosely determined is held by how well machines are made (`spread`).
    """

    identifier = "joints.geometric_error"
    physics = "joint_position_error"
    declared = Declaration(
        left_out="a joint or link not where the geometry has it",
        phrase="wrong geometry at {component}",
        usually="drawings, castings and zeros set by marks",
        port="geometry",
        inputs=(Input.PLACE,),
        sizes=(Size("*_rad", ANGLE, MADE), Size("*_m", LENGTH, MADE)),
    )
    measurands: ClassVar[tuple[Measurand, ...]] = (POSITIONS,)

    at = on(lambda robot: robot.jointed, each_joint, ALL_JOINTS, each_link, GEOMETRY)

    @property
    def indices(self) -> list[int]:
        """Which geometric errors of the tree (`KinematicTree.geometry_names`) its parameters are."""
        robot = self.robot.links
        count = len(self.robot.stiffness)
        if self.component == ALL_JOINTS:
            return list(range(count))
        if self.component == GEOMETRY:
            # The base's frame (the first end of link 0) is the instrument's.
            return [*range(count), *range(robot.tree.link_frames(0)[0] + len(FRAME_AXES), robot.tree.size)]
        if self.component.part is Part.JOINT:
            return [self.component.index]
        frames = robot.tree.link_frames(self.component.number)
        return [start + axis for start in frames for axis in range(len(FRAME_AXES))]

    def describe(self) -> tuple[Parameter, ...]:
        count, found = len(self.robot.stiffness), []
        for index in self.indices:
            angle = self.robot.units[index] == "rad" if index < count else (index - count) % len(FRAME_AXES) >= 3
            name = f"{self.robot.links.tree.geometry_names[index].replace(' ', '_')}_{'rad' if angle else 'm'}"
            spread = LOOSELY * (ANGLE if angle else LENGTH)
            found.append(Parameter(name, 1e-3, low=-50.0 * spread, high=50.0 * spread, spread=spread))
        return tuple(found)

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        changed = ca.SX(geometry)
        for position, index in enumerate(self.indices):
            changed[index] += theta[position]
        return changed

    def sentence(self, values: Values) -> str:
        if len(values) > 1:
            return f"The geometry differs from the robot file's: {self.component}, {len(values)} parameters."
        unit = "mrad" if next(iter(values)).endswith("_rad") else "mm"
        return self.said(f"The zero of {{component}} is off by {{first:1e3 .3g}} {unit}.", values)


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
    """All zeros and frames that a calibration of an arm identifies from absolute readings (`geometry`).

    The frame of joint k is moved by six small motions from where the URDF has it: x, y, z along, then a rotation
    Rz·Ry·Rx about, the axes that the joint's `<origin>` gives at coordinate zero. `link k` in the names is the link at
    whose far end the frame lies, so that joint k + 1 sits there (`mechanics/robots/kinematic_tree.py`). In a URDF with
    the motion E the `<origin>` is `origin·E` (`estimation/corrected_urdf.py`). Weights and levers act on the true
    geometry, so that a robot whose file has the identified geometry predicts the same.
    """

    identifier = "joints.calibrated_geometry"

    measurands = ()
    forms = tuple(LinkFrames)
    changes_geometry = True

    at = on(lambda robot: robot.jointed, GEOMETRY)

    @property
    def indices(self) -> list[int]:
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

    def own_weight_change(self, row: Row, theta: ca.SX) -> ca.SX:
        robot = self.robot.links
        geometry = self.geometry(ca.SX.zeros(robot.tree.size), theta)
        nominal = robot.own_weight_expression(row.pose, row.gravity)
        return robot.own_weight_expression(row.pose, row.gravity, geometry) - nominal

    def sentence(self, values: Values) -> str:
        return f"Zeros and frames of the joints differ from the URDF's: {len(values)} parameters were identified."


class ArmGeometryError(GeometricError):
    """An arm's geometry is not the nominal one: a joint's zero is off, or a link's far end not where it should be.

    `joint k`: offset of its zero. `link k`: true minus nominal frame at its far end, in that frame (m, rad). In
    deflections it shows through the levers.
    """

    identifier = "joints.position_error"
    measurands = (DEFLECTIONS,)
    forms = (Form(name="offset"), Form(name="frame"))
    changes_geometry = True

    at = on_any(each_joint, each_link)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        return [(component, cls.forms[component.part is Part.LINK]) for component in cls.components(robot)]

    def describe(self) -> tuple[Parameter, ...]:
        if self.component.part is Part.JOINT:
            return self.described([Parameter("offset_{motion}", 1e-3, low=-0.5, high=0.5)])
        units = [
            ("m", 0.1, LOOSELY * LENGTH) if len(axis) == 1 else ("rad", 0.5, LOOSELY * ANGLE) for axis in FRAME_AXES
        ]
        further = [f"{end.name}_" for end in self.robot.links.tree.ends if end.link == self.component.number][1:]
        return tuple(
            Parameter(f"frame_{end}{axis}_{unit}", 1e-3, low=-high, high=high, spread=spread)
            for end in ("", *further)
            for axis, (unit, high, spread) in zip(FRAME_AXES, units, strict=True)
        )

    def sentence(self, values: Values) -> str:
        if self.component.part is Part.JOINT:
            return super().sentence(values)
        text = "The far end of {component} is not where it should be: ({all:1e3 .2f}) mm and mrad in its own frame."
        return self.said(text, values)


_PASSES = 2


class ArmGeometricStiffness(Effect):
    """The change of an arm's geometry under load, by its own weight as well as by the payload's (theory.md 2.3).

    The joints stand in equilibrium where they are, not where they were sent: δ = c∘(τ_g(q + δ) + J(q + δ)ᵀF(q + δ)),
    with and without the load. The deflection is the difference of the two poses; a payload's weight keeps its direction
    while its lever turns with the tip. Two passes from δ = 0 give it to second order. `fraction` of the correction: 1
    is what mechanics asks for, 0 the base model.
    """

    identifier = "joints.geometric_stiffness"
    physics = "geometric_stiffness"
    declared = GeometricStiffness.declared
    measurands = (DEFLECTIONS,)

    at = on(lambda robot: robot.jointed, GEOMETRY)
    quantities = (Parameter("fraction", 1.0, low=-5.0, high=5.0),)
    says = "The arm's geometry changes noticeably under load: {fraction:.2f} of what mechanics predicts."

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        reference = row.absolute - row.wrench
        before, turned_before = self._equilibrium(reference, compliance, row, turns=False)
        after, turned_after = self._equilibrium(reference + wrench, compliance, row, turns=True)
        whole = ca.vertcat(after - before, rotation_vector(turned_after @ turned_before.T))
        linear = row.pose_map @ (compliance * (row.forward.T @ wrench))
        return deflection + theta[0] * (whole - linear)

    def _equilibrium(self, wrench: ca.SX, compliance: ca.SX, row: Row, *, turns: bool) -> tuple[ca.SX, ca.SX]:
        """Position and orientation of the tip in equilibrium under a wrench given at the commanded pose, of which a
        payload's lever `turns`.
        """
        robot = self.robot.links
        q = ca.SX.sym("q", len(self.robot.configuration))
        forward, _, rotation = robot.jacobian_expressions(q)
        turned = wrench + turned_lever(rotation, row, wrench) if turns else wrench
        torque = robot.own_weight_expression(q, row.gravity) + forward.T @ turned
        at = row.pose
        for _ in range(_PASSES):
            at = yielded(row.pose, compliance * ca.substitute(torque, q, at))
        return robot.tip(at)
