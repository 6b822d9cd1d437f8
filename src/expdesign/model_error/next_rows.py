"""The next measurements by what recordings hide: rows after which least error may be hidden at the targets.

Recordings with whitened base sensitivities Ã₀ and directions B̃₀ leave, with a further row, the plan [Ã₀; Ã₁], [B̃₀; B̃₁],
whose MEIR is that of any plan. It stands beside the expected total error of noise and load errors in the same unit:

    error² = total² + MEIR²,

the mean square error of an estimator with a bias (Box and Draper 1959), the bias being the largest that goes unnoticed.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.criteria.information import Information
from expdesign.design.problem import DesignProblem
from expdesign.design.sequential import expected_total, information_of, next_measurements
from expdesign.design.start import reachable_measurements
from expdesign.identification.recorded_knowledge import estimated_deviations
from expdesign.identification.whitening import Whitening
from expdesign.model_error.hidden import hidden_errors
from expdesign.model_error.impact import ModelErrorImpact
from expdesign.model_error.recorded import recorded_sensitivities
from expdesign.recordings.recordings import Recordings

CANDIDATES = 1000
_BATCH = 250
_SHARE = 0.7
"""Effects of the working set have at least this part of the largest hidden error."""
_AGREEMENT = 0.01
_ROUNDS = 8


class Objective(StrEnum):
    """What the next measurements shall make small."""

    TOTAL = "total"
    MEIR = "meir"
    BOTH = "both"

    def of(self, total: FloatArray, hidden: FloatArray) -> FloatArray:
        """The value to make small, in tolerances, from total error and MEIR."""
        if self is Objective.TOTAL:
            return total
        return hidden if self is Objective.MEIR else np.sqrt(total**2 + hidden**2)


@dataclass(frozen=True)
class Expected:
    """Expected errors at the targets, in tolerances.

    Attributes:
        total: from noise and load errors.
        meir: what physics beyond the model may add unnoticed.
    """

    total: float
    meir: float


@dataclass(frozen=True)
class NextRows:
    """Measurements to add (k, g), and what is expected before and after each of them."""

    decisions: FloatArray
    before: Expected
    after: tuple[Expected, ...]


@dataclass(frozen=True)
class _Rows:
    """Whitened base sensitivities (..., r, n_p) and directions (..., r, D) in units of the prior sizes."""

    base: FloatArray
    directions: FloatArray

    def with_each(self, other: "_Rows", chosen: slice) -> "_Rows":
        """These rows followed by those of each member of a batch, (c, r, …)."""
        pairs = (self.base, other.base[chosen]), (self.directions, other.directions[chosen])
        stacked = [np.concatenate([np.tile(own, (len(more), 1, 1)), more], axis=1) for own, more in pairs]
        return _Rows(*stacked)

    def reduced(self) -> "_Rows":
        """As few rows as say the same: all that counts are inner products of columns."""
        columns, width = np.concatenate([self.base, self.directions], axis=1), self.base.shape[1]
        if len(columns) > columns.shape[1]:
            columns = np.asarray(np.linalg.qr(columns, mode="r"))
        return _Rows(columns[:, :width], columns[:, width:])


class _Hidden:
    """MEIR of rows, of all effects or of a working set."""

    def __init__(self, impact: ModelErrorImpact) -> None:
        self.impact = impact
        n_p = impact.n_p
        factors = np.concatenate([np.ones(n_p), impact.deviations])
        self._errors = impact.errors * factors
        self._base = n_p

    def of(self, rows: _Rows, entries: IntArray | None = None, share: float = 1.0) -> FloatArray:
        """MEIR_e² of b designs, shape (b, E); infinite where the stiffness is not identified."""
        impact, n_p = self.impact, self._base
        physics, columns = impact.physics, np.arange(rows.directions.shape[-1])
        if entries is not None:
            physics, columns = impact.part(entries)
        errors = self._errors[..., np.concatenate([np.arange(n_p), n_p + columns])]
        directions = rows.directions[..., columns]
        found = hidden_errors(rows.base, directions, errors, physics, impact.assumptions, share=share)
        return np.where(np.isnan(found.squares), np.inf, found.squares)

    def recorded(self, recordings: Recordings) -> _Rows:
        """Rows of recordings; those held out do not count."""
        problem = self.impact.problem
        train = recordings.rows(~recordings.test)
        deviations = train.deviations
        if deviations is None:
            deviations = estimated_deviations(problem, recordings, train)
        whitening = Whitening(deviations, references=train.references)
        every = np.ones(len(train), dtype=bool)
        base, directions = recorded_sensitivities(problem.loaded.robot, train, self.impact.physics, whitening, every)
        return _Rows(base, directions * self.impact.deviations).reduced()

    def planned(self, decisions: FloatArray) -> _Rows:
        """Rows of single measurements (c, g) of the design space, (c, k, …)."""
        problem = self.impact.problem
        configurations, loads = problem.space.decode(decisions)
        base, directions = self.impact.whitened(problem.assess(configurations[:, None], loads[:, None]))
        return _Rows(base, directions * self.impact.deviations)


def next_rows(
    impact: ModelErrorImpact,
    recordings: Recordings,
    known: Information,
    objective: Objective,
    *,
    count: int,
    accuracy: float | None,
    seed: int,
) -> NextRows:
    """Up to `count` measurements after which the objective is least, one after the other, each the best of a sample.

    The largest over physics is taken over a working set, which grows until the choice is right for all effects.

    Args:
        impact: MEIR of the problem whose targets count.
        recordings: what was measured so far.
        known: the same, for the total error.
        objective: what shall become small.
        count: the most that may be added.
        accuracy: value of the objective at which to stop.
        seed: of the sample.

    Raises:
        InfeasibleError: no measurement is within the robot's limits.
    """
    problem, hidden = impact.problem, _Hidden(impact)
    pool = reachable_measurements(problem, CANDIDATES, np.random.default_rng(seed))
    planned, knowledge = hidden.planned(pool), information_of(problem, pool)
    rows = hidden.recorded(recordings)
    before = _expected(problem, hidden, rows, known)
    chosen: list[FloatArray] = []
    after: list[Expected] = []
    while len(chosen) < count:
        best = _best(problem, hidden, rows, known, planned, knowledge, objective)
        if best is None:
            # Nothing that a single row could add determines the stiffness yet.
            decision = next_measurements(problem, known, count=1, accuracy=None, seed=seed).decisions[0]
        else:
            decision = pool[best]
        added = hidden.planned(decision[None])
        rows = _Rows(*(part[0] for part in vars(rows.with_each(added, slice(None))).values())).reduced()
        known = known.plus(information_of(problem, decision[None]).part(0))
        chosen.append(decision)
        after.append(_expected(problem, hidden, rows, known))
        value = float(objective.of(np.array(after[-1].total), np.array(after[-1].meir)))
        if accuracy is not None and value <= accuracy:
            break
    return NextRows(np.array(chosen), before, tuple(after))


def _expected(problem: DesignProblem, hidden: _Hidden, rows: _Rows, known: Information) -> Expected:
    squares = hidden.of(_Rows(rows.base[None], rows.directions[None]))
    total = float(expected_total(known, problem.targets, problem.loaded.robot.compliance))
    return Expected(total, float(np.sqrt(squares.max())))


def _best(
    problem: DesignProblem,
    hidden: _Hidden,
    rows: _Rows,
    known: Information,
    planned: _Rows,
    knowledge: Information,
    objective: Objective,
) -> int | None:
    """Index of the candidate after which the objective is least; None where none makes it finite."""
    total = expected_total(known.plus(knowledge), problem.targets, problem.loaded.robot.compliance)
    every = hidden.of(rows.with_each(planned, slice(0, 1)), share=_SHARE)[0]
    if not np.isfinite(total).any():
        return None
    entries = np.flatnonzero(every >= _SHARE**2 * every.max())
    best = 0
    for _ in range(_ROUNDS):
        parts = [slice(start, start + _BATCH) for start in range(0, len(total), _BATCH)]
        squares = np.concatenate([hidden.of(rows.with_each(planned, part), entries).max(axis=1) for part in parts])
        scores = objective.of(total, np.sqrt(squares))
        best = int(np.argmin(scores))
        whole = hidden.of(rows.with_each(planned, slice(best, best + 1)), share=_SHARE)[0]
        if np.sqrt(whole.max()) <= (1.0 + _AGREEMENT) * np.sqrt(squares[best]):
            break
        entries = np.union1d(entries, np.flatnonzero(whole >= _SHARE**2 * whole.max()))
    return best if np.isfinite(scores[best]) else None
