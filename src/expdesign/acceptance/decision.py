"""Pass or fail: guarded acceptance of the attained pose (JCGM 106:2012, 8.3; ISO 14253-1).

After compensation the best estimate of the error is 0, with the expanded uncertainty U. With a guard band w = U the
acceptance interval is [−(T − U), T − U], and the estimate lies in it exactly where U ≤ T. An axis passes then: an error
beyond its tolerance has at most the probability that the coverage leaves.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr, stdtr

from expdesign.acceptance.budget import UncertaintyBudget
from expdesign.arrays import BoolArray, FloatArray

DECISION_RULE = (
    "an axis passes where its expanded uncertainty U does not exceed its tolerance T: guarded acceptance with a guard "
    "band of U (JCGM 106:2012, 8.3; ISO 14253-1), the estimated error after compensation being 0"
)
MOST = 1_000_000


@dataclass(frozen=True)
class Decision:
    """The decision on every axis of every target."""

    budget: UncertaintyBudget

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
        """Probability of an error beyond the tolerance, shape (t, n); NaN where an axis does not matter."""
        budget = self.budget
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
        "passes": decision.passes,
        "repetitions_until_it_passes": decision.needed,
        "measurements_until_it_passes": None if decision.needed is None else decision.needed * budget.measurements,
        "targets": [
            {
                "passes": bool(decision.passed[target].all()),
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
        "passes": bool(decision.passed[target, axis]),
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
    budget = decision.budget
    matters = int(budget.matters.sum())
    failing = int((~decision.passed).sum())
    level = f"{100.0 * budget.coverage.level:.4g} %"
    ratio = np.where(budget.matters, budget.expanded / budget.tolerance, -np.inf)
    texts = []
    if np.isnan(ratio).any():
        texts.append("Axes that are not determined by the measurements do not pass.")
    if failing == 0:
        texts.append(f"Every one of the {matters} axes with a tolerance passes.")
    else:
        texts.append(f"{failing} of the {matters} axes with a tolerance {'fails' if failing == 1 else 'fail'}.")
    if np.isfinite(ratio).any():
        target, axis = np.unravel_index(int(np.nanargmax(ratio)), ratio.shape)
        texts.append(
            f"The worst is {budget.axes[axis]} at target {target + 1}: U is {ratio[target, axis]:.3g} of its tolerance "
            f"(k = {budget.factor[target, axis]:.3g}, coverage {level}); an error beyond the tolerance has the "
            f"probability {decision.risk[target, axis]:.2g}."
        )
    if failing and decision.needed is None:
        texts.append(
            "No number of repetitions helps: errors that all measurements share (or what is not determined) exceed the "
            "tolerance by themselves. Know the load better, or measure otherwise."
        )
    elif failing and decision.needed is not None:
        texts.append(
            f"The whole plan done {decision.needed} times, set up anew each time "
            f"({decision.needed * budget.measurements} measurements), would pass; a plan that is optimised for as many "
            "measurements needs no more."
        )
    return texts
