"""What is accepted: guarded acceptance of the attained pose (JCGM 106:2012, 8.3; ISO 14253-1).

After compensation the best estimate of the error is 0, with the expanded uncertainty U. With a guard band w = U the
acceptance interval is [−(T − U), T − U], and the estimate lies in it exactly where U ≤ T. An axis passes then: an error
beyond its tolerance has at most the probability that the coverage leaves. Where U > T conformity is not proven; nothing
proves that the axis is beyond its tolerance either, which takes a check measurement (`verification`).

All of it rests on the model. Where its own recordings refute it nothing is decided, and no probability is stated. A
plan, of which nothing has been measured, is expected to pass or not.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from scipy.special import ndtr, stdtr

from expdesign.arrays import BoolArray, FloatArray
from expdesign.assurance.acceptance.budget import UncertaintyBudget
from expdesign.probabilities import probability_text

DECISION_RULE = (
    "an axis passes where its expanded uncertainty U does not exceed its tolerance T: guarded acceptance with a guard "
    "band of U (JCGM 106:2012, 8.3; ISO 14253-1), the estimated error after compensation being 0"
)
MOST = 1_000_000


class Basis(Enum):
    """What a decision rests on: a plan, a model that its recordings bear out, or one that they refute."""

    PLAN = "plan"
    MODEL = "model"
    REFUTED = "refuted"


_WORDS = {
    Basis.PLAN: ("expected to pass", "not expected to pass"),
    Basis.MODEL: ("pass", "not proven"),
    Basis.REFUTED: ("not decided", "not decided"),
}
NOT_DECIDED = "Acceptance is not decided: the model is refuted by its own recordings"


@dataclass(frozen=True)
class Decision:
    """The decision on every axis of every target.

    Attributes:
        budget: of the attained pose.
        basis: what it rests on.
        remedy: what to do where nothing is decided.
        check_readings: of every target, with which `verify` will prove conformity where it is planned to pass; None
            where no number will, or where that was not asked.
    """

    budget: UncertaintyBudget
    basis: Basis = Basis.MODEL
    remedy: str = "run `expdesign diagnose`"
    check_readings: int | None = None

    @property
    def verdict(self) -> str:
        """`pass`, `not proven` or `not decided`; of a plan `expected to pass` or `not expected to pass`."""
        return self._word(self.passes)

    def axis_verdict(self, target: int, axis: int) -> str:
        """The same of one axis of a target."""
        return self._word(bool(self.passed[target, axis]))

    def _word(self, passes: bool) -> str:
        return _WORDS[self.basis][0 if passes else 1]

    @property
    def decided(self) -> bool:
        """Whether the model bears a decision."""
        return self.basis is not Basis.REFUTED

    @property
    def passed(self) -> BoolArray:
        """Whether each axis passes, shape (t, n); True where an axis does not matter."""
        budget = self.budget
        passed: BoolArray = ~budget.matters | (budget.expanded <= budget.tolerance)
        return passed

    @property
    def passes(self) -> bool:
        """Whether every axis of every target does."""
        return bool(self.passed.all())

    @property
    def risk(self) -> FloatArray:
        """Probability of an error beyond the tolerance, shape (t, n); NaN where an axis does not matter.

        NaN as well where nothing is decided.
        """
        budget = self.budget
        if not self.decided:
            return np.full(budget.tolerance.shape, np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            score = budget.tolerance / budget.standard
        known = ~np.isfinite(budget.degrees)
        risk: FloatArray = 2.0 * np.where(known, ndtr(-score), stdtr(np.where(known, 1.0, budget.degrees), -score))
        return risk

    @property
    def repetitions(self) -> FloatArray:
        """How often the whole experiment has to be done until each axis passes, shape (t, n).

        Independent errors shrink with the root of the number, shared ones do not: r = k²·u_r²/(T² − k²·u_s²), rounded
        up; infinite where the shared part alone exceeds the tolerance, NaN where an axis does not matter.
        """
        budget = self.budget
        allowed = budget.tolerance**2 - budget.repeated(np.inf) ** 2
        repeatable = budget.expanded**2 - budget.repeated(np.inf) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            needed = np.where(allowed > 0.0, np.ceil(repeatable / allowed * (1.0 - 1e-12)), np.inf)
        unknown = np.isnan(budget.standard)
        needed = np.where(needed > MOST, np.inf, np.maximum(needed, 1.0))
        result: FloatArray = np.where(budget.matters, np.where(unknown, np.inf, needed), np.nan)
        return result

    @property
    def needed(self) -> int | None:
        """How often the whole experiment has to be done until all axes pass; None where no number is enough."""
        most = float(np.nanmax(self.repetitions))
        return int(most) if np.isfinite(most) else None


def acceptance_record(decision: Decision) -> dict[str, Any]:
    """What `run.json`, `evaluate --json` and `identification.json` say under `acceptance`."""
    budget = decision.budget
    return {
        "coverage": budget.coverage.level,
        "coverage_factor": budget.coverage.factor,
        "decision_rule": DECISION_RULE,
        "verdict": decision.verdict,
        "passes": decision.passes if decision.decided else None,
        "check_readings": decision.check_readings,
        "repetitions_until_it_passes": decision.needed,
        "measurements_until_it_passes": None if decision.needed is None else decision.needed * budget.measurements,
        "targets": [
            {
                "passes": bool(decision.passed[target].all()) if decision.decided else None,
                "axes": [_axis(decision, target, int(axis)) for axis in np.flatnonzero(budget.matters[target])],
            }
            for target in range(len(budget.tolerance))
        ],
    }


def _axis(decision: Decision, target: int, axis: int) -> dict[str, Any]:
    budget = decision.budget

    def at(values: FloatArray) -> float | None:
        value = float(values[target, axis])
        return value if np.isfinite(value) else None

    repetitions = at(decision.repetitions)
    return {
        "axis": budget.axes[axis],
        "tolerance": at(budget.tolerance),
        "budget": {one.name: at(one.deviation) for one in _merged(budget)},
        "standard_uncertainty": at(budget.standard),
        "degrees_of_freedom": at(budget.degrees),
        "coverage_factor": at(budget.factor),
        "expanded_uncertainty": at(budget.expanded),
        "verdict": decision.axis_verdict(target, axis),
        "passes": bool(decision.passed[target, axis]) if decision.decided else None,
        "probability_beyond_tolerance": at(decision.risk),
        "repetitions_until_it_passes": None if repetitions is None else int(repetitions),
    }


@dataclass(frozen=True)
class _Line:
    name: str
    deviation: FloatArray


def _merged(budget: UncertaintyBudget) -> list[_Line]:
    """Contributions by name; of several with one name (a source that is named twice), the root of the squares."""
    lines: dict[str, FloatArray] = {}
    for one in budget.contributions:
        lines[one.name] = np.hypot(lines[one.name], one.deviation) if one.name in lines else one.deviation
    return [_Line(name, deviation) for name, deviation in lines.items()]


def sentences(decision: Decision) -> list[str]:
    """What the decision says, in words."""
    if not decision.decided:
        return [f"{NOT_DECIDED}; {decision.remedy}."]
    budget = decision.budget
    level = f"{100.0 * budget.coverage.level:.4g} %"
    ratio = np.where(budget.matters, budget.expanded / budget.tolerance, -np.inf)
    texts = [_verdict_sentence(decision)]
    if np.isnan(ratio).any():
        texts.append("The measurements do not determine all of these axes.")
    if np.isfinite(ratio).any():
        target, axis = np.unravel_index(int(np.nanargmax(ratio)), ratio.shape)
        texts.append(
            f"The worst is {budget.axes[axis].rsplit('_', 1)[0]} at target {target + 1}: U is "
            f"{ratio[target, axis]:.3g} of its tolerance "
            f"(k = {budget.factor[target, axis]:.3g}, coverage {level}); an error beyond the tolerance has the "
            f"probability {probability_text(float(decision.risk[target, axis]), 2)}."
        )
    texts += _repetitions(decision)
    if decision.basis is Basis.PLAN and decision.passes:
        texts.append(_check_readings(decision.check_readings))
    return texts


def _verdict_sentence(decision: Decision) -> str:
    matters, failing = int(decision.budget.matters.sum()), int((~decision.passed).sum())
    if decision.basis is Basis.PLAN:
        if not failing:
            return f"The robot is expected to pass: on all {matters} axes with a tolerance U is within it."
        return f"The robot is not expected to pass: on {failing} of the {matters} axes with a tolerance U exceeds it."
    if not failing:
        return f"The robot passes: on all {matters} axes with a tolerance U is within it."
    return f"Not proven: on {failing} of the {matters} axes with a tolerance U exceeds it."


def _repetitions(decision: Decision) -> list[str]:
    """What would make a robot pass that does not."""
    if decision.passes:
        return []
    if decision.needed is None:
        return [
            "No number of repetitions helps: errors that all measurements share (or what is not determined) exceed the "
            "tolerance by themselves. Know the load better, or measure otherwise."
        ]
    return [
        f"The whole plan done {decision.needed} times, set up anew each time "
        f"({decision.needed * decision.budget.measurements} measurements), would pass; a plan that is optimised for as "
        "many measurements needs no more."
    ]


def _check_readings(count: int | None) -> str:
    if count is None:
        return "No number of check readings with this instrument lets `expdesign verify` prove conformity."
    return (
        f"To prove conformity, `expdesign verify` will need {count} independent check reading"
        f"{'' if count == 1 else 's'} of every target with this instrument."
    )
