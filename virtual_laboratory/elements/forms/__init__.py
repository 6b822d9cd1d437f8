"""Known physics by other laws than those that were written down, one class each."""

from __future__ import annotations

from ..unlisted.law import Unlisted
from .dahl_friction import DahlFriction
from .other_creep import OtherCreep
from .other_drift import OtherDrift
from .other_spring import OtherSpring
from .smeared_backlash import SmearedBacklash

FORMS: dict[str, type[Unlisted]] = {
    element.identifier: element
    for element in (
        DahlFriction,
        OtherCreep,
        OtherDrift,
        OtherSpring,
        SmearedBacklash,
    )
}
"""By identifier."""

__all__ = [
    "FORMS",
    "DahlFriction",
    "OtherCreep",
    "OtherDrift",
    "OtherSpring",
    "SmearedBacklash",
]
