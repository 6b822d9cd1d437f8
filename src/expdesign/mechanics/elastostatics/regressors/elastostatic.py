"""Compliances of the actuators: A = J̌·diag(JᵀΔF) (thesis 1.17, 1.18; theory.md 2.3)."""

from expdesign.arrays import FloatArray
from expdesign.mechanics.elastostatics.regressors.regressor import PoseMaps, Regressor
from expdesign.mechanics.robots.robot import Robot


class Elastostatic(Regressor):
    """Deflection per compliance (N and N·rad/m); the parameters are c = 1/k (m/N or rad/(N·m))."""

    noun = "stiffnesses"
    measurement = "loaded measurement"
    needs_load = True

    def names(self, robot: Robot) -> tuple[str, ...]:
        return robot.actuators

    def scale(self, robot: Robot) -> FloatArray:
        return robot.compliance

    def nominal(self, robot: Robot) -> FloatArray:
        return robot.compliance

    def matrix(self, maps: PoseMaps) -> FloatArray:
        matrix: FloatArray = maps.pose * maps.forces[..., None, :]
        return matrix
