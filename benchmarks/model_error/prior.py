"""Prior sizes of the physics of one design problem, as MEIR has them, to draw machines by."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.left_out import offsets
from expdesign.assurance.model_error.meir import Meir


class Prior:
    """Standard deviations by physics and component, those of the first variant whose parameters fit.

    Args:
        impact: whose physics and prior sizes are meant.
        factor: by which machines may be worse than their prior sizes.
    """

    def __init__(self, impact: Meir, factor: float = 1.0) -> None:
        start = offsets(impact.physics)
        self._sizes: dict[tuple[str, str, str], dict[str, float]] = {}
        for index, entry in enumerate(impact.physics):
            names = [entry.effect.parameters[i].name for i in entry.free]
            values = (factor * impact.deviations[start[index] : start[index + 1]]).tolist()
            self._sizes.setdefault(entry.key, dict(zip(names, values, strict=True)))

    def physics(self) -> set[str]:
        """Identifiers that are considered."""
        return {physics for physics, _, _ in self._sizes}

    def sizes(self, physics: str, component: str, begin: str) -> FloatArray:
        """Standard deviations of the parameters of one component whose names begin so, in their order."""
        for (known, where, _), sizes in self._sizes.items():
            found = [value for name, value in sizes.items() if name.startswith(begin)]
            if known == physics and where == component and found:
                return np.array(found)
        raise KeyError(f"{physics} of {component} has no {begin}")

    def normal(self, physics: str, component: str, begin: str, generator: Generator) -> FloatArray:
        """Independent normal parameters."""
        sizes = self.sizes(physics, component, begin)
        return sizes * generator.standard_normal(len(sizes))

    def positive(self, physics: str, component: str, begin: str, generator: Generator) -> float:
        """The magnitude of one normal parameter: gaps and friction are not negative."""
        return float(abs(self.normal(physics, component, begin, generator)[0]))


def compliance(diagonal: FloatArray, generator: Generator) -> FloatArray:
    """A random positive definite compliance whose diagonal is on average the one given.

    Wishart with twice as many degrees of freedom as axes: parts are soft in some directions and not in others.
    """
    count = len(diagonal)
    drawn = generator.standard_normal((count, 2 * count)) * np.sqrt(diagonal)[:, None]
    matrix: FloatArray = drawn @ drawn.T / (2 * count)
    return matrix
