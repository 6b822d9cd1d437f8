"""Body: one rigid body standing on something, a machine on its feet or the tip of a column.

It has no actuators, so that the base model does not deflect at all; whatever it deflects under load is physics that
`diagnose` finds. Its pose says where it is; where poses differ between rows (a column that lifts), what it stands on
may yield differently there.
"""

from functools import partial
from typing import Annotated, Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.coordinates import SPATIAL
from expdesign.io.schema import Number, validate
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.orientation import Orientation, rotation_matrix
from expdesign.mechanics.robots.parallel import PosedRobot
from expdesign.mechanics.robots.robot import Jacobians, RobotSection, gravity_or_standard

Point = Annotated[list[Number], Field(min_length=3, max_length=3)]


class BodySection(RobotSection):
    """A body's robot file."""

    kind: str = Field(description="The word `body`.")
    orientation: Orientation = Field(
        default="fixed-xyz",
        description="`fixed-xyz`: R = Rz·Ry·Rx; `moving-xyz`: R = Rx·Ry·Rz.",
    )
    home: Point = Field(
        default_factory=lambda: [0.0, 0.0, 0.0],
        description="Origin of P in O at the zero pose (m). Default: the origin of O.",
    )


class Body(PosedRobot):
    """A rigid body without actuators; pose `[x, y, z, rx, ry, rz]` relative to `home`.

    Attributes:
        orientation: how the angles of a pose make R.
    """

    kind = "body"
    on_support = True
    coordinates = SPATIAL
    configuration = SPATIAL.pose

    def __init__(
        self,
        *,
        home: FloatArray | None = None,
        orientation: Orientation = "fixed-xyz",
        gravity: ArrayLike | None = None,
        name: str = "body",
    ) -> None:
        self.name = name
        self.home = np.zeros(3) if home is None else np.asarray(home, dtype=float)
        self.orientation: Orientation = orientation
        self.stiffness = np.zeros(0)
        self.gravity = gravity_or_standard(gravity, 3)

    @classmethod
    def from_document(cls, document: YamlDocument) -> Self:
        section = validate(BodySection, document)
        return cls(
            home=np.array(section.home),
            orientation=section.orientation,
            gravity=section.gravity_m_s2,
            name=section.name,
        )

    def rotation(self, pose: ca.SX) -> ca.SX:
        return rotation_matrix(pose[3:6], self.orientation)

    def jacobian_expressions(self, configuration: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        return ca.SX.zeros(6, 0), ca.SX.zeros(6, 0), self.rotation(configuration)

    def kinematics(self, configuration: ca.SX) -> list[ca.SX]:
        return [self.rotation(configuration), self.pose_rate_map(configuration)]

    def jacobians_of(self, *kinematics: FloatArray) -> Jacobians:
        batch = kinematics[0].shape[:-2]
        nothing = np.zeros((*batch, 6, 0))
        return Jacobians(nothing, nothing, kinematics[0], partial(np.ones, batch))

    def pose_rates(self, configurations: FloatArray) -> FloatArray:
        return self._kinematics(configurations)[1]

    def actuator_coordinates(self, configurations: FloatArray) -> FloatArray:
        return np.zeros((*configurations.shape[:-1], 0))
