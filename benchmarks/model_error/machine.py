"""What the closed loop needs of a machine, and how many kinds of physics it may hide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import pandas as pd
from numpy.random import Generator

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import LoadedPoints


@dataclass(frozen=True)
class Concealed:
    """What a machine hides: the identifier of its physics (empty: none), and the components it may be found at."""

    physics: str = ""
    components: tuple[str, ...] = ()


class Machine(Protocol):
    """A robot as it really is, with an instrument."""

    concealed: Concealed

    def measured(self, rows: pd.DataFrame, seed: int) -> pd.DataFrame:
        """Deflections of the rows of a plan, with noise and standard deviations."""

    def errors(self, commands: FloatArray, targets: LoadedPoints) -> FloatArray:
        """Attained minus wanted pose (t, n) under the targets' payloads."""


class Factory(Protocol):
    """Machines of one class."""

    kinds: tuple[str, ...]
    place: str

    def machine(self, physics: str, stiffness: FloatArray, generator: Generator) -> Machine:
        """A machine that hides this physics (empty: none) at a component and of a size that are drawn."""
