"""What is accepted: guarded acceptance of the attained pose (JCGM 106:2012, 8.3; ISO 14253-1).

After compensation the best estimate of the error is 0, with the expanded uncertainty U. With a guard band w = U the
acceptance interval is [−(T − U), T − U], and the estimate lies in it exactly where U ≤ T. An axis passes then: an error
beyond its tolerance has at most the probability that the coverage leaves. Where U > T conformity is not proven; nothing
proves that the axis is beyond its tolerance either, which takes a check measurement (`verification`).

Two things U does not know: physics that the model leaves out, and that a robot is out of tolerance where any axis at
any target is. A robot that recordings determined therefore passes only where

    R = Σ_e p_e·P(any |error| > T | e)

is no more than the coverage leaves: the total specific consumer's risk (IUPAC/CITAC guide, Kuselman, Pennecchi, da
Silva and Hibbert, Pure Appl. Chem. 93, 2021, 113), over e, nothing or one physics that these recordings may hide
(`left_out`), of probability p_e. Errors of all axes and targets are jointly normal under each e (`any_axis`).

All of it rests on the model. Where its own recordings refute it nothing is decided, and no probability is stated. A
plan, of which nothing has been measured, is expected to pass or not, axis by axis.
"""

from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import ndtr, stdtr

from expdesign.arrays import BoolArray, FloatArray
from expdesign.assurance.acceptance.any_axis import NEGLIGIBLE, any_beyond
from expdesign.assurance.acceptance.budget import UncertaintyBudget
from expdesign.probabilities import SMALLEST, probability_text

DECISION_RULE = (
    "an axis passes where its expanded uncertainty U does not exceed its tolerance T: guarded acceptance with a guard "
    "band of U (JCGM 106:2012, 8.3; ISO 14253-1), the estimated error after compensation being 0; with recordings the "
    "robot passes only where the probability that any axis at any target is beyond T, by physics that they may hide "
    "as well, is within what the coverage leaves"
)
MOST = 1_000_000
_ROUNDING = 1e-9
"""Relative: an axis with U = T passes."""


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
class LeftOutRisk:
    """Alternatives to the model, as the recordings leave them: E effects at t targets along n axes.

    Attributes:
        phrases: a machine with each, in words.
        probability: that it is there, shape (E,); what is missing to 1 is that nothing is left out.
        mean: what it is expected to do to the attained pose (m, rad), shape (E, t, n).
        roots: of the covariances of that, E of shape (t, n, d): what d independent standard deviations do.
    """

    phrases: tuple[str, ...]
    probability: FloatArray
    mean: FloatArray
    roots: tuple[FloatArray, ...]

    @property
    def nothing(self) -> float:
        """Probability that nothing is left out."""
        return float(max(1.0 - self.probability.sum(), 0.0))


