"""Time to a hypervolume: the program against an ordinary pymoo script, or against plain NSGA-II on its own evaluation.

    python -m benchmarks.optimality.hypervolume script|plain [CONFIG] [--seconds S]

Both sides run one after the other in one process, each from nothing but the problem that was read. The program's side
is the whole search of `expdesign run` with the configuration's settings; the other side runs until it has used S
processor seconds. Hypervolumes are of (DUIR, FEIR) with a reference point a tenth of the best known front's extent
beyond its worst values, in parts of the best known one: that of all designs of both sides and of two more searches of
the program with other seeds. Seconds are processor seconds of one thread, so that other work on the machine does not
count (wall seconds stand beside them); nor does the time that it takes to look at what was reached.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population

from expdesign.arrays import FloatArray
from expdesign.planning.front import hypervolume, non_dominated
from expdesign.planning.operators.recombination import CanonicalOrder, DesignCrossover, DesignMutation
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.search import Progress, search
from expdesign.planning.start import starting_designs

from .ordinary_script import OrdinaryScript
from .tables import write

LEVELS = (0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99)
NAMES = {"script": "ordinary pymoo script", "plain": "plain NSGA-II on the program's evaluation"}


class Stopwatch:
    """Processor and wall seconds, without those spent while it is paused."""

    def __init__(self) -> None:
        self._start = self._now()

    @staticmethod
    def _now() -> FloatArray:
        return np.array([time.process_time(), time.perf_counter()])

    def read(self) -> FloatArray:
        return self._now() - self._start

    def forget(self, since: FloatArray) -> None:
        """Leave out what has passed since an earlier reading."""
        self._start = self._start + (self.read() - since)


@dataclass
class Trace:
    """Fronts (feasible objective values), and the processor and wall seconds after which each was there."""

    name: str
    seconds: list[FloatArray] = field(default_factory=list)
    fronts: list[FloatArray] = field(default_factory=list)
    parts: list[float] = field(default_factory=list)

    def add(self, watch: Stopwatch, values: FloatArray) -> None:
        now = watch.read()
        self.seconds.append(now)
        self.fronts.append(values[non_dominated(values)] if len(values) else values)
        watch.forget(now)

    def measure(self, point: FloatArray, largest: float) -> None:
        """Hypervolumes in parts of the best known one."""
        self.parts = [hypervolume(front, point) / largest if len(front) else 0.0 for front in self.fronts]

    def first(self, level: float) -> FloatArray:
        """Processor and wall seconds until a level is reached; NaN where it is not."""
        reached = (s for s, part in zip(self.seconds, self.parts, strict=True) if part >= level)
        return next(reached, np.full(2, np.nan))


def program(problem: DesignProblem, seed: int) -> Trace:
    """The search of `expdesign run`, state by state."""
    trace, watch = Trace("this program"), Stopwatch()

    def report(state: Progress) -> None:
        trace.add(watch, state.front)

    front = search(replace(problem, optimiser=replace(problem.optimiser, seed=seed)), report)
    trace.add(watch, np.stack([front.criteria[name] for name in front.objectives], axis=1))
    return trace


def genetic(which: str, problem: DesignProblem, script: OrdinaryScript, seconds: float, seed: int) -> Trace:
    """NSGA-II generation by generation: the script with pymoo's own operators, or the program's without gradients."""
    trace, watch = Trace(NAMES[which]), Stopwatch()
    for values in _generations(*(_plain(problem, seed) if which == "plain" else (script, {})), seed=seed):
        trace.add(watch, values)
        if trace.seconds[-1][0] > seconds:
            break
    return trace


def _plain(problem: DesignProblem, seed: int) -> tuple[DesignPopulation, dict[str, object]]:
    start = starting_designs(problem, 100, np.random.default_rng(seed))
    return DesignPopulation(problem), {
        "sampling": Population.new(X=np.unique(start, axis=0)),
        "crossover": DesignCrossover(problem.space),
        "mutation": DesignMutation(problem.space),
        "repair": CanonicalOrder(problem.space),
        "evaluator": Evaluator(),
    }


def _generations(population: object, parts: dict[str, object], *, seed: int) -> Iterator[FloatArray]:
    algorithm = NSGA2(pop_size=100, **parts)
    algorithm.setup(population, termination=("n_gen", 10**9), seed=seed)
    while True:
        algorithm.next()
        feasible = (algorithm.pop.get("G") <= 0.0).all(axis=1)
        yield algorithm.pop.get("F")[feasible]


def agreement(problem: DesignProblem, script: OrdinaryScript) -> float:
    """Largest relative difference of the script's objectives from the program's, over random designs."""
    decisions = starting_designs(problem, 20, np.random.default_rng(5))
    names = [variable.columns[0] for variable in problem.space.variables]
    assert names == [0, 1, 2, 3, 4, 5, 6, 7, 8], "the script knows this one form of problem"
    ours = DesignPopulation(problem).objectives(DesignPopulation(problem).decisions(decisions))[0]
    theirs = script.evaluate(decisions, return_values_of=["F"])
    return float(np.abs(theirs / ours - 1.0).max())


def main(which: str, path: Path, seconds: float, seed: int = 1) -> None:
    problem, script = read_problem(path), OrdinaryScript(path)
    ours = program(problem, seed)
    other = genetic(which, problem, script, seconds, seed)
    further = [program(problem, seed + extra).fronts[-1] for extra in (1, 2)]
    everything = np.concatenate([*ours.fronts, *(front for front in other.fronts if len(front)), *further])
    best = everything[non_dominated(everything)]
    point = best.max(axis=0) + 0.1 * (best.max(axis=0) - best.min(axis=0))
    rows = []
    for trace in (other, ours):
        trace.measure(point, hypervolume(best, point))
        times = {f"{level:.0%} (s)": float(trace.first(level)[0]) for level in LEVELS}
        end, wall = trace.seconds[-1]
        last = {"at the end": f"{trace.parts[-1]:.2%}", "after (s)": float(end), "wall (s)": float(wall)}
        rows.append({"method": trace.name, **times, **last, "steps": len(trace.parts)})
    notes = [
        f"Configuration {path}; its front has {len(ours.fronts[-1])} designs. Columns: processor seconds until that "
        "part of the best known hypervolume is reached.",
        f"The objectives of script and program differ by at most {agreement(problem, script):.1e} (relative).",
        *_ratios(ours, other),
    ]
    command = f"python -m benchmarks.optimality.hypervolume {which} {path} --seconds {seconds:g}"
    write(
        f"hypervolume-{which}-{path.stem}",
        f"Time to a hypervolume: {other.name}",
        command,
        seed,
        pd.DataFrame(rows),
        notes,
    )


def _ratios(ours: Trace, other: Trace) -> list[str]:
    level = max(other.parts)
    theirs, mine = other.first(level), ours.first(level)
    cpu, wall = theirs / mine
    notes = [
        f"To the same hypervolume: the {other.name} came to {level:.2%}, after {theirs[0]:.1f} s; the program had as "
        f"much after {mine[0]:.2f} s: **{cpu:.0f} times faster** ({wall:.0f} times by the wall clock)."
    ]
    for wanted in LEVELS:
        theirs, mine = other.first(wanted), ours.first(wanted)
        if np.isnan(mine[0]):
            notes.append(f"To {wanted:.0%}: the program does not reach it with this seed.")
        elif np.isnan(theirs[0]):
            budget = other.seconds[-1][0]
            notes.append(
                f"To {wanted:.0%}: not reached in {budget:.0f} s, against {mine[0]:.2f} s: more than "
                f"{budget / mine[0]:.0f} times faster."
            )
        else:
            notes.append(
                f"To {wanted:.0%}: {theirs[0]:.1f} s against {mine[0]:.2f} s, {theirs[0] / mine[0]:.0f} times."
            )
    return notes


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("which", choices=list(NAMES))
    parser.add_argument("config", nargs="?", type=Path, default=Path("configs/hexapod-h1.yaml"))
    parser.add_argument("--seconds", type=float)
    arguments = parser.parse_args()
    budget = {"script": 316.0, "plain": 66.0}[arguments.which]
    main(arguments.which, arguments.config, arguments.seconds or budget)
