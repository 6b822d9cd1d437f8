"""Held-out error on the judge's own series, which the model of a diagnosis predicts without having seen them."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from virtual_laboratory import Robot
from virtual_laboratory.recordings import deflection_columns, std_columns

from .linear_model import leg_forces, maps_of


@dataclass(frozen=True)
class HeldOut:
    """RMS of prediction errors divided by their standard deviation; `noise` is what the noise alone makes of it."""

    base: float
    model: float
    noise: float


def held_out(
    command: Sequence[str], model: Path, robot: dict[str, Any], seen: pd.DataFrame, later: pd.DataFrame, noise: float
) -> HeldOut | None:
    """Compare `expdesign predict` with the later series; None where it fails."""
    machine = Robot.from_mapping(robot)
    deflections = [name for name in deflection_columns(machine) if name in later]
    stds = [name for name in std_columns(machine) if name in later]
    measured, std = later[deflections].to_numpy(dtype=float), later[stds].to_numpy(dtype=float)
    base = _rms((measured - base_prediction(machine, seen, later, deflections, stds)) / std)
    points, predicted = model.parent / "later-points.csv", model.parent / "later-predicted.csv"
    later.drop(columns=[*deflections, *stds]).to_csv(points, index=False)
    call = [*command, "predict", str(model), str(points), "--out", str(predicted)]
    done = subprocess.run(call, capture_output=True, text=True, cwd=model.parent, timeout=300, check=False)
    if done.returncode != 0 or not predicted.exists():
        return None
    guess = pd.read_csv(predicted)[deflections].to_numpy(dtype=float)
    return HeldOut(base, _rms((measured - guess) / std), noise)


def base_prediction(
    robot: Robot, seen: pd.DataFrame, later: pd.DataFrame, deflections: list[str], stds: list[str]
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """What the base model, fitted to the seen rows, predicts for the later ones."""
    columns = [deflection_columns(robot).index(name) for name in deflections]

    def matrices(rows: pd.DataFrame) -> np.ndarray[Any, np.dtype[np.float64]]:
        each = zip(maps_of(robot, rows), leg_forces(robot, rows), strict=True)
        return np.array([maps.pose[columns] * force for maps, force in each])

    fitted = seen[seen["split"] != "test"] if "split" in seen else seen
    std = fitted[stds].to_numpy(dtype=float)
    left = (matrices(fitted) / std[:, :, None]).reshape(-1, robot.legs)
    right = (fitted[deflections].to_numpy(dtype=float) / std).ravel()
    compliance = np.linalg.lstsq(left, right, rcond=None)[0]
    return np.asarray(matrices(later) @ compliance)


def _rms(values: np.ndarray[Any, np.dtype[np.float64]]) -> float:
    return float(np.sqrt(np.mean(values**2)))
