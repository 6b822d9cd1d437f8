"""A payload that is heavier than assumed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..loads import Load
from .element import Element


@dataclass(frozen=True)
class PayloadMassError(Element):
    """The payload is heavier: m_true = m (1 + relative_mass_error); a wrench is scaled alike."""

    identifier: ClassVar[str] = "payload_mass_error"
    relative_mass_error: float

    def true_load(self, load: Load) -> Load:
        return load.scaled(1.0 + self.relative_mass_error)
