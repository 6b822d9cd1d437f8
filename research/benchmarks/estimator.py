"""Declared load errors weighed by the fit, or only propagated: error at the targets, and coverage of 95 % intervals.

    python -m research.benchmarks.estimator configs/hexapod-120kg.yaml --out results/runs/estimator

One robot is measured, identified and exactly compensated many times (theory.md 8, plant P1). Its load errors are drawn
as they are declared, twice and half as large, and its stiffness is far from the robot file's. All estimators meet the
same robots, noise and load errors; the fit knows the declaration alone.
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import ExactCompensation, deflections_under
from expdesign.assurance.validation.repeated import mean, root_mean_square
from expdesign.assurance.validation.simulation import Repetitions
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.identify import identify
from expdesign.estimation.load_errors import Estimator
from expdesign.io.output import csv_text, output_folder, write_file
from expdesign.io.table import parse_table
from expdesign.mechanics.loads.load import Wrench
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import search_single

NORMAL = 1.959963984540054
SETTINGS = (("as declared", 1.0, 0.1), ("twice", 2.0, 0.1), ("half", 0.5, 0.1), ("stiffness 30 % off", 1.0, 0.3))
"""Name, load errors as multiples of the declared ones, and relative scatter of the true stiffness (1 σ)."""
WAYS: tuple[tuple[Estimator, Estimator], ...] = (
    ("weighted", "weighted"),
    ("generalised", "weighted"),
    ("generalised", "generalised"),
)
"""Estimator of the fit, and that by which the plan was made."""
HEADS = ("weighted", "generalised", "generalised, own plan")
"""Headings of the ways: the RMS error (tolerances) of the first, and those of the others as shares of it."""


@dataclass(frozen=True)
class Attempt:
    """One repetition: errors at the targets (t, n), and shares of intervals that hold the truth."""

    errors: FloatArray
    stiffness: float
    targets: float


class Bench:
    """A plan that is carried out again and again."""

    def __init__(self, problem: DesignProblem, plan: Plan) -> None:
        self.problem, self.plan = problem, plan
        loaded = problem.loaded
        self._seen = loaded.under(Wrench(loaded.robot.coordinates))
        self._wrenches = loaded.load.wrenches(loaded.robot.jacobians(plan.configurations).rotation, plan.loads)
        self._recordings = self._blank()
        observation = self._seen.measure(plan.configurations, self._wrenches).observation[:, problem.noise.axes]
        self._shown = np.abs(observation).max(axis=(0, 1)) > 0.0

    def _blank(self) -> Recordings:
        """Recordings whose readings are still to be drawn."""
        problem, coordinates = self.problem, self.problem.loaded.robot.coordinates
        frame = plan_frame(self.plan, problem.loaded, True)
        deviations = np.sqrt(np.diag(problem.noise.covariance))
        for axis, deviation in zip(problem.noise.axes, deviations, strict=True):
            frame[coordinates.deflection[axis]], frame[coordinates.deviation[axis]] = 1e-6, deviation
        return recordings_from_table(parse_table(csv_text(frame), "bench"), problem.loaded.robot)

    @cached_property
    def _compensated(self) -> list[tuple[ExactCompensation, Callable[[FloatArray, FloatArray], FloatArray]]]:
        """Of every target the commands of estimates, and how far compliances move the robot from them."""
        loaded, targets = self.problem.loaded, self.problem.targets.configurations
        return [
            (ExactCompensation(loaded, target, wrench, loaded.robot.compliance), deflections_under(loaded, wrench))
            for target, wrench in zip(targets, self.problem.target_wrenches, strict=True)
        ]

    def _attained(self, target: FloatArray, reached: FloatArray) -> FloatArray:
        """Attained minus wanted pose (s, n) where the configurations (s, n_q) were reached."""
        away, robot = reached - target, self.problem.loaded.robot
        if not robot.jointed:
            return away
        return (robot.jacobians(target + away / 2.0).pose @ away[..., None])[..., 0]

    def compliances(self, scatter: float, seed: tuple[int, int]) -> FloatArray:
        """True compliances (n_p,) of a repetition."""
        known = self.problem.loaded.robot.compliance
        return known * np.exp(scatter * np.random.default_rng([*seed, 0]).standard_normal(len(known)))

    def recorded(self, true: FloatArray, factor: float, seed: tuple[int, int]) -> Recordings:
        """What is read in a repetition."""
        problem, plan = self.problem, self.plan
        where = (plan.configurations, plan.loads)
        added = problem.loaded.drawn_errors(*where, 1, np.random.default_rng([*seed, 1]))[0]
        measured = self._seen.measure(plan.configurations, self._wrenches + factor * added)
        pose_map = problem.loaded.robot.jacobians(plan.configurations).pose
        noise = problem.noise.drawn(plan.series, 1, np.random.default_rng([*seed, 2]), pose_map)[0]
        return replace(self._recordings, deflections=(measured.observation @ true)[:, problem.noise.axes] + noise)

    def attempts(self, estimators: tuple[Estimator, ...], true: FloatArray, recorded: Recordings) -> list[Attempt]:
        """The same recordings by several estimators."""
        problem, targets = self.problem, self.problem.targets
        found = [
            identify(problem.loaded.robot, recorded, load_errors=problem.load_errors, estimator=each)
            for each in estimators
        ]
        estimates = np.array([one.compliance.estimate for one in found])
        errors = np.empty((len(found), *targets.importance.shape))
        for index, (compensation, moved) in enumerate(self._compensated):
            commands = compensation.attained(estimates).commands
            attained = self._attained(compensation.target, commands + moved(commands, true))
            errors[:, index] = attained if targets.axes is None else attained @ targets.axes[index].T
        matters, attempts = targets.importance > 0.0, []
        for one, error in zip(found, errors, strict=True):
            inside = (one.compliance.low <= true) & (true <= one.compliance.high)
            seen = targets.observation
            deviations = np.sqrt(np.einsum("tnp,pq,tnq->tn", seen, one.covariance, seen))
            held = np.abs(error) <= NORMAL * deviations
            attempts.append(Attempt(error, float(inside[self._shown].mean()), float(held[matters].mean())))
        return attempts


def benches(problem: DesignProblem, seed: int) -> dict[Estimator, Bench]:
    """The plan that is best by `total` for each estimator."""
    found: dict[Estimator, Bench] = {}
    for estimator in dict.fromkeys(by for _, by in WAYS):
        case = replace(problem, estimator=estimator)
        best = search_single(case, known_criteria()["total"], seed=seed)
        configurations, loads = problem.space.decode(best.decisions[0])
        found[estimator] = Bench(problem, Plan(configurations, loads, np.arange(1, len(configurations) + 1)))
        print(f"plan by {estimator}: total {best.criteria['total'][0]:.4g}", file=sys.stderr, flush=True)
    return found


def repeated(
    made: dict[Estimator, Bench], setting: tuple[str, float, float], count: int, seed: int
) -> list[FloatArray]:
    """Of every way the repetitions: squared error, shares of intervals of stiffness and at targets, (count, 3)."""
    _, factor, scatter = setting
    found: list[list[Attempt]] = [[] for _ in WAYS]
    for repetition in range(count):
        for by, bench in made.items():
            mine = [index for index, way in enumerate(WAYS) if way[1] == by]
            true = bench.compliances(scatter, (seed, repetition))
            recorded = bench.recorded(true, factor, (seed, repetition))
            for index, attempt in zip(
                mine, bench.attempts(tuple(WAYS[index][0] for index in mine), true, recorded), strict=True
            ):
                found[index].append(attempt)
    targets = made["weighted"].problem.targets
    squares = [Repetitions(np.array([one.errors for one in each]), np.empty(0), 0.0).squares(targets) for each in found]
    shares = [np.array([[one.stiffness, one.targets] for one in each]) for each in found]
    return [np.column_stack(parts) for parts in zip(squares, shares, strict=True)]


def rows(problem: DesignProblem, name: str, count: int, seed: int) -> Iterator[dict[str, object]]:
    """The table of one configuration."""
    made = benches(problem, seed)
    for setting in SETTINGS:
        found = repeated(made, setting, count, seed)
        row: dict[str, object] = {"configuration": name, "load errors": setting[0]}
        for heading, one in zip(HEADS, found, strict=True):
            row[heading] = _attained(one[:, 0], found[0][:, 0])
        for column, what in ((1, "stiffness"), (2, "targets")):
            for heading, one in zip(HEADS[:2], found[:2], strict=True):
                share = mean(100.0 * one[:, column])
                row[f"{what} held, {heading}"] = _text(share.value, share.standard_error, 1)
        yield row
        print(f"{name}, {setting[0]}", file=sys.stderr, flush=True)


def _attained(squares: FloatArray, reference: FloatArray) -> str:
    """RMS of the reference itself, else the RMS as a share of it; both are of the same repetitions."""
    if np.array_equal(squares, reference):
        rms = root_mean_square(np.sqrt(squares))
        return _text(rms.value, rms.standard_error, 3)
    ratio = np.sqrt(squares.mean() / reference.mean())
    spread = (squares / squares.mean() - reference / reference.mean()).std(ddof=1) / np.sqrt(len(squares))
    return _text(ratio, 0.5 * ratio * spread, 3)


def _text(value: FloatArray, error: FloatArray, digits: int) -> str:
    return f"{float(value):.{digits}f} ± {float(error):.{digits}f}"


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("configs", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, default=Path("results/runs/estimator"))
    parser.add_argument("--repetitions", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    found = [
        row
        for config in options.configs
        for row in rows(read_problem(config), config.stem, options.repetitions, options.seed)
    ]
    table = pd.DataFrame(found)
    lines = [f"| {' | '.join(row)} |" for row in (table.columns, ("---",) * len(table.columns), *table.to_numpy())]
    with output_folder(options.out) as scratch:
        write_file(scratch / "estimator.csv", csv_text(table))
        write_file(scratch / "README.md", "\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main(sys.argv[1:])
