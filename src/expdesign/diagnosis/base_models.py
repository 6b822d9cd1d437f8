"""What a diagnosis starts from: the elastic robot that deflections show, or the placed robot that positions show.

Of deflections the base model is linear in the compliances: every one of them has to be determined, its sign can be
judged, and only what yields can be missing. Positions and poses also show geometry and own weight, so that many small
errors come together with the compliances, which knowledge beforehand keeps from being undetermined. Of an arm the
calibration identifies them first, so that what is called missing is missing beside a calibrated geometry.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, as_matrix
from expdesign.chain.component import Part
from expdesign.chain.readings.reading import Reading
from expdesign.chain.recordings.recordings import Recordings
from expdesign.diagnosis.options import OPTIONS
from expdesign.errors import NotIdentifiableError
from expdesign.estimation.arm import ArmCalibration, calibrate
from expdesign.estimation.estimability import idle_actuators, require_positive
from expdesign.estimation.fit import RANK_TOLERANCE, Fit
from expdesign.estimation.geometric import calibration_of
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class BaseModel:
    """The base model of a robot that goes with what an instrument reads; a body's support counts among its effects.

    Attributes:
        robot: the robot.
        elastic: whether it is the elastic robot. A part's mismatch is any function of the force in it then, and
            predictions take in by what share named effects are not exact. Otherwise so many effects can show that all
            of them may have to be fitted together.
    """

    robot: Robot
    elastic: bool

    @property
    def most_effects(self) -> int:
        """That are sought beside it, one at a time."""
        return 3 if self.elastic and len(self.robot.stiffness) else 6

    def own_directions(self, part: Part) -> bool:
        """Whether the effects of a part say how it can move the readings."""
        return part is Part.LINK or (part is Part.JOINT and not self.elastic)

    def calibrated(self, recordings: Recordings) -> ArmCalibration | None:
        """What is calibrated before anything is missing, if anything; for what is raised see `calibrate`."""
        if self.elastic or not self.robot.jointed:
            return None
        return calibrate(self.robot, recordings, calibration_of(self.robot, recordings, None))

    def idle(self, fitted: Recordings) -> BoolArray | None:
        """Actuators that no fitted row loads, shape (n_p,); None where that need not be known."""
        if not self.elastic:
            return None
        return idle_actuators(self.robot, self.robot.jacobians(fitted.configurations), fitted.wrenches, fitted.axes)

    def require_determined(self, recordings: Recordings, base: Fit, idle: BoolArray | None) -> None:
        """Raise a `NotIdentifiableError` where deflections do not determine it; else knowledge beforehand does."""
        sizes = np.linalg.norm(as_matrix(base.sensitivities), axis=0)
        # A force that is nothing but rounding determines no compliance.
        known = base.determined & (sizes > RANK_TOLERANCE * sizes.max(initial=0.0))
        known |= False if idle is None else idle
        if self.elastic and not known.all():
            legs = ", ".join(name for name, one in zip(self.robot.actuators, known, strict=True) if not one)
            remedy = "Add recordings in which every actuator carries load and moves an axis that is measured."
            what = f"no load reaches {legs}, or no measured axis shows it"
            raise NotIdentifiableError(what, where=recordings.source, remedy=remedy)

    def require_plausible(self, recordings: Recordings, base: Fit) -> None:
        """Raise an `InputError` where it fits as no robot does; geometry takes up what would turn a sign."""
        if self.elastic:
            require_positive(base, recordings, self.robot)

    def undetermined(self, fitted: Fit) -> list[str]:
        """Parameters that are known no better than beforehand; none of the elastic robot."""
        return [
            parameter.name
            for parameter, variance in zip(fitted.chain.parameters, np.diag(fitted.covariance), strict=True)
            if not self.elastic
            and np.isfinite(parameter.spread)
            and parameter.spread > 1e-5
            and variance > (OPTIONS.half * parameter.spread) ** 2
        ]


def base_model(robot: Robot, reading: Reading) -> BaseModel:
    """The base model of a robot for what an instrument reads."""
    return BaseModel(robot, reading.linear)
