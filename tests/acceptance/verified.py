"""A calibrated hexapod and check measurements of it whose truth is known."""

from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd

import expdesign as xd
from expdesign.chain.models.model_file import Model
from expdesign.planning.problem import DesignProblem
from tests.design.problems import HEXAPOD, changed, problem, recorded

STD = {"dx_m": 5e-7, "dy_m": 5e-7, "dz_m": 5e-7, "drx_rad": 2e-6, "dry_rad": 2e-6, "drz_rad": 2e-6}
CONFIG: dict[str, Any] = changed(
    HEXAPOD,
    {
        "experiment.load.gravity": ...,
        "experiment.measurements": 8,
        "targets.0.tolerance": {"dx_m": 3e-6, "dz_m": 3e-6, "drx_rad": 1e-5},
        "targets.1.tolerance": {"dy_m": 3e-6},
    },
)


@lru_cache(maxsize=1)
def case() -> DesignProblem:
    return problem(CONFIG)


@lru_cache(maxsize=1)
def model() -> Model:
    """Identified from a simulated experiment with noise, without load errors."""
    return xd.identify(CONFIG["robot"], recorded(case(), seed=11, load_errors=False)).model


def targets(repeats: int = 1) -> pd.DataFrame:
    rows = []
    for target in CONFIG["targets"]:
        payload = target["payload"]
        row = dict(zip(("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"), target["pose"], strict=True))
        row["mass_kg"] = payload["mass_kg"]
        row |= dict(zip(("com_x_m", "com_y_m", "com_z_m"), payload["com_m"], strict=True))
        rows += [row] * repeats
    return pd.DataFrame(rows)


def commands(repeats: int = 1) -> pd.DataFrame:
    return xd.compensate(model(), targets(repeats)).frame


def measured(
    frame: pd.DataFrame, generator: np.random.Generator, *, error: dict[str, float] | None = None, noise: bool = True
) -> pd.DataFrame:
    """The commands with deflections of the model with apK (the truth), noise, and an added error of the pose."""
    names = [name for name in frame.columns if not name.startswith(("s", "leg")) or name in ("sequence", "series")]
    bare = frame[[name for name in names if not name.startswith("target_")]]
    plan = bare.assign(series=np.arange(1, len(bare) + 1))
    truth = xd.simulate(case(), plan, noise=False, load_errors=False).frame
    result = frame.copy()
    for (name, sigma), column in zip(
        STD.items(), ("sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad"), strict=True
    ):
        drawn = generator.standard_normal(len(frame)) * sigma if noise else 0.0
        result[name] = truth[name] + drawn + (error or {}).get(name, 0.0)
        result[column] = sigma
    return result
