"""What a source of load error is: a small unknown δ, its covariance, and the wrench that it adds.

The sensitivity L with ε_F = L·δ (theory.md 5.2) is not written down per source: it is the derivative of the disturbed
wrench at δ = 0.

The centre of mass is not exactly where it is assumed: L = [0; −[m g]ₓ R] (theory.md 5.2).

The load does not act exactly along the assumed direction (file-formats.md, Run configurations).

The mass is not exactly the one assumed: L = F/m (theory.md 5.2).

An unknown wrench is added to the load, as a force sensor's noise or a cable does: L = I (theory.md 5.2).
"""

from abc import ABC, abstractmethod
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.loads.load import Load


class LoadErrorSource(ABC):
    """One source of error of the load during the experiment.

    Attributes:
        deviation: standard deviations of the independent components of δ, shape (d,).
        shared: whether one unknown δ holds for all measurements (systematic) or each has its own (random).
    """

    source: ClassVar[str]
    unit: ClassVar[str]

    def __init__(self, deviation: FloatArray, shared: bool = True) -> None:
        self.deviation = np.atleast_1d(np.asarray(deviation, dtype=float))
        self.shared = shared

    @classmethod
    @abstractmethod
    def dimension(cls, load: Load) -> int:
        """Number of components of δ for this load; 0 where the source does not exist for it."""

    @abstractmethod
    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        """Wrench with the error δ, exact to first order, shape (n,)."""

    def sensitivity(self, load: Load, parameters: ca.SX, rotation: ca.SX) -> ca.SX:
        """L = ∂F/∂δ at δ = 0, shape (n, d)."""
        delta = ca.SX.sym("delta", len(self.deviation))
        wrench = self.disturbed(load, parameters, rotation, delta)
        return ca.substitute(ca.jacobian(wrench, delta), delta, ca.SX.zeros(len(self.deviation)))


class CentreOfMassError(LoadErrorSource):
    """δ is the offset of the centre of mass in the platform frame."""

    source = "com"
    unit = "m"

    @classmethod
    def dimension(cls, load: Load) -> int:
        return len(load.coordinates.centre_of_mass) if load.has_mass else 0

    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        offset = ca.vertcat(0.0, delta, ca.SX.zeros(parameters.shape[0] - 1 - delta.shape[0]))
        return load.wrench(parameters + offset, rotation)


class DirectionError(LoadErrorSource):
    """δ tilts the load about x and y of O: gravity for a payload, force and moment together for a wrench."""

    source = "direction"
    unit = "rad"

    @classmethod
    def dimension(cls, load: Load) -> int:
        return len(load.coordinates.tilt)

    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        return load.turned(parameters, rotation, delta)


class MassError(LoadErrorSource):
    """δ is the difference of mass."""

    source = "mass"
    unit = "kg"

    @classmethod
    def dimension(cls, load: Load) -> int:
        return int(load.has_mass)

    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        return load.wrench(parameters + ca.vertcat(delta, ca.SX.zeros(parameters.shape[0] - 1)), rotation)


class WrenchError(LoadErrorSource):
    """δ is the added wrench at the origin of P along the axes of O."""

    source = "wrench"
    unit = "N, N·m"

    @classmethod
    def dimension(cls, load: Load) -> int:
        return load.coordinates.n

    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        return load.wrench(parameters, rotation) + delta
