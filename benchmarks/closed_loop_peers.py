"""The closed loop of `closed_loop.py` for plans that other people's tools choose, at equal cost.

    python -m benchmarks.closed_loop_peers configs/closed-loop.yaml --kept results/closed-loop/three-axes \
        --figaroh PYTHON --out results/closed-loop/peers-three-axes

- FIGAROH's posture selection from a pool of measurements, by its D-optimal SOCP and by its DetMax exchange (in an
  environment of its own, `--figaroh`: it is no dependency here). It is given this program's regressors, so that only
  the criterion and the choice are compared.
- A space-filling design: of many Latin hypercubes of `scipy.stats.qmc` over poses and loads the one of least centred
  discrepancy that the robot can reach. A different one is drawn in every repetition, so that luck averages out.

The plans by this program's criteria are those that `closed_loop.py` kept. All have as many measurements.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from benchmarks.closed_loop import (
    BEST,
    COLUMNS,
    LaboratoryBench,
    Loop,
    attained_with,
    cells,
    drawn_robot,
    expected,
    loop_of,
    plan_of_decisions,
    summary,
)
from benchmarks.closed_loop_arm import ArmBench
from benchmarks.optimality.against_figaroh import figaroh
from benchmarks.optimality.selection import choose_measurements
from scipy.stats import qmc

from expdesign.arrays import FloatArray
from expdesign.io.output import csv_text
from expdesign.io.table import read_table
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.planning.optimality.measurement_maps import MeasurementMaps
from expdesign.planning.plan import Plan, plan_frame, read_plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.start import reachable_measurements

KEPT = (BEST, "duir", "o1")
FILLING = "space-filling (scipy.stats.qmc)"
SAME_POOL = "DUIR from FIGAROH's pool"
_HYPERCUBES = 200


def pool_plans(problem: DesignProblem, python: str, pool: int, seed: int, *, same: bool) -> dict[str, Plan]:
    """What FIGAROH chooses from a pool of reachable measurements, by its SOCP and by its DetMax, and (`same`) what this
    program does by DUIR from the same pool.
    """
    decisions = reachable_measurements(problem, pool, np.random.default_rng(seed))
    rows = MeasurementMaps(problem, 0.0).rows(decisions)
    found = {}
    for name, options in (("FIGAROH, SOCP", ()), ("FIGAROH, DetMax exchange", ("--detmax",))):
        chosen, seconds = figaroh(python, rows, problem.space.measurements, *options)
        print(f"{name}: {seconds[0]:.1f} s of processor time", file=sys.stderr, flush=True)
        found[name] = plan_of_decisions(problem, decisions[chosen])
    if same:
        found[SAME_POOL] = plan_of_decisions(problem, choose_measurements(problem, decisions).variables)
    return found


def space_filling(problem: DesignProblem, generator: np.random.Generator) -> FloatArray:
    """Genes (m, g) of the reachable Latin hypercube of least centred discrepancy."""
    space, robot = problem.space, problem.loaded.robot
    best, least = None, np.inf
    for _ in range(_HYPERCUBES):
        unit = qmc.LatinHypercube(space.decisions, rng=generator).random(space.measurements)
        continuous = space.lower + unit * (space.upper - space.lower)
        decisions = np.where(space.discrete, np.minimum(np.floor(unit * (space.upper + 1.0)), space.upper), continuous)
        if not robot.usable(space.decode(decisions)[0]).all():
            continue
        discrepancy = qmc.discrepancy(unit)
        if discrepancy < least:
            best, least = decisions, discrepancy
    if best is None:
        raise RuntimeError(f"none of {_HYPERCUBES} Latin hypercubes can be reached")
    return best


def run(loop: Loop, plans: dict[str, Plan], repetitions: int, seed: int) -> pd.DataFrame:
    """Attained error of every plan in every repetition; robots and draws are those of `closed_loop.run`."""
    problem = loop.problem
    names = [*plans, FILLING]
    attained = {name: np.full(repetitions, np.nan) for name in names}
    predicted = {name: np.full(repetitions, np.nan) for name in names}
    for repetition in range(repetitions):
        stiffness, draw = drawn_robot(loop, seed, repetition)
        filling = space_filling(problem, np.random.default_rng([seed, 13, repetition]))
        for name, plan in (plans | {FILLING: plan_of_decisions(problem, filling)}).items():
            attained[name][repetition] = attained_with(loop, plan, stiffness, draw)
            predicted[name][repetition] = expected(problem, plan)
        if repetition % 20 == 19:
            print(f"{repetition + 1} of {repetitions} repetitions", file=sys.stderr, flush=True)
    return summary(attained, predicted)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("config", type=Path)
    parser.add_argument("--kept", type=Path, required=True, help="folder of closed_loop.py with plan-total.csv …")
    parser.add_argument("--figaroh", default=sys.executable, help="interpreter with figaroh")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--pool", type=int, default=1000)
    parser.add_argument("--same-pool", action="store_true", help="also this program's choice by DUIR from that pool")
    parser.add_argument("--repetitions", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    problem = read_problem(options.config)
    bench = ArmBench if isinstance(problem.loaded.robot, SerialRobot) else LaboratoryBench
    loop = loop_of(problem, 0.1, bench)
    plans = {}
    for name in KEPT:
        plans[name] = read_plan(read_table(options.kept / f"plan-{name}.csv"), problem.loaded, problem.noise)
    plans |= pool_plans(problem, options.figaroh, options.pool, options.seed, same=options.same_pool)
    table = run(loop, plans, options.repetitions, options.seed)
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "attained.csv").write_text(csv_text(table), encoding="utf-8")
    for name, plan in plans.items():
        if name not in KEPT:
            words = name.lower().replace("'s", "").replace(",", "").split()
            text = csv_text(plan_frame(plan, problem.loaded, False))
            (options.out / f"plan-{'-'.join(words)}.csv").write_text(text, encoding="utf-8")
    (options.out / "README.md").write_text(text_of(table, options), encoding="utf-8")
    print(table.to_string(index=False))


def text_of(table: pd.DataFrame, options: argparse.Namespace) -> str:
    """The result as Markdown."""
    command = (
        f"python -m benchmarks.closed_loop_peers {options.config} --kept {options.kept} --figaroh PYTHON "
        f"--out {options.out} --pool {options.pool} --repetitions {options.repetitions} --seed {options.seed}"
    )
    same = options.same_pool
    command += " --same-pool" * same
    rows = [f"| {' | '.join(row)} |" for row in (COLUMNS, ("---",) * len(COLUMNS), *cells(table))]
    told = (
        f"{options.repetitions} repetitions, robots and draws of noise and load errors as in `{options.kept}`, whose\n"
        f"plans by `{'`, `'.join(KEPT)}` were sought over all poses and loads; FIGAROH chooses from a pool of\n"
        f"{options.pool} reachable measurements with this program's regressors{', and so does DUIR' * same};\n"
        "a space-filling plan is drawn anew in every repetition. All have as many measurements. Error\n"
        "attained at the targets, in tolerances; ± is one standard error; differences are repetition by repetition."
    )
    return f"# Closed loop: plans of other tools\n\n```\n{command}\n```\n\n{told}\n\n" + "\n".join(rows) + "\n"


if __name__ == "__main__":
    main()
