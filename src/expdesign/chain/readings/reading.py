"""What the instrument reads: the link between the motion of the platform and the instrument's own errors."""

from abc import ABC, abstractmethod

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.parameter import Parameter
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings
from expdesign.chain.recordings.remark import Remark
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class Reading(ABC):
    """One kind of reading.

    Attributes:
        names: markers whose positions are read, in the order of `Row.marker`; none for deflections.
        oriented: those of which orientations are read as well.
        fixed: fixed points and gauges from which distances are read, in the order of `Row.point`.
        by_instrument: whether an instrument reads it, with its own errors.
        start: of the unknown parameters of the instrument, in the order of `parameters`.
        absolute: whether it says where the platform is, so that geometry shows; deflections are differences.
        chord_steps: to the true pose of a platform whose geometry is not nominal: deflections need it for their lever
            arms only, absolute readings to below their noise.
        linear: whether the base model is linear in its compliances and has no further parameters.
        compliance_spread: standard deviation of a compliance in units of the robot file's before anything is measured.
    """

    names: tuple[str, ...]
    oriented: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    by_instrument: bool = True
    start: FloatArray
    absolute: bool
    chord_steps: int = 4
    linear: bool
    compliance_spread: float

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """What of the instrument is unknown in every model."""

    @property
    @abstractmethod
    def degeneracies(self) -> list[Remark]:
        """What of the instrument is confounded in the fitted rows."""

    @property
    @abstractmethod
    def record(self) -> dict[str, object]:
        """What a model file says of it beside the values of `parameters`; empty for deflections."""

    @abstractmethod
    def width(self, robot: Robot) -> int:
        """Number of components of a reading."""

    @abstractmethod
    def with_own_weight(self, row: Row, change: ca.SX) -> Row:
        """The row where the robot's own weight loads the actuators by `change` (n_p,) more than assumed."""

    @abstractmethod
    def released(self, spreads: FloatArray) -> FloatArray:
        """Standard deviations of `parameters` where nothing is held that is merely confounded, from those held."""

    @abstractmethod
    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        """The reading (width,) of a platform that deflects.

        Args:
            robot: the robot.
            deflection: in pose coordinates (n,).
            row: the row.
            theta: values of `parameters`.
            geometry: errors of the geometry of the robot's links, or None.
        """

    def pose(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """Pose (n,) of a platform at `row.pose` that deflects, in the frames in which targets are given."""
        return row.pose + deflection

    def displacement(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, command: ca.SX) -> ca.SX:
        """That pose (n,) minus the commanded one, as far as readings of this kind show it."""
        return self.pose(robot, deflection, row, theta) - command

    @abstractmethod
    def at_points(self, points: LoadedPoints) -> LoadedPoints | None:
        """Points with markers numbered as here, or None where the points name none; raises `InputError`."""

    def predictable(self, robot: Robot, recordings: Recordings) -> BoolArray:
        """Rows whose prediction rests on nothing that the fitted rows leave confounded, shape (N,)."""
        return np.ones(len(recordings), dtype=bool)
