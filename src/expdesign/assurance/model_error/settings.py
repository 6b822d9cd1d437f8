"""What MEIR assumes: the test that notices, the physics considered, and how large it may be."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from math import isfinite

from expdesign.assurance.model_error.noticeable import LEVEL, POWER, noncentrality
from expdesign.chain.declaration import Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.errors import InputError
from expdesign.io.nearest import nearest

WHERE = "model_error"
"""Section of the configuration."""


@dataclass(frozen=True)
class Assumptions:
    """Assumptions of MEIR.

    Attributes:
        level: α of the χ² test.
        power: 1 − β with which an effect has to be noticed.
        physics: identifiers that are considered; None for all that the robot can have.
        without: identifiers that are left out of those.
        stated: prior sizes in place of the declared ones, by physics and names of parameters with `*`.
    """

    level: float = LEVEL
    power: float = POWER
    physics: frozenset[str] | None = None
    without: frozenset[str] = frozenset()
    stated: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        noncentrality(1, self.level, self.power)

    def with_sizes(self, changes: Mapping[str, float | dict[str, float]]) -> "Assumptions":
        """These assumptions with other sizes.

        Args:
            changes: by physics, the value of all its parameters, or values by parameter (names with `*`, as the
                physics declares them); what a value is a multiple of stays as it is declared.

        Raises:
            InputError: there is no such physics, it declares no such parameter, or a size is not positive.
        """
        stated = dict(self.stated)
        for physics, change in changes.items():
            named = change if isinstance(change, dict) else {"*": change}
            _require_declared(physics, change)
            for parameter, value in named.items():
                if not (value > 0.0 and isfinite(value)):
                    what = f"`{parameter}` cannot have the prior size {value:g}"
                    remedy = f"Give a positive size, or name it under `{WHERE}.without` if machines never have it."
                    raise InputError(what, where=f"{WHERE}.sizes.{physics}", remedy=remedy)
            stated[physics] = {**stated.get(physics, {}), **named}
        return replace(self, stated=stated)

    def size(self, effect: Effect, parameter: Parameter) -> Size:
        """How large a parameter of an effect may be."""
        size = effect.size(parameter)
        for name, value in self.stated.get(effect.physics, {}).items():
            if name in ("*", size.parameter) or fnmatchcase(parameter.name, name):
                size = replace(size, value=value, source="configuration")
        return size

    def considers(self, physics: str) -> bool:
        """Whether this physics is considered."""
        return (self.physics is None or physics in self.physics) and physics not in self.without


def _require_declared(physics: str, change: float | dict[str, float]) -> None:
    """Raise an `InputError` where no effect goes by a name, or none of its parameters by those of a change."""
    classes = [cls for cls in effect_classes() if cls.physics == physics]
    if not classes:
        known = sorted({cls.physics for cls in effect_classes()})
        raise InputError(f"no physics `{physics}`", where=f"{WHERE}.sizes", remedy=nearest(physics, known))
    if all(cls.declared.sizes for cls in classes) and isinstance(change, dict):
        names = [size.parameter for cls in classes for size in cls.declared.sizes]
        for parameter in change:
            if not any(fnmatchcase(parameter, name) or parameter == name for name in names):
                remedy = nearest(parameter, names)
                raise InputError(f"no parameter `{parameter}`", where=f"{WHERE}.sizes.{physics}", remedy=remedy)
