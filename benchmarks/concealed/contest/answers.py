"""The answer of a tool: one JSON file, read strictly."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..answers import NoAnswerError, names_of, probability_of

KEYS = {"mismatch", "location", "physics", "predictions"}


@dataclass(frozen=True)
class Named:
    """Physics that a tool says is there, with the probability that it gives."""

    name: str
    probability: float


@dataclass(frozen=True)
class Answer:
    """`location`: components, likeliest first; `predictions`: of the points, shape (rows, measured components)."""

    mismatch: bool
    location: tuple[str, ...]
    physics: tuple[Named, ...]
    predictions: NDArray[np.float64]

    def __str__(self) -> str:
        where = f" at {', '.join(self.location)}" if self.location else ""
        named = "; ".join(f"{each.name} ({each.probability:.2f})" for each in self.physics)
        return ("mismatch" if self.mismatch else "consistent") + where + (f": {named}" if named else "")


def read_answer(path: Path, components: Sequence[str], rows: int, legs: int) -> Answer:
    """The answer in a file.

    Raises:
        NoAnswerError: there is none, or one that is out of form, with the reason.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        raise NoAnswerError("no answer file") from None
    except ValueError as error:
        raise NoAnswerError(f"the answer is no JSON: {error}") from None
    try:
        return answer_from(content, components, rows, legs)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise NoAnswerError(f"the answer is out of form: {type(error).__name__}: {error}") from None


def answer_from(content: Mapping[str, Any], components: Sequence[str], rows: int, legs: int) -> Answer:
    """The answer in a document; ValueError, KeyError or TypeError where something is out of form."""
    if not isinstance(content, Mapping):
        raise ValueError("not an object")
    if unknown := set(content) - KEYS:
        raise ValueError(f"unknown keys {sorted(unknown)}")
    if not isinstance(content["mismatch"], bool):
        raise ValueError("`mismatch` is neither true nor false")
    location = content.get("location") or []
    if not isinstance(location, list):
        raise ValueError("`location` is no list")
    for name in location:
        names_of(name, legs)  # raises where there is no such component
    physics = tuple(_named(each) for each in content.get("physics") or [])
    return Answer(content["mismatch"], tuple(location), physics, _numbers(content["predictions"], components, rows))


def _named(entry: Mapping[str, Any]) -> Named:
    return Named(str(entry["name"]), probability_of(entry.get("probability", 1.0)))


def _numbers(content: Mapping[str, Any], components: Sequence[str], rows: int) -> NDArray[np.float64]:
    if missing := [name for name in components if name not in content]:
        raise ValueError(f"`predictions` lacks {', '.join(missing)}")
    columns = [np.asarray(content[name], dtype=float) for name in components]
    for name, column in zip(components, columns, strict=True):
        if column.shape != (rows,):
            raise ValueError(f"`predictions`, {name}: {column.size} numbers for {rows} points")
        if not np.isfinite(column).all():
            raise ValueError(f"`predictions`, {name}: not every number is finite")
    return np.column_stack(columns)
