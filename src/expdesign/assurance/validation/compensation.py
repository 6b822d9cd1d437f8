"""The exact compensation of very many estimates at one target, and what the explicit plant then attains.

theory.md 4.1: the command solves X̂_C + A(X̂_C, ΔF_D)·ĉ = X_D, and plant P1 attains X̂_A = X̂_C + A(X̂_C, ΔF_D)·c. The
iteration X ← X_D − A(X)·ĉ contracts by about ‖ΔX‖ divided by the size of the robot. Its start is X_D − A(X)·ĉ with A
expanded to first order about the command of the true compliances, so that one evaluation, which every sample needs
anyway to see that it solves the fixed point, is nearly always the only one.

With the physics of a model file X̂_C + f(X̂_C, ĉ) = X_D takes the place of the first equation, f the chain's motion of
the platform under the target's load; it is linear in X and c to the order at which the iteration starts.

A robot that is commanded by its actuators (an arm) is compensated there: q̂_C + diag(τ(q̂_C))·ĉ = q_D, τ = Jᵀ·ΔF_D, which
is the same iteration with another map; the tip's error is J̌ halfway times what the actuators are off. With the physics
of a model file its error is taken at the target, f(q_D, c) − f(q_D, ĉ), to first order in the deflection.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import ConvergenceError
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.symbolic import BatchFunction


@dataclass(frozen=True)
class Convergence:
    """When an iteration over poses has ended.

    Attributes:
        tolerance: largest remaining error or last change (m, rad), as in the command `compensate`.
        steps: at most.
        rounding: errors (m, rad) below this differ from a prediction of 0 by nothing.
    """

    tolerance: float = 1e-13
    steps: int = 60
    rounding: float = 1e-12


CONVERGENCE = Convergence()
"""Of every plant."""


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

    For a robot commanded by its pose A = J̌·diag(JᵀΔF) (thesis 1.18), for one commanded by its actuators diag(JᵀΔF).
    """
    robot = loaded.robot
    forward, pose_map, _ = robot.jacobian_expressions(configuration)
    forces = forward.T @ wrench
    return ca.diag(forces) if robot.jointed else pose_map @ ca.diag(forces)


def _deflection(
    loaded: LoadedRobot, configuration: ca.SX, wrench: FloatArray, compliances: ca.SX, parameters: FloatArray | None
) -> ca.SX:
    """Deflection (n,), or that of the joints of an arm, under the target's load."""
    if loaded.under_load is not None and parameters is not None:
        return loaded.under_load.expression(configuration, ca.SX(parameters), compliances)
    return deflection_map(loaded, configuration, ca.SX(wrench)) @ compliances


class ExactCompensation:
    """Compensation of one robot at one target.

    Args:
        loaded: the robot.
        target: X_D or q_D, shape (n_q,).
        wrench: ΔF_D, shape (n,); that of the target's orientation.
        true: compliances of the plant, shape (n_p,).
        parameters: of the target's load, shape (k,), where a robot has physics of its own.
        truth: the plant at the target, where it is not `loaded`.
    """

    def __init__(
        self,
        loaded: LoadedRobot,
        target: FloatArray,
        wrench: FloatArray,
        true: FloatArray,
        parameters: FloatArray | None = None,
        truth: LoadedRobot | None = None,
    ) -> None:
        self.robot = loaded.robot
        self.target = target
        self.true = true
        configuration = ca.SX.sym("X", len(target))
        estimate = ca.SX.sym("c", len(true))
        deflection = _deflection(loaded, configuration, wrench, estimate, parameters)
        known = ca.SX(loaded.robot.compliance)
        mapped = ca.substitute(ca.jacobian(deflection, estimate), estimate, known)
        at_known = ca.substitute(deflection, estimate, known)
        real = _deflection(truth or loaded, configuration, wrench, ca.SX(true), parameters)
        self._deflections = BatchFunction("deflections", [configuration, estimate], [deflection, real])
        # What does not follow from the compliances moves the platform as well.
        self._map = BatchFunction("map", [configuration], [mapped, at_known - mapped @ known])
        columns = [ca.jacobian(mapped[:, leg], configuration) for leg in range(len(true))]
        self._slopes = BatchFunction("slopes", [configuration], columns)
        self._at_target = loaded.under_load is not None and loaded.robot.configuration != loaded.robot.coordinates.pose

    def attained(self, estimates: FloatArray) -> Attained:
        """Commands and attained errors for ĉ of shape (s, n_p).

        Raises:
            ConvergenceError: a fixed point is not found.
        """
        if self._at_target:
            commands = np.broadcast_to(self.target, (len(estimates), len(self.target))).copy()
            predicted, actual = self._deflections(commands, estimates)
            return Attained(commands, actual - predicted, 0.0)
        commands = self._start(estimates)
        predicted, actual = self._deflections(commands, estimates)
        residual = np.abs(commands + predicted - self.target).max(axis=1)
        for _ in range(CONVERGENCE.steps):
            rows = np.flatnonzero(~(residual <= CONVERGENCE.tolerance))
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
        if not self.robot.jointed:
            return difference
        halfway = self.robot.jacobians(self.target + difference / 2.0).pose
        errors: FloatArray = (halfway @ difference[..., None])[..., 0]
        return errors

    def _start(self, estimates: FloatArray) -> FloatArray:
        """Commands with the map expanded about the command of the true compliances, shape (s, n_q)."""
        centre = self.target
        for _ in range(CONVERGENCE.steps):
            mapped, further = self._map(centre)
            following = self.target - mapped @ self.true - further
            if np.abs(following - centre).max() <= CONVERGENCE.tolerance:
                break
            centre = following
        mapped, further = self._map(centre)
        slopes = np.stack(self._slopes(centre), axis=-1)  # ∂A_kj/∂X_l as [k, l, j]
        step = (self.target - centre) - further - estimates @ mapped.T
        # X − centre = step − (∂A·ĉ)(X − centre), solved by substituting once: what is left is of third order.
        turned = (estimates @ slopes.reshape(-1, len(self.true)).T).reshape(-1, *slopes.shape[:2])
        commands: FloatArray = centre + step - (turned @ step[..., None])[..., 0]
        return commands
