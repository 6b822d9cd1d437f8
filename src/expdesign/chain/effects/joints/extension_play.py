"""A telescope's play along its axis changes with its extension: a worn spindle, a guide that overlaps less."""

from typing import ClassVar

import casadi as ca

from expdesign.chain.backlash import with_play
from expdesign.chain.component import Component, sliding_joints
from expdesign.chain.declaration import Declaration, Extension, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class ExtensionPlay(Effect):
    """The gap is `gap_m` + `gap_change`·q, and never negative; a joint that nothing pushes rests in its middle."""

    physics = "joint_backlash"
    declared = Declaration(
        left_out="play of a joint, the more the farther it is drawn out",
        phrase="play in {component}",
        usually="worn guides",
        port="actuators",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size("gap_m", 1e-5, "assumed: linear axis without preload"),
            Size("gap_change", 1e-4, "assumed: a guide that is worn over a part of its travel"),
        ),
    )
    forms: ClassVar[tuple[Variant, ...]] = tuple(Extension)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return sliding_joints(robot)

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("gap_m", 1e-5, low=0.0, high=0.1), Parameter("gap_change", 1e-5, low=-0.1, high=0.1))

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        index = self.component.index
        gap = theta[0] + theta[1] * row.lengths[index]
        # At a gap of 0 exactly, where every search starts, the slope must not be lost.
        gap = ca.if_else(gap < 0.0, 0.0, gap)
        return with_play(elongation, force, row, index, gap, (0.5, -0.5)), state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        gap, change = values["gap_m"], values["gap_change"]
        return (
            f"{self.subject} has {1e6 * gap[0]:.3g} ({1e6 * gap[1]:.3g} to {1e6 * gap[2]:.3g}) µm of play drawn in, "
            f"and {1e6 * change[0]:+.3g} µm more for every metre of extension."
        )
