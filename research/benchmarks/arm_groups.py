"""Held-out errors of a calibrated UR10e of which only some groups of parameters are wrong.

    python -m research.benchmarks.arm_groups [--seeds N] [--first SEED] [--out FOLDER]

Sixty positions of one marker are read without and with 8 kg and 30 µm of noise; the arm is that of
`arms_positions/machine.py`, computed by pinocchio. Either zeros and compliances alone are wrong, or all frames as well.
The error is that of 100 held-out positions, both loads, without noise, RMS in µm. Beside `identify` stands the same fit
to which somebody tells that the frames are as drawn (`hold`).
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

import expdesign as xd
from expdesign.chain.row import row_data
from expdesign.estimation.arm_options import Held
from research.benchmarks.arms_positions.machine import KINDS, NOISE, Machine
from research.benchmarks.arms_positions.rows import ENDS

POSES, HELD_OUT, PAYLOAD = 60, 100, 8.0
"""Fitted and held-out positions; kg, at the flange at the second reading of each."""
WAYS: dict[str, tuple[Held, ...]] = {"identify": (), "identify --hold lengths angles": ("lengths", "angles")}
WRONG = {"zeros and compliances": False, "zeros, compliances and frames": True}


def measured(
    seed: int, frames: bool, folder: Path, part: float = 1.0
) -> tuple[dict[str, object], pd.DataFrame, np.ndarray]:
    """A robot file's content, recordings in a part of the joints' ranges, and the positions without noise (N, 3)."""
    arm, random = KINDS["UR10e"], np.random.default_rng([seed, POSES])
    machine = Machine(arm, 1, random, frames=frames)
    count = 2 * (POSES + HELD_OUT)
    commands = np.repeat(random.uniform(part * arm.low, part * arm.high, (count // 2, len(arm.joints))), 2, axis=0)
    payloads = np.tile([0.0, PAYLOAD], count // 2)
    exact = machine.readings(commands, payloads)[:, 0]
    read = exact + NOISE * random.standard_normal(exact.shape)
    file = folder / "ur10e.urdf"
    file.write_text(arm.urdf, encoding="utf-8")
    robot = {"name": "UR10e", "kind": "serial", "urdf": str(file), "base_link": ENDS[0], "tip_link": ENDS[1]}
    table = pd.DataFrame(commands, columns=[f"q{k}_rad" for k in range(1, 7)])
    table[["px_m", "py_m", "pz_m"]] = read
    table[["spx_m", "spy_m", "spz_m"]] = NOISE
    table = table.assign(marker="ball", mass_kg=payloads, com_x_m=0.0, com_y_m=0.0, com_z_m=0.0)
    table["split"] = np.where(np.arange(count) < 2 * POSES, "train", "test")
    table = table.assign(sequence=range(1, 1 + count), series=range(1, 1 + count))
    return robot | {"actuator_stiffness": arm.stiffness.tolist()}, table, exact


def held_out_error(robot: dict[str, object], table: pd.DataFrame, exact: np.ndarray, hold: tuple[Held, ...]) -> float:
    """RMS distance (µm) of the held-out positions from the truth."""
    result = xd.identify(robot, table, hold=hold).result
    test, chain = result.recordings.rows(result.recordings.test), result.fit.chain
    predicted = chain.predict(row_data(test, chain.robot), result.fit.values)[:, test.axes]
    return float(1e6 * np.sqrt(((predicted - exact[2 * POSES :]) ** 2).sum(axis=1).mean()))


def main() -> None:
    """The table, on standard output and in `--out`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5, help="arms")
    parser.add_argument("--first", type=int, default=0, help="seed of the first arm")
    parser.add_argument("--out", type=Path, default=Path("results/runs/arm-groups"))
    given = parser.parse_args()
    lines = []
    with tempfile.TemporaryDirectory() as scratch:
        for seed in range(given.first, given.first + given.seeds):
            for wrong, frames in WRONG.items():
                of = measured(seed, frames, Path(scratch))
                for way, hold in WAYS.items():
                    lines.append({"wrong": wrong, "way": way, "seed": seed, "rms_um": held_out_error(*of, hold)})
                    print(*lines[-1].values(), sep=", ", flush=True)
    table = pd.DataFrame(lines).groupby(["wrong", "way"], sort=False)["rms_um"].agg(["mean", "sem", "count"])
    print(table.round(2).to_string())
    given.out.mkdir(parents=True, exist_ok=True)
    table.to_csv(given.out / "arm-groups.csv", float_format="%.4g")


if __name__ == "__main__":
    main()
