"""Geometric plans of an arm: what they are worth at the targets, with pinocchio as the machine.

    python -m benchmarks.arms.plans [--arms N] [--poses N] [--seconds N] [--results FOLDER]

Plans of as many poses are made by `run` for DUIR (with O1 beside it), taken from its front for O1 alone, and drawn at
random within the same bounds. The same simulated arms (zeros off by 1 mrad, frames by 0.3 mm and 0.5 mrad, stiffness by
20 %; joints yield under the links' weight) are measured with each: positions of three markers with 30 µm of noise, an
instrument and markers at unknown places. `identify` fits geometry and compliances. Stated is the RMS error of the
markers' predicted positions at the targets, without noise, with its standard error over arms, and the DUIR that was
planned. Nothing of the library is in the machine.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from benchmarks.arms.plant import PLACES, Arm, Faults, usual_faults

import expdesign as xd

Array = npt.NDArray[np.float64]
NOISE = 3e-5
ROBOT = Path(__file__).parents[2] / "configs" / "robots" / "ur5.yaml"
JOINTS = [f"q{k}_rad" for k in range(1, 7)]
LOW, HIGH = np.array([-1.0, -2.2, 0.4, -2.6, -2.2, -1.5]), np.array([1.0, -0.5, 2.2, 0.0, -0.9, 1.5])
TARGETS = np.array(
    [[0.0, -1.3, 1.5, -1.8, -1.57, 0.0], [0.6, -0.9, 1.2, -1.9, -1.57, 0.5], [-0.6, -1.9, 2.0, -1.2, -1.2, -0.5]]
)
_RANDOM = 5
"""Random plans."""


def configuration(poses: int) -> dict[str, Any]:
    """Of the plans: three markers 0.1 m apart make rotations as exact as NOISE over that lever."""
    deviation = {f"d{axis}_m": NOISE / np.sqrt(3.0) for axis in "xyz"} | {f"dr{a}_rad": NOISE / 0.1 for a in "xyz"}
    return {
        "schema_version": 1,
        "robot": str(ROBOT),
        "experiment": {
            "calibration": "geometric",
            "frames": "unknown",
            "measurements": poses,
            "poses": {"bounds": {n: [a, b] for n, a, b in zip(JOINTS, LOW.tolist(), HIGH.tolist(), strict=True)}},
            "deflection_noise": {"std": deviation},
        },
        "targets": [
            {"pose": each.tolist(), "tolerance": dict.fromkeys(("dx_m", "dy_m", "dz_m"), 1e-4)} for each in TARGETS
        ],
        "objectives": ["duir", "o1"],
        "optimiser": {"population": 40, "generations": 40, "seed": 1, "polish": True},
    }


def measured(arm: Arm, commands: Array, seed: int) -> pd.DataFrame:
    """Positions of the three markers at commands (N, 6)."""
    random = np.random.default_rng(seed)
    rows: list[dict[str, object]] = []
    for command in commands:
        for name, place in PLACES.items():
            row: dict[str, object] = {"sequence": len(rows) + 1, "series": len(rows) + 1, "marker": name}
            row |= dict(zip(JOINTS, command, strict=True))
            read = arm.position(command, place) + NOISE * random.standard_normal(3)
            row |= dict(zip(("px_m", "py_m", "pz_m"), read, strict=True))
            rows.append(row | dict.fromkeys(("spx_m", "spy_m", "spz_m"), NOISE))
    return pd.DataFrame(rows)


def error(faults: Faults, commands: Array, seed: int) -> float:
    """RMS length (m) of the errors of predicted positions at the targets after a calibration with a plan."""
    arm = Arm(faults)
    identified = xd.identify(ROBOT, measured(arm, commands, seed))
    points = measured(arm, TARGETS, 0).drop(columns=["px_m", "py_m", "pz_m", "spx_m", "spy_m", "spz_m"])
    predicted = xd.predict(identified, points).frame[["px_m", "py_m", "pz_m"]].to_numpy()
    true = np.array([arm.position(command, place) for command in TARGETS for place in PLACES.values()])
    return float(np.sqrt(((predicted - true) ** 2).sum(axis=1).mean()))


def _faults(seed: int) -> Faults:
    return replace(usual_faults(seed, tool=0.0), periodic=(0.0, 0.0))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arms", type=int, default=60)
    parser.add_argument("--poses", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=60.0, help="of the search for plans")
    parser.add_argument("--results", type=Path, default=Path("results/arms"))
    given = parser.parse_args()
    config = configuration(given.poses)
    found = xd.run(config, seconds=given.seconds)
    designs = found.plans
    front = found.pareto
    best = int(front["design"].to_numpy()[int(np.argmin(front["duir"].to_numpy()))])
    o1 = int(front["design"].to_numpy()[int(np.argmax(front["o1"].to_numpy()))])
    random = np.random.default_rng(3)
    plans = {
        "DUIR": [designs.loc[designs["design"] == best, JOINTS].to_numpy()],
        "O1": [designs.loc[designs["design"] == o1, JOINTS].to_numpy()],
        "random": [random.uniform(LOW, HIGH, (given.poses, 6)) for _ in range(_RANDOM)],
    }
    figures: dict[str, Any] = {"poses": given.poses, "arms": given.arms}
    for name, alternatives in plans.items():
        frames = [pd.DataFrame(each, columns=JOINTS).assign(sequence=range(1, len(each) + 1)) for each in alternatives]
        planned = [xd.evaluate(config, frame.assign(series=frame["sequence"])).record["duir"] for frame in frames]
        errors = np.array([
            error(_faults(seed), alternatives[seed % len(alternatives)], seed)
            for seed in range(given.arms)
        ])  # fmt: skip
        spread = float((errors**2).std() / np.sqrt(len(errors)) / (2.0 * np.sqrt((errors**2).mean())))
        figures[name] = {
            "planned DUIR": round(float(np.sqrt(np.mean(np.square(planned)))), 4),
            "error_um": round(1e6 * float(np.sqrt((errors**2).mean())), 2),
            "standard_error_um": round(1e6 * spread, 2),
        }
        print(name, figures[name], flush=True)
    given.results.mkdir(parents=True, exist_ok=True)
    (given.results / "plans.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
