"""A geometric calibration repeated with non-linear kinematics: what poses attain after identification (theory.md 9.I).

The estimates are those of the criteria, π̂ = π + G·(noise and load errors); what they lead to is not linearised. With
the identified geometry ĝ, length errors δl̂ and compliances ĉ the command is chosen so that the platform should stand
loaded at the target X_t,

    X_u = X_t − J̌(X_u; ĝ)·diag(ĉ)·J(X_u; ĝ)ᵀ·F,    q_C = q(X_u; ĝ) − δl̂,

and the machine goes to the pose at which its own geometry has these lengths, q(X; g) = q_C, and deflects from there.
"""

from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import settled
from expdesign.errors import ConvergenceError, InputError
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.symbolic import BatchFunction
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem


class GeometricPlant:
    """A machine on legs with true geometry and compliances as its file has them, which is commanded by a model of it.

    Args:
        problem: of a calibration of the geometry, alone or with the stiffness.
        plan: what is measured.

    Raises:
        InputError: the frames of the instrument are unknown.
    """

    def __init__(self, problem: DesignProblem, plan: Plan) -> None:
        loaded = problem.loaded
        if loaded.regressor.redundant:
            what = "experiments with unknown frames cannot be repeated: their parameters have no values one by one"
            where = f"{problem.source}, experiment.frames"
            remedy = "Take `frames: unknown` out: predicted readings have the same variance then."
            raise InputError(what, where=where, remedy=remedy)
        self.robot: ParallelRobot = loaded.robot.inverse_kinematics
        self.nominal: FloatArray = np.array(self.robot.geometry, dtype=float)
        self.actuators = len(loaded.robot.stiffness)
        self.compliance = np.array(loaded.robot.compliance)
        self.stiffness_too = loaded.regressor.needs_load
        self._per_wrench = loaded.measure(plan.configurations, plan.loads).compliance

    def deflections(self, added: FloatArray) -> FloatArray:
        """What wrenches (s, m, n) that nobody knows of add to the measured poses, shape (s, m, n)."""
        moved: FloatArray = np.einsum("mij,smj->smi", self._per_wrench, added)
        return moved

    def attained(self, estimates: FloatArray, target: FloatArray, wrench: FloatArray) -> tuple[FloatArray, float]:
        """Attained minus wanted pose (s, n) of commands by estimates (s, p), and the largest last step to these.

        Raises:
            ConvergenceError: a pose is not found.
        """
        count, split = len(estimates), len(self.nominal)
        wrong, lengths, compliance = np.split(estimates, [split, split + self.actuators], axis=1)
        geometry = self.nominal + wrong
        if not self.stiffness_too:
            compliance = np.tile(self.compliance, (count, 1))
        load = np.broadcast_to(wrench, (count, len(wrench)))
        wanted = np.broadcast_to(target, (count, len(target)))
        unloaded, residual = settled(lambda x: wanted - self._deflection(x, geometry, compliance, load)[0], wanted)
        try:
            pose = self.robot.pose_of(self._lengths(unloaded, geometry)[0] - lengths, unloaded)
        except ConvergenceError as error:
            remedy = "Check the plan: it hardly identifies the geometry."
            raise ConvergenceError("a commanded pose is not found", where="Monte-Carlo", remedy=remedy) from error
        own = np.broadcast_to(self.nominal, geometry.shape), np.broadcast_to(self.compliance, compliance.shape)
        return pose + self._deflection(pose, *own, load)[0] - target, residual

    @cached_property
    def _lengths(self) -> BatchFunction:
        pose, geometry, lengths, _ = self._symbolic()
        return BatchFunction("lengths", [pose, geometry], [lengths])

    @cached_property
    def _deflection(self) -> BatchFunction:
        pose, geometry, _, rates = self._symbolic()
        compliance, wrench = ca.SX.sym("c", self.actuators), ca.SX.sym("F", pose.shape[0])
        pose_map = ca.solve(rates, ca.SX.eye(pose.shape[0]))
        forward = ca.solve(self.robot.pose_rate_map(pose), pose_map)
        deflection = pose_map @ (compliance * (forward.T @ wrench))
        return BatchFunction("deflection", [pose, geometry, compliance, wrench], [deflection])

    def _symbolic(self) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        pose, geometry = ca.SX.sym("X", self.robot.coordinates.n), ca.SX.sym("g", len(self.nominal))
        lengths = self.robot.actuator_lengths(pose, geometry)
        return pose, geometry, lengths, ca.jacobian(lengths, pose)
