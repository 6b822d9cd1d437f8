"""Recordings that are wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kinematics import Vector
from .element import Element, require


@dataclass(frozen=True)
class Outlier(Element):
    """Single wrong recordings: rows that were written down with an error that belongs to no physics.

    Either the given `rows` (0 = first) or a random `fraction` of all. Each is off by `size` standard
    deviations in every measured component, with random signs; `size_m` and `size_rad` are used where there is
    no noise.
    """

    identifier: ClassVar[str] = "outlier"
    rows: Sequence[int] = ()
    fraction: float = 0.0
    size: float = 20.0
    size_m: float = 1e-5
    size_rad: float = 4e-5

    def __post_init__(self) -> None:
        require(0 <= self.fraction < 1, "fraction: must be between 0 and 1")

    def spoil(self, deflections: Vector, std: Vector, rng: np.random.Generator) -> Vector:
        count = len(deflections)
        require(all(0 <= row < count for row in self.rows), f"rows: the recordings have rows 0 ... {count - 1}")
        chosen = list(self.rows) or list(rng.permutation(count)[: round(self.fraction * count)])
        sizes = np.array([self.size_m] * min(3, len(std)) + [self.size_rad] * (len(std) - 3))
        sizes = np.where(std > 0, self.size * std, sizes)
        spoilt = deflections.copy()
        spoilt[chosen] += sizes * rng.choice([-1.0, 1.0], size=(len(chosen), len(std)))
        return spoilt
