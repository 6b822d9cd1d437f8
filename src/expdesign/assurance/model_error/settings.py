"""What MEIR assumes: the test that notices, the physics considered, and how large it may be."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from math import isfinite

import numpy as np
from scipy.special import chdtri, chndtrinc

from expdesign.arrays import FloatArray, IntArray
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
        level: α of the χ² test, the share of sound machines in which it raises an alarm.
        power: 1 − β, the share of experiments in which an effect that is just noticed is found.
        physics: identifiers that are considered; None for all that the robot can have.
        without: identifiers that are left out of those.
        sizes: prior sizes in place of the declared ones: by physics, the value of all its parameters, or values by
            parameter (names with `*`, as the physics declares them); what a value is a multiple of stays as declared.

    Raises:
        InputError: the level and the power are not 0 < α < 1 − β < 1, there is no such physics, it declares no such
            parameter, or a size is not positive.
    """

    level: float = 0.01
    power: float = 0.8
    physics: Collection[str] | None = None
    without: Collection[str] = ()
    sizes: Mapping[str, float | Mapping[str, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not 0.0 < self.level < self.power < 1.0:
            what = f"a test at the level {self.level:g} with the power {self.power:g} does not exist"
            raise InputError(what, where=WHERE, remedy="Choose 0 < level < power < 1, such as 0.01 and 0.8.")
        for physics, stated in self.sizes.items():
            _require_declared(physics, stated if isinstance(stated, Mapping) else ())
            for parameter, value in self._stated(physics).items():
                if not (value > 0.0 and isfinite(value)):
                    what = f"`{parameter}` cannot have the prior size {value:g}"
                    remedy = f"Give a positive size, or name it under `{WHERE}.without` if machines never have it."
                    raise InputError(what, where=f"{WHERE}.sizes.{physics}", remedy=remedy)

    def _stated(self, physics: str) -> Mapping[str, float]:
        """Sizes of a physics by names of parameters."""
        stated = self.sizes.get(physics, {})
        return stated if isinstance(stated, Mapping) else {"*": stated}

    def size(self, effect: Effect, parameter: Parameter) -> Size:
        """How large a parameter of an effect may be."""
        size = effect.size(parameter)
        for name, value in self._stated(effect.physics).items():
            if name == size.parameter or fnmatchcase(parameter.name, name):
                size = replace(size, value=value, source="configuration")
        return size

    def considers(self, physics: str) -> bool:
        """Whether this physics is considered."""
        return (self.physics is None or physics in self.physics) and physics not in self.without

    def noncentrality(self, dof: IntArray | int) -> FloatArray:
        """λ at which χ² tests with so many degrees of freedom, at least 1, at the level have the power.

        P(χ²_dof(λ) > q) = 1 − β with q the (1 − α) quantile of the central distribution (Patnaik 1949). 11.68 for one
        degree of freedom, 1 % and 80 %.
        """
        return np.asarray(chndtrinc(chdtri(dof, self.level), dof, 1.0 - self.power))


def _require_declared(physics: str, parameters: Collection[str]) -> None:
    """Raise an `InputError` where no effect goes by a name, or none of its parameters by such names."""
    classes = [cls for cls in effect_classes() if cls.physics == physics]
    if not classes:
        known = sorted({cls.physics for cls in effect_classes()})
        raise InputError(f"no physics `{physics}`", where=f"{WHERE}.sizes", remedy=nearest(physics, known))
    names = [size.parameter for cls in classes for size in cls.declared.sizes]
    for parameter in parameters if all(cls.declared.sizes for cls in classes) else ():
        if not any(fnmatchcase(parameter, name) for name in names):
            remedy = nearest(parameter, names)
            raise InputError(f"no parameter `{parameter}`", where=f"{WHERE}.sizes.{physics}", remedy=remedy)
