"""One answer held against one truth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from .answers import LAW, UNKNOWN, Answer, Effect, NoAnswerError, read_answer
from .case import Case, measured_components
from .held_out import Predicted, predicted
from .program import Outcome

NAMED = ("one", "two")
"""Families in which physics of the library shall be named."""
STRANGE = "outside"
"""The family in which it shall be said that no known physics is there."""


@dataclass(frozen=True)
class Judged:
    """A case after its diagnosis: `answer` is None and `problem` says why where there is none."""

    truth: Mapping[str, Any]
    outcome: Outcome
    answer: Answer | None
    predicted: Predicted | None = None
    problem: str = ""

    @property
    def name(self) -> str:
        return str(self.truth["case"])

    @property
    def family(self) -> str:
        return str(self.truth["family"])

    @property
    def parts(self) -> set[str]:
        """Every component that is a right answer."""
        return {part for effect in self.truth["effects"] for part in effect["parts"]}

    @property
    def physics(self) -> list[str]:
        """Identifiers that are really there."""
        return [str(each["physics"]) for each in self.truth["effects"]]

    @property
    def effects(self) -> tuple[Effect, ...]:
        """What was said to be there."""
        return self.answer.effects if self.answer else ()

    @property
    def alarmed(self) -> bool:
        """Whether a mismatch was reported; no answer is none."""
        return self.answer is not None and self.answer.verdict != "consistent"

    @property
    def located(self) -> bool:
        """Whether the component named first is an accepted one."""
        return self.alarmed and self.answer is not None and self.answer.first in self.parts

    @property
    def effect_located(self) -> bool:
        """Whether that of the first effect is."""
        return bool(self.effects) and bool(self.effects[0].components) and self.effects[0].components[0] in self.parts

    @property
    def component_right(self) -> bool:
        """Whether all components of the first effect (the location where there is none) are those of a real effect."""
        if self.answer is None:
            return False
        named = self.effects[0].components if self.effects else self.answer.location
        return any(_at(named, effect) for effect in self.truth["effects"])

    @property
    def first_right(self) -> bool:
        """Whether the effect that is named first is there."""
        return bool(self.effects) and self.effects[0].physics in self.physics

    @property
    def first_or_group_right(self) -> bool:
        """Whether it is, or what is declared to explain the recordings as well."""
        return bool(self.effects) and bool(({self.effects[0].physics} | self.effects[0].group) & set(self.physics))

    def both_found(self, groups: bool = True) -> bool:
        """Whether every real effect is among those said, each of which stands for one."""
        return _matched(self.physics, [{each.physics} | (each.group if groups else set()) for each in self.effects])

    @property
    def declared_unknown(self) -> bool:
        """Whether the answer is that no known physics accounts for the mismatch."""
        if self.answer is None or not self.alarmed:
            return False
        return self.answer.verdict in ("modelled", "unexplained") or any(not each.named for each in self.effects)

    def conclusions(self) -> Iterator[tuple[Effect, bool]]:
        """Every effect said, and whether that physics is really there at that component."""
        for each in self.effects:
            if each.physics == UNKNOWN:
                yield each, self.family == STRANGE
            else:
                yield (
                    each,
                    any(
                        _at(each.components, effect)
                        for effect in self.truth["effects"]
                        if each.physics in (LAW, effect["physics"])
                    ),
                )

    @property
    def misnamed(self) -> list[Effect]:
        """Known physics concluded with more than 0.5 probability that is not there in any form."""
        right = {name for effect in self.truth["effects"] for name in effect["names"]}
        return [each for each in self.effects if each.named and each.physics not in right and each.probability > 0.5]

    @property
    def strays(self) -> list[Effect]:
        """Entries, names and laws alike, all of whose components have nothing to do with what is there."""
        return [each for each in self.effects if not self.parts & set(each.components)]

    @property
    def worse(self) -> bool:
        """Whether held-out readings are predicted more than 2 % worse than by the base model, or not at all."""
        return self.predicted is None or self.predicted.worse

    @property
    def error(self) -> float:
        """Held-out RMS against the true values, in standard deviations of the readings."""
        return self.predicted.model if self.predicted else float("inf")

    @property
    def base(self) -> float:
        """The same by the base model."""
        return self.predicted.base if self.predicted else float("nan")

    @property
    def declared_ratio(self) -> float | None:
        """Held-out RMS over the noise floor, as the diagnosis states it."""
        fit = self.answer.fit if self.answer else {}
        return fit["test_after"] / fit.get("noise_rms", 1.0) if "test_after" in fit else None

    @property
    def coverage(self) -> list[float]:
        """For each true curve that a law was given for: share of its points inside the band."""
        curves = [curve for effect in self.truth["effects"] for curve in effect["curves"]]
        shares = [covered(law, curve) for curve in curves for law in self.effects]
        return [share for share in shares if share is not None]

    def description(self) -> str:
        """What is really there, in words."""
        each = [
            f"{e['physics']} at {' or '.join(e['parts'])} ({e['mismatch_in_std']:.1f} std)"
            for e in self.truth["effects"]
        ]
        return " + ".join(each) or "nothing"

    def faults(self) -> list[str]:
        """What is wrong, in words."""
        if self.problem:
            return [self.problem]
        if self.family == "none":
            return ["false alarm"] if self.alarmed else []
        if not self.alarmed:
            return ["not detected"]
        if self.family == STRANGE:
            return [] if self.declared_unknown else ["not declared unknown"]
        if self.family in NAMED:
            return self._naming()
        found = [f"wrongly named {each.physics}" for each in self.misnamed]
        if not self.located:
            found.append("located elsewhere")
        if self.predicted is None:
            found.append("no prediction")
        elif self.error >= 1.0:
            found.append(f"held-out {self.error:.2f}")
        if self.predicted and self.worse:
            found.append("worse than base")
        return found

    def _naming(self) -> list[str]:
        found = []
        if not self.first_or_group_right:
            found.append("other physics first")
        elif not self.first_right:
            found.append("first only within its group")
        if not self.component_right:
            found.append("other component")
        if self.family == "two" and not self.both_found():
            found.append("not both")
        return found


def judge(case: Case, outcome: Outcome, folder: Path) -> Judged:
    """Read the answer of a case and hold it against the truth."""
    if outcome.problem:
        return Judged(case.truth, outcome, None, problem=outcome.problem)
    try:
        answer = read_answer(folder, len(case.truth["true_stiffness"]))
    except NoAnswerError as error:
        return Judged(case.truth, outcome, None, problem=str(error))
    path, found = folder / "predicted.csv", None
    if path.exists():
        guess = pd.read_csv(path)
        found = predicted(case, guess) if set(measured_components(case.later)) <= set(guess) else None
    return Judged(case.truth, outcome, answer, found)


def covered(law: Effect, curve: Mapping[str, Any]) -> float | None:
    """Share of a true curve's points inside the 95 % band of a law at its component that depends on its input alone.

    The law's CSV has a column whose name begins with that of the input (`length_m`), and `mean`, `low`, `high`. Law and
    base stiffness share what is constant (a compliance) or linear (an elongation over force): the difference between
    the true curve and the mean is freed of that, weighted by the band, before it is held against the band. None where
    the law is none of that curve.
    """
    table = law.curve
    if table is None or curve["component"] not in law.components:
        return None
    columns = [str(name) for name in table if str(name).startswith(curve["input"])]
    if not columns or not {"mean", "low", "high"} <= set(table) or len(set(law.depends_on) - {curve["input"]}):
        return None
    table = table.sort_values(columns[0])
    at, true = np.asarray(curve["inputs"]), np.asarray(curve["values"])
    inside = (at >= table[columns[0]].min()) & (at <= table[columns[0]].max())
    if inside.sum() < 5:
        return None
    mean, low, high = (np.interp(at[inside], table[columns[0]], table[name]) for name in ("mean", "low", "high"))
    form = at[inside] if curve["quantity"] == "elongation_m" else np.ones(int(inside.sum()))
    width = np.maximum((high - low) / 2, 1e-300)
    difference = true[inside] - mean
    shared = float(np.sum(form * difference / width**2) / np.sum(form**2 / width**2))
    rest = difference - shared * form
    return float(np.mean((rest >= low - mean) & (rest <= high - mean)))


def _at(named: tuple[str, ...], effect: Mapping[str, Any]) -> bool:
    return bool(named) and set(named) <= set(effect["parts"])


def _matched(wanted: list[str], offers: list[set[str]]) -> bool:
    """Whether every wanted identifier can be given an offer of its own."""
    if not wanted:
        return True
    first, rest = wanted[0], wanted[1:]
    return any(first in offer and _matched(rest, offers[:i] + offers[i + 1 :]) for i, offer in enumerate(offers))
