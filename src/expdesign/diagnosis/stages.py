"""Stages of a diagnosis in their order, which every part of it reports by identity; not every diagnosis has all."""

from collections.abc import Callable
from enum import Enum


class Stage(Enum):
    """One stage, with the words that say what is being done."""

    BASE = "fitting the base model"
    LIBRARY = "preparing the library"
    GROUPS = "all effects at once"
    EFFECTS = "looking for effect"
    PORTS = "preparing laws at ports"
    HELD_OUT = "checking on held-out recordings"
    ALTERNATIVES = "weighing alternatives"
    HIDDEN = "looking for what may still be hidden"

    @property
    def number(self) -> int:
        """Its place in the order, from 1."""
        return list(Stage).index(self) + 1

    def of_all(self, detail: str = "") -> str:
        """What is being done, and how far that is."""
        return f"stage {self.number} of at most {len(Stage)}: {self.value}{detail and f' {detail}'}"


Report = Callable[[Stage, str], None]
"""Progress callback: the stage, and a detail such as the number of the effect."""


def unheard(stage: Stage, detail: str) -> None:
    """No-op progress callback."""
