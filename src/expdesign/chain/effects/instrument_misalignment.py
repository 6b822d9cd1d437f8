"""The instrument's axes are rotated from the base frame by Q.

An instrument that measures poses reads the position Qᵀ·p and the orientation Qᵀ·R·Q in its own axes, and a deflection
is the difference of two such readings. Some software turns the differences themselves instead; at poses away from zero
the two differ.
"""

import casadi as ca

from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.hexapod import Hexapod
from expdesign.robots.orientation import angles_of, rotation_matrix
from expdesign.robots.robot import Robot


class InstrumentMisalignment(Effect):
    """Variants: empty (poses are read in the turned axes) and `differences` (deflections are turned)."""

    physics = "instrument_misalignment"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        spatial = isinstance(robot, Hexapod)
        return [("instrument", variant) for variant in (("", "differences") if spatial else ("",))]

    def describe(self) -> tuple[Parameter, ...]:
        axes = "xyz" if self.robot.coordinates.n > 2 else "z"
        return tuple(Parameter(f"rot_{axis}_rad", 1e-2, low=-1.0, high=1.0) for axis in axes)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if theta.shape[0] == 1:
            c, s = ca.cos(theta[0]), ca.sin(theta[0])
            return ca.vertcat(c * reading[0] + s * reading[1], -s * reading[0] + c * reading[1])
        turn = rotation_matrix(theta, "fixed-xyz")
        if self.variant == "differences" or not isinstance(self.robot, Hexapod):
            return ca.vertcat(turn.T @ reading[:3], turn.T @ reading[3:])
        angles = angles_of(turn.T @ row.rotation @ turn, self.robot.orientation)
        pose = ca.SX.sym("read", 6)
        rates = ca.substitute(self.robot.pose_rate_map(pose), pose, ca.vertcat(row.pose[:3], angles))
        twist = ca.solve(row.rates, reading)
        return rates @ ca.vertcat(turn.T @ twist[:3], turn.T @ twist[3:])

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        angles = ", ".join(f"{1e3 * v[0]:.2f}" for v in values.values())
        return f"The instrument's axes are rotated from the base frame by ({angles}) mrad."
