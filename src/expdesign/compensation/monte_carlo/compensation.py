"""The exact compensation of very many estimates at one target, and what the explicit plant then attains.

theory.md 4.1: the command solves X̂_C + A(X̂_C, ΔF_D)·ĉ = X_D, and plant P1 attains X̂_A = X̂_C + A(X̂_C, ΔF_D)·c. The
iteration X ← X_D − A(X)·ĉ contracts by about ‖ΔX‖ divided by the size of the robot. Its start is X_D − A(X)·ĉ with A
expanded to first order about the command of the true compliances, so that one evaluation, which every sample needs
anyway to see that it solves the fixed point, is nearly always the only one.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.elastostatics.geometric_stiffness import geometric_stiffness_expression
from expdesign.elastostatics.measurements import LoadedRobot
from expdesign.errors import ConvergenceError
from expdesign.robots.parallel import ParallelRobot
from expdesign.symbolic import BatchFunction

TOLERANCE = 1e-13
"""m, rad: largest remaining error of the predicted pose, as in the command `compensate`."""
_ITERATIONS = 50


@dataclass(frozen=True)
class Attained:
    """Many repetitions at one target.

    Attributes:
        commands: X̂_C, shape (s, n).
        errors: X̂_A − X_D (m, rad), shape (s, n).
        residual: largest |X̂_C + A(X̂_C)·ĉ − X_D| (m, rad).
    """

    commands: FloatArray
    errors: FloatArray
    residual: float


def observation_expression(loaded: LoadedRobot, pose: ca.SX, wrench: ca.SX) -> ca.SX:
    """A = J̌·diag(Jᵀ·ΔF) (thesis 1.18) at a symbolic pose, n×n_p; with geometric stiffness (I + D·K_G)⁻¹·A."""
    robot = loaded.robot
    forward, pose_map, _ = robot.jacobian_expressions(pose)
    forces = forward.T @ wrench
    observation = pose_map @ ca.diag(forces)
    if not (loaded.geometric_stiffness and isinstance(robot, ParallelRobot)):
        return observation
    compliance = pose_map @ ca.diag(ca.SX(robot.compliance)) @ forward.T
    softening = ca.SX.eye(pose.shape[0]) + compliance @ geometric_stiffness_expression(robot, pose, forces)
    return ca.solve(softening, observation)


class ExactCompensation:
    """Compensation of one robot at one target.

    Args:
        loaded: the robot, commanded by its pose.
        target: X_D, shape (n,).
        wrench: ΔF_D, shape (n,); that of the target's orientation.
        true: compliances of the plant, shape (n_p,).
    """

    def __init__(self, loaded: LoadedRobot, target: FloatArray, wrench: FloatArray, true: FloatArray) -> None:
        self.target = target
        pose = ca.SX.sym("X", len(target))
        estimate = ca.SX.sym("c", len(true))
        observation = observation_expression(loaded, pose, ca.SX(wrench))
        both = [observation @ estimate, observation @ ca.SX(true)]
        self._deflections = BatchFunction("deflections", [pose, estimate], both)
        self._observation = BatchFunction("observation", [pose], [observation])
        columns = [ca.jacobian(observation[:, leg], pose) for leg in range(len(true))]
        self._slopes = BatchFunction("slopes", [pose], columns)
        self.true = true

    def attained(self, estimates: FloatArray) -> Attained:
        """Commands and attained errors for ĉ of shape (s, n_p).

        Raises:
            ConvergenceError: a fixed point is not found.
        """
        commands = self._start(estimates)
        predicted, actual = self._deflections(commands, estimates)
        residual = np.abs(commands + predicted - self.target).max(axis=1)
        for _ in range(_ITERATIONS):
            open_rows = np.flatnonzero(~(residual <= TOLERANCE))
            if not open_rows.size:
                return Attained(commands, commands + actual - self.target, float(residual.max()))
            commands[open_rows] = self.target - predicted[open_rows]
            predicted[open_rows], actual[open_rows] = self._deflections(commands[open_rows], estimates[open_rows])
            residual[open_rows] = np.abs(commands[open_rows] + predicted[open_rows] - self.target).max(axis=1)
        what = f"no command was found for {open_rows.size} of {len(estimates)} estimates"
        raise ConvergenceError(what, remedy="Errors this large cannot be compensated; is the noise in m and rad?")

    def _start(self, estimates: FloatArray) -> FloatArray:
        """Commands with A expanded about the command of the true compliances, shape (s, n)."""
        centre = self.target
        for _ in range(_ITERATIONS):
            (observation,) = self._observation(centre)
            following = self.target - observation @ self.true
            if np.abs(following - centre).max() <= TOLERANCE:
                break
            centre = following
        (observation,) = self._observation(centre)
        slopes = np.stack(self._slopes(centre), axis=-1)  # ∂A_kj/∂X_l as [k, l, j]
        step = (self.target - centre) - estimates @ observation.T
        commands: FloatArray = centre + step
        # X − centre = step − (∂A·ĉ)(X − centre), solved by substituting once: what is left is of third order.
        commands -= np.einsum("klj,sj,sl->sk", slopes, estimates, step, optimize=True)
        return commands
