"""A tool that nothing states."""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from expdesign.chain.component import PLATFORM, on
from expdesign.chain.declaration import ONLY, Declaration, Input, Size, Variant
from expdesign.chain.effect import Parameter, Values
from expdesign.chain.recordings.recordings import POSITIONS
from expdesign.chain.row import Row
from expdesign.chain.tabulated import TabulatedEffect
from expdesign.mechanics.robots.orientation import moment
from expdesign.mechanics.robots.robot import Robot

_SMALLEST = 1e-9
"""kg; a centre of less is not told."""


@dataclass(frozen=True)
class Tip:
    """The tip that has the tool, where a robot has several."""

    number: int
    name: str

    def __str__(self) -> str:
        return self.name


class UnknownTool(TabulatedEffect):
    """A tool or a payload of unknown mass and centre rides on the tip in every row.

    Its weight is m·g, at R·c about the origin of P; the first moments m·c (`tool_moment_x_kgm`) are fitted, in which
    it is linear, and the centre of mass is reported. In deflections it is there before and after, and cancels. Of a
    robot with several tips each may have a tool (variants: their names), which loads the joints that carry it in rows
    of every tip, and the base's own compliance in rows of its own tip alone.
    """

    physics = "payload_mass_error"
    declared = Declaration(
        left_out="a tool that nothing states",
        phrase="masses that are not what was assumed",
        usually="cables and adapters",
        port="payload",
        inputs=(Input.PLACE,),
        sizes=(
            Size("tool_mass_kg", 0.1, "assumed: a cable or an adapter of 0.1 kg that no drawing has"),
            Size("tool_moment_?_kgm", 0.01, "assumed: the same at 0.1 m"),
        ),
    )
    measurands = (POSITIONS,)

    @classmethod
    def variants(cls, robot: Robot) -> Sequence[Variant]:
        tips = robot.links.tree.tips if robot.jointed else ()
        return [Tip(number, name) for number, name in enumerate(tips)] if len(tips) > 1 else [ONLY]

    at = on(lambda robot: robot.coordinates.centre_of_mass, PLATFORM)
    together = True
    quantities = (
        Parameter("tool_mass_kg", 1.0, low=0.0, high=1e6),
        Parameter("tool_moment_{axis}_kgm", 0.1),
    )

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        weight = ca.vertcat(theta[0] * row.gravity, moment(row.rotation @ theta[1:], row.gravity))
        if not isinstance(self.variant, Tip):
            return wrench + weight
        return wrench + self.robot.links.tree.looked_at(row.pose)[self.variant.number] * weight

    def own_weight_change(self, row: Row, theta: ca.SX) -> ca.SX:
        """In rows of other tips the tool weighs as a part of the robot."""
        if not isinstance(self.variant, Tip):
            return super().own_weight_change(row, theta)
        tree = self.robot.links.tree
        q = ca.SX.sym("q", len(self.robot.configuration))
        pose = tree.forward(q)[self.variant.name]
        # The first moments are no functions of q: their sum with the mass is m·p, of which gravity makes the torque.
        potential = ca.dot(row.gravity, theta[0] * pose[:3, 3] + pose[:3, :3] @ theta[1:])
        torque = ca.gradient(potential, q)[: len(self.robot.stiffness)]
        elsewhere = 1.0 - tree.looked_at(row.pose)[self.variant.number]
        return elsewhere * ca.substitute(torque, q, row.pose)

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        mass = ca.if_else(ca.fabs(theta[0]) > _SMALLEST, theta[0], _SMALLEST)
        centre = {f"tool_com_{axis}_m": theta[1 + i] / mass for i, axis in enumerate(self.robot.coordinates.axes)}
        return {"tool_mass_kg": theta[0], **centre}

    def sentence(self, values: Values) -> str:
        centre = ", ".join(f"{1e3 * values[name][0]:.0f}" for name in values if name.startswith("tool_com"))
        tip = "the tip `{variant}`" if isinstance(self.variant, Tip) else "the tip"
        rides = f"rides on {tip}, its centre of mass at ({centre}) mm in its axes."
        return self.said(f"A tool of {{tool_mass_kg:.3g}} kg that nothing accounts for {rides}", values)
