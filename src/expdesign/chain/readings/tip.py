"""Where the tip of an arm is: what commands are found with, in the place of an instrument's reading.

The chain ends with the tip's position and the rotation vector of R·Aᵀ, A being the orientation that it shall have
(`Row.aim`), along the axes of O or of the instrument. Unknowns are those of the reading that the model was identified
with, so that its values and covariance serve as they are.
"""

from dataclasses import dataclass
from typing import Literal

import casadi as ca

from expdesign.arrays import FloatArray
from expdesign.chain.parameter import Parameter
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.readings.reading import Reading
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.recordings.remark import Remark
from expdesign.chain.row import Row
from expdesign.mechanics.moments import in_space
from expdesign.mechanics.robots.orientation import rotation_matrix, rotation_vector
from expdesign.mechanics.robots.robot import Robot

Frame = Literal["base", "instrument"]


@dataclass(frozen=True)
class TipPose(Reading):
    """The tip's pose.

    Attributes:
        identified: the reading of the model.
        frame: along whose axes.
    """

    identified: Reading
    frame: Frame = "base"
    oriented = ("tip",)
    by_instrument = False
    linear = False

    @property
    def names(self) -> tuple[str, ...]:  # type: ignore[override]
        return self.identified.names

    @property
    def start(self) -> FloatArray:  # type: ignore[override]
        return self.identified.start

    @property
    def absolute(self) -> bool:  # type: ignore[override]
        return self.identified.absolute

    @property
    def compliance_spread(self) -> float:  # type: ignore[override]
        return self.identified.compliance_spread

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.identified.parameters

    @property
    def degeneracies(self) -> list[Remark]:
        return []

    @property
    def record(self) -> dict[str, object]:
        return {}

    def width(self, robot: Robot) -> int:
        return 6

    def with_own_weight(self, row: Row, change: ca.SX) -> Row:
        return self.identified.with_own_weight(row, change)

    def released(self, spreads: FloatArray) -> FloatArray:
        return spreads

    def at_points(self, points: LoadedPoints) -> LoadedPoints | None:
        return points

    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        position, rotation = in_space(*robot.frame(row.pose, deflection, geometry))
        if self.frame == "instrument":
            assert isinstance(self.identified, MarkerPosition)
            known = self.identified.instrument
            frame = theta[:6] if known is None else ca.SX(known)
            instrument = rotation_matrix(frame[3:6], "fixed-xyz")
            position, rotation = instrument.T @ (position - frame[:3]), instrument.T @ rotation
        return ca.vertcat(position, rotation_vector(rotation @ ca.reshape(row.aim, 3, 3).T))
