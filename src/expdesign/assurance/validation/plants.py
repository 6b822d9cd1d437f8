"""The two plants that an experiment can be repeated with: what is measured at a plan, and what a command attains."""

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from scipy.linalg import block_diag

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import Attained
from expdesign.assurance.validation.equilibrium import Equilibrium
from expdesign.errors import ArgumentError
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Wrench
from expdesign.planning.plan import Plan


class Plant(ABC):
    """A robot with true compliances, of which a plan is measured."""

    name: ClassVar[str]

    def __init__(self, loaded: LoadedRobot, plan: Plan) -> None:
        self.loaded = loaded
        self.plan = plan
        self.true = loaded.robot.compliance

    def model(self) -> FloatArray:
        """Deflections (m, n) that the robot's model predicts under the assumed loads with the true compliances."""
        nothing = np.zeros((len(self.plan), self.loaded.robot.coordinates.n))
        return self.loaded.deflections(self.plan.configurations, self.plan.loads, nothing)

    @abstractmethod
    def deflections(self, added: FloatArray) -> FloatArray:
        """Deflections (s, m, n) under the assumed loads and added wrenches (s, m, n)."""

    @abstractmethod
    def errors(self, attained: Attained, target: FloatArray, wrench: FloatArray) -> FloatArray:
        """Attained minus wanted pose (s, n) of commands at a target (n,) under a wrench (n,)."""


class ExplicitPlant(Plant):
    """P1: X_loaded = X_cmd + A(X_cmd, ΔF)·c, the mapping on which identification and compensation rest."""

    name = "explicit"

    def __init__(self, loaded: LoadedRobot, plan: Plan) -> None:
        super().__init__(loaded, plan)
        measured = loaded.measure(plan.configurations, plan.loads)
        self._nominal = self.model()
        self._compliance = block_diag(*measured.compliance)

    def deflections(self, added: FloatArray) -> FloatArray:
        if self.loaded.under_load is not None:
            return self.loaded.deflections(self.plan.configurations, self.plan.loads, added)
        flat = added.reshape(len(added), -1) @ self._compliance.T
        deflections: FloatArray = self._nominal + flat.reshape(added.shape)
        return deflections

    def errors(self, attained: Attained, target: FloatArray, wrench: FloatArray) -> FloatArray:
        return attained.errors


class EquilibriumPlant(Plant):
    """P2: the exact equilibrium of the loaded robot. Its difference from P1 is an error that no criterion predicts."""

    name = "equilibrium"

    def __init__(self, loaded: LoadedRobot, plan: Plan) -> None:
        super().__init__(loaded, plan)
        if not loaded.robot.on_legs:
            what = f"the full equilibrium is for robots on legs, not for a {loaded.robot.kind}"
            raise ArgumentError(what, argument="plant", remedy="Use argument `plant=explicit`.")
        if loaded.under_load is not None:
            what = "the full equilibrium is of legs that stretch alone, and this robot is a model with effects"
            raise ArgumentError(what, argument="plant", remedy="Use argument `plant=explicit`, which has them.")
        closed_form = self._robot = loaded.robot.inverse_kinematics
        self._measured = Equilibrium(closed_form, loaded.load, self.true)
        self._used = Equilibrium(closed_form, Wrench(closed_form.coordinates), self.true)
        self._explicit = ExplicitPlant(loaded, plan)
        self._lengths = closed_form.lengths(plan.configurations)
        nothing = np.zeros((1, *plan.configurations.shape))
        self._nominal = self._solved(self._explicit.deflections(nothing), nothing)

    def deflections(self, added: FloatArray) -> FloatArray:
        if not added.any():
            return np.broadcast_to(self._nominal, added.shape).copy()
        nothing = np.zeros((1, *added.shape[1:]))
        start = self._nominal + (self._explicit.deflections(added) - self._explicit.deflections(nothing))
        return self._solved(start, added)

    def _solved(self, start: FloatArray, added: FloatArray) -> FloatArray:
        """Deflections (s, m, n) in equilibrium from a first guess of them."""
        poses = self.plan.configurations

        def flat(values: FloatArray) -> FloatArray:
            return np.broadcast_to(values, (len(added), *values.shape[-2:])).reshape(-1, values.shape[-1])

        loaded = self._measured.poses(flat(poses + start), flat(self._lengths), flat(self.plan.loads), flat(added))
        deflections: FloatArray = loaded.reshape(added.shape) - poses
        return deflections

    def errors(self, attained: Attained, target: FloatArray, wrench: FloatArray) -> FloatArray:
        commands = attained.commands
        loads = np.broadcast_to(wrench, commands.shape)
        start = target + attained.errors
        poses = self._used.poses(start, self._robot.lengths(commands), loads, np.zeros_like(commands))
        return poses - target


PLANTS: dict[str, type[Plant]] = {plant.name: plant for plant in (ExplicitPlant, EquilibriumPlant)}
