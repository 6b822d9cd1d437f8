"""One answer held against one truth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from .answers import Answer, Conclusion
from .held_out import HeldOut

UNKNOWN = "unknown"
LAW = "law"


@dataclass(frozen=True)
class Case:
    """A case after its diagnosis: `answer` is None and `problem` says why where there is none."""

    truth: Mapping[str, Any]
    answer: Answer | None
    wall_s: float
    problem: str = ""
    later: HeldOut | None = None
    cpu_s: float = float("nan")

    @property
    def name(self) -> str:
        return str(self.truth["case"])

    @property
    def kind(self) -> str:
        return str(self.truth["kind"])

    @property
    def physics(self) -> list[str]:
        """Identifiers that are really there."""
        return [str(each["physics"]) for each in self.truth["effects"]]

    @property
    def first(self) -> Conclusion | None:
        """The conclusion that is named first."""
        return self.answer.conclusions[0] if self.answer and self.answer.conclusions else None

    @property
    def alarmed(self) -> bool:
        """Whether a mismatch was reported; no answer is none."""
        return self.answer is not None and self.answer.verdict != "consistent"

    @property
    def first_right(self) -> bool:
        return self.first is not None and self.first.physics in self.physics

    @property
    def first_or_group_right(self) -> bool:
        return self.first is not None and bool(({self.first.physics} | self.first.group) & set(self.physics))

    @property
    def component_right(self) -> bool:
        """Whether the first conclusion's place (the location where nothing is concluded) is one of a real effect."""
        if self.answer is None:
            return False
        named = self.first.component if self.first else self.answer.location
        return any(_at(named, effect) for effect in self.truth["effects"])

    def both_found(self, groups: bool = True) -> bool:
        """Whether every real effect is among the conclusions, each conclusion standing for one."""
        if self.answer is None:
            return False
        offers = [{each.physics} | (each.group if groups else set()) for each in self.answer.conclusions]
        return _matched(self.physics, offers)

    @property
    def declared_unknown(self) -> bool:
        """Whether the answer is that no known physics accounts for the mismatch."""
        if self.answer is None or not self.alarmed:
            return False
        unnamed = any(c.physics in (UNKNOWN, LAW) for c in self.answer.conclusions)
        return self.answer.verdict in ("modelled", "unexplained") or unnamed

    def conclusions(self) -> Iterator[tuple[Conclusion, bool]]:
        """Every conclusion, and whether that physics is really there at that component."""
        for each in self.answer.conclusions if self.answer else ():
            if each.physics == UNKNOWN:
                yield each, self.kind == "outside"
            elif each.physics == LAW:
                yield each, any(_at(each.component, effect) for effect in self.truth["effects"])
            else:
                real = [effect for effect in self.truth["effects"] if effect["physics"] == each.physics]
                yield each, any(_at(each.component, effect) for effect in real)

    @property
    def declared_ratio(self) -> float | None:
        """Held-out RMS over the noise floor, as the diagnosis states it."""
        if self.answer is None or "test_after" not in self.answer.fit:
            return None
        return self.answer.fit["test_after"] / self.answer.fit.get("noise_rms", 1.0)

    @property
    def declared_change(self) -> float | None:
        """Held-out RMS after over before, as the diagnosis states it."""
        fit = self.answer.fit if self.answer else {}
        if "test_after" not in fit or not fit.get("test_before"):
            return None
        return fit["test_after"] / fit["test_before"]

    def faults(self) -> list[str]:
        """What is wrong with the answer, in words."""
        if self.problem:
            return [self.problem]
        if self.kind == "none":
            return ["false alarm"] if self.alarmed else []
        if not self.alarmed:
            return ["not detected"]
        if self.kind == "outside":
            return [] if self.declared_unknown else ["not declared unknown"]
        found = []
        if not self.first_or_group_right:
            found.append("other physics first")
        elif not self.first_right:
            found.append("first only within its group")
        if not self.component_right:
            found.append("other component")
        if self.kind == "two" and not self.both_found():
            found.append("not both")
        return found

    def description(self) -> str:
        """What is really there, in words."""
        each = [
            f"{effect['physics']} at {', '.join(effect['components'])} (alone {effect['chi2_dof_alone']:.1f})"
            for effect in self.truth["effects"]
        ]
        return " + ".join(each) or "nothing"


def _at(named: frozenset[str], effect: Mapping[str, Any]) -> bool:
    return bool(named) and named <= set(effect["components"])


def _matched(wanted: list[str], offers: list[set[str]]) -> bool:
    """Whether every wanted identifier can be given an offer of its own."""
    if not wanted:
        return True
    first, rest = wanted[0], wanted[1:]
    return any(first in offer and _matched(rest, offers[:i] + offers[i + 1 :]) for i, offer in enumerate(offers))
