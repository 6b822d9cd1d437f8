"""A body's support yields: rotation under moment, about the body's own origin or about a centre that is found."""

from dataclasses import dataclass
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component, symmetric
from expdesign.chain.declaration import TEN_PERCENT, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.support import Over, ending, measured_axes, over_pose, powers, split_over, with_powers
from expdesign.mechanics.robots.robot import Robot

_AXES = ("rx", "ry", "rz")
_PAIRS = ((0, 1), (0, 2), (1, 2))
_FARTHEST = 50.0
"""m; a centre of rotation farther away than this is a translation."""


class SupportForm(StrEnum):
    """Springs about the axes of O, about any axes through the origin of P, or about a point that is found."""

    AXES = "axes"
    ROTATION = "rotation"
    CENTRE = "centre"


@dataclass(frozen=True)
class Springs:
    """The form, and the range of a pose coordinate over which the compliance is a parabola."""

    form: SupportForm
    over: Over | None = None

    def __str__(self) -> str:
        return f"{self.form}{ending(self.over)}"


class SupportCompliance(Effect):
    """ω = C·M with M the moment about the centre of rotation, which is the origin of P or is found.

    Variants: `axes` (C diagonal: springs about x, y and z), `rotation` (C symmetric: springs about any axes), either
    of them ` over` a pose coordinate that varies (a column yields more the farther it is drawn out: C is a parabola in
    that coordinate), and `centre` (`rotation` about a point fixed to the ground, which moves P as well as turning it).
    """

    physics = "base_compliance"
    declared = Declaration(
        left_out="compliance of a body's support",
        phrase="a soft base",
        usually="stands, floors and bolted feet",
        port="supports",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(Size("compliance_*", 0.1, TEN_PERCENT, "pose compliance"),),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [BASE] if robot.on_support else []

    @classmethod
    def variant_from_text(cls, robot: Robot, text: str) -> Variant:
        form, over = split_over(text)
        return Springs(SupportForm(form), over)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        if not robot.on_support:
            return []
        found = [Springs(SupportForm.AXES), Springs(SupportForm.ROTATION)]
        if measured_axes(points) & {0, 1, 2} or np.ptp(points.wrenches[:, :3], axis=0).any():
            # Pure moments and rotations say nothing of where a body turns.
            found.append(Springs(SupportForm.CENTRE))
        for over in over_pose(points, robot.configuration):
            found += [Springs(SupportForm.AXES, over), Springs(SupportForm.ROTATION, over)]
        return [(BASE, springs) for springs in found]

    def describe(self) -> tuple[Parameter, ...]:
        diagonal = [Parameter(f"compliance_{a}_{a}_rad_per_Nm", 1e-6, low=0.0) for a in _AXES]
        upper = [Parameter(f"compliance_{_AXES[i]}_{_AXES[j]}_rad_per_Nm", 1e-6) for i, j in _PAIRS]
        chosen = tuple(diagonal if self.variant.form is SupportForm.AXES else diagonal + upper)
        if self.variant.form is SupportForm.CENTRE:
            return chosen + tuple(
                Parameter(f"centre_{axis}_m", 1.0, neutral=0.0, low=-_FARTHEST, high=_FARTHEST, shape=True)
                for axis in "xyz"
            )
        return with_powers(chosen, self.variant.over)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant.form is not SupportForm.CENTRE:
            return [self.neutral()]
        position = self.robot.position(points.configurations).mean(axis=0)
        # On the ground below the body, at its own height, and far below.
        heights = (position[2], 0.0, position[2] - 3.0)
        return [np.concatenate([np.zeros(6), [position[0], position[1], height]]) for height in heights]

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.variant.form is SupportForm.CENTRE:
            arm = row.position - theta[6:9]
            turn = symmetric(theta[:6], 3) @ (wrench[3:] + ca.cross(arm, wrench[:3]))
            return deflection + row.rates @ ca.vertcat(ca.cross(turn, arm), turn)
        width = 3 if self.variant.form is SupportForm.AXES else 6
        turn = ca.SX.zeros(3)
        for i, factor in enumerate(powers(self.variant.over, row, self.robot.configuration)):
            turn += factor * (symmetric(theta[width * i : width * (i + 1)], 3) @ wrench[3:])
        return deflection + row.rates @ ca.vertcat(ca.SX.zeros(3), turn)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        known = {axis: values[f"compliance_{axis}_{axis}_rad_per_Nm"] for axis in _AXES}
        listed = ", ".join(
            f"{1e6 * v[0]:.3g} ({1e6 * v[1]:.3g} to {1e6 * v[2]:.3g}) µrad per N·m about {axis[1]}"
            for axis, v in known.items()
            if abs(v[2]) < 1e299
        )
        text = f"What the body stands on yields: {listed or 'by an amount that is hardly known'}"
        if self.variant.over is not None:
            text += f" {self.variant.over.sentence}"
        if self.variant.form is SupportForm.CENTRE:
            x, y, z = (values[f"centre_{axis}_m"][0] for axis in "xyz")
            text += f"; it turns about ({x:.2f}, {y:.2f}, {z:.2f}) m in O"
        return text + "."
