"""Whether intervals hold: a tool of unknown mass, and positions that were not fitted, with pinocchio as the machine.

`python -m benchmarks.arms.coverage [--experiments N] [--rows N] [--results FOLDER]`. In every experiment zeros, links,
stiffnesses and the tool of the arm are drawn anew, three markers are read, and geometry, compliances, tool, instrument
and markers are fitted together. Stated are the share of 95 % intervals of the tool's mass and first moments that hold
the truth, and the share of held-out readings within 1.96 predicted standard deviations. Partial results are kept.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from benchmarks.arms.plant import recordings, usual_faults

from expdesign.app.api.inputs import table_of
from expdesign.chain.chain import Chain
from expdesign.chain.effects.joints.geometry import GeometricError
from expdesign.chain.effects.load.tool import UnknownTool
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.row import row_data
from expdesign.diagnosis.held_out import within_intervals
from expdesign.diagnosis.sample import Sample
from expdesign.estimation.fit import Data, fit
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.robot_file import read_robot

_NORMAL_95 = 1.959964


def experiment(seed: int, rows: int) -> tuple[list[bool], int, int]:
    """Whether the intervals of mass and moments hold, held-out readings within theirs, and how many there are."""
    tool = float(np.random.default_rng([seed, 1]).uniform(1.0, 5.0))
    faults = replace(usual_faults(seed, tool=tool), periodic=(0.0, 0.0))
    robot = read_robot(Path("configs/robots/ur5.yaml"))
    read = recordings_from_table(table_of(recordings(faults, rows, seed), "positions.csv"), robot)
    assert read.deviations is not None
    whitening = Whitening(read.deviations)
    data = Data(read, row_data(read, robot), whitening, reading=reading_of(robot, read))
    effects = (GeometricError.from_text(robot, "geometry"), UnknownTool.from_text(robot, "platform"))
    chain = Chain(robot, effects, reading=data.reading)
    sample = Sample.of(data, ~read.test)
    found = fit(chain, sample)
    own = chain.slices[1]
    mass, centre = faults.tool
    off = np.abs(found.values[own] - np.array([mass, *(mass * centre)]))
    holds = off <= _NORMAL_95 * np.sqrt(np.diag(found.covariance)[own])
    inside, count = within_intervals(found, sample, read.test)
    return holds.tolist(), inside, count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--experiments", type=int, default=100)
    parser.add_argument("--rows", type=int, default=150)
    parser.add_argument("--results", type=Path, default=Path("results/arms"))
    arguments = parser.parse_args()
    arguments.results.mkdir(parents=True, exist_ok=True)
    file = arguments.results / "coverage.json"
    holds: list[list[bool]] = []
    shares: list[float] = []
    for seed in range(arguments.experiments):
        own, inside, count = experiment(seed + 100, arguments.rows)
        holds.append(own)
        shares.append(inside / count)
        figures = {
            "experiments": len(shares),
            "rows": arguments.rows,
            "tool": np.mean(holds, axis=0).round(4).tolist(),
            "tool_standard_error": round(float(np.sqrt(0.95 * 0.05 / len(holds))), 4),
            "held_out": round(float(np.mean(shares)), 4),
            "held_out_standard_error": round(float(np.std(shares) / np.sqrt(len(shares))), 4),
        }
        file.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
        print(figures, flush=True)


if __name__ == "__main__":
    main()
