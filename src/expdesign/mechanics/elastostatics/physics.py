"""What takes the place of J̌·diag(c)·Jᵀ where a robot is known to do more than stretch its actuators."""

from typing import Protocol

import casadi as ca

from expdesign.arrays import FloatArray
from expdesign.mechanics.loads.load import Load
from expdesign.mechanics.robots.robot import Jacobians


class LoadedPhysics(Protocol):
    """How a robot deflects under one kind of load, about known compliances."""

    @property
    def linear_in_load(self) -> bool:
        """Whether the derivative by the compliances is affine in each quantity of the load alone, and that by the
        wrench does not depend on the load.
        """
        ...

    def maps(
        self, configurations: FloatArray, loads: FloatArray, jacobians: Jacobians
    ) -> tuple[FloatArray, FloatArray]:
        """Derivatives of the deflection (..., n) with respect to the compliances, (..., n, n_p), and the wrench,
        (..., n, n), at configurations (..., n_q) under loads (..., k).
        """
        ...

    def deflections(
        self, configurations: FloatArray, loads: FloatArray, jacobians: Jacobians, added: FloatArray
    ) -> FloatArray:
        """Deflections (..., n) under the loads and added wrenches (..., n)."""
        ...

    def expression(self, configuration: ca.SX, loads: ca.SX, compliances: ca.SX) -> ca.SX:
        """Deflection (n,) at a symbolic configuration, load and compliances (m/N or rad/(N·m))."""
        ...


class Physics(Protocol):
    """How a robot deflects, as its instrument reads it or as its platform moves."""

    def under(self, load: Load, *, instrument: bool) -> LoadedPhysics:
        """The same under a kind of load; with `instrument` as it is read, else as the platform moves."""
        ...
