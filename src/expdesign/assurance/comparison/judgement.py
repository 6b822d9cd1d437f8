"""Every design judged by every criterion, and by the accuracy that it attains in repeated virtual experiments.

The attained accuracy is what the criterion `total` predicts: the RMS over repetitions of √(mean over targets of
Σ_i (error_i / tolerance_i)²), or, with `aggregate: max`, that of the worst target. All designs meet the same random
numbers, so that their differences are less uncertain than their values.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.assurance.comparison.contenders import Contender, Each, here
from expdesign.assurance.validation.simulation import simulate
from expdesign.errors import NotIdentifiableError
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem

AGREEMENT = 1e-3
"""Part of the attained error below which designs are said to be equally accurate."""

ATTAINED = "attained"


@dataclass(frozen=True)
class Judgement:
    """Designs of one configuration.

    Attributes:
        problem: the configuration.
        contenders: the designs.
        values: every criterion by its name, shape (d,) each; NaN where it cannot be identified.
        squares: (error / tolerance)² of every repetition, shape (d, s); NaN where a target is not identified.
    """

    problem: DesignProblem
    contenders: tuple[Contender, ...]
    values: dict[str, FloatArray]
    squares: FloatArray

    @property
    def longer(self) -> BoolArray:
        """Designs with more measurements than the configuration has, of which its bound says nothing, shape (d,)."""
        return np.array([len(one.plan) > self.problem.space.measurements for one in self.contenders])

    @property
    def attained(self) -> FloatArray:
        """RMS error at the targets after compensation, in tolerances, shape (d,)."""
        return np.sqrt(self.squares.mean(axis=1))

    @property
    def attained_standard_error(self) -> FloatArray:
        """Of `attained`: that of the mean square divided by twice the root."""
        return self._error_of_mean(self.squares) / (2.0 * self.attained)

    @property
    def best(self) -> int:
        """Index of the design that attains the best accuracy."""
        return int(np.nanargmin(self.attained))

    @property
    def attained_ratio(self) -> FloatArray:
        """Attained error divided by the best design's, shape (d,)."""
        return self.attained / self.attained[self.best]

    @property
    def attained_ratio_standard_error(self) -> FloatArray:
        """Of `attained_ratio`, to first order, from the same repetitions of both designs (0 for the best)."""
        relative = self.squares / self.squares.mean(axis=1, keepdims=True)
        return self.attained_ratio / 2.0 * self._error_of_mean(relative - relative[self.best])

    @property
    def same_plan(self) -> IntArray:
        """Index of the first design with the same measurements, whatever their order, shape (d,)."""
        firsts: dict[tuple[tuple[float, ...], ...], int] = {}
        found = []
        for index, contender in enumerate(self.contenders):
            rows = np.round(np.concatenate([contender.plan.configurations, contender.plan.loads], axis=1), 9) + 0.0
            found.append(firsts.setdefault(tuple(sorted(tuple(row) for row in rows.tolist())), index))
        return np.array(found)

    def agreeing(self, part: float = AGREEMENT) -> list[list[int]]:
        """Designs of criteria whose attained errors differ by at most `part`, the most accurate group first.

        All designs meet the same random numbers, so that differences as small as that are seen.
        """
        order = sorted(
            (i for i, one in enumerate(self.contenders) if one.origin == "optimised" and np.isfinite(self.attained[i])),
            key=lambda i: float(self.attained[i]),
        )
        groups: list[list[int]] = []
        for index in order:
            if groups and self.attained[index] <= (1.0 + part) * self.attained[groups[-1][0]]:
                groups[-1].append(index)
            else:
                groups.append([index])
        return groups

    def ratio(self, name: str) -> FloatArray:
        """How many times worse than the best design by this criterion, shape (d,): 1 is the best."""
        values = self.values[name]
        if not np.isfinite(values).any():
            return np.full(len(values), np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.problem.criteria[name].maximise:
                return np.nanmax(values) / values
            return values / np.nanmin(values)

    def frame(self) -> pd.DataFrame:
        """One row per design: values, attained accuracy with its standard error, and ratios to the best."""
        names = list(self.values)
        columns: dict[str, object] = {
            "design": [contender.name for contender in self.contenders],
            "origin": [contender.origin for contender in self.contenders],
            "measurements": [len(contender.plan) for contender in self.contenders],
        }
        columns |= self.values
        columns |= {ATTAINED: self.attained, f"{ATTAINED}_standard_error": self.attained_standard_error}
        columns |= {f"{name}_ratio": self.ratio(name) for name in names}
        columns |= {
            f"{ATTAINED}_ratio": self.attained_ratio,
            f"{ATTAINED}_ratio_standard_error": self.attained_ratio_standard_error,
        }
        first = self.same_plan
        columns["same_plan_as"] = [
            "" if first[i] == i else self.contenders[first[i]].name for i in range(len(self.contenders))
        ]
        return pd.DataFrame(columns)

    @staticmethod
    def _error_of_mean(samples: FloatArray) -> FloatArray:
        return samples.std(axis=1, ddof=1) / np.sqrt(samples.shape[1])


def judge(
    problem: DesignProblem,
    contenders: list[Contender],
    samples: int,
    seed: int,
    report: Callable[[str], None] = lambda text: None,
    each: Each | None = None,
) -> Judgement:
    """Judge designs by every criterion and by `samples` repetitions of experiment, identification and compensation.

    `each` does the repetitions of each design.

    Raises:
        NotIdentifiableError: no design identifies what the targets need.
        InputError: the frames of the instrument are unknown.
    """
    values: dict[str, list[float]] = {name: [] for name in problem.criteria}
    squares = np.full((len(contenders), samples), np.nan)
    judged: list[int] = []
    for index, contender in enumerate(contenders):
        plan = contender.plan
        assessment = problem.assess(plan.configurations[None], plan.loads[None], plan.series[None])
        for name, criterion in problem.criteria.items():
            values[name].append(float(criterion.values(assessment)[0]))
        if bool(assessment.identifies_targets[0]):
            judged.append(index)
        else:
            report(contender.name)
    arguments = [(contenders[index].plan, samples, seed) for index in judged]
    for position, found in (each or here(problem))(_squares, arguments):
        squares[judged[position]] = found
        report(contenders[judged[position]].name)
    if np.isnan(squares).all():
        what = "no design identifies what the targets need"
        raise NotIdentifiableError(what, where=problem.source, remedy="Allow more measurements, axes or loads.")
    return Judgement(problem, tuple(contenders), {name: np.array(v) for name, v in values.items()}, squares)


def _squares(problem: DesignProblem, plan: Plan, samples: int, seed: int) -> FloatArray:
    """(error / tolerance)² of every repetition, shape (s,)."""
    return simulate(problem, plan, samples, seed).squares(problem.targets)
