"""Hexapod (Gough-Stewart platform): six legs of any placement between base and platform (theory.md 2.2).

Joints of a hexapod on circles, given by a radius and angles instead of coordinates.

The usual hexapod has its joints in three pairs, 120° apart, on a circle in the base and one in the platform. With
`half_angle_deg` h the joints of a pair lie h to either side of the pair's axis; legs run from joint i of the base to
joint i of the platform, whose pairs lie halfway between those of the base.
"""

from typing import Annotated, Self

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from expdesign.arrays import FloatArray
from expdesign.coordinates import SPATIAL
from expdesign.io.schema import Number, Positive, Section, invalid, validate
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.drawing import Drawing, DrawnPart
from expdesign.mechanics.robots.orientation import Orientation, rotation_matrix
from expdesign.mechanics.robots.parallel import StraightLegs
from expdesign.mechanics.robots.robot import RobotSection

_PAIRS = np.array([0.0, 120.0, 240.0])


class RingSection(Section):
    """`base` or `platform` of a hexapod: six joints on a circle about z."""

    radius_m: Positive = Field(description="Radius of the circle (m).")
    half_angle_deg: Annotated[Number, Field(gt=0.0, lt=60.0)] | None = Field(
        default=None,
        description="Half the angle between the joints of a pair (°), the platform's pairs halfway between the base's; "
        "or `angles_deg`.",
    )
    angles_deg: Annotated[list[Number], Field(min_length=6, max_length=6)] | None = Field(
        default=None, description="Angle of each joint about z (°)."
    )
    height_m: Number = Field(default=0.0, description="Height of the circle along z (m).")
    yaw_deg: Number = Field(default=0.0, description="Rotation of the circle about z (°).")

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if (self.half_angle_deg is None) == (self.angles_deg is None):
            raise invalid(
                "exactly one of `half_angle_deg` and `angles_deg` is needed",
                remedy="Three pairs of joints (`half_angle_deg: 10`), or the angle of every joint.",
            )
        return self

    def joints(self, *, platform: bool) -> FloatArray:
        """Coordinates of the joints (m), one row per leg, shape (6, 3)."""
        if self.angles_deg is not None:
            angles = np.array(self.angles_deg)
        else:
            assert self.half_angle_deg is not None
            half = self.half_angle_deg
            pairs = np.repeat(_PAIRS, 2)
            # Leg 2k of the base's pair k runs to the platform's pair before it, leg 2k+1 to the one behind it.
            side = np.tile([-1.0, 1.0], 3)
            angles = pairs + side * (60.0 - half if platform else half)
        turned = np.radians(angles + self.yaw_deg)
        return np.stack(
            [self.radius_m * np.cos(turned), self.radius_m * np.sin(turned), np.full(6, self.height_m)], axis=1
        )


Point = Annotated[list[Number], Field(min_length=3, max_length=3)]
SixPoints = Annotated[list[Point], Field(min_length=6, max_length=6)]


class LimitsSection(Section):
    """`limits` of a parallel robot's file."""

    leg_length: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="Shortest and longest leg, `[low, high]` (m). Default: no limits."
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.leg_length is not None and self.leg_length[0] >= self.leg_length[1]:
            message = (
                f"the shortest leg ({self.leg_length[0]:g}) is not shorter than the longest ({self.leg_length[1]:g})"
            )
            raise invalid(message, "leg_length", "Write `[shortest, longest]` in m.")
        return self

    def pair(self) -> tuple[float, float] | None:
        """`leg_length` as a tuple."""
        return None if self.leg_length is None else (self.leg_length[0], self.leg_length[1])


class HexapodSection(RobotSection):
    """A hexapod's robot file."""

    kind: str = Field(description="The word `hexapod`.")
    orientation: Orientation = Field(
        default="fixed-xyz",
        description="`fixed-xyz`: R = Rz·Ry·Rx; `moving-xyz`: R = Rx·Ry·Rz.",
    )
    home: Point = Field(description="Origin of P in O at the zero pose (m).")
    base_joints: SixPoints | None = Field(
        default=None, description="Joints on the base in O, a row per leg (m); or `base`."
    )
    platform_joints: SixPoints | None = Field(
        default=None, description="Joints on the platform in P, a row per leg (m); or `platform`."
    )
    base: RingSection | None = Field(default=None, description="Joints on the base by radius and angles.")
    platform: RingSection | None = Field(default=None, description="Joints on the platform by radius and angles.")
    actuator_stiffness: Annotated[list[Positive], Field(min_length=6, max_length=6)] = Field(
        description="Approximate stiffness apK of each leg (N/m)."
    )
    limits: LimitsSection = Field(default=LimitsSection(), description="Limits of the legs.")

    @model_validator(mode="after")
    def _joints_once(self) -> Self:
        for name, ring in (("base", self.base), ("platform", self.platform)):
            if (ring is None) == (getattr(self, f"{name}_joints") is None):
                what = "the key is missing" if ring is None else f"the joints are also given as `{name}`"
                raise invalid(
                    what, f"{name}_joints", f"Give `{name}_joints` (m), or `{name}` with a radius and angles."
                )
        return self

    def joints(self) -> tuple[FloatArray, FloatArray]:
        """Base joints in O and platform joints in P (m), shape (6, 3) each."""
        base = np.array(self.base_joints) if self.base is None else self.base.joints(platform=False)
        platform = np.array(self.platform_joints) if self.platform is None else self.platform.joints(platform=True)
        return base, platform


class Hexapod(StraightLegs):
    """Six-leg parallel robot; pose `[x, y, z, rx, ry, rz]` relative to `home`."""

    kind = "hexapod"
    orientation: Orientation
    coordinates = SPATIAL
    configuration = SPATIAL.pose

    @classmethod
    def from_document(cls, document: YamlDocument) -> Self:
        section = validate(HexapodSection, document)
        base, platform = section.joints()
        return cls(
            base_joints=base,
            platform_joints=platform,
            home=np.array(section.home),
            stiffness=np.array(section.actuator_stiffness),
            orientation=section.orientation,
            gravity=section.gravity_m_s2,
            leg_length=section.limits.pair(),
            name=section.name,
        )

    def rotation(self, pose: ca.SX) -> ca.SX:
        return rotation_matrix(pose[3:6], self.orientation)

    def scaling_frame(self) -> tuple[FloatArray, float]:
        centre: FloatArray = self.platform_joints.mean(axis=0)
        spread = float(np.sqrt(((self.platform_joints - centre) ** 2).sum(axis=1).mean()))
        return centre, spread or 1.0

    def drawing(self, configurations: FloatArray) -> Drawing:
        origin = self.home + configurations[..., :3]
        rotation = self.jacobians(configurations).rotation
        platform = origin[..., None, :] + self.platform_joints @ rotation.swapaxes(-1, -2)
        points = np.concatenate([np.broadcast_to(self.base_joints, platform.shape), platform], axis=-2)
        parts = (
            DrawnPart("base", "base", ((*range(6), 0),)),
            DrawnPart("legs", "actuator", tuple((leg, leg + 6) for leg in range(6))),
            DrawnPart("platform", "platform", ((*range(6, 12), 6),)),
        )
        return Drawing(points, origin, parts, dict(zip(self.actuators, parts[1].paths, strict=True)))
