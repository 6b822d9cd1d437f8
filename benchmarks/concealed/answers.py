"""What a diagnosis answered: diagnosis.json (file-formats.md, diagnosis.json), read strictly."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

VERDICTS = ("consistent", "explained", "modelled", "unexplained")
COMPONENTS = {"all legs", "all joints", "platform", "base", "payload", "instrument", "environment", "geometry"}
FIT = ("noise_rms", "train_before", "train_after", "test_before", "test_after")


class NoAnswerError(Exception):
    """There is no diagnosis.json that says what it must."""


@dataclass(frozen=True)
class Conclusion:
    physics: str
    component: frozenset[str]
    probability: float
    group: frozenset[str]  # identifiers that are declared to explain the recordings as well

    def __str__(self) -> str:
        others = f" or {', '.join(sorted(self.group))}" if self.group else ""
        return f"{self.physics}{others} at {', '.join(sorted(self.component)) or '?'} (p {self.probability:.2f})"


@dataclass(frozen=True)
class Answer:
    verdict: str
    conclusions: tuple[Conclusion, ...] = ()
    location: frozenset[str] = frozenset()
    fit: Mapping[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        return "; ".join([self.verdict, *map(str, self.conclusions)])


def read_answer(path: Path, legs: int) -> Answer:
    """Answer of one diagnosis."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return answer_from(content, legs)
    except OSError:
        raise NoAnswerError("no diagnosis.json") from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise NoAnswerError(f"diagnosis.json: {type(error).__name__}: {error}") from None


def answer_from(content: Mapping[str, Any], legs: int) -> Answer:
    verdict = content["verdict"]
    if verdict not in VERDICTS:
        raise ValueError(f"verdict {verdict!r}")
    conclusions = []
    for each in content["effects"]:
        probability = float(each["probability"])
        if not 0.0 <= probability <= 1.0:
            raise ValueError(f"probability {probability}")
        group = frozenset(str(name) for name in each["indistinguishable_from"]) - {str(each["physics"])}
        conclusions.append(Conclusion(str(each["physics"]), names_of(each["component"], legs), probability, group))
    location = content.get("location")
    place = names_of(location["component"], legs) if location else frozenset()
    fit = {name: float(content["fit"][name]) for name in FIT if content["fit"][name] is not None}
    return Answer(verdict, tuple(conclusions), place, fit)


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
