"""What a source of load error is: a small unknown δ, its covariance, and the wrench that it adds.

The sensitivity L with ε_F = L·δ (theory.md 5.2) is not written down per source: it is the derivative of the disturbed
wrench at δ = 0.
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
