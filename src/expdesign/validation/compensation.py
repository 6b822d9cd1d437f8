"""The exact compensation of very many estimates at one target, and what the explicit plant then attains.

theory.md 4.1: the command solves X̂_C + A(X̂_C, ΔF_D)·ĉ = X_D, and plant P1 attains X̂_A = X̂_C + A(X̂_C, ΔF_D)·c. The
iteration X ← X_D − A(X)·ĉ contracts by about ‖ΔX‖ divided by the size of the robot. Its start is X_D − A(X)·ĉ with A
expanded to first order about the command of the true compliances, so that one evaluation, which every sample needs
anyway to see that it solves the fixed point, is nearly always the only one.

A robot that is commanded by its actuators (an arm) is compensated there: q̂_C + diag(τ(q̂_C))·ĉ = q_D, τ = Jᵀ·ΔF_D, which
is the same iteration with another map; the tip's error is J̌ halfway times what the actuators are off.
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
"""m, rad: largest remaining error of the predicted configuration, as in the command `compensate`."""
_ITERATIONS = 50


@dataclass(frozen=True)
class Attained:
    """Many repetitions at one target.

    Attributes:
        commands: X̂_C (or q̂_C), shape (s, n_q).
        errors: X̂_A − X_D (m, rad), shape (s, n).
        residual: largest error of the predicted configuration at a command (m, rad).
    """

    commands: FloatArray
    errors: FloatArray
    residual: float


def deflection_map(loaded: LoadedRobot, configuration: ca.SX, wrench: ca.SX) -> ca.SX:
    """Change of the configuration per compliance at a symbolic configuration, n_q×n_p.

    For a robot commanded by its pose A = J̌·diag(JᵀΔF) (thesis 1.18), with geometric stiffness (I + D·K_G)⁻¹·A; for one
    commanded by its actuators diag(JᵀΔF).
    """
    robot = loaded.robot
    forward, pose_map, _ = robot.jacobian_expressions(configuration)
    forces = forward.T @ wrench
    if not isinstance(robot, ParallelRobot):
        return ca.diag(forces)
    observation = pose_map @ ca.diag(forces)
    if not loaded.geometric_stiffness:
        return observation
    compliance = pose_map @ ca.diag(ca.SX(robot.compliance)) @ forward.T
    stiffness = geometric_stiffness_expression(robot, configuration, forces)
    return ca.solve(ca.SX.eye(configuration.shape[0]) + compliance @ stiffness, observation)


class ExactCompensation:
    """Compensation of one robot at one target.

    Args:
        loaded: the robot.
        target: X_D or q_D, shape (n_q,).
        wrench: ΔF_D, shape (n,); that of the target's orientation.
        true: compliances of the plant, shape (n_p,).
        truth: the plant, where its geometry is not that of `loaded`.
    """

    def __init__(
        self,
        loaded: LoadedRobot,
        target: FloatArray,
        wrench: FloatArray,
        true: FloatArray,
        truth: LoadedRobot | None = None,
    ) -> None:
        self.robot = loaded.robot
        self.target = target
        self.true = true
        configuration = ca.SX.sym("X", len(target))
        estimate = ca.SX.sym("c", len(true))
        mapped = deflection_map(loaded, configuration, ca.SX(wrench))
        real = mapped if truth is None else deflection_map(truth, configuration, ca.SX(wrench))
        both = [mapped @ estimate, real @ ca.SX(true)]
        self._deflections = BatchFunction("deflections", [configuration, estimate], both)
        self._map = BatchFunction("map", [configuration], [mapped])
        columns = [ca.jacobian(mapped[:, leg], configuration) for leg in range(len(true))]
        self._slopes = BatchFunction("slopes", [configuration], columns)

    def attained(self, estimates: FloatArray) -> Attained:
        """Commands and attained errors for ĉ of shape (s, n_p).

        Raises:
            ConvergenceError: a fixed point is not found.
        """
        commands = self._start(estimates)
        predicted, actual = self._deflections(commands, estimates)
        residual = np.abs(commands + predicted - self.target).max(axis=1)
        for _ in range(_ITERATIONS):
            rows = np.flatnonzero(~(residual <= TOLERANCE))
            if not rows.size:
                return Attained(commands, self._pose_errors(commands + actual), float(residual.max()))
            commands[rows] = self.target - predicted[rows]
            predicted[rows], actual[rows] = self._deflections(commands[rows], estimates[rows])
            residual[rows] = np.abs(commands[rows] + predicted[rows] - self.target).max(axis=1)
        what = f"no command was found for {rows.size} of {len(estimates)} repetitions"
        raise ConvergenceError(what, remedy="Errors this large cannot be compensated; is the noise in m and rad?")

    def _pose_errors(self, reached: FloatArray) -> FloatArray:
        """Attained minus wanted pose (s, n) where the configurations (s, n_q) were reached."""
        difference = reached - self.target
        if isinstance(self.robot, ParallelRobot):
            return difference
        halfway = self.robot.jacobians(self.target + difference / 2.0).pose
        errors: FloatArray = (halfway @ difference[..., None])[..., 0]
        return errors

    def _start(self, estimates: FloatArray) -> FloatArray:
        """Commands with the map expanded about the command of the true compliances, shape (s, n_q)."""
        centre = self.target
        for _ in range(_ITERATIONS):
            (mapped,) = self._map(centre)
            following = self.target - mapped @ self.true
            if np.abs(following - centre).max() <= TOLERANCE:
                break
            centre = following
        (mapped,) = self._map(centre)
        slopes = np.stack(self._slopes(centre), axis=-1)  # ∂A_kj/∂X_l as [k, l, j]
        step = (self.target - centre) - estimates @ mapped.T
        # X − centre = step − (∂A·ĉ)(X − centre), solved by substituting once: what is left is of third order.
        turned = (estimates @ slopes.reshape(-1, len(self.true)).T).reshape(-1, *slopes.shape[:2])
        commands: FloatArray = centre + step - (turned @ step[..., None])[..., 0]
        return commands
