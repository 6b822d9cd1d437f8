"""A base that yields."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Point
from ..kinematics import Matrix
from .bushing import bushing_matrix
from .element import Element, Stage

if TYPE_CHECKING:
    from ..machine import Machine


@dataclass(frozen=True)
class BaseCompliance(Element):
    """The base plate, with all base joints, is a body on a bushing on the ground.

    The instrument stands on the ground.

    Bushing as for `PlatformCompliance`, in the axes of O at the point `at_m` (m, in O).
    """

    identifier: ClassVar[str] = "base_compliance"
    stage: ClassVar[Stage] = Stage.BODIES
    stiffness: Sequence[float] | Matrix
    at_m: Sequence[float] = (0.0, 0.0, 0.0)

    def build(self, machine: Machine) -> None:
        at = np.asarray(self.at_m, dtype=float)
        base = machine.engine.add_body(np.zeros(3), machine.engine.ground.placement)
        machine.engine.add_bushing(Point(machine.base, at), Point(base, at), bushing_matrix(self.stiffness))
        machine.base = base
