"""The exact compensation of very many estimates at one target, and what the explicit plant then attains.

theory.md 4.1: the command solves X̂_C + A(X̂_C, ΔF_D)·ĉ = X_D, and plant P1 attains X̂_A = X̂_C + A(X̂_C, ΔF_D)·c. The
iteration X ← X_D − A(X)·ĉ contracts by about ‖ΔX‖ divided by the size of the robot, 1e-4 on a stiff one: four
evaluations, of which the first is the same for all estimates, reach the rounding.

With the physics of a model file X̂_C + f(X̂_C, ĉ) = X_D takes the place of the first equation, f the chain's motion of
the platform under the target's load.

A robot that is commanded by its actuators (an arm) is compensated there: q̂_C + diag(τ(q̂_C))·ĉ = q_D, τ = Jᵀ·ΔF_D, which
is the same iteration with another map; the tip's error is J̌ halfway times what the actuators are off. With the physics
of a model file its error is taken at the target, f(q_D, c) − f(q_D, ĉ), to first order in the deflection.
"""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import ConvergenceError
from expdesign.mechanics.elastostatics.maps import actuator_forces
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.symbolic import BatchFunction

TOLERANCE, STEPS = 1e-13, 60
"""m, rad: largest remaining error or last change at which an iteration over poses ends, as in the command `compensate`;
steps at most.
"""


def settled(step: Callable[[FloatArray], FloatArray], start: FloatArray) -> tuple[FloatArray, float]:
    """The fixed point of a step that contracts (s, n), and the largest last change.

    Raises:
        ConvergenceError: it is not found.
    """
    place = start
    for _ in range(STEPS):
        before, place = place, step(place)
        moved = np.abs(place - before).max(axis=1)
        if (moved <= TOLERANCE).all():
            return place, float(moved.max())
    what = f"no command was found for {int((~(moved <= TOLERANCE)).sum())} of {len(start)} repetitions"
    raise ConvergenceError(what, remedy="Errors this large cannot be compensated; is the noise in m and rad?")


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


def deflections_under(
    loaded: LoadedRobot, wrench: FloatArray, parameters: FloatArray | None = None
) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """How far a load moves a robot, as a function of configurations (..., n_q) and compliances (..., n_p).

    A·c with A = J̌·diag(JᵀΔF) (thesis 1.18) of a robot that is commanded by its pose, diag(JᵀΔF)·c of the joints of an
    arm, shape (..., n_q); with physics of its own what its chain says.

    Args:
        loaded: the robot.
        wrench: ΔF, shape (n,).
        parameters: of the load, shape (k,), where the robot has physics of its own.
    """
    robot = loaded.robot
    if loaded.under_load is not None and parameters is not None:
        symbols = ca.SX.sym("X", len(robot.configuration)), ca.SX.sym("c", len(robot.stiffness))
        moved = loaded.under_load.expression(symbols[0], ca.SX(parameters), symbols[1])
        function = BatchFunction("deflections", symbols, [moved])
        return lambda configurations, compliances: function(configurations, compliances)[0]

    def explicit(configurations: FloatArray, compliances: FloatArray) -> FloatArray:
        jacobians = robot.jacobians(configurations)
        yielded: FloatArray = actuator_forces(jacobians, wrench) * compliances
        return yielded if robot.jointed else (jacobians.pose @ yielded[..., None])[..., 0]

    return explicit


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
        self.robot, self.target, self.true = loaded.robot, target, true
        self._predicted = deflections_under(loaded, wrench, parameters)
        # What does not follow from the compliances moves the platform as well.
        self._actual = self._predicted if truth is None else deflections_under(truth, wrench, parameters)
        self._at_target = loaded.under_load is not None and loaded.robot.configuration != loaded.robot.coordinates.pose

    def attained(self, estimates: FloatArray) -> Attained:
        """Commands and attained errors for ĉ of shape (s, n_p).

        Raises:
            ConvergenceError: a fixed point is not found.
        """
        if self._at_target:
            off = self._actual(self.target, self.true) - self._predicted(self.target, estimates)
            return Attained(np.tile(self.target, (len(estimates), 1)), off, 0.0)
        start = self.target - self._predicted(self.target, estimates)
        commands, residual = settled(lambda place: self.target - self._predicted(place, estimates), start)
        return Attained(commands, self._pose_errors(commands + self._actual(commands, self.true)), residual)

    def _pose_errors(self, reached: FloatArray) -> FloatArray:
        """Attained minus wanted pose (s, n) where the configurations (s, n_q) were reached."""
        difference = reached - self.target
        if not self.robot.jointed:
            return difference
        halfway = self.robot.jacobians(self.target + difference / 2.0).pose
        errors: FloatArray = (halfway @ difference[..., None])[..., 0]
        return errors
