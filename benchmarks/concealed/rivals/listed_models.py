"""Choice among listed parametric models by AIC or BIC with a general optimiser (scipy).

The list is this program's own: every effect of `expdesign.chain.effects` at every place of the robot, with its exact
sensitivities, as a problem of pyPESTO or a system identification in MuJoCo would be given. The number of effects grows
forward: each candidate is ranked by how much of the residuals its directions explain at its starts, the best are fitted
from all their starts by `scipy.optimize.least_squares` within their bounds, and the one whose criterion is least is
kept while the criterion falls (H. Akaike, IEEE Trans. Autom. Control 19 (1974) 716; G. Schwarz, Ann. Statist. 6 (1978)
461). Without the correction for small samples AIC chooses too much; `AICc` is what pyPESTO's selection offers for that.
"""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from expdesign.arrays import as_matrix
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.row import RowData
from expdesign.diagnosis.library import candidates, library
from expdesign.diagnosis.sample import Sample
from expdesign.estimation.fit import Data
from expdesign.estimation.whitening import Whitening

from .question import Array, Question, Reply

_FITTED = 8
"""Candidates that are fitted in every round."""
_MOST_EFFECTS = 3
_MOST_STARTS = 3


@dataclass(frozen=True)
class Fitted:
    """A model after its fit: effects in the order in which they were added, parameters, sum of squares."""

    effects: tuple[Effect, ...]
    values: Array
    squares: float

    def criterion(self, name: str, readings: int) -> float:
        """AIC with its correction for small samples, or BIC, of residuals in known standard deviations."""
        count = len(self.values)
        if name == "bic":
            return self.squares + count * float(np.log(readings))
        return self.squares + 2 * count + 2 * count * (count + 1) / max(readings - count - 1, 1)


class Selection:
    """Forward selection on one question."""

    def __init__(self, question: Question) -> None:
        self.question = question
        recordings, robot = question.recordings, question.robot
        everything, chosen = question.rows, question.order[: question.fitted]
        rows = RowData(everything.values[chosen], _renumbered(everything.series[chosen]), everything.position[chosen])
        data = Data(recordings, rows, Whitening(question.std))
        self.sample = Sample.of(data, np.ones(len(recordings), dtype=bool))
        self.library = library(robot, recordings)

    def chosen(self, criterion: str) -> Fitted:
        """The model whose criterion is least."""
        readings = self.sample.readings
        best = self.fit((), [np.zeros(0)], None)
        for _ in range(_MOST_EFFECTS):
            taken = {effect.slot for effect in best.effects}
            further = [self.fit((*best.effects, e), self._starts(e), best.values) for e in self._ranked(best, taken)]
            following = min(further, key=lambda each: each.criterion(criterion, readings), default=best)
            if following.criterion(criterion, readings) >= best.criterion(criterion, readings):
                break
            best = following
        return best

    def _ranked(self, present: Fitted, taken: Set[object]) -> list[Effect]:
        """The candidates that explain most of the residuals to first order."""
        robot, sample = self.question.robot, self.sample
        chain = Chain(robot, present.effects)
        residuals, sensitivities = sample.residuals_with_sensitivities(chain, present.values)
        basis = np.linalg.qr(sensitivities.reshape(-1, len(present.values)))[0]
        left = residuals.ravel() - basis @ (basis.T @ residuals.ravel())
        free = [effect for effect in self.library if effect.slot not in taken]
        explained = []
        for candidate in candidates(free, sample, robot, present.values[: len(robot.stiffness)]):
            best = 0.0
            for directions in candidate.directions:
                freed = directions - basis @ (basis.T @ directions)
                best = max(best, float(left @ left) - float(_left_by(freed, left)))
            explained.append((best - 2.0 * len(candidate.effect.parameters), candidate.effect))
        explained.sort(key=lambda each: -each[0])
        return [effect for _, effect in explained[:_FITTED]]

    def _starts(self, effect: Effect) -> list[Array]:
        points = self.question.recordings
        starts = [*effect.starts(points), *effect.large_starts(points)]
        if len(starts) <= _MOST_STARTS:
            return starts
        return [starts[index] for index in np.linspace(0, len(starts) - 1, _MOST_STARTS).astype(int)]

    def fit(self, effects: tuple[Effect, ...], starts: list[Array], before: Array | None) -> Fitted:
        """The best of the fits from all starts of the last effect."""
        chain, sample = Chain(self.question.robot, effects), self.sample
        low, high = chain.bounds()
        before = np.ones(len(self.question.robot.stiffness)) if before is None else before
        best: Fitted | None = None

        def residuals(values: Array) -> Array:
            return sample.residuals(chain, values).ravel()

        def slopes(values: Array) -> Array:
            return -as_matrix(sample.residuals_with_sensitivities(chain, values)[1])

        for start in starts:
            first = np.clip(np.concatenate([before, start]), low + 1e-9, high - 1e-9)
            found = least_squares(
                residuals,
                first,
                jac=slopes,
                bounds=(low, high),
                x_scale=chain.scales(),
                max_nfev=40,
            )
            if best is None or 2 * found.cost < best.squares:
                best = Fitted(effects, found.x, float(2 * found.cost))
        assert best is not None
        return best


def _renumbered(
    series: np.ndarray[tuple[int, ...], np.dtype[np.int_]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.int_]]:
    return np.unique(series, return_inverse=True)[1]


def _left_by(directions: Array, left: Array) -> float:
    """Sum of squares that directions leave."""
    norms = np.linalg.norm(directions, axis=0)
    kept = directions[:, norms > 1e-9]
    if not kept.shape[1]:
        return float(left @ left)
    rest = left - kept @ np.linalg.lstsq(kept, left, rcond=1e-8)[0]
    return float(rest @ rest)


def solve(question: Question, criterion: str) -> Reply:
    """The chosen model's prediction; its effects are named with the weight of the criterion against the base model."""
    model = Selection(question).chosen(criterion)
    predicted = Chain(question.robot, model.effects).predict(question.rows, model.values)[question.order]
    location = [str(effect.component) for effect in model.effects]
    physics = [(effect.physics, 1.0) for effect in model.effects]
    return Reply(predicted[:, question.recordings.axes], bool(model.effects), location, physics)
