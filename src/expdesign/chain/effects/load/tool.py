"""A tool or a payload of unknown mass and centre rides on the tip in every row.

Its weight is m·g, at R·c about the origin of P; the first moments m·c are fitted, in which it is linear. In deflections
it is there before and after, and cancels.
"""

import casadi as ca

from expdesign.chain.component import PLATFORM, Component
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.moments import moment
from expdesign.recordings.measurand import POSITIONS
from expdesign.robots.robot import Robot

_SMALLEST = 1e-9
"""kg; a centre of less is not told."""


class UnknownTool(Effect):
    """`tool_mass_kg` and the first moments `tool_moment_x_kgm` ...; reported with the centre of mass."""

    physics = "payload_mass_error"
    measurands = (POSITIONS,)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [PLATFORM] if robot.coordinates.centre_of_mass else []

    def describe(self) -> tuple[Parameter, ...]:
        moments = (Parameter(f"tool_moment_{axis}_kgm", 0.1) for axis in self.robot.coordinates.axes)
        return (Parameter("tool_mass_kg", 1.0, low=-1e5, high=1e6), *moments)

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        return wrench + ca.vertcat(theta[0] * row.gravity, moment(row.rotation @ theta[1:], row.gravity))

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        mass = ca.if_else(ca.fabs(theta[0]) > _SMALLEST, theta[0], _SMALLEST)
        centre = {f"tool_com_{axis}_m": theta[1 + i] / mass for i, axis in enumerate(self.robot.coordinates.axes)}
        return {"tool_mass_kg": theta[0], **centre}

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        mass = values["tool_mass_kg"]
        centre = ", ".join(f"{1e3 * values[name][0]:.0f}" for name in values if name.startswith("tool_com"))
        return (
            f"A tool of {mass[0]:.3g} kg ({mass[1]:.3g} to {mass[2]:.3g}) that nothing accounts for rides on the tip, "
            f"its centre of mass at ({centre}) mm in its axes."
        )
