"""The sensor by which loads are known does not read in proportion on one axis, or has a wrong scale there.

A scale that is wrong on all axes alike is a change of all compliances (theory.md 5.2) and cannot be seen; on one axis
it can, and so can a scale that grows with the load.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.chain.component import PAYLOAD, Component
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

_REFERENCE = 100.0
"""N or N·m; the load to which an error that grows refers."""
_VARIES = 1e-9


class Growth(StrEnum):
    """Whether the share by which the load is wrong is the same under all loads; the values end a variant's text."""

    CONSTANT = ""
    GROWING = " growing"


@dataclass(frozen=True)
class SensorAxis:
    """An axis of the sensor (`fx`, ...), and how its error goes with the load."""

    axis: str
    growth: Growth

    def __str__(self) -> str:
        return f"{self.axis}{self.growth}"


class ForceSensor(Effect):
    """The load on one axis is (1 + s)·w (variant `fx`), or w + s·w·|w|/100 (`fx growing`), of the whole load."""

    identifier = "load.force_sensor"
    physics = "payload_mass_error"
    declared = Declaration(
        left_out="error of a mass or of the scale of a wrench",
        phrase="a force sensor that does not read in proportion",
        usually="force sensors and load cells",
        port="payload",
        form="constant",
        inputs=(Input.FORCE,),
        sizes=(
            Size("relative_mass_error", 5e-3, "assumed: a load cell of class 0.5 (ISO 376:2011)"),
            Size("relative_error_at_100*", 5e-3, "assumed: the same at the targets' loads", "own deflection"),
        ),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [PAYLOAD]

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        axes = (name.rsplit("_", 1)[0] for name in robot.coordinates.wrench)
        return [SensorAxis(axis, growth) for axis in axes for growth in Growth]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        if robot.on_support or points.payload is not None:
            return []  # payloads are weighed (`PayloadMassError`); a body's base model does not deflect
        names = [name.rsplit("_", 1)[0] for name in robot.coordinates.wrench]
        varies = np.ptp(points.absolute, axis=0) > _VARIES * np.abs(points.absolute).max(initial=0.0)
        seen = {name for name, varied in zip(names, varies, strict=True) if varied}
        return [(PAYLOAD, variant) for variant in cls.variants(robot) if getattr(variant, "axis", "") in seen]

    @property
    def form_name(self) -> str:
        return "growing" if self.variant.growth is Growth.GROWING else self.declared.form

    @property
    def _index(self) -> int:
        return [name.rsplit("_", 1)[0] for name in self.robot.coordinates.wrench].index(self.variant.axis)

    def describe(self) -> tuple[Parameter, ...]:
        if self.variant.growth is Growth.CONSTANT:
            return (Parameter("relative_mass_error", 0.01, low=-0.99, high=9.0),)
        unit = self.robot.coordinates.wrench[self._index].rsplit("_", 1)[1]
        return (Parameter(f"relative_error_at_100{unit}", 0.01, low=-0.9, high=9.0),)

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        index = self._index
        gained = ca.SX.zeros(wrench.shape[0])
        if self.variant.growth is Growth.CONSTANT:
            gained[index] = theta[0] * wrench[index]
            return wrench + gained
        before = row.absolute[index] - row.wrench[index]
        now = before + wrench[index]
        gained[index] = theta[0] * (now * ca.fabs(now) - before * ca.fabs(before)) / _REFERENCE
        return wrench + gained

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, v = next(iter(values.items()))
        size = f"{100 * v[0]:+.2f} % ({100 * v[1]:+.2f} to {100 * v[2]:+.2f} %)"
        if self.variant.growth is Growth.CONSTANT:
            return f"The load along {self.variant.axis} is really {size} larger than stated on every row."
        unit = "N·m" if name.endswith("Nm") else "N"
        return (
            f"The load along {self.variant.axis} is really larger than stated, the more the larger it is: {size} at "
            f"100 {unit}."
        )
