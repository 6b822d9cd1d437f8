"""Recordings of the virtual laboratory, an independent multibody engine, and the chain fitted to them."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.fit import Fit, fit
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot_file import read_robot
from tests.chain.kinds import kind_for
from tests.fitting import data_of
from tests.identification.experiments import read
from tests.oracle import Array

FOLDER = Path(__file__).parents[2] / "configs" / "robots"
STIFFNESS = {
    "hexapod-h1": [5.5e6, 5e6, 5.2e6, 4.9e6, 5.6e6, 5.1e6],
    "bipod": [0.95e7, 1.4e7],
}
DEVIATION = {"hexapod-h1": [5e-7] * 3 + [2e-6] * 3, "bipod": [5e-7] * 2}


@cache
def machine(name: str) -> ParallelRobot:
    """A robot of configs/robots."""
    robot = read_robot(FOLDER / f"{name}.yaml")
    assert isinstance(robot, ParallelRobot)
    return robot


def experiment(name: str, series: int = 25, loads: int = 6, seed: int = 0) -> pd.DataFrame:
    """Series that begin unloaded, with loads, times and temperatures at random."""
    generator = np.random.default_rng(seed)
    rows: list[list[float]] = []
    time = 0.0
    for number in range(series):
        if name == "bipod":
            pose = generator.uniform(-1.0, 1.0, 2) * [0.1, 0.1]
        else:
            pose = generator.uniform(-0.5, 0.5, 6) * [0.06, 0.06, 0.04, 0.3, 0.3, 0.4]
        for index in range(loads):
            time += generator.uniform(20.0, 80.0)
            loaded = float(index > 0)
            if name == "bipod":
                load = loaded * generator.uniform(-1.0, 1.0, 2) * [400.0, 1000.0]
            else:
                place = generator.uniform(-0.2, 0.2, 3) * [1.0, 1.0, 0.0] + [0.0, 0.0, 0.12]
                load = np.array([loaded * generator.choice([5.0, 10.0, 26.5]), *place])
            temperature = 20.0 + 2.0 * np.sin(time / 2000.0) + 0.3 * generator.standard_normal()
            rows.append([len(rows) + 1, number + 1, time, *pose, *load, temperature])
    loads_named = ["fx_N", "fy_N"] if name == "bipod" else ["mass_kg", "com_x_m", "com_y_m", "com_z_m"]
    names = ["sequence", "series", "time_s", *machine(name).configuration, *loads_named, "temperature_degC"]
    return pd.DataFrame(rows, columns=names)


def measured(
    name: str, *elements: dict[str, Any], rows: pd.DataFrame | None = None, noise: bool = False, seed: int = 1
) -> pd.DataFrame:
    """The rows as the laboratory measures them, with standard deviations stated."""
    pytest.importorskip("exudyn", reason="the laboratory's engine is an extra")
    from research.laboratory import Robot  # noqa: PLC0415 (an extra)
    from research.laboratory.truth import laboratory_from  # noqa: PLC0415

    truth: dict[str, Any] = {"true_stiffness": STIFFNESS[name], "elements": list(elements)}
    columns = machine(name).coordinates
    if noise:
        truth["noise"] = {"std": dict(zip(columns.deflection, DEVIATION[name], strict=True))}
    bench = laboratory_from(Robot.read(FOLDER / f"{name}.yaml"), truth, seed)
    found = bench.measure(experiment(name) if rows is None else rows)
    return found.assign(**dict(zip(columns.deviation, DEVIATION[name], strict=True)))


def recorded(name: str, *elements: dict[str, Any], **options: Any) -> Recordings:
    """The same as the reader gives it."""
    return read(measured(name, *elements, **options), machine(name))


def fitted(name: str, recordings: Recordings, physics: str, component: str, variant: str) -> tuple[Fit, Fit, Array]:
    """Fits of the base model and of the chain with one effect from its best start, and the effect's parameters."""
    data = data_of(recordings, machine(name))
    base = fit(Chain(machine(name)), data)
    effect = kind_for(machine(name), recordings, physics).from_text(machine(name), component, variant)
    chain = Chain(machine(name), (effect,))
    starts = effect.starts(recordings)
    fits = [fit(chain, data, np.concatenate([base.values, start])) for start in starts[:: max(1, len(starts) // 100)]]
    best = min(fits, key=lambda result: result.chi2)
    return base, best, best.values[chain.slices[0]]
