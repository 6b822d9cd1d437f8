"""Forward kinematics of parallel robots: the pose at given leg lengths, by Newton's method from a pose nearby.

q(X + δX) = q(X) + ∂q/∂X·δX (thesis 1.13); from within the workspace it converges quadratically, and where it does not,
the lengths belong to no pose near the start.
"""

from functools import lru_cache

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import ConvergenceError
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.symbolic import BatchFunction

_TOLERANCE = 1e-14
"""m of leg length; rounding of lengths below a metre is 1e-16."""
_PASSES = 30


class ForwardKinematics:
    """X(q; g) of a parallel robot.

    Args:
        robot: the robot; its own geometry holds where none is given.
    """

    def __init__(self, robot: ParallelRobot) -> None:
        self._robot = robot
        pose, geometry = ca.SX.sym("X", robot.coordinates.n), ca.SX.sym("g", len(robot.geometry))
        lengths = robot.actuator_lengths(pose, geometry)
        self._rates = BatchFunction("rates", [pose, geometry], [lengths, ca.jacobian(lengths, pose)])

    def pose(self, lengths: FloatArray, start: FloatArray, geometry: FloatArray | None = None) -> FloatArray:
        """Poses (..., n) with the given leg lengths (m), near `start` (..., n).

        Args:
            lengths: shape (..., n_p).
            start: poses nearby, shape (..., n).
            geometry: joint coordinates in the order of `geometry_names` (m), shape (..., n_g); the robot's own if None.

        Raises:
            ConvergenceError: no pose near the start has these lengths.
        """
        coordinates = self._robot.geometry if geometry is None else geometry
        batch = np.broadcast_shapes(lengths.shape[:-1], start.shape[:-1], coordinates.shape[:-1])
        pose: FloatArray = np.broadcast_to(start, (*batch, start.shape[-1])).copy()
        for _ in range(_PASSES):
            reached, rates = self._rates(pose, coordinates)
            missing = lengths - reached
            if not np.isfinite(rates).all():
                break
            pose += np.linalg.solve(rates, missing[..., None])[..., 0]
            if np.abs(missing).max() < _TOLERANCE * max(1.0, float(np.abs(lengths).max()) / 0.1):
                return pose
        what = "there is no pose with these leg lengths near the one that is expected"
        raise ConvergenceError(what, remedy="Check the lengths, or the geometry in the robot file.")


@lru_cache(maxsize=32)
def forward_kinematics(robot: ParallelRobot) -> ForwardKinematics:
    """The forward kinematics of a robot; its expressions are made once."""
    return ForwardKinematics(robot)
