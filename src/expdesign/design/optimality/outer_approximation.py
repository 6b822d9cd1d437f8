"""Branch and bound over whole plans, by cuts of the convex criterion (theory.md 10.7).

The information of a plan is linear in how often it takes each column, and the criterion is convex in the information:
every Q gives a cut, linear in the columns, below which no plan lies. An integer program over the cuts found so far
bounds all whole plans from below; its plans give the next cuts (outer approximation, Duran & Grossmann 1986). The
linear programs of its tree (`tree.py`) are solved by HiGHS (Huangfu & Hall 2018).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linprog

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.design.optimality.columns import Columns
from expdesign.design.optimality.weights import Dual, Relaxation

_REGULARISATION = 1e-10
_NEAR, _PIECES = 0.05, 4
_ROUNDING = 3e-6
"""Relative slack for the tolerances of the integer program."""
_KEPT, _IDLE_SLACK = 100, 1e-3
_RATE, _FIXED = 1.4e6, 7000.0
"""Coefficients of linear programs per second, and as how many the rest of a program counts."""
_LOOSE = 1e-4
"""A column whose bound exceeds what it tells by less than this part of a measurement's is not split."""


@dataclass(frozen=True)
class Program:
    """Outcome of one linear program.

    Attributes:
        times: how often every column is taken, shape (J,); None where no plan satisfies the program.
        visits: measurements, or series, at every pose, shape (p,).
        bound: what no plan goes below, the criterion squared; infinite where there is none.
    """

    times: FloatArray | None
    visits: FloatArray
    bound: float


