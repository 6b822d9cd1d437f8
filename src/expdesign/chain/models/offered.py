"""What physics a robot can have beside its base model: places, forms, parameters and their usual sizes.

Everything is read off the effects' own declarations.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass

from expdesign.chain.component import Component
from expdesign.chain.effect import Effect
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.chain.parameter import Parameter
from expdesign.chain.recordings.measurand import POSITIONS
from expdesign.io.units import measured_column
from expdesign.mechanics.robots.robot import Robot

_SMALL = 1e-3
"""m or rad, below which sizes are written in millionths."""


@dataclass(frozen=True)
class Offered:
    """One physics at places where it has the same parameters.

    Attributes:
        effect: at the first of its places.
        components: where it can be.
        variants: its forms there; the first is taken where none is named.
    """

    effect: Effect
    components: tuple[Component, ...]
    variants: tuple[str, ...]

    @property
    def physics(self) -> str:
        """Its identifier."""
        return self.effect.physics

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """With their bounds and typical values."""
        return self.effect.parameters

    @property
    def sentence(self) -> str:
        """What it is: the first line that its file says of itself, or its class where a file has several."""
        module = sys.modules[type(self.effect).__module__]
        several = sum(isinstance(each, type) and issubclass(each, Effect) for each in vars(module).values()) > 2
        return ((type(self.effect).__doc__ if several else module.__doc__) or "").strip().split("\n")[0]

    @property
    def example(self) -> str:
        """What `simulate --conceal` takes, with the usual sizes; '' where it shows in positions of markers only."""
        if set(self.effect.measurands) <= {POSITIONS}:
            return ""
        free = [parameter for parameter in self.parameters if not parameter.shape]
        parts = [f"{self.physics} at {self.components[0]}"] + [each for each in self.variants[:1] if each]
        if len(self.parameters) <= 3:
            parts += [self._written(each, named=len(free) > 1 or each.shape) for each in self.parameters]
        return ", ".join(part for part in parts if part)

    def _written(self, parameter: Parameter, *, named: bool) -> str:
        """A parameter with its usual size; '' where that is a multiple of what the robot has."""
        size = self.effect.size(parameter)
        value = parameter.neutral if parameter.shape else size.value
        if parameter.shape and value == 0.0:
            return ""
        if size.of and not parameter.shape:
            return ""
        unit, factor = unit_of_parameter(parameter.name), 1.0
        if unit in ("m", "rad"):
            unit, factor = (f"u{unit}", 1e6) if value < _SMALL else (f"m{unit}", 1e3)
        text = f"{value * factor:.4g} {unit}".strip() if "/" not in unit else f"{value:.4g}"
        return f"{parameter.name} {text}" if named else text


def offered(robot: Robot) -> list[Offered]:
    """Every physics that the robot can have, by name."""
    found = [each for cls in effect_classes() for each in _of_class(cls, robot)]
    return sorted(found, key=lambda each: (each.physics, each.effect.identifier))


def unit_of_parameter(name: str) -> str:
    """The SI unit at the end of a parameter's name, such as `m`, `1/K` or `rad/Nm`; '' for a ratio."""
    head, per, last = name.rpartition("_per_")
    if per:
        before = head.rpartition("_")[2]
        return f"{before if before in ('m', 'rad', 'Nm', 'N') else '1'}/{last}"
    unit = name.rpartition("_")[2]
    if unit in ("m", "rad", "N", "Nm", "s", "kg", "kgm"):
        return unit
    measured = measured_column(name)
    return "" if measured is None else measured.unit.name


def effects_of(cls: type[Effect], robot: Robot) -> Iterator[Effect]:
    """The effect at every component in every form that the robot, and not recordings, decides."""
    for component in cls.components(robot):
        for variant in cls.variants(robot):
            try:
                effect = cls(robot, component, variant)
                if effect.parameters:
                    yield effect
            except ValueError:  # this form is not at this component
                continue


def _of_class(cls: type[Effect], robot: Robot) -> list[Offered]:
    groups: dict[tuple[str, ...], list[Effect]] = {}
    for effect in effects_of(cls, robot):
        groups.setdefault(tuple(parameter.name for parameter in effect.parameters), []).append(effect)
    return [
        Offered(
            effects[0],
            tuple(dict.fromkeys(effect.component for effect in effects)),
            tuple(dict.fromkeys(str(effect.variant) for effect in effects)),
        )
        for effects in groups.values()
    ]
