"""What an experiment is repeated with: what is measured at a plan, and what a command attains."""

from abc import ABC, abstractmethod

import numpy as np
from scipy.linalg import block_diag

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import Attained
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.planning.plan import Plan


class Plant(ABC):
    """A robot with true compliances, of which a plan is measured."""

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
