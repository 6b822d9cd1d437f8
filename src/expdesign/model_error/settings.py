"""What MEIR assumes: the test that notices, the physics considered, and how large it may be."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite

from expdesign.chain.effect import Effect
from expdesign.errors import InputError
from expdesign.files.nearest import nearest
from expdesign.model_error.noticeable import LEVEL, POWER, noncentrality
from expdesign.model_error.prior_sizes import SIZES, Size
from expdesign.plugins import implementations

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
        sizes: prior sizes.
        readings: instead of the prior sizes, the RMS of the readings in standard deviations (with what the base model
            would explain) that each parameter alone may cause; None for the prior sizes.
    """

    level: float = LEVEL
    power: float = POWER
    physics: frozenset[str] | None = None
    without: frozenset[str] = frozenset()
    sizes: tuple[Size, ...] = field(default=SIZES)
    readings: float | None = None

    def __post_init__(self) -> None:
        noncentrality(1, self.level, self.power)
        if self.readings is not None and not (self.readings > 0.0 and isfinite(self.readings)):
            what = f"{self.readings:g} standard deviations on the readings cannot be the largest that an effect causes"
            raise InputError(what, where=f"{WHERE}.readings", remedy="Choose a positive number, such as 10.")
        for size in self.sizes:
            _require_positive(size)

    def with_sizes(self, changes: Mapping[str, float | dict[str, float]]) -> "Assumptions":
        """These assumptions with other sizes.

        Args:
            changes: by physics, the value of all its rows, or values by parameter (names with `*`); what a value is a
                multiple of stays as it is in the table.

        Physics that the table lacks, of an effect from outside, gets rows of its own in the parameters' units.

        Raises:
            InputError: there is no such physics, the parameter is not in the table, or a size is not positive.
        """
        sizes = list(self.sizes)
        for physics, change in changes.items():
            rows = [i for i, size in enumerate(sizes) if size.physics == physics]
            if not rows and physics in _known_physics():
                named = change if isinstance(change, dict) else {"*": change}
                sizes += [Size(physics, name, value, "", "configuration", False) for name, value in named.items()]
                continue
            if not rows:
                known = sorted({size.physics for size in sizes})
                raise InputError(f"no physics `{physics}`", where=f"{WHERE}.sizes", remedy=nearest(physics, known))
            named = change if isinstance(change, dict) else {sizes[i].parameter: change for i in rows}
            for parameter, value in named.items():
                found = [i for i in rows if sizes[i].parameter == parameter]
                if not found:
                    remedy = nearest(parameter, [sizes[i].parameter for i in rows])
                    raise InputError(f"no parameter `{parameter}`", where=f"{WHERE}.sizes.{physics}", remedy=remedy)
                sizes[found[0]] = replace(sizes[found[0]], value=value, source="configuration", assumed=False)
        return replace(self, sizes=tuple(sizes))

    def considers(self, physics: str) -> bool:
        """Whether this physics is considered."""
        return (self.physics is None or physics in self.physics) and physics not in self.without


def _known_physics() -> set[str]:
    """Identifiers of all physics for which an effect is known."""
    return {kind.physics for kind in implementations("expdesign.chain.effects", Effect)}  # type: ignore[type-abstract]


def _require_positive(size: Size) -> None:
    if not (size.value > 0.0 and isfinite(size.value)):
        what = f"`{size.parameter}` cannot have the prior size {size.value:g}"
        remedy = "Give a positive size, or name the physics under `model_error.without` if machines never have it."
        raise InputError(what, where=f"{WHERE}.sizes.{size.physics}", remedy=remedy)
