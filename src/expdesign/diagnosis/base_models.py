"""What a diagnosis starts from: the elastic robot that deflections show, or the placed robot that positions show.

Of deflections the base model is linear in the compliances: every one of them has to be determined, its sign can be
judged, and only what yields can be missing. Positions and poses also show geometry and own weight, so that many small
errors come together with the compliances, which knowledge beforehand keeps from being undetermined. Of an arm the
calibration identifies them first, so that what is called missing is missing beside a calibrated geometry.
"""

from abc import ABC, abstractmethod

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


class BaseModel(ABC):
    """One kind of base model.

    Attributes:
        most_effects: that are sought beside it, one at a time.
        several_at_once: whether so many effects can show that all of them may have to be fitted together.
        inexact: whether predictions take in by what share named effects are not exact, and are averaged where rows are
            few.
        located_by_force: whether a part's mismatch is any function of the force in it, with its own directions only
            across; otherwise the effects of joints say how a joint can move the readings.
    """

    most_effects: int
    several_at_once: bool
    inexact: bool
    located_by_force: bool

    def own_directions(self, part: Part) -> bool:
        """Whether the effects of a part say how it can move the readings."""
        return part is Part.LINK or (part is Part.JOINT and not self.located_by_force)

    @abstractmethod
    def calibrated(self, robot: Robot, recordings: Recordings) -> ArmCalibration | None:
        """What is calibrated before anything is missing, if anything; for what is raised see `calibrate`."""

    @abstractmethod
    def idle(self, robot: Robot, fitted: Recordings) -> BoolArray | None:
        """Actuators that no fitted row loads, shape (n_p,); None where that need not be known."""

    @abstractmethod
    def require_determined(self, robot: Robot, recordings: Recordings, base: Fit, idle: BoolArray | None) -> None:
        """Raise a `NotIdentifiableError` where the recordings do not determine the base model."""

    @abstractmethod
    def require_plausible(self, robot: Robot, recordings: Recordings, base: Fit) -> None:
        """Raise an `InputError` where a base model that fits is one that no robot has."""

    @abstractmethod
    def undetermined(self, fitted: Fit) -> list[str]:
        """Parameters that are known no better than beforehand."""


class ElasticRobot(BaseModel):
    """The base model of deflections."""

    several_at_once = False
    inexact = True
    located_by_force = True

    def __init__(self, most_effects: int) -> None:
        self.most_effects = most_effects

    def calibrated(self, robot: Robot, recordings: Recordings) -> ArmCalibration | None:
        return None

    def idle(self, robot: Robot, fitted: Recordings) -> BoolArray | None:
        return idle_actuators(robot, robot.jacobians(fitted.configurations), fitted.wrenches, fitted.axes)

    def require_determined(self, robot: Robot, recordings: Recordings, base: Fit, idle: BoolArray | None) -> None:
        sizes = np.linalg.norm(as_matrix(base.sensitivities), axis=0)
        # A force that is nothing but rounding determines no compliance.
        known = base.determined & (sizes > RANK_TOLERANCE * sizes.max(initial=0.0))
        known |= False if idle is None else idle
        if not known.all():
            legs = ", ".join(name for name, one in zip(robot.actuators, known, strict=True) if not one)
            remedy = "Add recordings in which every actuator carries load and moves an axis that is measured."
            what = f"no load reaches {legs}, or no measured axis shows it"
            raise NotIdentifiableError(what, where=recordings.source, remedy=remedy)

    def require_plausible(self, robot: Robot, recordings: Recordings, base: Fit) -> None:
        require_positive(base, recordings, robot)

    def undetermined(self, fitted: Fit) -> list[str]:
        return []


class PlacedRobot(BaseModel):
    """The base model of positions of markers and of poses."""

    most_effects = 6
    several_at_once = True
    inexact = False
    located_by_force = False

    def calibrated(self, robot: Robot, recordings: Recordings) -> ArmCalibration | None:
        if not robot.jointed:
            return None
        return calibrate(robot, recordings, calibration_of(robot, recordings, None))

    def idle(self, robot: Robot, fitted: Recordings) -> BoolArray | None:
        return None

    def require_determined(self, robot: Robot, recordings: Recordings, base: Fit, idle: BoolArray | None) -> None:
        """Knowledge beforehand determines what the recordings do not."""

    def require_plausible(self, robot: Robot, recordings: Recordings, base: Fit) -> None:
        """Geometry takes up what would turn a compliance's sign."""

    def undetermined(self, fitted: Fit) -> list[str]:
        return [
            parameter.name
            for parameter, variance in zip(fitted.chain.parameters, np.diag(fitted.covariance), strict=True)
            if np.isfinite(parameter.spread)
            and parameter.spread > 1e-5
            and variance > (OPTIONS.half * parameter.spread) ** 2
        ]


def base_model(robot: Robot, reading: Reading) -> BaseModel:
    """The base model that goes with what an instrument reads; a body's support counts among its effects."""
    if not reading.linear:
        return PlacedRobot()
    return ElasticRobot(most_effects=3 if len(robot.stiffness) else 6)
