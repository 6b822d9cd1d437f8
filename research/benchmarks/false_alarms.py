"""The largest gain of log evidence by any law in noise alone: `python -m research.benchmarks.false_alarms`.

Per experiment the dictionary is made once, and every repetition is another draw of the noise: with Φᵀ·P·Φ = U·Λ·Uᵀ
of an entry, only w = Uᵀ·Φᵀ·P·y changes (`expdesign.diagnosis.evidence.state`).
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from expdesign.app.api.inputs import load_robot
from expdesign.app.api.recorded import read_recordings
from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.evidence.dictionary import Dictionary
from expdesign.diagnosis.evidence.state import Present, linearised
from expdesign.diagnosis.options import OPTIONS
from expdesign.mechanics.robots.robot import Robot
from research.benchmarks.concealed.case import Case, generate, write_questions
from research.benchmarks.concealed.cases import draw_case, orders

_LOGS = np.linspace(np.log(1e-3), np.log(1e6), 64)


def experiments(count: int, seed: int, only: str) -> Iterator[tuple[Case, Robot, Recordings]]:
    """Cases of one kind (`none`, `outside`, an identifier) with the robot and the recordings."""
    with TemporaryDirectory() as scratch:
        for case in generate(draw_case, orders(count, seed, [only]), seed):
            folder = Path(scratch) / case.name
            write_questions(case, folder)
            machine = load_robot(folder / "robot.yaml")
            yield case, machine.robot, read_recordings(folder / "recordings.csv", machine)


def largest_gains(dictionary: Dictionary, base: Present, noise: FloatArray) -> FloatArray:
    """Of every column of the noise (M, R), the largest gain by any entry, shape (R,)."""
    factor = base.factor
    projected = noise - factor @ (factor.T @ noise)
    best = np.zeros(noise.shape[1])
    for atom in dictionary.atoms:
        through = factor.T @ atom.directions
        values, vectors = np.linalg.eigh(atom.directions.T @ atom.directions - through.T @ through)
        values = np.maximum(values, 0.0)
        squares = (vectors.T @ (atom.directions.T @ projected)) ** 2
        for variance in np.exp(_LOGS):
            share = 1.0 + variance * values
            gains = 0.5 * ((variance / share) @ squares - np.log(share).sum())
            best = np.maximum(best, gains)
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--experiments", type=int, default=6)
    parser.add_argument("--repetitions", type=int, default=100, help="draws of noise per experiment")
    parser.add_argument("--seed", type=int, default=20260)
    chosen = parser.parse_args()
    generator = np.random.default_rng(chosen.seed)
    every = []
    for case, robot, recordings in experiments(chosen.experiments, chosen.seed, "none"):
        found = diagnose(robot, recordings)
        sample = found.names.sample
        base = linearised(found.base, sample)
        dictionary = Dictionary(robot, sample, found.base.values)
        noise = generator.standard_normal((len(base.readings), chosen.repetitions))
        gains = largest_gains(dictionary, base, noise)
        every.append(gains)
        name = f"{case.truth['case']}, {robot.kind}, {int(sample.counts.sum())} rows, {len(dictionary.atoms)} entries"
        print(f"{name}: median {np.median(gains):.2f}, largest {gains.max():.2f}", flush=True)
    gains = np.concatenate(every)
    listed = ", ".join(f"{100 * q:g} %: {np.quantile(gains, q):.2f}" for q in (0.5, 0.95, 0.98, 0.99))
    print(f"{len(gains)} repetitions, seed {chosen.seed}: quantiles {listed}; largest {gains.max():.2f}")
    for limit in (6.0, OPTIONS.alarm, 10.0):
        print(f"above {limit:g}: {100.0 * (gains >= limit).mean():.2f} %")


if __name__ == "__main__":
    main()
