"""Where a loaded parallel robot comes to rest, exactly: the full-equilibrium plant P2 (theory.md 2.3).

At commanded leg lengths q_cmd the loaded pose X satisfies q(X) = q_cmd + c∘(J(X)ᵀF(X)): forces are taken where the
platform is, and a payload's moment turns with it. Nothing is linearised; the Newton matrix J̌ is kept from the start.
"""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import CONVERGENCE
from expdesign.errors import ConvergenceError
from expdesign.mechanics.loads.load import Load
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.symbolic import BatchFunction


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
        for _ in range(CONVERGENCE.steps):
            (residual,) = self._residual(poses[rows], lengths[rows], loads[rows], added[rows])
            correction = (step[rows] @ residual[..., None])[..., 0]
            poses[rows] -= correction
            rows = rows[~(np.abs(correction).max(axis=1) <= CONVERGENCE.tolerance)]
            if not rows.size:
                return poses
        what = f"{rows.size} of {len(start)} loaded poses do not come to rest"
        raise ConvergenceError(what, remedy="The load is beyond what the robot can bear; use the explicit plant.")
