"""Noise levels of an arm's calibration, and weights of rows for losses that grow slower than squares.

They are found together with its parameters (iteratively re-weighted least squares).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import gammaln, xlogy

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.recordings import Remark
from expdesign.errors import NotIdentifiableError
from expdesign.estimation.arm_options import Loss
from expdesign.estimation.arm_problem import ArmProblem
from expdesign.estimation.goodness import REFUTED, p_value_of
from expdesign.estimation.groups import Priors, Sized, with_groups
from expdesign.estimation.noise_level import NoiseGroup, NoiseLevel, axis_groups
from expdesign.estimation.remarks import GenerousNoise, NoiseBeyondStated

_GENEROUS = 0.7
"""RMS of the residuals in stated standard deviations below which these are far too large, and are estimated; only where
χ² is improbably small as well."""
_FREEDOM = 4.0
"""Degrees of freedom of Student's t."""
_CORNER = 1.345
"""Standard deviations where Huber's loss becomes linear: 95 % efficient at normal noise."""


def _weight(loss: Loss, squares: FloatArray, count: FloatArray | float) -> FloatArray:
    """Weights of rows by the sums of squares of their whitened residuals, `count` each."""
    if loss == "huber":
        return np.minimum(1.0, _CORNER / np.maximum(np.sqrt(squares / count), 1e-12))
    if loss == "student":
        return (_FREEDOM + count) / (_FREEDOM + squares)
    return np.ones_like(squares)


def _weights(loss: Loss, residuals: FloatArray) -> FloatArray:
    """Weights (N,) of rows with whitened residuals (N, k), 0 where nothing was read."""
    count = np.maximum((residuals != 0.0).sum(axis=1), 1)
    return _weight(loss, (residuals**2).sum(axis=1), count)


def _counted(loss: Loss, weights: FloatArray) -> FloatArray:
    """By what r² counts for a level, from the weights w of its rows: w, or w² where w·r² has no bound.

    Levels are the solution of Σ w·r² = n for Student's t, whose likelihood asks for that, and of Σ (w·r)² = n for
    Huber's loss (his proposal 2; Huber, Robust Statistics, 1981, section 6.7).
    """
    return weights**2 if loss == "huber" else weights


@lru_cache(maxsize=32)
def _share(loss: Loss, components: int) -> float:
    """Mean of what r² counts per component at normal noise, by which levels are made consistent."""
    if loss == "squares":
        return 1.0
    half = components / 2.0

    def integrand(squares: float) -> float:
        weight = float(_counted(loss, _weight(loss, np.array([squares]), float(components)))[0])
        density = xlogy(half - 1.0, squares / 2.0) - squares / 2.0 - gammaln(half) - np.log(2.0)  # of chi squared
        return weight * squares * float(np.exp(density))

    return float(quad(integrand, 0.0, 60.0 + 10.0 * components, limit=200)[0]) / components


_ROUNDS = 8
"""Times that noise levels and weights are found again; they settle in three or four."""
_SETTLED = 0.02
"""Relative change of noise levels at which they have settled."""
_GUESS = 1e-3
"""m, rad; noise level with which its estimation starts."""


@dataclass(frozen=True)
class Settled:
    """A solution with the noise that it was found at.

    Attributes:
        start: of all parameters, those outside `live` as they stay.
        effective: deviations divided by the roots of robust weights, shape (N, k).
        mean_square: of the weighted residuals, over its mean at normal noise.
    """

    solution: Sized
    start: FloatArray
    noise: NoiseLevel
    effective: FloatArray
    mean_square: float
    dof: float
    stated: tuple[float, int, float] | None
    remarks: list[Remark]


