"""Time to a hypervolume: an ordinary pymoo script, plain NSGA-II on the program's evaluation, and the program.

    python -m benchmarks.optimality.hypervolume [CONFIG] [--script-seconds S] [--plain-seconds S]

Four ways to the same front, one after the other in one process. Hypervolumes are of (DUIR, FEIR) with a reference
point a tenth of the best known front's extent beyond its worst values, and are given in parts of the best known one
(that of all designs of this run together). Seconds are processor seconds of one thread, so that other work on the
machine does not count; nor does the time that it takes to compute hypervolumes.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population

from expdesign.arrays import FloatArray
from expdesign.design.front import hypervolume, non_dominated
from expdesign.design.operators import CanonicalOrder, DesignCrossover, DesignMutation
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.optimality.polish import polish_rounds
from expdesign.design.optimality.seeds import relaxed_designs
from expdesign.design.problem import DesignProblem
from expdesign.design.problem_file import read_problem
from expdesign.design.pymoo_problem import DesignPopulation
from expdesign.design.search import search
from expdesign.design.start import starting_designs

from .ordinary_script import OrdinaryScript
from .tables import write

LEVELS = (0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999)


@dataclass
class Trace:
    """Fronts (feasible objective values) and the seconds after which each was there."""

    name: str
    seconds: list[float] = field(default_factory=list)
    fronts: list[FloatArray] = field(default_factory=list)

    def follow(self, states: Iterator[FloatArray]) -> "Trace":
        """Take the time of each state, and not of looking at it."""
        spent, start = 0.0, time.process_time()
        for values in states:
            spent += time.process_time() - start
            self.seconds.append(spent)
            self.fronts.append(values[non_dominated(values)] if len(values) else values)
            start = time.process_time()
        return self


def genetic(
    problem: object, population: Population | None, seconds: float, seed: int, **parts: object
) -> Iterator[FloatArray]:
    """Feasible values after each generation of NSGA-II, for so many seconds."""
    sampling = {} if population is None else {"sampling": population}
    algorithm = NSGA2(pop_size=100, **sampling, **parts)
    algorithm.setup(problem, termination=("n_gen", 10**9), seed=seed)
    spent = 0.0
    while spent < seconds:
        start = time.process_time()
        algorithm.next()
        spent += time.process_time() - start
        feasible = (algorithm.pop.get("G") <= 0.0).all(axis=1)
        yield algorithm.pop.get("F")[feasible]


def plain(problem: DesignProblem, seconds: float, seed: int) -> Iterator[FloatArray]:
    """NSGA-II with this program's evaluation and variation, without anything else."""
    population = DesignPopulation(problem)
    start = starting_designs(problem, 100, np.random.default_rng(seed))
    parts = {
        "crossover": DesignCrossover(problem.space),
        "mutation": DesignMutation(problem.space),
        "repair": CanonicalOrder(problem.space),
        "evaluator": Evaluator(),
    }
    yield from genetic(population, Population.new(X=np.unique(start, axis=0)), seconds, seed, **parts)


def program(problem: DesignProblem, seed: int) -> Iterator[FloatArray]:
    """The relaxation's designs, then the rounds of the polish, from designs drawn at random."""
    objectives = Objectives(problem)
    space = problem.space
    drawn = starting_designs(problem, 100, np.random.default_rng(seed)).reshape(100, space.measurements, space.genes)
    yield objectives.values(relaxed_designs(problem))
    for designs in polish_rounds(problem, drawn):
        yield objectives.values(designs)


def whole(problem: DesignProblem) -> Iterator[FloatArray]:
    """The front of `expdesign run`: the genetic search of the configuration, then the polish."""
    yield Objectives(problem).values(search(problem).genes)


def agreement(problem: DesignProblem, script: OrdinaryScript) -> float:
    """Largest relative difference of the script's objectives from the program's, over random designs."""
    genes = starting_designs(problem, 20, np.random.default_rng(5))
    names = [variable.columns[0] for variable in problem.space.variables]
    assert names == [0, 1, 2, 3, 4, 5, 6, 7, 8], "the script knows this one form of problem"
    ours = DesignPopulation(problem).objectives(DesignPopulation(problem).genes(genes))[0]
    theirs = script.evaluate(genes, return_values_of=["F"])
    return float(np.abs(theirs / ours - 1.0).max())


