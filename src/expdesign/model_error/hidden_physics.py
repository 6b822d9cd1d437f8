"""What one plan, or one set of recordings, hides: a list by effect, the worst first."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.model_error.hidden import Hidden
from expdesign.model_error.left_out import LeftOut


@dataclass(frozen=True)
class HiddenPhysics:
    """What one effect could do without being noticed.

    Attributes:
        physics, component, variant: the effect.
        phrase: a machine that has it, in words: `play in leg 3`.
        error: MEIR_e, the error at the targets in tolerances.
        parameters: the worst combination of its parameters, by name with unit; shapes as they were assumed.
        parameter: the one that is largest against its prior size.
        noticed: by which factor that combination has to grow until it is noticed with the required power; 1 where it
            just is, infinite where the readings do not show it at all.
        tolerable: by which factor it may grow until it uses up the tolerance, below 1 where it already does more.
        rank: independent directions in which the effect shows in the residuals.
    """

    physics: str
    component: str
    variant: str
    phrase: str
    error: float
    parameters: dict[str, float]
    parameter: str
    noticed: float
    tolerable: float
    rank: int

    @property
    def limited_by(self) -> str:
        """What keeps the error from being larger: `detection`, `size` or both."""
        return "size" if self.noticed > 1.0 + 1e-6 else "detection"


def hidden_physics(
    hidden: Hidden, physics: tuple[LeftOut, ...], deviations: FloatArray, design: int = 0
) -> tuple[HiddenPhysics, ...]:
    """Every effect of one design at the worst of its starts, the largest error first.

    Args:
        hidden: of b designs.
        physics: its entries.
        deviations: prior sizes of all columns, shape (D,).
        design: index of the design.
    """
    start: IntArray = np.cumsum([0, *(entry.columns for entry in physics)])
    worst: dict[tuple[str, str, str], HiddenPhysics] = {}
    for index, entry in enumerate(physics):
        error = float(np.sqrt(hidden.squares[design, index]))
        known = worst.get(entry.key)
        if known is not None and known.error >= error:
            continue
        values, size = entry.start.copy(), hidden.sizes[index][design]
        values[entry.free] += size * deviations[start[index] : start[index + 1]]
        visible = float(hidden.visible[design, index])
        worst[entry.key] = HiddenPhysics(
            *entry.key,
            entry.effect.phrase,
            error=error,
            parameters={p.name: float(v) for p, v in zip(entry.effect.parameters, values, strict=True)},
            parameter=entry.effect.parameters[entry.free[int(np.abs(size).argmax())]].name,
            noticed=1.0 / float(np.sqrt(visible)) if visible > 0.0 else float("inf"),
            tolerable=1.0 / error if error > 0.0 else float("inf"),
            rank=int(hidden.rank[design, index]),
        )
    return tuple(sorted(worst.values(), key=lambda each: -each.error))
