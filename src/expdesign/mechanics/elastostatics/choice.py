"""The regressor of `experiment.calibration`, by what a robot is commanded in."""

from expdesign.mechanics.elastostatics.arm_calibration import ArmElastostatic, ArmGeometric
from expdesign.mechanics.elastostatics.calibration import (
    Calibration,
    Elastostatic,
    Frames,
    Geometric,
    Regressor,
    Stacked,
)


def regressor_for(calibration: Calibration, *, frames_known: bool = True, links: bool = False) -> Regressor:
    """The regressor of a calibration, with unknown frames where they are so.

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
