"""Effects whose places, parameters and sentences are data."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from expdesign.chain.component import ACTUATORS, Component
from expdesign.chain.declaration import Parameter
from expdesign.chain.effect import Effect, Values
from expdesign.mechanics.robots.robot import Robot

ENDLESS = (-1e300, 1e300)
"""Interval of what nothing determines and no limit bounds: JSON has no infinite numbers."""


class _Alone(float):
    """A number in a sentence: `{tau_s.best:1e3 .3g}` writes it in thousandths."""

    def __format__(self, spec: str) -> str:
        *factor, number = spec.split()
        return format(float(self) * float(factor[0]) if factor else float(self), number)


@dataclass(frozen=True)
class _Interval:
    """An estimate with its interval in a sentence.

    `{gap:1e6 .3g}` is `12 (10 to 14)` in millionths, `{ratio:100 .1f %}` is `12.0 % (10.0 to 14.0 %)`. An interval that
    is all that is `possible` says nothing of the value.
    """

    best: _Alone
    low: _Alone
    high: _Alone
    possible: tuple[float, float]

    @property
    def undetermined(self) -> bool:
        return (self.low, self.high) == self.possible

    def __format__(self, spec: str) -> str:
        if self.undetermined:
            return "undetermined"
        spec, percent, _ = spec.partition(" %")
        return f"{self.best:{spec}}{percent} ({self.low:{spec}} to {self.high:{spec}}{percent})"


class _Listed(tuple[_Interval, ...]):
    """All values in a sentence, without their intervals: `{all:1e3 .2f}`."""

    def __format__(self, spec: str) -> str:
        return ", ".join(format(each if each.undetermined else each.best, spec) for each in self)


class TabulatedEffect(Effect):
    """An effect whose places, parameters and sentence are data.

    Names of parameters may hold `{force}` and `{motion}`, the units where it acts (N and m, or Nm and rad), and
    `{axis}`, for which they are repeated along every axis of the robot's workspace.

    Attributes:
        at: its components on a robot.
        quantities: its parameters.
        says: its sentence, with `{component}`, `{subject}` (the same as first word), `{variant}`, `{s}` (of a verb),
            `{force}` and `{motion}`, and the reported values (`_Interval`): `{first}`, `{all}`, and by name, with or
            without these units.
    """

    at: ClassVar[Callable[[Robot], Sequence[Component]]]
    quantities: ClassVar[tuple[Parameter, ...]] = ()
    says: ClassVar[str] = ""

    @classmethod
    def components(cls, robot: Robot) -> Sequence[Component]:
        return cls.at(robot)

    @property
    def units(self) -> tuple[str, str]:
        """Units of force and motion where it acts, as names of parameters have them."""
        turns = self.component.part in ACTUATORS and self.robot.units[self.actuators[0]] == "rad"
        return ("Nm", "rad") if turns else ("N", "m")

    def described(self, quantities: Sequence[Parameter]) -> tuple[Parameter, ...]:
        """Parameters with their names filled in."""
        (force, motion), axes = self.units, self.robot.coordinates.axes
        return tuple(
            replace(each, name=each.name.format(force=force, motion=motion, axis=axis))
            for each in quantities
            for axis in (axes if "{axis}" in each.name else axes[:1])
        )

    def describe(self) -> tuple[Parameter, ...]:
        return self.described(self.quantities)

    def sentence(self, values: Values) -> str:
        return self.said(self.says, values) if self.says else super().sentence(values)

    def said(self, text: str, values: Values) -> str:
        """A text like `says` with what it names filled in."""
        force, motion = self.units
        limits = {p.name: (max(p.low, ENDLESS[0]), min(p.high, ENDLESS[1])) for p in self.parameters}
        known = {
            name: _Interval(_Alone(best), _Alone(low), _Alone(high), limits.get(name, ENDLESS))
            for name, (best, low, high) in values.items()
        }
        plain = {name.removesuffix(f"_{force}").removesuffix(f"_{motion}"): value for name, value in known.items()}
        return text.format(
            component=self.component,
            subject=self.subject,
            variant=self.variant,
            s="" if self.component.several else "s",
            force=force.replace("Nm", "N·m"),
            motion=motion,
            first=next(iter(known.values())),
            all=_Listed(known.values()),
            **plain | known,
        )
