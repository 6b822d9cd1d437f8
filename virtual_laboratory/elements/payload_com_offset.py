"""A payload whose centre of mass is elsewhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..loads import Load
from .element import Element


@dataclass(frozen=True)
class PayloadComOffset(Element):
    """The payload's centre of mass is elsewhere, by [com_dx_m, com_dy_m, com_dz_m] (m, platform axes).

    A wrench acts at a point that is off by as much.
    """

    identifier: ClassVar[str] = "payload_com_offset"
    com_dx_m: float = 0.0
    com_dy_m: float = 0.0
    com_dz_m: float = 0.0

    def true_load(self, load: Load) -> Load:
        return load.shifted(np.array([self.com_dx_m, self.com_dy_m, self.com_dz_m]))
