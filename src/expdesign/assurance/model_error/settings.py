"""What MEIR assumes: the test that notices, the physics considered, and how large it may be."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from functools import lru_cache
from math import isfinite

from scipy.optimize import brentq
from scipy.special import chdtri, chndtr

from expdesign.chain.declaration import Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.errors import InputError
from expdesign.io.nearest import nearest

WHERE = "model_error"
"""Section of the configuration."""
LEVEL = 0.01
"""α: share of sound machines in which the test raises an alarm."""
POWER = 0.8
"""1 − β: share of experiments in which an effect that is just noticed is found."""


@lru_cache(maxsize=256)
def noncentrality(dof: int, level: float = LEVEL, power: float = POWER) -> float:
    """λ at which a χ² test with `dof` degrees of freedom at the given level has the given power.

    P(χ²_dof(λ) > q) = 1 − β with q the (1 − α) quantile of the central distribution (Patnaik 1949). 11.68 for one
    degree of freedom, 1 % and 80 %.

    Raises:
        InputError: the level and the power are not 0 < α < 1 − β < 1.
    """
    if not 0.0 < level < power < 1.0:
        what = f"a test at the level {level:g} with the power {power:g} does not exist"
        raise InputError(what, where="model_error", remedy="Choose 0 < level < power < 1, such as 0.01 and 0.8.")
    if dof < 1:
        raise ValueError("a test needs at least one degree of freedom")
    critical = chdtri(dof, level)
    high = 1.0
    while 1.0 - chndtr(critical, dof, high) < power:
        high *= 2.0
    return float(brentq(lambda value: 1.0 - chndtr(critical, dof, value) - power, 0.0, high, xtol=1e-12, rtol=1e-12))


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
