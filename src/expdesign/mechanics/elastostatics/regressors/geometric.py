"""Errors of the geometry of a parallel robot: A^g = J̌·[−∂q/∂g, I] (theory.md 9.I).

The parameters are errors of every joint coordinate g in the robot file and of every leg's length. At given readings of
the actuators q(X; g) = q + δl holds, so that δX = J̌·(δl − ∂q/∂g·δg); for a hexapod row i of the bracket is
[u_iᵀ (base joint), −u_iᵀR (platform joint), 1 (length)], 42 parameters in all. What is measured are poses without load,
against the commanded ones.
"""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.elastostatics.regressors.regressor import PoseMaps, Regressor
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot import Robot

TYPICAL_ERROR = 1e-4
"""m; of joints and lengths before calibration."""


class Geometric(Regressor):
    """Pose error per error of a joint coordinate or a leg's length (1 and rad/m)."""

    noun = "geometric parameters"
    measurement = "pose measurement"
    needs_load = False

    def names(self, robot: Robot) -> tuple[str, ...]:
        return (*_closed_form(robot).geometry_names, *(f"{name} length" for name in robot.actuators))

    def scale(self, robot: Robot) -> FloatArray:
        return np.full(len(self.names(robot)), TYPICAL_ERROR)

    def nominal(self, robot: Robot) -> FloatArray:
        return np.zeros(len(self.names(robot)))

    def require(self, robot: Robot) -> str | None:
        return "geometric calibration needs a robot on legs" if robot.inverse_kinematics is None else None

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        closed_form = _closed_form(robot)
        geometry = ca.SX.sym("g", len(closed_form.geometry))
        rates = ca.jacobian(closed_form.actuator_lengths(configuration, geometry), geometry)
        return {"geometry": ca.substitute(rates, geometry, ca.SX(closed_form.geometry))}

    def matrix(self, maps: PoseMaps) -> FloatArray:
        return np.concatenate([-maps.pose @ maps.further["geometry"], maps.pose], axis=-1)


def _closed_form(robot: Robot) -> ParallelRobot:
    closed_form = robot.inverse_kinematics
    assert closed_form is not None  # `Geometric.require`
    return closed_form