def main(path: Path, script_seconds: float, plain_seconds: float, seed: int = 1) -> None:
    problem = read_problem(path)
    problem = replace(problem, optimiser=replace(problem.optimiser, seed=seed, population=100))
    script = OrdinaryScript(path)
    difference = agreement(problem, script)
    traces = [
        Trace("ordinary pymoo script").follow(genetic(script, None, script_seconds, seed)),
        Trace("plain NSGA-II on our evaluation").follow(plain(problem, plain_seconds, seed)),
        # The relaxation is solved twice here, once for its own row; its first solution is taken off below.
        Trace("relaxation and polish").follow(program(problem, seed)),
        Trace("the program's whole search").follow(whole(problem)),
    ]
    ours = traces[-2]
    twice = ours.seconds[0]
    ours.seconds = [twice] + [seconds - twice for seconds in ours.seconds[1:]]
    everything = np.concatenate([front for trace in traces for front in trace.fronts if len(front)])
    best = everything[non_dominated(everything)]
    point = best.max(axis=0) + 0.1 * (best.max(axis=0) - best.min(axis=0))
    largest = hypervolume(best, point)
    reached: Callable[[Trace], list[float]] = lambda trace: [  # noqa: E731
        hypervolume(front, point) / largest if len(front) else 0.0 for front in trace.fronts
    ]
    rows = []
    for trace in traces:
        parts = reached(trace)
        times = [next((s for s, p in zip(trace.seconds, parts, strict=True) if p >= level), np.nan) for level in LEVELS]
        row = {"method": trace.name, **{f"{level:.1%} (s)": t for level, t in zip(LEVELS, times, strict=True)}}
        rows.append({**row, "at the end": f"{parts[-1]:.2%}", "after (s)": trace.seconds[-1], "steps": len(parts)})
    table = pd.DataFrame(rows)
    notes = [
        f"Configuration {path}; objectives of script and program differ by at most {difference:.1e}.",
        "Columns: processor seconds until that part of the best known hypervolume.",
        "Relaxation and polish start from random designs, without a genetic search; `expdesign run` has one before "
        f"them ({problem.optimiser.generations} generations of {problem.optimiser.population}): last row.",
        *_ratios(traces, reached),
    ]
    command = f"python -m benchmarks.optimality.hypervolume {path} --script-seconds {script_seconds:g}"
    command += f" --plain-seconds {plain_seconds:g}"
    write(f"hypervolume-{path.stem}", "Time to a hypervolume", command, seed, table, notes)


def _ratios(traces: list[Trace], reached: Callable[[Trace], list[float]]) -> list[str]:
    ours, notes = traces[-2], []
    mine = reached(ours)
    for trace in traces[:-2]:
        last = max(reached(trace))
        needed = next(s for s, part in zip(trace.seconds, reached(trace), strict=True) if part >= last)
        same = next((s for s, part in zip(ours.seconds, mine, strict=True) if part >= last), np.nan)
        notes.append(
            f"{trace.name}: reached at most {last:.2%}, after {needed:.1f} s; the polish had as much after "
            f"{same:.2f} s, {needed / same:.0f} times faster."
        )
        level = next((s for s, part in zip(ours.seconds, mine, strict=True) if part >= 0.99), np.nan)
        if last < 0.99:
            notes.append(
                f"{trace.name}: 99 % not reached in {trace.seconds[-1]:.0f} s; the polish took {level:.2f} s, "
                f"more than {trace.seconds[-1] / level:.0f} times faster."
            )
    return notes


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config", nargs="?", type=Path, default=Path("configs/hexapod-h1.yaml"))
    parser.add_argument("--script-seconds", type=float, default=600.0)
    parser.add_argument("--plain-seconds", type=float, default=120.0)
    arguments = parser.parse_args()
    main(arguments.config, arguments.script_seconds, arguments.plain_seconds)
