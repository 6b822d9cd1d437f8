"""Physics that the engine cannot leave out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .element import Element


@dataclass(frozen=True)
class GeometricStiffness(Element):
    """The change of geometry under load; it is always there.

    Every equilibrium is one of the loaded geometry, with or without this element.

    It shows at loads of tonnes or with soft legs: the deflection is (K_C + K_G)^-1 F instead of K_C^-1 F.
    """

    identifier: ClassVar[str] = "geometric_stiffness"
