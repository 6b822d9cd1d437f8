"""A tool or a payload of unknown mass and centre rides on the tip in every row.

Its weight is m·g, at R·c about the origin of P; the first moments m·c are fitted, in which it is linear. In deflections
it is there before and after, and cancels. Of a robot with several tips each may have a tool, which loads the
joints that carry it in rows of every tip (and the base's own compliance in rows of its own tip alone).
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import casadi as ca

from expdesign.chain.component import PLATFORM, Component
from expdesign.chain.declaration import ONLY, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import POSITIONS
from expdesign.chain.row import Row
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


class UnknownTool(Effect):
    """`tool_mass_kg` and the first moments `tool_moment_x_kgm` ...; reported with the centre of mass.

    Variants: the names of the tips, where there are several.
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
    def components(cls, robot: Robot) -> list[Component]:
        return [PLATFORM] if robot.coordinates.centre_of_mass else []

    @classmethod
    def variants(cls, robot: Robot) -> Sequence[Variant]:
        tips = robot.links.tree.tips if robot.jointed else ()
        return [Tip(number, name) for number, name in enumerate(tips)] if len(tips) > 1 else [ONLY]

    @property
    def slot(self) -> tuple[Hashable, ...]:
        return self.physics, self.component, self.variant

    def describe(self) -> tuple[Parameter, ...]:
        moments = (Parameter(f"tool_moment_{axis}_kgm", 0.1) for axis in self.robot.coordinates.axes)
        return (Parameter("tool_mass_kg", 1.0, low=0.0, high=1e6), *moments)

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

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        mass = values["tool_mass_kg"]
        centre = ", ".join(f"{1e3 * values[name][0]:.0f}" for name in values if name.startswith("tool_com"))
        tip = f"the tip `{self.variant}`" if isinstance(self.variant, Tip) else "the tip"
        return (
            f"A tool of {mass[0]:.3g} kg ({mass[1]:.3g} to {mass[2]:.3g}) that nothing accounts for rides on {tip}, "
            f"its centre of mass at ({centre}) mm in its axes."
        )
