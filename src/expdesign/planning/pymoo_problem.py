"""The design problem as pymoo sees it: decision vectors of a population in, objectives and constraints out."""

import numpy as np
from pymoo.core.problem import Problem

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.robot import CONDITION_LIMIT
from expdesign.planning.constraints import LIMITS
from expdesign.planning.operators.archive import Archive
from expdesign.planning.optimality.objectives import Objectives
from expdesign.planning.problem import DesignProblem

UNIDENTIFIED = 1e30
"""Objective of a design that identifies too little. Such a design also violates a constraint, so that the number never
reaches a front; it is finite only because NaN and infinity upset the ranking of the others."""


_FEW, _MEASUREMENTS = 25, 4000
"""Designs that are evaluated together where that is costly, and measurements of designs where it is not."""


class DesignPopulation(Problem):  # type: ignore[misc]
    """Objectives (minimised) and constraints (≤ 0) of a population.

    Constraints: the robot's limits (m or rad of excess), the scaled condition number (decades above its limit), and
    the number of target axes that cannot be identified; then those of `experiment.constraints` and the budget (min),
    where there are some.

    Attributes:
        design_problem: what is designed.
        wanted: the objectives and `total`.
        archive: of the feasible designs that were evaluated.
        evaluations: designs evaluated so far.
    """

    def __init__(self, problem: DesignProblem) -> None:
        space = problem.space
        self.design_problem = problem
        self.wanted = Objectives(problem)
        shape = space.measurements, space.decisions
        self.archive = Archive(shape, len(problem.objectives), self.wanted.names)
        # What has no gradient has a costly evaluation.
        costly = not self.wanted.differentiable.all()
        self._together = _FEW if costly else max(1, _MEASUREMENTS // max(1, space.measurements))
        self.evaluations = 0
        super().__init__(
            n_var=space.measurements * space.decisions,
            n_obj=len(problem.objectives),
            n_ieq_constr=(3 if problem.constraints is None else 5 + len(LIMITS)) + (problem.budget is not None),
            xl=np.tile(space.lower, space.measurements),
            xu=np.tile(space.upper, space.measurements),
        )

    def decisions(self, vectors: FloatArray) -> FloatArray:
        """Decision variables per measurement (b, m, g) of decision vectors (b, m·g)."""
        space = self.design_problem.space
        return vectors.reshape(len(vectors), space.measurements, space.decisions)

    def objectives(self, decisions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Objectives (b, k), to be minimised, and constraints (b, c) of designs given as decisions (b, m, g)."""
        values, violations = self.criteria(decisions)
        return values[:, : self.n_obj], violations

    def criteria(self, decisions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The same with `total` behind the objectives, where it is none of them.

        Designs are evaluated in parts, after each of which they are known, whatever ends the search.
        """
        values, violations = np.zeros((0, len(self.wanted.criteria))), np.zeros((0, self.n_ieq_constr))
        for start in range(0, len(decisions), self._together):
            part = decisions[start : start + self._together]
            found, beyond = self._part(part)
            self.evaluations += len(part)
            feasible = (beyond <= 0.0).all(axis=1)
            self.archive.add(part[feasible], found[feasible])
            values, violations = np.concatenate([values, found]), np.concatenate([violations, beyond])
        return values, violations

    def _part(self, decisions: FloatArray) -> tuple[FloatArray, FloatArray]:
        problem = self.design_problem
        configurations, loads = problem.space.decode(decisions)
        assessment = problem.assessed(decisions)
        condition = assessment.measurements.jacobians.condition.max(axis=1)
        singular = ~np.isfinite(condition)
        unidentified = ((~assessment.estimable) & (problem.targets.importance > 0.0)).sum(axis=(1, 2))
        values = self.wanted.values(assessment)
        unusable = (unidentified > 0) | singular | ~np.isfinite(values).all(axis=1)
        values[unusable] = UNIDENTIFIED
        excess = problem.loaded.robot.limit_excess(configurations).max(axis=1)
        violations = np.stack(
            [
                np.maximum(excess - 1e-12, -1.0),
                np.where(singular, 300.0, np.log10(np.where(singular, 1.0, condition) / CONDITION_LIMIT)),
                np.where(unusable, np.maximum(unidentified, 1), 0).astype(float),
            ],
            axis=1,
        )
        if problem.constraints is not None:
            further = problem.constraints.violations(problem.loaded, configurations, loads)
            violations = np.concatenate([violations, further], axis=1)
        if problem.budget is not None and problem.space.settings is not None:
            over = problem.space.settings.minutes(decisions) - problem.budget.minutes - 1e-9
            violations = np.concatenate([violations, over[:, None]], axis=1)
        return values, violations

    def _evaluate(self, x: FloatArray, out: dict[str, FloatArray], *args: object, **kwargs: object) -> None:
        values, out["G"] = self.criteria(self.decisions(x))
        out["F"], out["criteria"] = values[:, : self.n_obj], values
