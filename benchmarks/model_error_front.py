"""The front of total against MEIR, by NSGA-II from a given plan, and the time that a design costs.

expdesign run configs/hexapod-h1.yaml --out results/mine
python -m benchmarks.model_error_front configs/hexapod-h1.yaml results/mine/plan.csv --generations 250
"""

import argparse
import time
from dataclasses import replace
from typing import Any

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.problem import Problem
from pymoo.optimize import minimize

from expdesign.api.inputs import problem_of, table_of
from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import known_criteria
from expdesign.design.plan import read_plan
from expdesign.design.problem import DesignProblem
from expdesign.design.space import DesignSpace
from expdesign.design.variables import Rows
from expdesign.model_error.hidden_physics import hidden_physics
from expdesign.model_error.impact import ModelErrorImpact
from expdesign.model_error.settings import Assumptions
from expdesign.robots.robot import CONDITION_LIMIT

POPULATION = 80


def decisions_of(space: DesignSpace, configurations: FloatArray, loads: FloatArray) -> FloatArray:
    """Genes (m, g) of a plan."""
    quantities = np.concatenate([configurations, loads], axis=1)
    decisions = np.zeros((len(configurations), space.decisions))
    for index, variable in enumerate(space.variables):
        values = quantities[:, list(variable.columns)]
        if isinstance(variable.domain, Rows):
            distances = np.linalg.norm(variable.domain.table[None] - values[:, None], axis=-1)
            decisions[:, index] = distances.argmin(axis=1)
        else:
            decisions[:, index] = values[:, 0]
    return decisions


class Front(Problem):  # type: ignore[misc]
    """Total and MEIR of the active physics over designs within the robot's limits."""

    def __init__(self, problem: DesignProblem, impact: ModelErrorImpact, measurements: int) -> None:
        self.problem, self.impact, self.measurements = problem, impact, measurements
        space = problem.space
        low, high = np.tile(space.lower, measurements), np.tile(space.upper, measurements)
        super().__init__(n_var=len(low), n_obj=2, n_ieq_constr=1, xl=low, xu=high)

    def _evaluate(self, x: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        problem = self.problem
        configurations, loads = problem.space.decode(x.reshape(len(x), self.measurements, -1))
        assessment = problem.assess(configurations, loads)
        total = known_criteria()["total"].values(assessment)
        meir = self.impact.values(assessment)
        out["F"] = np.nan_to_num(np.column_stack([total, meir]), nan=1e3)
        robot = problem.loaded.robot
        excess = robot.limit_excess(configurations).max(axis=1)
        singular = robot.jacobians(configurations).condition.max(axis=1) > CONDITION_LIMIT
        out["G"] = np.where(singular, 1.0, excess)[:, None]


def main() -> None:
    """Print the front with the physics that is hidden, and the cost of a design."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config")
    parser.add_argument("plan")
    parser.add_argument("--generations", type=int, default=250)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--readings", type=float, help="bound on the readings instead of prior sizes")
    parser.add_argument("--without", nargs="*", default=[])
    given = parser.parse_args()
    problem = problem_of(given.config)
    plan = read_plan(table_of(given.plan, "plan"), problem.loaded, shared_reference=False)
    assumptions = replace(Assumptions(), readings=given.readings, without=frozenset(given.without))
    whole = ModelErrorImpact(problem, assumptions)
    space, generator = problem.space, np.random.default_rng(given.seed)
    pool = np.stack([space.sample(len(plan), generator) for _ in range(3 * POPULATION)])
    usable = problem.loaded.robot.usable(space.decode(pool)[0]).all(axis=1)
    start = np.concatenate([pool[usable][: POPULATION - 1], decisions_of(space, plan.configurations, plan.loads)[None]])
    impact = whole.restricted(whole.active(problem.assess(*space.decode(start)), share=0.6))
    print(f"{len(impact.physics)} of {len(whole.physics)} entries are active")
    for name, each in (("all", whole), ("active", impact)):
        each.values(problem.assess(*space.decode(start)))
        began = time.process_time()
        each.values(problem.assess(*space.decode(start)))
        print(f"{name}: {1e3 * (time.process_time() - began) / len(start):.2f} ms of CPU per design")
    algorithm = NSGA2(pop_size=POPULATION, sampling=start.reshape(len(start), -1))
    result = minimize(Front(problem, impact, len(plan)), algorithm, ("n_gen", given.generations), seed=given.seed)
    order = np.argsort(result.F[:, 0])
    configurations, loads = space.decode(result.X[order].reshape(len(order), len(plan), -1))
    hidden = whole.hidden(problem.assess(configurations, loads))
    print("| total | MEIR of the active physics | MEIR | hidden |\n| --- | --- | --- | --- |")
    for index in range(0, len(order), max(1, len(order) // 12)):
        scales = np.broadcast_to(
            whole.scales(whole.whitened(problem.assess(configurations, loads))[1]), (len(order), len(whole.deviations))
        )
        worst = hidden_physics(hidden, whole.physics, scales[index], index)[0]
        total, meir = result.F[order[index]]
        print(f"| {total:.4f} | {meir:.3f} | {worst.error:.3f} | {worst.physics}, {worst.component} {worst.variant} |")


if __name__ == "__main__":
    main()
