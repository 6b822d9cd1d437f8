"""What a diagnosis answered: diagnosis.json (file-formats.md, diagnosis.json) and curves beside it, read strictly."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

VERDICTS = ("consistent", "explained", "modelled", "unexplained")
COMPONENTS = {"all legs", "all joints", "platform", "base", "payload", "instrument", "environment", "geometry"}
FIT = ("noise_rms", "train_before", "train_after", "test_before", "test_after")
LAW, UNKNOWN = "law", "unknown"


class NoAnswerError(Exception):
    """There is no answer that says what it must."""


@dataclass(frozen=True)
class Effect:
    """An entry of `effects`: physics with what is declared to explain the recordings as well, or a law and its curve.

    `curve` is that of a law, where its file is there.
    """

    physics: str
    components: tuple[str, ...]
    probability: float
    group: frozenset[str] = frozenset()
    depends_on: tuple[str, ...] = ()
    curve: pd.DataFrame | None = None

    @property
    def named(self) -> bool:
        """Whether it is known physics."""
        return self.physics not in (LAW, UNKNOWN)

    def __str__(self) -> str:
        what = f"{self.physics} of {', '.join(self.depends_on)}" if self.depends_on else self.physics
        others = f" or {', '.join(sorted(self.group))}" if self.group else ""
        return f"{what}{others} at {', '.join(self.components) or '?'} (p {self.probability:.2f})"


@dataclass(frozen=True)
class Answer:
    """`location`: components in the order in which they are named; `candidates`: component and probability."""

    verdict: str
    effects: tuple[Effect, ...] = ()
    location: tuple[str, ...] = ()
    candidates: tuple[tuple[str, float], ...] = ()
    fit: Mapping[str, float] = field(default_factory=dict)

    @property
    def first(self) -> str | None:
        """The component that is named first: by the location, else by the first effect."""
        named = self.location or (self.effects[0].components if self.effects else ())
        return named[0] if named else None

    def __str__(self) -> str:
        where = f" at {', '.join(self.location)}" if self.location else ""
        return "; ".join([self.verdict + where, *map(str, self.effects)])


def read_answer(folder: Path, legs: int) -> Answer:
    """The diagnosis.json of a folder, with the curves beside it."""
    try:
        return answer_from(json.loads((folder / "diagnosis.json").read_text(encoding="utf-8")), legs, folder)
    except OSError:
        raise NoAnswerError("no diagnosis.json") from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise NoAnswerError(f"diagnosis.json: {type(error).__name__}: {error}") from None


def answer_from(content: Mapping[str, Any], legs: int, folder: Path) -> Answer:
    """The answer, or ValueError, KeyError or TypeError where something is out of form."""
    if content["verdict"] not in VERDICTS:
        raise ValueError(f"verdict {content['verdict']!r}")
    location = content.get("location") or {}
    candidates = tuple(
        (_ordered(each["component"], legs)[0], probability_of(each["probability"]))
        for each in location.get("candidates") or ()
    )
    effects = tuple(_effect(each, legs, folder) for each in content["effects"])
    fit = {name: float(content["fit"][name]) for name in FIT if content["fit"][name] is not None}
    return Answer(content["verdict"], effects, _ordered(location.get("component"), legs), candidates, fit)


def _effect(entry: Mapping[str, Any], legs: int, folder: Path) -> Effect:
    physics, path = str(entry["physics"]), entry.get("curve")
    return Effect(
        physics,
        _ordered(entry["component"], legs),
        probability_of(entry["probability"]),
        frozenset(str(name) for name in entry["indistinguishable_from"]) - {physics},
        tuple(str(each) for each in entry.get("depends_on") or ()),
        pd.read_csv(folder / str(path)) if path and (folder / str(path)).exists() else None,
    )


def probability_of(value: Any) -> float:
    """A number between 0 and 1, or ValueError."""
    probability = float(value)
    if not 0.0 <= probability <= 1.0:
        raise ValueError(f"probability {probability}")
    return probability


def names_of(component: Any, legs: int) -> frozenset[str]:
    """Components of a result, which names one or a list; the list of all legs is `all legs`."""
    names = {component} if isinstance(component, str) else {str(each) for each in component or ()}
    each_leg = {f"leg {leg + 1}" for leg in range(legs)}
    each_part = {f"{kind} {number + 1}" for kind in ("joint", "link") for number in range(legs)}  # of a serial robot
    for name in names - each_leg - each_part - COMPONENTS:
        raise ValueError(f"component {name!r}")
    if each_leg <= names:
        names = (names - each_leg) | {"all legs"}
    return frozenset(names)


def _ordered(component: Any, legs: int) -> tuple[str, ...]:
    """Components in their order."""
    names = names_of(component, legs)
    listed = [component] if isinstance(component, str) else list(component or ())
    rest = [name for name in listed if name in names]
    return tuple(rest) if len(rest) == len(names) else ("all legs", *rest)
