"""What elements outside the library have in common: where they may be found, and how a leg's law is written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...legs import Leg
from ..element import Element, OfLegs


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
class LegPhysics(OfLegs, Unlisted):
    """Physics of one leg or of all: accepted is that leg alone (`all legs` where it is in all)."""

    @property
    def parts(self) -> tuple[str, ...]:
        return (self.component,)
