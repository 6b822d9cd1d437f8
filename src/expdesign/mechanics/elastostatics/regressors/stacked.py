"""Several groups of parameters that are identified together: A = [A_1 A_2 ...] (theory.md 9.I)."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.elastostatics.regressors.arm import ArmElastostatic, ArmGeometric
from expdesign.mechanics.elastostatics.regressors.elastostatic import Elastostatic
from expdesign.mechanics.elastostatics.regressors.frames import Frames
from expdesign.mechanics.elastostatics.regressors.geometric import Geometric
from expdesign.mechanics.elastostatics.regressors.regressor import PoseMaps, Regressor
from expdesign.mechanics.robots.robot import Robot


class Stacked(Regressor):
    """The parameters of several regressors, one after the other.

    Args:
        parts: at least one.
    """

    def __init__(self, parts: tuple[Regressor, ...]) -> None:
        self.parts = parts
        self.noun = "parameters"
        self.measurement = parts[-1].measurement
        self.needs_load = any(part.needs_load for part in parts)
        self.redundant = sum(part.redundant for part in parts)

    def names(self, robot: Robot) -> tuple[str, ...]:
        return tuple(name for part in self.parts for name in part.names(robot))

    def scale(self, robot: Robot) -> FloatArray:
        return np.concatenate([part.scale(robot) for part in self.parts])

    def nominal(self, robot: Robot) -> FloatArray:
        return np.concatenate([part.nominal(robot) for part in self.parts])

    def require(self, robot: Robot) -> str | None:
        return next((lack for part in self.parts if (lack := part.require(robot)) is not None), None)

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        return {name: value for part in self.parts for name, value in part.expressions(robot, configuration).items()}

    def matrix(self, maps: PoseMaps) -> FloatArray:
        return np.concatenate([part.matrix(maps) for part in self.parts], axis=-1)


CALIBRATIONS = ("elastostatic", "geometric", "both")


def regressor_for(calibration: str, *, frames_known: bool = True, links: bool = False) -> Regressor:
    """The regressor of `experiment.calibration` (one of `CALIBRATIONS`), with unknown frames where they are so.

    `links` says that the robot is commanded in joints.
    """
    if calibration == "elastostatic":
        return Elastostatic()
    if links:
        geometric = ArmGeometric(frames_known=frames_known)
        return geometric if calibration == "geometric" else Stacked((geometric, ArmElastostatic()))
    frames = () if frames_known else (Frames(),)
    if calibration == "geometric":
        return Stacked((*frames, Geometric())) if frames else Geometric()
    return Stacked((*frames, Geometric(), Elastostatic()))
