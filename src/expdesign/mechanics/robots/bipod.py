"""Planar bipod: two legs from two base points to one tool point (theory.md 2.1)."""

from typing import Annotated, Self

import casadi as ca
import numpy as np
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.coordinates import PLANAR
from expdesign.io.schema import Number, Positive, validate
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.drawing import Drawing, DrawnPart
from expdesign.mechanics.robots.hexapod import LimitsSection
from expdesign.mechanics.robots.parallel import StraightLegs
from expdesign.mechanics.robots.robot import RobotSection

Point = Annotated[list[Number], Field(min_length=2, max_length=2)]


class BipodSection(RobotSection):
    """A bipod's robot file."""

    axes = "xy"
    kind: str = Field(description="The word `bipod`.")
    home: Point = Field(description="Tool point in O at the zero pose (m).")
    base_joints: Annotated[list[Point], Field(min_length=2, max_length=2)] = Field(
        description="Joints on the base in O, a row per leg (m); both legs end at the tool point."
    )
    actuator_stiffness: Annotated[list[Positive], Field(min_length=2, max_length=2)] = Field(
        description="Approximate stiffness apK of each leg (N/m)."
    )
    limits: LimitsSection = Field(default=LimitsSection(), description="Limits of the legs.")


class Bipod(StraightLegs):
    """Two-leg planar robot; pose `[x, y]` of the tool point relative to `home`."""

    kind = "bipod"
    coordinates = PLANAR
    configuration = PLANAR.pose

    @classmethod
    def from_document(cls, document: YamlDocument) -> Self:
        section = validate(BipodSection, document)
        return cls(
            base_joints=np.array(section.base_joints),
            home=np.array(section.home),
            stiffness=np.array(section.actuator_stiffness),
            gravity=section.gravity_m_s2,
            leg_length=section.limits.pair(),
            name=section.name,
        )

    def rotation(self, pose: ca.SX) -> ca.SX:
        return ca.SX.eye(2)

    def scaling_frame(self) -> tuple[FloatArray, float]:
        return np.zeros(2), 1.0

    def reference_configuration(self) -> FloatArray:
        """The apex of an equilateral triangle on the base joints: a bipod's zero pose may lie on its base line."""
        first, second = self.base_joints
        span = second - first
        apex: FloatArray = (first + second) / 2.0 + np.sqrt(0.75) * np.array([-span[1], span[0]]) - self.home
        return apex

    def drawing(self, configurations: FloatArray) -> Drawing:
        origin = self.home + configurations
        base = np.broadcast_to(self.base_joints, (*origin.shape[:-1], 2, 2))
        points = np.concatenate([base, origin[..., None, :]], axis=-2)
        parts = (
            DrawnPart("base", "base", ((0, 1),)),
            DrawnPart("legs", "actuator", ((0, 2), (1, 2))),
            DrawnPart("tool point", "platform", ((2,),)),
        )
        return Drawing(points, origin, parts, dict(zip(self.actuators, parts[1].paths, strict=True)))
