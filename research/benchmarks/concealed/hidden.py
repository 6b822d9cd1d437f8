"""What is concealed in a case: one piece of physics whose size is still to be chosen."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from research.laboratory.elements import LIBRARY, OUTSIDE, Element
from research.laboratory.elements.forms import FORMS
from research.laboratory.elements.unlisted import UNLISTED

from .case import UnsuitableError
from .experiments import Experiment, Wishes
from .linear_model import Array


def _same(rows: pd.DataFrame) -> pd.DataFrame:
    return rows


@dataclass(frozen=True)
class Sized:
    """Physics of a definite size: laboratory elements, the loads that really acted, legs softer by a factor."""

    elements: tuple[Mapping[str, Any], ...] = ()
    true_rows: Callable[[pd.DataFrame], pd.DataFrame] = _same
    softness: float = 1.0
    remark: str = ""

    def build(self) -> list[Element]:
        catalogue = LIBRARY | OUTSIDE | UNLISTED | FORMS
        made = []
        for entry in self.elements:
            parameters = dict(entry)
            made.append(catalogue[parameters.pop("physics")](**parameters))
        return made

    def __or__(self, other: Sized) -> Sized:
        return Sized(
            (*self.elements, *other.elements),
            lambda rows: other.true_rows(self.true_rows(rows)),
            self.softness * other.softness,
            "; ".join(filter(None, (self.remark, other.remark))),
        )


@dataclass(frozen=True)
class Hidden:
    """One piece of physics: `of_size` makes it from a size between `low` and `high`; it shows more the larger it is.

    `components`: what may be named as its place; a list of several names is right where all of them are in it.
    """

    physics: str
    components: tuple[str, ...]
    low: float
    high: float
    of_size: Callable[[float], Sized]


@dataclass(frozen=True)
class Recipe:
    """How to conceal one piece of physics in an experiment that was drawn with its `wishes` in mind."""

    physics: str
    wishes: Callable[[np.random.Generator], Wishes]
    hide: Callable[[Experiment, np.random.Generator], Hidden]
    planar: bool = True
    pairs: bool = True  # whether it may stand beside a second effect


def element(physics: str, **parameters: Any) -> dict[str, Any]:
    """A laboratory element as plain numbers and lists."""
    return {"physics": physics} | {name: plain(value) for name, value in parameters.items()}


def plain(value: Any) -> Any:
    """The value in Python's own numbers, lists and mappings, as files hold them."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, Mapping):
        return {name: plain(each) for name, each in value.items()}
    return value


def unit(rng: np.random.Generator, size: int) -> Array:
    """A random direction."""
    drawn = rng.normal(size=size)
    return np.asarray(drawn / np.linalg.norm(drawn))


def pick_leg(experiment: Experiment, rng: np.random.Generator, reversals: bool = False) -> int:
    """Index of a leg that carries load, and pulls in some rows and pushes in others where `reversals` asks for it."""
    forces = experiment.forces[experiment.fitted]
    loaded = np.abs(forces) > 1e-6 * np.abs(forces).max()
    typical = np.abs(forces).mean(axis=0)
    able = typical > 0.4 * typical.max()
    if reversals:
        rows = loaded.sum(axis=0)
        pulling, pushing = ((forces > 0) & loaded).sum(axis=0) / rows, ((forces < 0) & loaded).sum(axis=0) / rows
        able &= np.minimum(pulling, pushing) > 0.2
    if not able.any():
        raise UnsuitableError("no leg is loaded as this physics needs it")
    return int(rng.choice(np.flatnonzero(able)))


def leg_or_all(experiment: Experiment, rng: np.random.Generator, reversals: bool = False, every: float = 0.3) -> str:
    """`leg 3`, or `all legs` in the share `every` of cases."""
    if rng.random() < every:
        return "all legs"
    return f"leg {pick_leg(experiment, rng, reversals) + 1}"


def numbers_of(component: str, legs: int) -> Sequence[int]:
    """Indices of the legs of a component."""
    return range(legs) if component == "all legs" else [int(component.split()[1]) - 1]
