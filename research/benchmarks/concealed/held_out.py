"""Held-out error: what a model predicts for rows that a diagnosis never saw, against the base model's prediction."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from research.laboratory import Robot
from research.laboratory.recordings import deflection_columns

from .case import Case, measured_components
from .linear_model import Array, leg_forces, maps_of

WORSE = 1.02
"""Readings are predicted worse than by the base model from this ratio of RMS errors."""


@dataclass(frozen=True)
class Predicted:
    """RMS errors in standard deviations of the readings: against the true values, and against the readings.

    `standardised`: errors over the standard deviation that the prediction states; empty where it states none.
    """

    base: float
    model: float
    base_read: float
    model_read: float
    standardised: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def worse(self) -> bool:
        """Whether the readings are predicted more than 2 % worse than by the base model."""
        return self.model_read > WORSE * self.base_read


def predicted(case: Case, guess: pd.DataFrame) -> Predicted:
    """Errors of a guess of the held-out readings, with the standard deviations that it states, if it does."""
    later, names = case.later, measured_components(case.later)
    stds = [deviation_of(name) for name in names]
    true, read = later[[f"true_{n}" for n in names]].to_numpy(dtype=float), later[names].to_numpy(dtype=float)
    std, model = later[stds].to_numpy(dtype=float), guess[names].to_numpy(dtype=float)
    base = base_prediction(case, names, stds)
    own = guess[stds].to_numpy(dtype=float) if set(stds) <= set(guess) else np.full_like(model, np.nan)
    usable = np.isfinite(own) & (own > 0)
    errors = [(base - true) / std, (model - true) / std, (base - read) / std, (model - read) / std]
    of_base, of_model, base_read, model_read = (float(np.sqrt(np.mean(each**2))) for each in errors)
    return Predicted(of_base, of_model, base_read, model_read, ((model - true)[usable] / own[usable]).ravel())


def deviation_of(reading: str) -> str:
    """Column of the standard deviation of a reading: `sx_m` of `dx_m`, `spx_m` of the position `px_m`."""
    return f"s{reading}" if reading.startswith("p") else f"s{reading[1:]}"


def base_prediction(case: Case, names: list[str], stds: list[str]) -> Array:
    """What the base model, fitted to the seen rows, predicts for the held-out ones."""
    seen, later = case.recordings, case.later
    if f"base_{names[0]}" in later:
        return later[[f"base_{name}" for name in names]].to_numpy(dtype=float)
    robot = Robot.from_mapping(case.robot)
    columns = [deflection_columns(robot).index(name) for name in names]

    def matrices(rows: pd.DataFrame) -> Array:
        each = zip(maps_of(robot, rows), leg_forces(robot, rows), strict=True)
        return np.array([maps.pose[columns] * force for maps, force in each])

    fitted = seen[seen["split"] != "test"] if "split" in seen else seen
    std = fitted[stds].to_numpy(dtype=float)
    left = (matrices(fitted) / std[:, :, None]).reshape(-1, robot.legs)
    right = (fitted[names].to_numpy(dtype=float) / std).ravel()
    compliance = np.linalg.lstsq(left, right, rcond=None)[0]
    return np.asarray(matrices(later) @ compliance)
