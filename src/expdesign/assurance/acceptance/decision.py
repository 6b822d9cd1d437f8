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

from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np
from scipy.special import ndtr, stdtr

from expdesign.arrays import BoolArray, FloatArray
from expdesign.assurance.acceptance.any_axis import NEGLIGIBLE, any_beyond
from expdesign.assurance.acceptance.budget import UncertaintyBudget

ROUNDING = 1e-9
"""Relative; an axis with U = T passes."""
MOST_REPETITIONS = 1_000_000
"""Repetitions or readings beyond which a number is as good as none."""


class Basis(Enum):
    """What a decision rests on: a plan, a model that its recordings bear out, or one that they do not."""

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
    """The decision on every axis of every target, t targets along n axes; every array of it is computed once.

    Attributes:
        budget: of the attained pose.
        basis: what it rests on.
        cause, remedy: why nothing is decided where it is not, and what to do then.
        check_readings: of every target, with which `verify` will prove conformity where it is planned to pass; None
            where no number will, or where that was not asked.
        left_out: what the recordings may hide; None of a plan, or where nothing can be left out.
    """

    budget: UncertaintyBudget
    basis: Basis = Basis.MODEL
    remedy: str = "run `expdesign diagnose`"
    check_readings: int | None = None
    left_out: LeftOutRisk | None = None
    cause: str = "the model is refuted by its own recordings"

    @property
    def verdict(self) -> str:
        """`pass`, `not proven` or `not decided`; of a plan `expected to pass` or `not expected to pass`."""
        return self._word(self.robot_passes)

    def axis_verdict(self, target: int, axis: int) -> str:
        """The same of one axis of a target."""
        return self._word(bool(self.axis_passes[target, axis]))

    def _word(self, passes: bool) -> str:
        return _WORDS[self.basis][0 if passes else 1]

    @property
    def decided(self) -> bool:
        """Whether the model bears a decision."""
        return self.basis is not Basis.REFUTED

    @property
    def risk_left(self) -> float:
        """The probability that the coverage leaves, which is accepted."""
        return 1.0 - self.budget.coverage.level

    @cached_property
    def u_within_tolerance(self) -> BoolArray:
        """Whether U ≤ T, shape (t, n); True where an axis does not matter."""
        budget = self.budget
        within: BoolArray = ~budget.matters | (budget.expanded <= budget.tolerance)
        return within

    @cached_property
    def axis_passes(self) -> BoolArray:
        """Whether each axis by itself passes, shape (t, n); True where an axis does not matter."""
        likely = self.axis_risk > self.risk_left * (1.0 + ROUNDING)
        passes: BoolArray = self.u_within_tolerance & ~(self.budget.matters & likely)
        return passes

    @cached_property
    def robot_passes(self) -> bool:
        """Whether U is within every tolerance and, of a robot that was measured, R no more than the coverage leaves."""
        within = bool(self.u_within_tolerance.all())
        return within and not (self.basis is Basis.MODEL and self.robot_risk > self.risk_left)

    @cached_property
    def axis_risk(self) -> FloatArray:
        """Probability of an error of each axis beyond its tolerance, shape (t, n); NaN where it does not matter.

        NaN as well where nothing is decided.
        """
        return self._mixed(self._tails[0].sum(axis=0), self.hidden_axis_risk)

    @cached_property
    def hidden_axis_risk(self) -> FloatArray:
        """The part of `axis_risk` that each physics has which the recordings may hide, shape (E, t, n)."""
        parts: FloatArray = self._probabilities[:, None, None] * self._tails[1:].sum(axis=1)
        return parts

    @cached_property
    def robot_risk(self) -> float:
        """R, the probability that any axis at any target is beyond its tolerance; NaN where nothing is decided.

        NaN as well where the recordings do not determine an axis that matters.
        """
        return float(self._mixed(np.array(self._any(0)), self.hidden_robot_risk))

    @cached_property
    def hidden_robot_risk(self) -> FloatArray:
        """The part of `robot_risk` that each physics has which the recordings may hide, shape (E,)."""
        pairs = enumerate(self._probabilities, start=1)
        return np.array([p * self._any(index, NEGLIGIBLE / max(p, NEGLIGIBLE)) for index, p in pairs])

    @property
    def _probabilities(self) -> FloatArray:
        """Of what may be left out, shape (E,)."""
        return np.zeros(0) if self.left_out is None or not self.decided else self.left_out.probability

    def _mixed(self, right: FloatArray, hidden: FloatArray) -> FloatArray:
        """Probability over what may be left out: `right` where nothing is, and the parts of each physics (E, ...)."""
        nothing = 1.0 if self.left_out is None else self.left_out.nothing
        mixed: FloatArray = nothing * right + hidden.sum(axis=0) if self.decided else np.full_like(right, np.nan)
        return mixed

    @cached_property
    def _tails(self) -> FloatArray:
        """Probabilities of an error above and below the tolerance, shape (1 + E, 2, t, n).

        Where nothing is left out, and where each physics is that the recordings may hide.
        """
        budget, shape = self.budget, self.budget.tolerance.shape
        means, added = np.zeros((1, *shape)), np.zeros((1, *shape))
        if self.left_out is not None and len(self._probabilities):
            means = np.concatenate([means, self.left_out.mean])
            added = np.concatenate([added, [(root**2).sum(axis=-1) for root in self.left_out.roots]])
        spread = np.sqrt(budget.standard**2 + added)
        with np.errstate(divide="ignore", invalid="ignore"):
            # Welch-Satterthwaite: what hidden physics adds is no estimate.
            degrees = np.where(np.isinf(budget.degrees), np.inf, budget.degrees * (spread / budget.standard) ** 4)
            scores = np.stack([means - budget.tolerance, -means - budget.tolerance], axis=1) / spread[:, None]
        degrees = np.broadcast_to(degrees[:, None], scores.shape)
        finite = np.isfinite(degrees)
        tails: FloatArray = np.where(finite, stdtr(np.where(finite, degrees, 1.0), scores), ndtr(scores))
        return tails

    def _any(self, index: int, negligible: float = NEGLIGIBLE) -> float:
        """Probability of an error beyond any tolerance where nothing (0) or some physics (1 … E) is left out.

        `negligible` as of `any_beyond`.
        """
        matters = self.budget.matters
        above, below = self._tails[index][:, matters]
        if np.isnan(above).any() or not self.decided:
            return float("nan")
        covariance = self.budget.covariance[matters][:, matters]
        if index and self.left_out is not None:
            root = self.left_out.roots[index - 1][matters]
            covariance = covariance + root @ root.T
        return any_beyond(above, below, covariance, negligible)

    @cached_property
    def repetitions(self) -> FloatArray:
        """How often the whole experiment has to be done until U is within each tolerance, shape (t, n).

        The least whole number by `UncertaintyBudget.repeated`; infinite where `MOST_REPETITIONS` are too few, NaN where
        an axis does not matter.
        """
        budget = self.budget
        enough = budget.repeated(MOST_REPETITIONS) <= budget.tolerance
        least, most = np.zeros(enough.shape), np.where(self.u_within_tolerance, 1.0, MOST_REPETITIONS)
        while (most - least > 1.0).any():  # what is least is too few, what is most enough
            between = np.ceil(0.5 * (least + most))
            within = (budget.repeated(between) <= budget.tolerance) | (between == most)
            least, most = np.where(within, least, between), np.where(within, between, most)
        result = np.where(enough | self.u_within_tolerance, most, np.inf)
        return np.where(budget.matters, result, np.nan)

    @property
    def repetitions_needed(self) -> int | None:
        """How often the whole experiment has to be done until U is within all tolerances; None where no number is
        enough, and where it is within them already and the robot does not pass: repeating a plan does not show what
        it hides.
        """
        most = float(np.nanmax(self.repetitions))
        hidden = self.u_within_tolerance.all() and not self.robot_passes
        return int(most) if np.isfinite(most) and not hidden else None


def undecided(decision: Decision) -> Decision:
    """The decision withheld, because its recordings fit only if they are read otherwise."""
    cause = "the recordings fit only if they are read otherwise, or not at all"
    return replace(decision, basis=Basis.REFUTED, cause=cause, remedy="correct them as the warning says")
