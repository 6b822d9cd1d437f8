"""The reading of an instrument that measures poses of the platform, in the coordinates of the commanded ones.

With known frames it is the true pose with its deflection. With unknown ones the instrument's frame and that of the
target on the platform are displaced by (t_I, R_I) and (t_T, R_T), small and unknown (theory.md 9.I):

    p' = R_Iᵀ·(p + R·t_T − t_I),   R' = R_Iᵀ·R·R_T,

p = home + X being the position of P. All base joints, or all platform joints, may be displaced alike to the same
effect: the twelve are a gauge freedom of the geometry, which priors fix and no prediction of a reading depends on.
"""

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.parameter import Parameter
from expdesign.chain.readings.reading import Reading
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.recordings.remark import Remark
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import angles_of, rotation_matrix
from expdesign.mechanics.robots.robot import Robot

FRAME_SPREAD = 0.02
"""m or rad; how well the frames are known where they are called unknown."""
_SCALE = 1e-4


@dataclass(frozen=True)
class MeasuredPose(Reading):
    """A measured pose.

    Attributes:
        frames_known: whether the frames of instrument and target are those of the commands.
        start: of the unknown placements of the frames, zeros.
    """

    frames_known: bool = True
    names = ()
    absolute = True
    linear = False
    compliance_spread = 3.0

    @property
    def start(self) -> FloatArray:  # type: ignore[override]
        return np.zeros(len(self.parameters))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        if self.frames_known:
            return ()
        units = ("m", "m", "m", "rad", "rad", "rad")
        axes = ("x", "y", "z", "rx", "ry", "rz")
        return tuple(
            Parameter(f"{frame} {axis}_{unit}", _SCALE, low=-1.0, high=1.0, spread=FRAME_SPREAD)
            for frame in ("instrument", "artefact")
            for axis, unit in zip(axes, units, strict=True)
        )

    @property
    def degeneracies(self) -> list[Remark]:
        return []

    @property
    def record(self) -> dict[str, object]:
        return {"frames": "known" if self.frames_known else "unknown"}

    def width(self, robot: Robot) -> int:
        return robot.coordinates.n

    def with_own_weight(self, row: Row, change: ca.SX) -> Row:
        return replace(row, carried=row.carried + change)

    def released(self, spreads: FloatArray) -> FloatArray:
        return spreads

    def at_points(self, points: LoadedPoints) -> LoadedPoints | None:
        return points if points.poses else None

    def pose(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """As the instrument reads it: with unknown frames no other pose is determined."""
        return self.expression(robot, deflection, row, theta, None)

    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        """The pose (n,) that is read of a platform at `row.pose` that deflects."""
        if self.frames_known:
            return row.pose + deflection
        assert robot.orientation is not None
        position, rotation = robot.frame(row.pose, deflection)
        instrument, target = (rotation_matrix(theta[6 * i + 3 : 6 * i + 6], "fixed-xyz") for i in range(2))
        seen = instrument.T @ (position + rotation @ theta[6:9] - theta[:3])
        angles = angles_of(instrument.T @ rotation @ target, robot.orientation)
        return ca.vertcat(seen - ca.SX(robot.inverse_kinematics.home), angles)
