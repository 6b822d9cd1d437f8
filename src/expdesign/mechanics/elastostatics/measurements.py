"""What a batch of designs measures: the linear model of every reading and of what load errors do to it.

What takes the place of J̌·diag(c)·Jᵀ where a robot is known to do more than stretch its actuators.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal, Protocol

import casadi as ca
import numpy as np
from scipy.linalg import block_diag

from expdesign.arrays import BoolArray, FloatArray
from expdesign.mechanics.elastostatics.calibration import Elastostatic, PoseMaps, Regressor
from expdesign.mechanics.elastostatics.maps import actuator_forces, cartesian_compliance
from expdesign.mechanics.loads.errors.source import LoadErrorSource
from expdesign.mechanics.loads.load import Load, rows_first
from expdesign.mechanics.robots.robot import Jacobians, Robot
from expdesign.mechanics.symbolic import BatchFunction


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


Distribution = Literal["normal", "uniform"]
"""Of errors that are drawn; `uniform` has the same standard deviations."""


@dataclass(frozen=True)
class Measurements:
    """Linear model of measurements, with any batch dimensions in front of the measurement index i.

    Attributes:
        observation: A_i, reading per parameter of the regressor (thesis 1.17, theory.md 9.I), shape (..., n, n_p).
        compliance: D_i with the approximate stiffness, deflection per load error (theory.md 5.1), shape (..., n, n).
        load_errors: L_i·diag(σ), wrench error per standard deviation of δ, one source after the other, (..., n, d).
        sources: the columns of each source in it.
        jacobians: the kinematic maps, on which the noise may depend.
    """

    observation: FloatArray
    compliance: FloatArray
    load_errors: FloatArray
    sources: tuple[slice, ...]
    jacobians: Jacobians


class LoadedRobot:
    """A robot under one kind of load with its sources of load error.

    Args:
        robot: the robot.
        load: the kind of load.
        sources: sources of load error.
        regressor: what is calibrated.
        physics: how the robot deflects, where it does more than stretch its actuators.
        instrument: whether deflections are as the instrument reads them; else they are those of the platform.
    """

    def __init__(
        self,
        robot: Robot,
        load: Load,
        sources: tuple[LoadErrorSource, ...] = (),
        regressor: Regressor | None = None,
        physics: Physics | None = None,
        *,
        instrument: bool = True,
    ) -> None:
        self.robot = robot
        self.load = load
        self.sources = sources
        self.regressor = Elastostatic() if regressor is None else regressor
        self.physics = physics
        self._under_load = None if physics is None else physics.under(load, instrument=instrument)

    def under(self, load: Load, *, instrument: bool = True) -> "LoadedRobot":
        """The same robot under another kind of load, whose errors are not known."""
        return LoadedRobot(self.robot, load, (), self.regressor, self.physics, instrument=instrument)

    @property
    def under_load(self) -> LoadedPhysics | None:
        """The robot's own physics under the load; None where its actuators alone are elastic."""
        return self._under_load

    @property
    def linear_in_load(self) -> bool:
        """Whether the observation matrix is linear in the load and the compliance does not depend on it."""
        return self._under_load is None or self._under_load.linear_in_load

    @cached_property
    def scale(self) -> FloatArray:
        """Typical size of each parameter that is calibrated, shape (n_p,)."""
        return self.regressor.scale(self.robot)

    @cached_property
    def _columns(self) -> tuple[slice, ...]:
        """The columns of each source among all load errors."""
        ends = np.cumsum([0, *(len(source.deviation) for source in self.sources)]).tolist()
        return tuple(slice(start, end) for start, end in pairwise(ends))

    def _error_expressions(self, parameters: ca.SX, rotation: ca.SX) -> list[ca.SX]:
        """L·diag(σ) of all load errors side by side (n, d), where there are some."""
        errors = [
            source.sensitivity(self.load, parameters, rotation) @ ca.diag(ca.SX(source.deviation))
            for source in self.sources
        ]
        return [ca.horzcat(*errors)] if errors else []

    @cached_property
    def _measured(self) -> tuple[BatchFunction, int, tuple[str, ...]]:
        """What a measurement is made of, as one function of configuration and load: kinematics, load, regressor's own.

        Returns:
            The function, the number of matrices of the kinematics, and the names of the regressor's.
        """
        configuration = ca.SX.sym("q", len(self.robot.configuration))
        parameters = ca.SX.sym("load", len(self.load.columns))
        kinematics = self.robot.kinematics(configuration)
        own = self.regressor.expressions(self.robot, configuration)
        _, rotation = self.robot.frame(configuration, ca.SX.zeros(self.robot.coordinates.n))
        load = [self.load.wrench(parameters, rotation), *self._error_expressions(parameters, rotation)]
        outputs = [*kinematics, *load, *own.values()]
        function = BatchFunction("measured", [configuration, parameters], ca.cse(outputs))
        return function, len(kinematics), tuple(own)

    @cached_property
    def _errors(self) -> BatchFunction:
        rotation, parameters = self.load.symbols
        return self.load.function("load_errors", self._error_expressions(parameters, rotation))

    def load_errors(self, rotation: FloatArray, loads: FloatArray) -> tuple[FloatArray, ...]:
        """L·diag(σ) of each source (..., n, d), at R of the platform (..., d, d) and loads (..., k)."""
        if not self.sources:
            return ()
        batch = np.broadcast_shapes(rotation.shape[:-2], loads.shape[:-1])
        matrix = self._matrix(batch, self._errors(rows_first(rotation), loads))
        return tuple(matrix[..., columns] for columns in self._columns)

    def _matrix(self, batch: tuple[int, ...], errors: Sequence[FloatArray]) -> FloatArray:
        """L·diag(σ) of all load errors (..., n, d); a single column comes as a vector, and none not at all."""
        shape = (*batch, self.robot.coordinates.n, sum(len(source.deviation) for source in self.sources))
        if not errors:
            return np.zeros(shape)
        return errors[0] if errors[0].shape == shape else errors[0].reshape(shape)

    def measure(self, configurations: FloatArray, loads: FloatArray) -> Measurements:
        """The linear model at configurations (..., n_q) under loads (..., k), `load.columns` naming the latter."""
        function, count, names = self._measured
        values = function(configurations, loads)
        jacobians = self.robot.jacobians_of(*values[:count])
        wrench, own = values[count], len(values) - len(names)
        errors = self._matrix(wrench.shape[:-1], values[count + 1 : own])
        further = dict(zip(names, values[own:], strict=True))
        observation = self.regressor.matrix(PoseMaps(jacobians.pose, actuator_forces(jacobians, wrench), further))
        compliance = cartesian_compliance(jacobians, self.robot.compliance)
        if self._under_load is not None:
            elastic, changed = self._under_load.maps(configurations, loads, jacobians)
            observation = self.regressor.under_load(observation, elastic, (compliance, changed))
            compliance = changed
        return Measurements(observation, compliance, errors, self._columns, jacobians)

    def deflections(self, configurations: FloatArray, loads: FloatArray, added: FloatArray) -> FloatArray:
        """Deflections (..., n) of the robot as it is known, under loads (..., k) and added wrenches (..., n)."""
        if self._under_load is not None:
            return self._under_load.deflections(configurations, loads, self.robot.jacobians(configurations), added)
        measured = self.measure(configurations, loads)
        nominal = measured.observation @ self.robot.compliance
        deflections: FloatArray = nominal + (measured.compliance @ added[..., None])[..., 0]
        return deflections

    def drawn_errors(
        self,
        configurations: FloatArray,
        loads: FloatArray,
        count: int,
        generator: np.random.Generator,
        distribution: Distribution = "normal",
        acts: Sequence[BoolArray] | None = None,
    ) -> FloatArray:
        """Actual minus assumed wrench ε_F = Σ L·δ (N, N·m) of `count` repetitions (theory.md 5.2), shape (count, m, n).

        A shared source has one δ for all m measurements of a repetition; an unloaded measurement has no error. Shared
        ones are drawn first, so that they are the same for a generator in the same state, whatever is measured.

        Args:
            configurations: shape (m, n_q).
            loads: assumed loads, shape (m, k).
            count: of repetitions.
            generator: of random numbers.
            distribution: of δ; `uniform` has the same standard deviations.
            acts: in which measurements each source acts, shape (m,) each; in all if left out.
        """
        rotation = self.robot.jacobians(configurations).rotation
        wrenches, scaled = self.load.wrenches(rotation, loads), self.load_errors(rotation, loads)
        rows = wrenches.size
        total = np.zeros((count, rows))
        for index in sorted(range(len(self.sources)), key=lambda index: not self.sources[index].shared):
            source, sensitivity = self.sources[index], scaled[index]
            if acts is not None:
                sensitivity = sensitivity * acts[index][:, None, None]
            width = sensitivity.shape[-1]
            spread = sensitivity.reshape(rows, width) if source.shared else block_diag(*sensitivity)
            if distribution == "normal":
                delta = generator.standard_normal((count, spread.shape[1]))
            else:
                delta = generator.uniform(-np.sqrt(3.0), np.sqrt(3.0), (count, spread.shape[1]))
            total += delta @ spread.T
        errors = total.reshape(count, *wrenches.shape)
        errors[:, (wrenches == 0.0).all(axis=1)] = 0.0
        return errors
