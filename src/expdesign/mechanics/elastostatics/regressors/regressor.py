"""What a regressor is: the parameters that a calibration identifies, and how each of them moves the platform.

The method asks for nothing else. With ε_X = A·π for small parameters π, the information of a measurement, the error of
an estimate and the error that it leaves after compensation follow from A alone (theory.md 3 to 5 and 9.I): the
compliances of the actuators are one choice of π, errors of the geometry another. Each regressor gives A from a few
matrices of a pose, in NumPy that can be differentiated (`differentiation.py`).
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import casadi as ca

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class PoseMaps:
    """What regressors are made of, with any batch dimensions in front.

    Attributes:
        pose: J̌, rate of the pose coordinates per actuator speed (thesis 1.13), shape (..., n, n_a).
        forces: τ, forces in the actuators (N or N·m), shape (..., n_a).
        further: the matrices of `Regressor.expressions` by name, shape (..., rows, columns) each.
    """

    pose: FloatArray
    forces: FloatArray
    further: dict[str, FloatArray]


class Regressor(ABC):
    """One group of parameters.

    Attributes:
        noun: what its parameters are called, in the plural.
        measurement: what one measurement is called.
        needs_load: whether a measurement without load tells nothing.
        redundant: how many combinations of its parameters are never identifiable (gauge freedoms). Estimates of such
            parameters do not exist, predictions of the pose may (theory.md 9.I, gauge freedoms).
    """

    noun: str
    measurement: str
    needs_load: bool
    redundant: int = 0

    @abstractmethod
    def names(self, robot: Robot) -> tuple[str, ...]:
        """Names of the parameters π, shape (p,)."""

    @abstractmethod
    def scale(self, robot: Robot) -> FloatArray:
        """Typical size of each parameter, shape (p,): for conditioning and rank tests, of no influence on results."""

    @abstractmethod
    def nominal(self, robot: Robot) -> FloatArray:
        """Value of each parameter of the robot as its file describes it, shape (p,)."""

    def require(self, robot: Robot) -> str | None:
        """What a robot lacks for this regressor, or None."""
        return None

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        """Matrices that depend on the configuration alone, by name; none where J̌ and τ are enough."""
        return {}

    @abstractmethod
    def matrix(self, maps: PoseMaps) -> FloatArray:
        """A with ε_X = A·π in pose coordinates, shape (..., n, p)."""
