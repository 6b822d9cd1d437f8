"""Joints of a hexapod on circles, given by a radius and angles instead of coordinates.

The usual hexapod has its joints in three pairs, 120° apart, on a circle in the base and one in the platform. With
`half_angle_deg` h the joints of a pair lie h to either side of the pair's axis; legs run from joint i of the base to
joint i of the platform, whose pairs lie halfway between those of the base.
"""

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from expdesign.arrays import FloatArray
from expdesign.io.schema import Number, Positive, Section, invalid

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
        default=None, description="Angle of every joint about z (°)."
    )
    height_m: Number = Field(default=0.0, description="Height of the circle along z (m).")
    yaw_deg: Number = Field(default=0.0, description="Turn of the whole circle about z (°).")

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
