"""Geometry of a robot on legs: every joint's place and every leg's length, as absolute poses show them (theory.md 9.I).

The true pose X solves q(X; g + δg) = q(X_C; g) + δl, X_C being the command: the controller computes lengths with the
nominal geometry g, and the machine has another one.
"""

import casadi as ca
import numpy as np

from expdesign.chain.component import GEOMETRY, Component, each_leg
from expdesign.chain.declaration import ONLY
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.effects.legs.joint_position_error import JointPositionError
from expdesign.chain.recordings.recordings import POSES, POSITIONS
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot import Robot

WIDEST = 0.02
"""m; standard deviation of joints and lengths of which nothing is known beforehand, far above what machining leaves."""
_SCALE = 1e-4


class LegGeometry(Effect):
    """True minus nominal joints (m) in the frame each is fixed to, then true minus commanded lengths (m or rad).

    It is part of every model of a geometric calibration.
    """

    physics = "joint_position_error"
    declared = JointPositionError.declared
    measurands = (POSES, POSITIONS)
    changes_geometry = True

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [GEOMETRY] if each_leg(robot) else []

    @property
    def _closed_form(self) -> ParallelRobot:
        return self.robot.inverse_kinematics

    def describe(self) -> tuple[Parameter, ...]:
        known = self.robot.geometry_std
        spread = WIDEST if known is None else known
        limit = 50.0 * spread
        joints = [f"{name.replace(' ', '_')}_m" for name in self._closed_form.geometry_names]
        pairs = zip(self.robot.actuators, self.robot.units, strict=True)
        lengths = [f"{name.replace(' ', '_')}_length_{unit}" for name, unit in pairs]
        return tuple(Parameter(name, _SCALE, low=-limit, high=limit, spread=spread) for name in (*joints, *lengths))

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        return geometry + theta[: geometry.shape[0]]

    def lengths(self, commanded: ca.SX, theta: ca.SX) -> ca.SX:
        return commanded + theta[-commanded.shape[0] :]

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        errors = 1e3 * np.array([value[0] for value in values.values()])
        return (
            f"Joints and lengths of the legs differ from the robot file by {np.sqrt((errors**2).mean()):.3g} mm "
            f"(RMS of {len(errors)} parameters)."
        )


def leg_geometry(robot: Robot) -> LegGeometry:
    """The geometry of a robot on legs; raises `ValueError` for another robot."""
    return LegGeometry(robot, GEOMETRY, ONLY)