@dataclass(frozen=True)
class Decision:
    """The decision on every axis of every target.

    Attributes:
        budget: of the attained pose.
        basis: what it rests on.
        remedy: what to do where nothing is decided.
        check_readings: of every target, with which `verify` will prove conformity where it is planned to pass; None
            where no number will, or where that was not asked.
        left_out: what the recordings may hide; None of a plan, or where nothing can be left out.
    """

    budget: UncertaintyBudget
    basis: Basis = Basis.MODEL
    remedy: str = "run `expdesign diagnose`"
    check_readings: int | None = None
    left_out: LeftOutRisk | None = None

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
        """Whether each axis by itself passes, shape (t, n); True where an axis does not matter."""
        passed: BoolArray = self.within & ~(self.budget.matters & (self.risk > self.allowed * (1.0 + _ROUNDING)))
        return passed

    @property
    def within(self) -> BoolArray:
        """Whether U is within the tolerance, shape (t, n); True where an axis does not matter."""
        budget = self.budget
        within: BoolArray = ~budget.matters | (budget.expanded <= budget.tolerance)
        return within

    @property
    def allowed(self) -> float:
        """The probability that the coverage leaves."""
        return 1.0 - self.budget.coverage.level

    @property
    def endangered(self) -> bool:
        """Whether an error beyond any tolerance is likelier than the coverage allows, although U is within each."""
        if self.basis is not Basis.MODEL or not self.within.all():
            return False
        return self.whole_risk > self.allowed

    @property
    def passes(self) -> bool:
        """Whether every axis of every target does, and the robot as a whole."""
        return bool(self.within.all()) and not self.endangered

    @property
    def risk(self) -> FloatArray:
        """Probability of an error of each axis beyond its tolerance, shape (t, n); NaN where it does not matter.

        NaN as well where nothing is decided.
        """
        if not self.decided:
            return np.full(self.budget.tolerance.shape, np.nan)
        right = self._tails().sum(axis=0)
        return right if self.left_out is None else self.left_out.nothing * right + self.hidden_risk.sum(axis=0)

    @property
    def hidden_risk(self) -> FloatArray:
        """The part of `risk` that each physics has which the recordings may hide, shape (E, t, n)."""
        if self.left_out is None or not self.decided:
            return np.zeros((0, *self.budget.tolerance.shape))
        hidden = self.left_out
        tails = [self._tails(mean, root) for mean, root in zip(hidden.mean, hidden.roots, strict=True)]
        parts: FloatArray = hidden.probability[:, None, None] * np.sum(tails, axis=1)
        return parts

    @cached_property
    def whole_risk(self) -> float:
        """R, the probability that any axis at any target is beyond its tolerance; NaN where nothing is decided.

        NaN as well where the recordings do not determine an axis that matters.
        """
        if not self.decided:
            return float("nan")
        hidden = self.whole_hidden_risk
        nothing = 1.0 if self.left_out is None else self.left_out.nothing
        return float(nothing * self._any() + hidden.sum())

    @cached_property
    def whole_hidden_risk(self) -> FloatArray:
        """The part of `whole_risk` that each physics has which the recordings may hide, shape (E,)."""
        if self.left_out is None or not self.decided:
            return np.zeros(0)
        hidden = self.left_out
        alternatives = zip(hidden.probability, hidden.mean, hidden.roots, strict=True)
        return np.array([p * self._any(mean, root, NEGLIGIBLE / max(p, NEGLIGIBLE)) for p, mean, root in alternatives])

    def _tails(self, mean: FloatArray | float = 0.0, root: FloatArray | None = None) -> FloatArray:
        """Probabilities of an error above and below the tolerance, shape (2, t, n).

        Args:
            mean: of the error that hidden physics makes, shape (t, n).
            root: of its covariance, shape (t, n, d).
        """
        budget = self.budget
        added = 0.0 if root is None else (root**2).sum(axis=-1)
        spread = np.sqrt(budget.standard**2 + added)
        with np.errstate(divide="ignore", invalid="ignore"):
            # Welch-Satterthwaite: what hidden physics adds is no estimate.
            degrees = np.where(np.isinf(budget.degrees), np.inf, budget.degrees * (spread / budget.standard) ** 4)
            scores = np.stack([mean - budget.tolerance, -mean - budget.tolerance]) / spread
        finite = np.isfinite(degrees)
        tails: FloatArray = np.where(finite, stdtr(np.where(finite, degrees, 1.0), scores), ndtr(scores))
        return tails

    def _any(
        self, mean: FloatArray | float = 0.0, root: FloatArray | None = None, negligible: float = NEGLIGIBLE
    ) -> float:
        """Probability of an error beyond any tolerance, arguments as of `_tails`; `negligible` as of `any_beyond`."""
        matters = self.budget.matters
        above, below = self._tails(mean, root)[:, matters]
        if np.isnan(above).any():
            return float("nan")
        covariance = self.budget.covariance[matters][:, matters]
        if root is not None:
            covariance = covariance + root[matters] @ root[matters].T
        return any_beyond(above, below, covariance, negligible)

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
        """How often the whole experiment has to be done until U is within all tolerances; None where no number is
        enough, and where it is within them already and the robot does not pass: repeating a plan does not show what
        it hides.
        """
        most = float(np.nanmax(self.repetitions))
        return int(most) if np.isfinite(most) and not self.endangered else None