@dataclass(frozen=True)
class ArmNoise:
    """Noise levels and robust weights, found together with the parameters."""

    problem: ArmProblem
    priors: Priors
    loss: Loss

    def settled(self, start: FloatArray) -> Settled:
        """The solution at the stated deviations if these account for the residuals, else at those that do."""
        stated = self.problem.train.deviations
        if stated is None:
            levels = np.full(len(self._kinds), _GUESS)
            found = self._solve(start, self._as_levels(levels), np.ones(len(self.problem.train)), known=False)
            return self._estimated(found, start, levels * found.noise, None)
        known = np.isfinite(stated)
        # A coordinate that no row has stays without a deviation.
        squared, count = (stated**2).sum(axis=0, where=known), known.sum(axis=0)
        typical = np.sqrt(np.divide(squared, count, out=np.full(count.shape, np.nan), where=count > 0))
        deviations = np.where(known, stated, typical)
        weights: FloatArray = np.ones(len(deviations))
        for _ in range(1 if self.loss == "squares" else _ROUNDS):
            found = self._solve(start, deviations, weights)
            weights, before = _weights(self.loss, self._whitened(found, weights)), weights
            if np.abs(weights - before).max() < _SETTLED:
                break
        squares, dof = self._by_kind(found, weights)
        total, freedom = float(squares.sum()), max(float(dof.sum()), 1.0)
        judged = (total, round(freedom), p_value_of(total, freedom))
        beyond = judged[2] < REFUTED
        generous = total < _GENEROUS**2 * freedom and 1.0 - judged[2] < REFUTED
        if not (beyond or generous):
            noise = NoiseLevel(deviations, "recordings")
            effective = deviations / np.sqrt(weights)[:, None]
            return Settled(found, start, noise, effective, total / freedom, freedom, judged, [])
        whole = start.copy()
        whole[self.problem.live] = found.values
        ratio = np.sqrt(squares / np.maximum(dof, 1.0))
        typical = np.array([self._typical(deviations, columns) for _, columns in self._kinds])
        if generous:
            return self._estimated(found, whole, typical * ratio, judged, generous=typical)
        levels = typical * np.sqrt(np.maximum(ratio**2 - 1.0, 0.0))
        return self._estimated(found, whole, levels, judged, deviations)

    def _estimated(
        self,
        found: Sized,
        start: FloatArray,
        levels: FloatArray,
        judged: tuple[float, int, float] | None,
        stated: FloatArray | None = None,
        generous: FloatArray | None = None,
    ) -> Settled:
        """Levels of every kind, in addition to what is stated if that is too small, until they settle.

        `generous` are stated levels of every kind that are far too large.
        """
        weights: FloatArray = np.ones(len(self.problem.train))
        whole = start.copy()
        whole[self.problem.live] = found.values
        for _ in range(_ROUNDS):
            deviations = self._as_levels(levels, stated)
            found = self._solve(whole, deviations, weights)
            whole[self.problem.live] = found.values
            residuals = self._whitened(found, weights)
            weights = _weights(self.loss, residuals)
            _, dof = self._by_kind(found, weights)
            fresh: FloatArray = np.array([
                self._level(residuals, weights, deviations, columns, freedom, stated)
                for (_, columns), freedom in zip(self._kinds, dof, strict=True)
            ])  # fmt: skip
            before = np.array([self._typical(deviations, columns) for _, columns in self._kinds])
            levels = fresh
            after = self._as_levels(levels, stated)
            change = [self._typical(after, c) / b - 1.0 for (_, c), b in zip(self._kinds, before, strict=True)]
            if np.abs(change).max() < _SETTLED:
                break
        deviations = self._as_levels(levels, stated)
        groups = tuple(
            NoiseGroup(name, columns, self._typical(deviations, columns), float(freedom))
            for (name, columns), freedom in zip(self._kinds, dof, strict=True)
        )
        remarks: list[Remark] = []
        if generous is not None:
            remarks = [
                GenerousNoise(each.name, size, each.deviation) for each, size in zip(groups, generous, strict=True)
            ]
        if stated is not None:
            remarks = [
                NoiseBeyondStated(group.name, self._typical(stated, group.columns), group.deviation, float(extra))
                for group, extra in zip(groups, levels, strict=True)
                if extra > 0.0
            ]
        noise = NoiseLevel(deviations, "residuals", groups)
        effective = deviations / np.sqrt(weights)[:, None]
        squares, _ = self._by_kind(found, weights)
        mean_square = float(squares.sum() / dof.sum())
        return Settled(found, start, noise, effective, mean_square, float(dof.sum()), judged, remarks)

    @property
    def _kinds(self) -> list[tuple[str, IntArray]]:
        return axis_groups(self.problem.train, 3)

    def _solve(self, start: FloatArray, deviations: FloatArray, weights: FloatArray, *, known: bool = True) -> Sized:
        effective = deviations / np.sqrt(weights)[:, None]
        return with_groups(
            lambda values: self.problem.linearised(values, effective, start),
            self.priors,
            start[self.problem.live],
            known_noise=known,
        )

    def _whitened(self, found: Sized, weights: FloatArray) -> FloatArray:
        """Residuals of a solution with weights (N,) as they are without these, 0 where nothing was read, (N, k)."""
        seen = self.problem.seen
        whitened = np.zeros(seen.shape)
        whitened[seen] = found.residuals
        return whitened / np.sqrt(weights)[:, None]

    def _counted(self, weights: FloatArray) -> FloatArray:
        """By what r² counts for a level over its mean at normal noise, (N,): a row is weighed by all its readings."""
        counts = np.maximum(self.problem.seen.sum(axis=1), 1)
        shares = {count: _share(self.loss, count) for count in np.unique(counts).tolist()}
        usual = np.array([shares[count] for count in counts.tolist()])
        found: FloatArray = _counted(self.loss, weights) / usual
        return found

    def _by_kind(self, found: Sized, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The sum of what r² counts over its mean at normal noise, and n − tr(H), of every kind of reading."""
        seen = self.problem.seen
        counted = np.broadcast_to((self._counted(weights) / weights)[:, None], seen.shape)[seen]
        columns = np.broadcast_to(np.arange(seen.shape[1]), seen.shape)[seen]
        hat = ((found.slopes @ (found.covariance / found.noise**2)) * found.slopes).sum(axis=1)
        squares, dof = [], []
        for _, mine in self._kinds:
            inside = np.isin(columns, mine)
            squares.append(float((counted * found.residuals**2)[inside].sum()))
            dof.append(float(inside.sum() - hat[inside].sum()))
        if min(dof) < 0.5:
            what = "the rows leave no reading over from which their noise could be judged"
            remedy = "Measure more poses."
            raise NotIdentifiableError(what, where=self.problem.train.source, remedy=remedy)
        return np.array(squares), np.array(dof)

    def _level(
        self,
        residuals: FloatArray,
        weights: FloatArray,
        deviations: FloatArray,
        columns: IntArray,
        freedom: float,
        stated: FloatArray | None,
    ) -> float:
        """The level of one kind with which the sum of what r²/(s² + σ²) counts is its degrees of freedom."""
        inside = self.problem.seen[:, columns]
        squares = (self._counted(weights)[:, None] * (residuals * deviations)[:, columns] ** 2)[inside]
        if stated is None:
            return max(float(np.sqrt(squares.sum() / freedom)), 1e-12)
        known = stated[:, columns][inside] ** 2
        if (squares / known).sum() <= freedom:
            return 0.0
        most = float(squares.sum() / freedom)
        extra = brentq(lambda level: (squares / (known + level)).sum() - freedom, 0.0, most, xtol=1e-15 * most)
        return float(np.sqrt(extra))

    def _as_levels(self, levels: FloatArray, stated: FloatArray | None = None) -> FloatArray:
        deviations = np.zeros_like(self.problem.train.deflections) if stated is None else stated.copy()
        for (_, columns), level in zip(self._kinds, levels, strict=True):
            deviations[:, columns] = np.sqrt(deviations[:, columns] ** 2 + level**2)
        return deviations

    def _typical(self, deviations: FloatArray, columns: IntArray) -> float:
        inside = self.problem.seen[:, columns]
        return float(np.sqrt((deviations[:, columns][inside] ** 2).mean()))
