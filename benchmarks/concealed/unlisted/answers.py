"""What a diagnosis answered, laws and located candidates included, read strictly."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from ..answers import NoAnswerError, names_of

VERDICTS = ("consistent", "explained", "modelled", "unexplained")
NOT_NAMED = ("law", "unknown")


@dataclass(frozen=True)
class Effect:
    """An entry of `effects`; `curve` is that of a law, where its file is there."""

    physics: str
    components: tuple[str, ...]
    probability: float
    depends_on: tuple[str, ...] = ()
    curve: pd.DataFrame | None = None

    def __str__(self) -> str:
        what = f"{self.physics} of {', '.join(self.depends_on)}" if self.depends_on else self.physics
        return f"{what} at {', '.join(self.components) or '?'} (p {self.probability:.2f})"


@dataclass(frozen=True)
class Answer:
    """`location`: components in the order in which they are named; `candidates`: component and probability."""

    verdict: str
    effects: tuple[Effect, ...]
    location: tuple[str, ...]
    candidates: tuple[tuple[str, float], ...]

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
    """The answer, or ValueError where something is out of form."""
    if content["verdict"] not in VERDICTS:
        raise ValueError(f"verdict {content['verdict']!r}")
    location = content.get("location") or {}
    candidates = []
    for each in location.get("candidates") or ():
        candidates.append((_ordered(each["component"], legs)[0], _probability(each["probability"])))
    effects = tuple(_effect(each, legs, folder) for each in content["effects"])
    return Answer(content["verdict"], effects, _ordered(location.get("component"), legs), tuple(candidates))


def _effect(entry: Mapping[str, Any], legs: int, folder: Path) -> Effect:
    curve, path = None, entry.get("curve")
    if path and (folder / str(path)).exists():
        curve = pd.read_csv(folder / str(path))
    depends_on = tuple(str(each) for each in entry.get("depends_on") or ())
    components = _ordered(entry["component"], legs)
    return Effect(str(entry["physics"]), components, _probability(entry["probability"]), depends_on, curve)


def _probability(value: Any) -> float:
    probability = float(value)
    if not 0.0 <= probability <= 1.0:
        raise ValueError(f"probability {probability}")
    return probability


def _ordered(component: Any, legs: int) -> tuple[str, ...]:
    """Components in their order; a list of all legs is `all legs`."""
    names = names_of(component, legs)
    listed = [component] if isinstance(component, str) else list(component or ())
    rest = [name for name in listed if name in names]
    return tuple(rest) if len(rest) == len(names) else ("all legs", *rest)
