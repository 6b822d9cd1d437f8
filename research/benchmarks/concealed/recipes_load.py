"""Concealed physics of the load and of the instrument that reads its effect."""

from __future__ import annotations

import numpy as np
import pandas as pd

from .case import UnsuitableError
from .experiments import Experiment, Wishes
from .hidden import Hidden, Recipe, Sized, element, unit


def _com_offset(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    direction = unit(rng, 3) * [1.0, 1.0, 0.5]

    def of_size(size: float) -> Sized:
        x, y, z = size * direction
        return Sized((element("payload_com_offset", com_dx_m=x, com_dy_m=y, com_dz_m=z),))

    return Hidden("payload_com_offset", ("payload",), 2e-4, 0.15 * experiment.machine.reach, of_size)


def _mass_error(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    """One of several weights is wrong, one disc of a stack, or an adapter was forgotten. Not a scale of everything."""
    weights, rows = experiment.weights, experiment.rows
    if len(weights) < 2:
        raise UnsuitableError("needs several weights")
    kind = rng.choice(["weight", "disc", "adapter"], p=[0.45, 0.15, 0.4])
    used = rows.loc[experiment.fitted, "mass_kg"]
    chosen = int(rng.integers(1 if kind == "disc" else 0, len(weights)))
    heavy = weights[chosen]
    if kind == "weight" and not 0.1 < (used == heavy).mean() < 0.7:
        raise UnsuitableError("that weight is used too little, or nearly alone")
    sign = 1.0 if kind == "adapter" else rng.choice([-1.0, 1.0])

    def of_size(size: float) -> Sized:
        def true_rows(frame: pd.DataFrame) -> pd.DataFrame:
            mass = frame["mass_kg"]
            concerned = {"weight": mass == heavy, "disc": mass >= heavy, "adapter": mass > 0}[str(kind)]
            return frame.assign(mass_kg=np.where(concerned, mass + sign * size, mass))

        return Sized((), true_rows, remark=f"{kind}: {sign * size:+.4g} kg of {heavy:.4g} kg")

    limit = (0.3 if kind == "weight" else 0.5) * float(weights[0 if kind == "adapter" else chosen])
    return Hidden("payload_mass_error", ("payload",), 1e-3 * limit, limit, of_size)


def _tilt(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    angle = rng.uniform(0, 2 * np.pi)
    planar = experiment.machine.robot.planar

    def of_size(size: float) -> Sized:
        if planar:
            return Sized((element("load_direction_tilt", tilt_z_rad=size * np.sign(np.cos(angle))),))
        tilts = {"tilt_x_rad": size * np.cos(angle), "tilt_y_rad": size * np.sin(angle)}
        return Sized((element("load_direction_tilt", **tilts),))

    return Hidden("load_direction_tilt", ("payload", "environment"), 3e-4, 0.1, of_size)


def _misalignment(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    direction = np.array([0.0, 0.0, rng.choice([-1.0, 1.0])]) if experiment.machine.robot.planar else unit(rng, 3)

    def of_size(size: float) -> Sized:
        x, y, z = size * direction
        return Sized((element("instrument_misalignment", rot_x_rad=x, rot_y_rad=y, rot_z_rad=z),))

    return Hidden("instrument_misalignment", ("instrument",), 5e-4, 0.15, of_size)


def _scale(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    axes = [axis for axis in experiment.measured if axis < 3]
    scales = np.zeros(3)
    for axis in axes if rng.random() < 0.4 else [rng.choice(axes)]:
        scales[axis] = rng.uniform(0.4, 1.0) * rng.choice([-1.0, 1.0])

    def of_size(size: float) -> Sized:
        x, y, z = size * scales / np.abs(scales).max()
        return Sized((element("instrument_scale", scale_x=x, scale_y=y, scale_z=z),))

    return Hidden("instrument_scale", ("instrument",), 5e-4, 0.15, of_size)


def _outlier(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    rows = experiment.rows
    count = int(rng.integers(1, max(2, round(0.03 * len(rows))) + 1))
    chosen = sorted(int(each) for each in rng.choice(np.flatnonzero(experiment.fitted), count, replace=False))

    def of_size(size: float) -> Sized:
        return Sized((element("outlier", rows=chosen, size=size),), remark=f"{count} of {len(rows)} rows")

    return Hidden("outlier", ("instrument", "environment"), 5.0, 80.0, of_size)


RECIPES = (
    Recipe(
        "payload_com_offset",
        lambda rng: Wishes(load="payload" if rng.random() < 0.8 else "wrench", large=rng.random() < 0.4),
        _com_offset,
        planar=False,
    ),
    Recipe("payload_mass_error", lambda rng: Wishes(load="payload", large=rng.random() < 0.6), _mass_error),
    Recipe("load_direction_tilt", lambda rng: Wishes(large=rng.random() < 0.4), _tilt),
    Recipe("instrument_misalignment", lambda rng: Wishes(positions=True, large=rng.random() < 0.4), _misalignment),
    Recipe("instrument_scale", lambda rng: Wishes(positions=True, large=rng.random() < 0.7), _scale),
    Recipe("outlier", lambda rng: Wishes(), _outlier),
)
