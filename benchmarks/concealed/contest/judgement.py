"""One answer held against one truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from ..answers import LAW, UNKNOWN, NoAnswerError
from ..case import Case, measured_components
from ..held_out import base_prediction, deviation_of, predicted
from ..program import Outcome
from .answers import Answer, Named, read_answer


@dataclass(frozen=True)
class Judged:
    """A case and what one tool answered.

    `base` and `error`: RMS of predicted less true deflections on the held-out rows, in standard deviations of the
    readings, of the base model and of the tool (infinite without an answer); `worse`: whether the tool predicts their
    *readings* more than 2 % worse than the base model.
    """

    tool: str
    truth: Mapping[str, Any]
    cost: Outcome
    answer: Answer | None
    problem: str
    base: float
    error: float
    worse: bool

    @property
    def case(self) -> str:
        return str(self.truth["case"])

    @property
    def physics(self) -> str:
        return str(self.truth["physics"])

    @property
    def extent(self) -> str:
        return str(self.truth["extent"])

    @property
    def detected(self) -> bool:
        return self.answer is not None and self.answer.mismatch

    @property
    def located(self) -> bool:
        """Whether the component named first is one at which something is."""
        parts = {part for effect in self.truth["effects"] for part in effect["parts"]}
        return self.detected and self.answer is not None and bool(set(self.answer.location[:1]) & parts)

    @property
    def named(self) -> bool:
        """Whether the physics named first is there."""
        return bool(self._names) and self._names[0].name in self._there

    @property
    def misnamed(self) -> bool:
        """Whether listed physics that is not there in any form is given more than 0.5 probability."""
        return any(each.name not in self._there and each.probability > 0.5 for each in self._names)

    @property
    def _names(self) -> list[Named]:
        return [each for each in (self.answer.physics if self.answer else ()) if each.name not in (LAW, UNKNOWN)]

    @property
    def _there(self) -> set[str]:
        return {name for effect in self.truth["effects"] for name in effect["names"]}

    def row(self) -> dict[str, Any]:
        """For a table with one row per case and tool."""
        there = " + ".join(f"{each['physics']} at {' or '.join(each['parts'])}" for each in self.truth["effects"])
        return {
            "seed": self.truth["seed"],
            "case": self.case,
            "tool": self.tool,
            "physics": self.physics,
            "extent": self.extent,
            "robot": self.truth["robot"],
            "rows": self.truth["rows"],
            "truth": there or "nothing",
            "answer": str(self.answer) if self.answer else "",
            "problem": self.problem,
            "detected": self.detected,
            "located": self.located,
            "named": self.named,
            "misnamed": self.misnamed,
            "base_rms": round(self.base, 4),
            "held_out_rms": round(self.error, 4),
            "worse_than_base": self.worse,
            "cpu_s": round(self.cost.cpu_s, 2),
            "wall_s": round(self.cost.wall_s, 2),
        }


def judge(tool: str, case: Case, cost: Outcome, answer: Path) -> Judged:
    """Read the answer of a tool and hold it against the truth."""
    names = measured_components(case.later)
    stds = [deviation_of(name) for name in names]
    base = pd.DataFrame(base_prediction(case, names, stds), columns=names)
    try:
        if cost.problem:
            raise NoAnswerError(cost.problem)
        found = read_answer(answer, names, len(case.later), len(case.truth["true_stiffness"]))
    except NoAnswerError as error:
        of_base = predicted(case, base).base
        return Judged(tool, case.truth, cost, None, str(error), of_base, float("inf"), True)
    errors = predicted(case, pd.DataFrame(found.predictions, columns=names))
    return Judged(tool, case.truth, cost, found, "", errors.base, errors.model, errors.worse)
