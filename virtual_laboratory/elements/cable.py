"""A cable that pulls; outside the library of known effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Point
from .element import Element

if TYPE_CHECKING:
    from ..machine import Machine


@dataclass(frozen=True)
class Cable(Element):
    """A cable from the base to the platform: it pulls with k (L - slack_m) once it is taut, and cannot push.

    `base_m` in O, `platform_m` in P (m), `stiffness_N_per_m`. With `on_payload` it comes with the payload and
    is absent from the unloaded reference.
    """

    identifier: ClassVar[str] = "cable"
    base_m: Sequence[float]
    platform_m: Sequence[float]
    slack_m: float
    stiffness_N_per_m: float
    on_payload: bool = True

    def build(self, machine: Machine) -> None:
        def tension(length: float) -> float:
            if self.on_payload and not machine.loaded:
                return 0.0
            return self.stiffness_N_per_m * max(length - self.slack_m, 0.0)

        start = Point(machine.base, np.asarray(self.base_m, dtype=float))
        end = Point(machine.mount, np.asarray(self.platform_m, dtype=float))
        machine.engine.add_spring(start, end, self.stiffness_N_per_m, tension)