def acceptance_record(decision: Decision) -> dict[str, Any]:
    """What `run.json`, `evaluate --json` and `identification.json` say under `acceptance`."""
    budget = decision.budget
    return {
        "coverage": budget.coverage.level,
        "coverage_factor": budget.coverage.factor,
        "decision_rule": DECISION_RULE,
        "verdict": decision.verdict,
        "passes": decision.passes if decision.decided else None,
        **_whole(decision),
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


def _whole(decision: Decision) -> dict[str, float | None]:
    """The probability that any axis is beyond its tolerance; nothing of a plan."""
    if decision.basis is Basis.PLAN:
        return {}
    whole, hidden = decision.whole_risk, float(decision.whole_hidden_risk.sum())
    known = bool(np.isfinite(whole))
    return {
        "probability_of_any_beyond_tolerance": whole if known else None,
        "probability_of_any_by_hidden_physics": hidden if known and decision.left_out is not None else None,
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
        "probability_by_hidden_physics": None if decision.left_out is None else at(decision.hidden_risk.sum(axis=0)),
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
        worst = (
            f"The worst is {budget.axes[axis].rsplit('_', 1)[0]} at target {target + 1}: U is "
            f"{ratio[target, axis]:.3g} of its tolerance (k = {budget.factor[target, axis]:.3g}, coverage {level})"
        )
        if decision.basis is Basis.PLAN:
            risk = probability_text(float(decision.risk[target, axis]), 2)
            texts.append(f"{worst}; an error beyond the tolerance has the probability {risk}.")
        else:
            texts += [f"{worst}.", *_risk_sentence(decision)]
    texts += _repetitions(decision)
    if decision.basis is Basis.PLAN and decision.passes:
        texts.append(_check_readings(decision.check_readings))
    return texts


def _verdict_sentence(decision: Decision) -> str:
    matters, exceeding = int(decision.budget.matters.sum()), int((~decision.within).sum())
    within = f"on all {matters} axes with a tolerance U is within it"
    exceeds = f"on {exceeding} of the {matters} axes with a tolerance U exceeds it"
    if decision.basis is Basis.PLAN:
        return f"The robot is {'not ' if exceeding else ''}expected to pass: {exceeds if exceeding else within}."
    if decision.passes:
        return f"The robot passes: {within}."
    if exceeding:
        return f"Not proven: {exceeds}."
    left = probability_text(decision.allowed, 2)
    return f"Not proven: {within}, but an error beyond any of them is likelier than the coverage leaves ({left})."


def _risk_sentence(decision: Decision) -> list[str]:
    """The probability of an error beyond any tolerance, and how much of it physics has that is not in the model."""
    whole = decision.whole_risk
    if np.isnan(whole):
        return []
    text = f"The probability that any axis is beyond its tolerance is {probability_text(whole, 2)}"
    target, axis = np.unravel_index(int(np.nanargmax(decision.risk)), decision.risk.shape)
    if whole >= SMALLEST:
        alone = probability_text(float(decision.risk[target, axis]), 2)
        text += f", of {decision.budget.axes[axis].rsplit('_', 1)[0]} at target {target + 1} alone {alone}"
    if decision.left_out is None:
        return [f"{text}, if the model is right: what these recordings may hide is not counted."]
    parts: dict[str, float] = {}
    for phrase, part in zip(decision.left_out.phrases, decision.whole_hidden_risk, strict=True):
        parts[phrase] = parts.get(phrase, 0.0) + float(part)
    hidden = "physics that these recordings may hide"
    if sum(parts.values()) < SMALLEST:
        return [f"{text}, {hidden} included."]
    share = probability_text(sum(parts.values()), 2)
    return [f"{text}; {hidden} has {share} of it, foremost {max(parts, key=lambda phrase: parts[phrase])}."]


def _repetitions(decision: Decision) -> list[str]:
    """What would make a robot pass that does not."""
    if decision.passes:
        return []
    if decision.endangered and decision.whole_risk - decision.whole_hidden_risk.sum() > decision.allowed:
        return ["Every axis passes by itself, not all of them together: repeat the plan, or measure more."]
    if decision.endangered:
        return [
            "Record what would show that physics (`expdesign run` with the objective `meir` plans it), or prove "
            "conformity by check readings with `expdesign verify`."
        ]
    if decision.needed is None:
        return [
            "No number of repetitions helps: errors that all measurements share (or what is not determined) exceed the "
            "tolerance by themselves. Know the load better, or measure otherwise."
        ]
    return [
        f"The whole plan done {decision.needed} times, set up anew each time "
        f"({decision.needed * decision.budget.measurements} measurements), would bring U within all tolerances; a plan "
        "that is optimised for as many measurements needs no more."
    ]


def _check_readings(count: int | None) -> str:
    if count is None:
        return "No number of check readings with this instrument lets `expdesign verify` prove conformity."
    return (
        f"To prove conformity, `expdesign verify` will need {count} independent check reading"
        f"{'' if count == 1 else 's'} of every target with this instrument."
    )
