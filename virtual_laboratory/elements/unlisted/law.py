"""What elements outside the library have in common: where they may be found, and how a leg's law is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ...legs import Leg, LegConditions, LegLaw
from ..element import Element, legs_of


class Unlisted(Element):
    """Physics for which no effect was written.

    `accepted`: the components that are right answers to where it acts, by the rule in the element's docstring. `also`:
    identifiers of known physics that would not be a wrong name, because the law is a form of theirs. `abscissa`: where
    the law is a curve over one scalar, its name; `curve` is then the law: for `length`, `temperature` and `swivel` the
    leg's whole compliance (m/N), for `force` its elongation beyond the linear spring (m).
    """

    also: ClassVar[tuple[str, ...]] = ()
    abscissa: ClassVar[str] = ""

    accepted: ClassVar[tuple[str, ...]] = ()

    @property
    def parts(self) -> tuple[str, ...]:
        """Accepted components."""
        return self.accepted

    def curve(self, at: float, leg: Leg) -> float:
        """The law at one value of its scalar, in SI units."""
        raise NotImplementedError


@dataclass(frozen=True)
class LegPhysics(Unlisted):
    """Physics of one leg or of all: accepted is that leg alone (`all legs` where it is in all).

    A subclass gives the elongation, or a law with a memory.
    """

    component: str

    @property
    def parts(self) -> tuple[str, ...]:
        return (self.component,)

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        return {index: self.law(legs[index]) for index in legs_of(self.component, len(legs))}

    def law(self, leg: Leg) -> LegLaw:
        """The law of one leg; `stretch` without memory unless a subclass says otherwise."""
        return _Memoryless(self, leg)

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        """Elongation beyond the linear spring (m) at a tension (N)."""
        raise NotImplementedError


@dataclass
class _Memoryless(LegLaw):
    physics: LegPhysics
    leg: Leg

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self.physics.stretch(force, self.leg, conditions)
