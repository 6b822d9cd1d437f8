"""Where a loaded parallel robot comes to rest, exactly: the full-equilibrium plant P2 (theory.md 2.3).

At commanded leg lengths q_cmd the loaded pose X satisfies q(X) = q_cmd + c∘(J(X)ᵀF(X)): forces are taken where the
platform is, and a payload's moment turns with it. Nothing is linearised; the Newton matrix J̌ is kept from the start.
"""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import STEPS, TOLERANCE, Attained
from expdesign.assurance.validation.simulation import ExplicitPlant
from expdesign.errors import ConvergenceError
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Load, Wrench
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.symbolic import BatchFunction
from expdesign.planning.plan import Plan


class Equilibrium:
    """Loaded poses of a robot under one kind of load.

    Args:
        robot: a parallel robot.
        load: the kind of load.
        compliance: true compliances of the legs (m/N), shape (n_p,).
    """

    def __init__(self, robot: ParallelRobot, load: Load, compliance: FloatArray) -> None:
        n = robot.coordinates.n
        pose, command = ca.SX.sym("X", n), ca.SX.sym("q", len(compliance))
        parameters, added = ca.SX.sym("load", len(load.columns)), ca.SX.sym("added", n)
        forward, _, rotation = robot.jacobian_expressions(pose)
        forces = forward.T @ (load.wrench(parameters, rotation) + added)
        lengths = robot.actuator_lengths(pose, ca.SX(robot.geometry))
        residual = lengths - command - ca.SX(compliance) * forces
        self._residual = BatchFunction("equilibrium", [pose, command, parameters, added], [residual])
        self.robot = robot

    def poses(self, start: FloatArray, lengths: FloatArray, loads: FloatArray, added: FloatArray) -> FloatArray:
        """Loaded poses, shape (N, n).

        Args:
            start: first guesses, shape (N, n).
            lengths: commanded leg lengths (m), shape (N, n_p).
            loads: parameters of the load, shape (N, k).
            added: wrench beside the load (N, N·m), shape (N, n).

        Raises:
            ConvergenceError: the robot does not come to rest near the start.
        """
        poses = start.copy()
        step = self.robot.jacobians(start).pose
        rows = np.arange(len(start))
        for _ in range(STEPS):
            (residual,) = self._residual(poses[rows], lengths[rows], loads[rows], added[rows])
            correction = (step[rows] @ residual[..., None])[..., 0]
            poses[rows] -= correction
            rows = rows[~(np.abs(correction).max(axis=1) <= TOLERANCE)]
            if not rows.size:
                return poses
        what = f"{rows.size} of {len(start)} loaded poses do not come to rest"
        raise ConvergenceError(what, remedy="The load is beyond what the robot can bear.")


class EquilibriumPlant(ExplicitPlant):
    """P2: the exact equilibrium of the loaded robot. Its difference from P1 is an error that no criterion predicts."""

    def __init__(self, loaded: LoadedRobot, plan: Plan) -> None:
        super().__init__(loaded, plan)
        closed_form = self._robot = loaded.robot.inverse_kinematics
        self._measured = Equilibrium(closed_form, loaded.load, self.true)
        self._used = Equilibrium(closed_form, Wrench(closed_form.coordinates), self.true)
        self._lengths = closed_form.lengths(plan.configurations)
        nothing = np.zeros((1, *plan.configurations.shape))
        self._nominal = self._solved(super().deflections(nothing), nothing)

    def deflections(self, added: FloatArray) -> FloatArray:
        if not added.any():
            return np.broadcast_to(self._nominal, added.shape).copy()
        nothing = np.zeros((1, *added.shape[1:]))
        start = self._nominal + (super().deflections(added) - super().deflections(nothing))
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
