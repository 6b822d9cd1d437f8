"""What a concealed physics is to its case, whatever engine makes it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from ..case import UnsuitableError
from .campaigns import Wishes
from .hexapods import Array

Machine = TypeVar("Machine")


@dataclass(frozen=True)
class Concealed(Generic[Machine]):
    """`of_size` makes the machine with the physics; it shows more the larger the size between `low` and `high`.

    `parts`: components that are right as its place, `names`: identifiers of known physics that are no wrong ones.
    """

    parts: tuple[str, ...]
    names: tuple[str, ...]
    low: float
    high: float
    of_size: Callable[[float], Machine]
    remark: str = ""


@dataclass(frozen=True)
class Kind(Generic[Machine]):
    """A kind of physics: what a campaign must have for it, and how it is concealed in one."""

    wishes: Wishes
    conceal: Callable[..., Concealed[Machine]]


def chosen_leg(forces: Array, rng: np.random.Generator, reversing: bool = False) -> tuple[int, float]:
    """A leg (or joint) that carries load, and its largest force; with `reversing`, one that is pushed and pulled."""
    typical = np.abs(forces).mean(axis=0)
    able = typical > 0.4 * typical.max()
    if reversing:
        able &= np.minimum((forces > 0).mean(axis=0), (forces < 0).mean(axis=0)) > 0.15
    if not able.any():
        raise UnsuitableError("nothing is loaded as this physics needs it")
    leg = int(rng.choice(np.flatnonzero(able)))
    return leg, float(np.abs(forces[:, leg]).max())