class Master:
    """The program over some columns.

    Args:
        relaxation: targets, prior and m.
        parts: the columns, by their number of measurements.
        unit: a value of the criterion squared, by which cuts are scaled.

    Attributes:
        work: processor seconds of the cuts and linear programs so far, as estimated from their sizes.
    """

    def __init__(self, relaxation: Relaxation, parts: list[Columns], unit: float) -> None:
        self._relaxation, self._unit = relaxation, unit
        self._parameters = relaxation.prior.shape[0]
        self._duals: list[Dual] = []
        self._kept: list[int] = []
        self._idle: dict[int, int] = {}
        self.work = 0.0
        self._use([part for part in parts if len(part)])

    def __len__(self) -> int:
        return len(self._sizes)

    @property
    def cuts(self) -> int:
        """Number of cuts."""
        return len(self._duals)

    def _use(self, parts: list[Columns]) -> None:
        self.parts = parts
        self._edges = np.cumsum([0, *(len(part) for part in parts)])
        self._information = self._joined([part.information(self._parameters) for part in parts])
        self._sizes = np.concatenate([np.full(len(part), part.size) for part in parts] or [np.zeros(0, dtype=int)])
        self._coefficients = [self._most(dual) for dual in self._duals]
        poses = np.concatenate([part.pose for part in parts] or [np.zeros(0, dtype=np.int64)])
        distinct, self._group = np.unique(poses, return_inverse=True)
        self._at_poses = np.zeros((len(distinct), len(poses)))
        self._at_poses[self._group, np.arange(len(poses))] = 1.0
        count = np.concatenate([[0.0], self._sizes, np.zeros(len(distinct))])[None]
        visits = np.concatenate([np.zeros((len(distinct), 1)), self._at_poses, -np.eye(len(distinct))], axis=1)
        self._plans = np.concatenate([count, visits])

    def _joined(self, arrays: list[FloatArray]) -> FloatArray:
        return np.concatenate(arrays) if arrays else np.zeros((0, self._parameters, self._parameters))

    def _most(self, dual: Dual) -> FloatArray:
        self.work += sum(part.seconds for part in self.parts)
        return np.concatenate([part.most(dual) for part in self.parts]) / self._unit

    def cut(self, dual: Dual) -> None:
        """Add the cut 2·tr(LQ) − tr(QᵀPQ) − Σ x_j·tr(QᵀN_jQ) ≤ t."""
        self._kept.append(len(self._duals))
        self._idle[len(self._duals)] = 0
        self._duals.append(dual)
        self._coefficients.append(self._most(dual))

    def _sum(self, times: FloatArray) -> FloatArray:
        """P + Σ x_j·N_j of a plan (J,), with the loads that stand for the columns, shape (q, q)."""
        found: FloatArray = self._relaxation.prior + np.tensordot(times, self._information, axes=1)
        return found

    def _targets(self, matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The criterion squared at every target (b, t) for informations (b, q, q), and their inverses."""
        size = np.trace(matrix, axis1=1, axis2=2)[:, None, None] / matrix.shape[1]
        inverse = np.linalg.inv(matrix + _REGULARISATION * np.maximum(size, 1e-300) * np.eye(matrix.shape[1]))
        targets = self._relaxation.targets
        values: FloatArray = ((targets @ inverse[:, None]) * targets).sum(axis=(2, 3))
        return values, inverse

    def cut_at(self, times: FloatArray) -> float:
        """Add the cuts that touch the criterion at a plan (J,), whole or not; the criterion squared there."""
        found, inverses = self._targets(self._sum(times)[None])
        values = found[0]
        order = np.argsort(-values, kind="stable")[:_PIECES]
        for target in order[values[order] >= (1.0 - _NEAR) * values[order[0]]]:
            root = self._relaxation.targets[target]
            matrix = inverses[0] @ root.T
            prior = float(np.trace(matrix.T @ self._relaxation.prior @ matrix))
            self.cut(Dual(matrix, float(np.trace(root @ matrix)), prior, self._relaxation.count))
        return float(values[order[0]])

    def exchanged(self, times: FloatArray) -> FloatArray:
        """A whole plan (J,) after exchanges of columns of equal size that help, until none does (Fedorov 1972)."""
        times = times.copy()
        matrix = self._sum(times)
        value = float(self._targets(matrix[None])[0].max())
        improved = True
        while improved:
            improved = False
            for column in np.flatnonzero(times):
                without = times.copy()
                without[column] -= 1.0
                same = np.flatnonzero((self._sizes == self._sizes[column]) & self._open(without))
                trial = matrix - self._information[column] + self._information[same]
                found = self._targets(trial)[0].max(axis=1)
                best = int(found.argmin())
                if found[best] < value * (1.0 - 1e-9):
                    times, matrix, value, improved = without, trial[best], float(found[best]), True
                    times[same[best]] += 1.0
        return times

    def _open(self, times: FloatArray) -> BoolArray:
        """Columns that can be added to a plan as far as its visits of poses go, shape (J,)."""
        room: BoolArray = (self._at_poses @ times + 1.0 <= self.most_visits)[self._group]
        return room

    @property
    def most_visits(self) -> int:
        """Columns that there may be at one pose: one series, or as many measurements as a plan has."""
        return 1 if self.parts and self.parts[0].sites.series else self._relaxation.count

    def rounded(self, times: FloatArray, generator: np.random.Generator) -> FloatArray | None:
        """A whole plan (J,) of columns drawn by their weights, or None where no columns fill it."""
        left, m = self._relaxation.count, self._relaxation.count
        plan = np.zeros(len(self))
        floor = np.floor(times + 1e-6)
        weights = times - floor + 1e-6 / len(self)
        plan += floor
        left = m - int((plan * self._sizes).sum())
        while left > 0:
            open_ = (self._sizes <= left) & self._open(plan)
            if not open_.any():
                return None
            chance = np.where(open_, weights, 0.0)
            plan[generator.choice(len(self), p=chance / chance.sum())] += 1.0
            left = m - int((plan * self._sizes).sum())
        return plan

    def solve(self, low: FloatArray | None = None, high: FloatArray | None = None) -> Program:
        """The best plan by the cuts so far, of columns in parts.

        Args:
            low: the least of times and visits, shape (J + p,); 0 where left out.
            high: the most of them.
        """
        number, poses, m = len(self), len(self._at_poses), self._relaxation.count
        nowhere = np.zeros(poses)
        if number == 0:
            return Program(None, nowhere, np.inf)
        low = np.zeros(number + poses) if low is None else low
        high = self.highest if high is None else high
        binding = np.array([self._coefficients[i] for i in self._kept])
        self.work += (binding.size + _FIXED) / _RATE
        constants = np.array([2.0 * self._duals[i].gain - self._duals[i].prior for i in self._kept]) / self._unit
        cuts = np.concatenate([-np.ones((len(binding), 1)), -binding, np.zeros((len(binding), poses))], axis=1)
        found: Any = linprog(
            np.concatenate([[1.0], np.zeros(number + poses)]),
            A_ub=cuts,
            b_ub=-constants,
            A_eq=self._plans,
            b_eq=np.concatenate([[m], nowhere]),
            bounds=np.stack([np.concatenate([[0.0], low]), np.concatenate([[np.inf], high])], axis=1).tolist(),
            method="highs-ds",
        )
        if found.status == 2:
            return Program(None, nowhere, np.inf)
        if found.x is None:
            return Program(None, nowhere, 0.0)
        self._retire(found.ineqlin.residual)
        times = np.maximum(found.x[1 : 1 + number], 0.0)
        return Program(times, found.x[1 + number :], max(0.0, float(found.fun) * self._unit * (1.0 - _ROUNDING)))

    def _retire(self, slack: FloatArray) -> None:
        """Leave out cuts that have not mattered for long, so that the programs stay small."""
        for place, cut in enumerate(self._kept):
            self._idle[cut] = 0 if slack[place] < _IDLE_SLACK else self._idle[cut] + 1
        if len(self._kept) > _KEPT:
            order = np.argsort([self._idle[cut] for cut in self._kept], kind="stable")
            self._kept = sorted(self._kept[i] for i in order[: _KEPT // 2])

    @property
    def highest(self) -> FloatArray:
        """The most that times and visits can be, shape (J + p,)."""
        most = np.full(len(self._at_poses), float(self.most_visits))
        return np.concatenate([np.minimum(self._relaxation.count // self._sizes, self.most_visits), most])

    def plan(self, times: FloatArray) -> FloatArray:
        """The measurements (m, g) of a whole plan, with the loads that stand for its columns."""
        found = []
        for part, edge in zip(self.parts, self._edges, strict=False):
            for column in np.flatnonzero(times[edge : edge + len(part)]):
                found += int(times[edge + column]) * [part.measurements(int(column))]
        return np.concatenate(found)

    def refine(self, times: FloatArray) -> IntArray | None:
        """Split the boxes of a plan's columns (J,) where the cut there is loose.

        Returns:
            For every column from now on the column it was, −1 where it is part of one that was split, shape (J',);
            None where nothing was split.
        """
        self.cut_at(times)
        dual = self._duals[-1]
        parts, origins = [], []
        for part, edge in zip(self.parts, self._edges, strict=False):
            added = part.by_corner(dual)[0]
            slack = (added.max(axis=2) - added[:, :, 0]).max(axis=1)
            loose = slack > _LOOSE * max(float(np.abs(added).max(initial=0.0)), 1e-300)
            taken = np.flatnonzero(loose & (times[edge : edge + len(part)] > 0.0))
            halves = {int(column): part.split(int(column), dual) for column in taken}
            split = {column: new for column, new in halves.items() if new is not None}
            kept = np.setdiff1d(np.arange(len(part)), list(split))
            keep = part.take(kept)
            pose = np.concatenate([keep.pose, *(new.pose for new in split.values())])
            boxes = np.concatenate([keep.boxes, *(new.boxes for new in split.values())])
            parts.append(Columns(part.sites, pose, boxes))
            origins.append(np.concatenate([edge + kept, np.full(len(pose) - len(kept), -1)]))
        origin: IntArray = np.concatenate(origins)
        if (origin >= 0).all():
            return None
        self._use(parts)
        return origin


def most_sensitive(parts: list[Columns], dual: Dual, number: int) -> list[Columns]:
    """The columns that tell most per measurement by a Q, of each number of measurements."""
    kept = []
    for part in (each for each in parts if len(each)):
        order: IntArray = np.argsort(-part.most(dual), kind="stable")[:number]
        kept.append(part.take(np.sort(order)))
    return kept
