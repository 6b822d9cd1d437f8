"""One answer held against one truth, in numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from virtual_laboratory import Robot

from ..answers import NoAnswerError
from ..held_out import base_prediction
from ..run import Outcome
from .answers import NOT_NAMED, Answer, Effect, read_answer
from .case import Case

_UNITS = {"length": ("length",), "force": ("force",), "temperature": ("temperature",)}


@dataclass(frozen=True)
class Predicted:
    """Held-out errors in standard deviations of the readings: against the true values, and against the readings.

    `standardised`: errors over the standard deviation that the prediction states; empty where it states none.
    """

    base: float
    model: float
    base_read: float
    model_read: float
    standardised: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class Judged:
    """A case after its diagnosis."""

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
    def alarmed(self) -> bool:
        return self.answer is not None and self.answer.verdict != "consistent"

    @property
    def located(self) -> bool:
        """Whether the component named first is an accepted one."""
        return self.alarmed and self.answer is not None and self.answer.first in self.parts

    @property
    def effect_located(self) -> bool:
        """Whether that of the first effect is."""
        effects = self.answer.effects if self.answer else ()
        return bool(effects) and bool(effects[0].components) and effects[0].components[0] in self.parts

    @property
    def misnamed(self) -> list[Effect]:
        """Known physics concluded with more than 0.5 probability that is not there in any form."""
        right = {name for effect in self.truth["effects"] for name in effect["names"]}
        effects = self.answer.effects if self.answer else ()
        return [e for e in effects if e.physics not in (*NOT_NAMED, *right) and e.probability > 0.5]

    @property
    def strays(self) -> list[Effect]:
        """Entries, names and laws alike, all of whose components have nothing to do with what is there."""
        effects = self.answer.effects if self.answer else ()
        return [each for each in effects if not self.parts & set(each.components)]

    @property
    def coverage(self) -> list[float]:
        """For each true curve that a law was given for: share of its points inside the band."""
        found = []
        for effect in self.truth["effects"]:
            for curve in effect["curves"]:
                for law in self.answer.effects if self.answer else ():
                    share = covered(law, curve)
                    if share is not None:
                        found.append(share)
        return found

    def description(self) -> str:
        each = [
            f"{e['physics']} at {' or '.join(e['parts'])} ({e['mismatch_in_std']:.1f} std)"
            for e in self.truth["effects"]
        ]
        return " + ".join(each) or "nothing"

    def faults(self) -> list[str]:
        """What is wrong, in words."""
        if self.problem:
            return [self.problem]
        found = [f"wrongly named {each.physics}" for each in self.misnamed]
        if self.family == "none":
            return [*(["false alarm"] if self.alarmed else []), *found]
        if not self.alarmed:
            return ["not detected"]
        if not self.located:
            found.append("located elsewhere")
        if self.predicted is None:
            found.append("no prediction")
        elif self.predicted.model >= 1.0:
            found.append(f"held-out {self.predicted.model:.2f}")
        if self.predicted and self.predicted.model_read > 1.02 * self.predicted.base_read:
            found.append("worse than base")
        return found


def judge(case: Case, outcome: Outcome, folder: Path) -> Judged:
    """Read the answer of a case and hold it against the truth."""
    if outcome.problem:
        return Judged(case.truth, outcome, None, problem=outcome.problem)
    try:
        answer = read_answer(folder, len(case.truth["true_stiffness"]))
    except NoAnswerError as error:
        return Judged(case.truth, outcome, None, problem=str(error))
    return Judged(case.truth, outcome, answer, predicted=_predicted(case, folder / "predicted.csv"))


def _predicted(case: Case, path: Path) -> Predicted | None:
    if not path.exists():
        return None
    later, guess = case.later, pd.read_csv(path)
    names = [str(name)[5:] for name in later if str(name).startswith("true_")]
    stds = [deviation_of(name) for name in names]
    if not set(names) <= set(guess):
        return None
    true, read = later[[f"true_{n}" for n in names]].to_numpy(dtype=float), later[names].to_numpy(dtype=float)
    std, model = later[stds].to_numpy(dtype=float), guess[names].to_numpy(dtype=float)
    if f"base_{names[0]}" in later:
        base = later[[f"base_{name}" for name in names]].to_numpy(dtype=float)
    else:
        base = base_prediction(Robot.from_mapping(case.robot), case.recordings, later, names, stds)
    own = guess[stds].to_numpy(dtype=float) if set(stds) <= set(guess) else np.full_like(model, np.nan)
    usable = np.isfinite(own) & (own > 0)
    standardised = ((model - true)[usable] / own[usable]).ravel()

    errors = [(base - true) / std, (model - true) / std, (base - read) / std, (model - read) / std]
    of_base, of_model, base_read, model_read = (float(np.sqrt(np.mean(each**2))) for each in errors)
    return Predicted(of_base, of_model, base_read, model_read, standardised)


def deviation_of(reading: str) -> str:
    """Column of the standard deviation of a reading: `sx_m` of `dx_m`, `spx_m` of the position `px_m`."""
    return f"s{reading}" if reading.startswith("p") else f"s{reading[1:]}"


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
    columns = [str(name) for name in table if str(name).startswith(_UNITS[curve["input"]])]
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
