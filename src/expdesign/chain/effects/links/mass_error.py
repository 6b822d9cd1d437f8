"""A link weighs something else than its URDF says (CAD masses without cables, covers or grease).

Own weight cancels from deflections, so that a link's mass shows in positions only, as a sag other than the assumed one.
"""

from collections.abc import Sequence

import casadi as ca

from expdesign.chain.component import Component, heavy_links
from expdesign.chain.declaration import Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import POSITIONS
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

_SPREAD = 0.3
"""Standard deviation of a link's true mass about that of its CAD model, which lacks cables, covers and grease."""


class LinkMassError(Effect):
    """`link k`, with what hangs on it, weighs 1 + `relative_mass_error` times as much as assumed."""

    physics = "payload_mass_error"
    declared = Declaration(
        left_out="error of a mass or of the scale of a wrench",
        phrase="masses that are not what was assumed",
        usually="cables, covers and grease that a CAD model lacks",
        port="actuators",
        inputs=(Input.PLACE,),
        sizes=(Size("relative_mass_error", _SPREAD, "assumed: what CAD models of links leave out"),),
    )
    measurands = (POSITIONS,)

    @classmethod
    def components(cls, robot: Robot) -> Sequence[Component]:
        return heavy_links(robot)

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("relative_mass_error", 0.1, low=-0.9, high=3.0, spread=_SPREAD),)

    def own_weight_change(self, row: Row, theta: ca.SX) -> ca.SX:
        robot = self.robot.links
        q = ca.SX.sym("q", len(self.robot.configuration))
        only = ca.SX([float(k == self.component.index) for k in range(len(self.robot.stiffness))])
        torque = robot.own_weight_expression(q, row.gravity, factors=only)
        return theta[0] * ca.substitute(torque, q, row.pose)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["relative_mass_error"]
        size = f"{100 * v[0]:+.1f} % ({100 * v[1]:+.1f} to {100 * v[2]:+.1f} %)"
        return f"{self.subject}, with what hangs on it, is {size} heavier than the URDF says."
