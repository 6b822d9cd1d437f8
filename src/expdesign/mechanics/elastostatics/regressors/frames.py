"""Where the instrument and what it looks at are, when nobody knows: twelve freedoms that measured poses cannot tell
from the robot's own geometry (theory.md 9.I).

A displacement of the instrument's frame moves every measured pose by one twist in base axes, one of the target on the
platform by one twist in platform axes. A displacement of all base joints, or of all platform joints, does exactly the
same: the parameters are therefore never estimable one by one, but the pose that the instrument will read is.
"""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.elastostatics.regressors.geometric import TYPICAL_ERROR
from expdesign.mechanics.elastostatics.regressors.regressor import PoseMaps, Regressor
from expdesign.mechanics.moments import frame_turn, twist_transfer
from expdesign.mechanics.robots.robot import Robot


class Frames(Regressor):
    """Measured pose per displacement (1, rad/m) and per rotation (m, rad) of the two frames, in space."""

    noun = "placements of the frames"
    measurement = "pose measurement"
    needs_load = False
    redundant = 12

    def names(self, robot: Robot) -> tuple[str, ...]:
        parts = ("x", "y", "z", "rx", "ry", "rz")
        return tuple(f"{frame} {part}" for frame in ("instrument", "artefact") for part in parts)

    def scale(self, robot: Robot) -> FloatArray:
        return np.full(12, TYPICAL_ERROR)

    def nominal(self, robot: Robot) -> FloatArray:
        return np.zeros(12)

    def require(self, robot: Robot) -> str | None:
        spatial = robot.inverse_kinematics is not None and robot.coordinates.n == 6
        return None if spatial else "frames that are unknown need a robot with six pose coordinates"

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        state = robot.commanded_state(configuration, ca.SX(robot.gravity))
        _, rotation = robot.frame(configuration, ca.SX.zeros(6))
        return {"frames": state.rates @ ca.horzcat(twist_transfer(state.position, 6), frame_turn(rotation, 6))}

    def matrix(self, maps: PoseMaps) -> FloatArray:
        return maps.further["frames"]
