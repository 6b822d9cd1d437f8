"""The instrument's axes are rotated from the base frame by Q.

An instrument that measures poses reads the position Qᵀ·p and the orientation Qᵀ·R·Q in its own axes, and a deflection
is the difference of two such readings. Some software turns the differences themselves instead; at poses away from zero
the two differ.

Q is given by the angles of `fixed-xyz`, Q = Rz(rot_z)·Ry(rot_y)·Rx(rot_x), whatever the robot's own convention; the
columns of Q are the instrument's axes in the base frame.
"""

import casadi as ca

from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.chain.support import measured_axes
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.body import Body
from expdesign.robots.hexapod import Hexapod
from expdesign.robots.orientation import angles_of, rotation_matrix
from expdesign.robots.robot import Robot


def _seen_turns(points: LoadedPoints) -> list[str]:
    """Variants for a body: a turn about an axis shows where the two axes that it mixes were measured."""
    axes = measured_axes(points)
    pairs = {"x": ({1, 2}, {4, 5}), "y": ({0, 2}, {3, 5}), "z": ({0, 1}, {3, 4})}
    seen = [axis for axis, mixed in pairs.items() if any(pair <= axes for pair in mixed)]
    return [""] if len(seen) == len(pairs) else [f"about {axis}" for axis in seen]


class InstrumentMisalignment(Effect):
    """Variants: empty (poses are read in the turned axes), `differences` (deflections are turned), and for bodies of
    which not all axes were measured `about z` and so on (deflections are turned about one axis).
    """

    physics = "instrument_misalignment"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        if points.marker is not None:
            return []  # the instrument's frame is a parameter of every model
        if isinstance(robot, Body):
            return [("instrument", variant) for variant in _seen_turns(points)]
        spatial = isinstance(robot, Hexapod)
        return [("instrument", variant) for variant in (("", "differences") if spatial else ("",))]

    def describe(self) -> tuple[Parameter, ...]:
        axes = "xyz" if self.robot.coordinates.n > 2 else "z"
        if self.variant.startswith("about"):
            axes = self.variant[-1]
        return tuple(Parameter(f"rot_{axis}_rad", 1e-2, low=-1.0, high=1.0) for axis in axes)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.variant.startswith("about"):
            angles = ca.SX.zeros(3)
            angles["xyz".index(self.variant[-1])] = theta[0]
            turn = rotation_matrix(angles, "fixed-xyz")
            return ca.vertcat(turn.T @ reading[:3], turn.T @ reading[3:])
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
