"""What a leg does beyond its linear spring.

A leg is a chain: commanded length, linear spring, and any number of further members in series that carry the
same axial force. A member is described by its elongation under a tension N (compression is negative), and may
remember what happened in its series. The linear spring N/k itself is in the engine.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np

from .kinematics import Vector


@dataclass(frozen=True)
class Leg:
    """A leg: its number (0 = leg 1) and the stiffness of its spring (N/m)."""

    index: int
    stiffness: float


@dataclass(frozen=True)
class LegConditions:
    """What a leg is under in one state: time (s), temperature (degC), commanded length (m).

    Time and temperature are NaN where the recordings have none. `reference` marks the unloaded state
    to which the deflections of the series are relative. `direction` is the commanded direction of the leg from
    its base joint (unit vector, in O), `home_direction` that at the home pose, `travel` the commanded position of
    the platform from its home (m, in O).
    """

    time: float
    temperature: float
    length: float
    reference: bool = False
    direction: Vector = field(default_factory=lambda: np.zeros(3), compare=False)
    home_direction: Vector = field(default_factory=lambda: np.zeros(3), compare=False)
    travel: Vector = field(default_factory=lambda: np.zeros(3), compare=False)


class LegLaw(ABC):
    """Elongation of one member of one leg, beyond the leg's linear spring."""

    def start(self, conditions: LegConditions) -> None:
        """Begin a series, relaxed, in the conditions of its reference state."""
        del conditions

    @abstractmethod
    def elongation(self, force: float, conditions: LegConditions) -> float:
        """Elongation (m) at a tension (N), without changing the member's memory."""

    def accept(self, force: float, conditions: LegConditions) -> None:
        """Remember the state that has been reached."""
        del force, conditions
