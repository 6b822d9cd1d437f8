"""Where on a robot an effect acts: a kind of part and, where there are several of it, its number."""

from dataclasses import dataclass
from enum import Enum


class Part(Enum):
    """Kinds of components with the words by which results name them."""

    LEG = "leg"
    JOINT = "joint"
    LINK = "link"
    ALL_LEGS = "all legs"
    ALL_JOINTS = "all joints"
    PLATFORM = "platform"
    BASE = "base"
    PAYLOAD = "payload"
    INSTRUMENT = "instrument"
    ENVIRONMENT = "environment"
    GEOMETRY = "geometry"


_NUMBERED = (Part.LEG, Part.JOINT, Part.LINK)


@dataclass(frozen=True)
class Component:
    """A part of the machine or of its surroundings, e.g. leg 3; `str` gives the text that files and results use.

    Attributes:
        part: its kind.
        number: which one, from 1, of legs, joints and links; 0 for parts of which there is one.

    Raises:
        ValueError: a number is missing, or there is one too many.
    """

    part: Part
    number: int = 0

    def __post_init__(self) -> None:
        if (self.part in _NUMBERED) != (self.number >= 1):
            raise ValueError(f"`{self}` is no component")

    def __str__(self) -> str:
        return f"{self.part.value} {self.number}" if self.number else self.part.value

    @property
    def index(self) -> int:
        """Index from 0 of a leg, joint or link."""
        return self.number - 1

    @property
    def several(self) -> bool:
        """Whether it stands for all legs or all joints."""
        return self.part in (Part.ALL_LEGS, Part.ALL_JOINTS)


def component_from_text(text: str) -> Component:
    """The component that a file names; raises `ValueError` for a text that names none."""
    word, _, number = text.rpartition(" ")
    numbered = {part.value: part for part in _NUMBERED}
    if word in numbered and number.isdecimal():
        return Component(numbered[word], int(number))
    return Component(Part(text))


PLATFORM = Component(Part.PLATFORM)
BASE = Component(Part.BASE)
PAYLOAD = Component(Part.PAYLOAD)
INSTRUMENT = Component(Part.INSTRUMENT)
ENVIRONMENT = Component(Part.ENVIRONMENT)
GEOMETRY = Component(Part.GEOMETRY)
ALL_LEGS = Component(Part.ALL_LEGS)
ALL_JOINTS = Component(Part.ALL_JOINTS)
