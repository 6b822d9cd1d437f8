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

import numpy as np
from scipy.special import ndtr, stdtr

from expdesign.arrays import BoolArray, FloatArray
from expdesign.assurance.acceptance.any_axis import any_beyond
from expdesign.assurance.acceptance.budget import UncertaintyBudget
from expdesign.assurance.acceptance.options import ACCEPTANCE


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
        likely = self.risk > self.allowed * (1.0 + ACCEPTANCE.rounding)
        passed: BoolArray = self.within & ~(self.budget.matters & likely)
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
        hidden, negligible = self.left_out, ACCEPTANCE.negligible
        alternatives = zip(hidden.probability, hidden.mean, hidden.roots, strict=True)
        return np.array([p * self._any(mean, root, negligible / max(p, negligible)) for p, mean, root in alternatives])

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
        self, mean: FloatArray | float = 0.0, root: FloatArray | None = None, negligible: float = ACCEPTANCE.negligible
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
        needed = np.where(needed > ACCEPTANCE.most, np.inf, np.maximum(needed, 1.0))
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
