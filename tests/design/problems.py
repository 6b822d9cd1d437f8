"""Run configurations for the tests of the design search, as mappings that are changed key by key."""

from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

import expdesign as xd
from expdesign.io.yaml_reader import parse_yaml
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.sampling import starting_designs
from expdesign.planning.schema import CostsSection
from tests.cases import symmetric_hexapod
from tests.oracle import Array

BIPOD: dict[str, Any] = {
    "schema_version": 1,
    "robot": {
        "name": "bipod",
        "kind": "bipod",
        "home": [0.0, 0.0],
        "base_joints": [[-0.5, 0.0], [0.5, 0.0]],
        "actuator_stiffness": [1.0e7, 1.3e7],
    },
    "experiment": {
        "measurements": 2,
        "poses": {"bounds": {"x_m": [-0.3, 0.3], "y_m": [0.35, 0.95]}},
        "load": {"kind": "wrench", "fx_N": [-500.0, 500.0], "fy_N": [-1000.0, -500.0]},
        "deflection_noise": {"std": {"dx_m": 1.0e-6, "dy_m": 2.0e-6}},
        "load_error": [{"source": "wrench", "std": [5.0, 8.0], "shared": False}],
    },
    "targets": [{"pose": [0.1, 0.6], "wrench": [0.0, -1000.0], "tolerance": {"dx_m": 1.0e-6}}],
    "optimiser": {"population": 20, "generations": 10, "seed": 1, "polish": False},
}

_H1 = symmetric_hexapod(0.24, 0.17, 0.30, 0.03, 5.24e6)

HEXAPOD: dict[str, Any] = {
    "schema_version": 1,
    "robot": {
        "name": "H1",
        "kind": "hexapod",
        "home": [0.0, 0.0, 0.3],
        "base_joints": _H1.base_joints.tolist(),
        "platform_joints": _H1.platform_joints.tolist(),
        "actuator_stiffness": [5.24e6] * 6,
        "limits": {"leg_length": [0.24, 0.36]},
    },
    "experiment": {
        "measurements": 3,
        "poses": {
            "bounds": {
                "x_m": [-0.03, 0.03],
                "y_m": [-0.03, 0.03],
                "z_m": [-0.02, 0.02],
                "rx_rad": [-0.15, 0.15],
                "ry_rad": [-0.15, 0.15],
            }
        },
        "load": {
            "kind": "payload",
            "mass_kg": {"choices": [5, 10, 26.5]},
            "com_x_m": [-0.1, 0.1],
            "com_y_m": [-0.1, 0.1],
            "com_z_m": 0.12,
            "gravity": {"tilt_x_rad": [0, 0.5]},
        },
        "deflection_noise": {
            "std": {"dx_m": 5e-7, "dy_m": 5e-7, "dz_m": 5e-7, "drx_rad": 2e-6, "dry_rad": 2e-6, "drz_rad": 2e-6}
        },
        "load_error": [
            {"source": "com", "std": [0.001, 0.001, 0.001]},
            {"source": "mass", "std": 0.01},
            {"source": "direction", "std": [0.0005, 0.0005]},
            {"source": "wrench", "std": [0.5, 0.5, 0.5, 0.05, 0.05, 0.05], "shared": False},
        ],
    },
    "targets": [
        {
            "pose": [0.02, 0.0, 0.0, 0.0, 0.0, 0.0],
            "payload": {"mass_kg": 26.5, "com_m": [0.03, 0.02, 0.15]},
            "tolerance": {"dx_m": 1e-6, "dz_m": 1e-6, "drx_rad": 1e-5},
        },
        {
            "pose": [0.0, 0.01, 0.01, 0.1, 0.0, 0.1],
            "payload": {"mass_kg": 20.0, "com_m": [0.0, 0.0, 0.15]},
            "tolerance": {"dy_m": 2e-6},
            "weight": 2.0,
        },
    ],
    "optimiser": {"population": 16, "generations": 6, "seed": 3, "polish": False},
}


def changed(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """A copy with dotted keys replaced (`targets.0.pose`), or removed where the new value is `...`."""
    result = deepcopy(base)
    for key, value in changes.items():
        *path, last = (int(part) if part.isdigit() else part for part in key.split("."))
        place: Any = result
        for part in path:
            place = place[part]
        if value is ...:
            del place[last]
        else:
            place[last] = value
    return result


def problem(base: dict[str, Any], changes: dict[str, Any] | None = None, folder: Path = Path()) -> DesignProblem:
    """The problem of a configuration written to YAML and read again."""
    text = yaml.safe_dump(changed(base, changes or {}), sort_keys=False)
    return problem_from_document(parse_yaml(text, "run.yaml", folder))


def designs(here: DesignProblem, count: int, seed: int = 0) -> Array:
    """Designs (count, m, g) within all limits, as a search begins with."""
    return starting_designs(here, count, np.random.default_rng(seed))


def plan_for(here: DesignProblem, seed: int = 1, *, at_one_pose: bool = False) -> Plan:
    """A random plan within all limits, every measurement a series of its own or all of them one at one pose."""
    poses, loads = here.space.decode(here.space.canonical(designs(here, 1, seed))[0])
    if at_one_pose:
        return Plan(np.repeat(poses[:1], len(poses), axis=0), loads, np.ones(len(poses), dtype=np.int64))
    return Plan(poses, loads, np.arange(1, len(poses) + 1))


def plan_table(here: DesignProblem, seed: int = 1) -> pd.DataFrame:
    """A random plan within all limits as the file that a run writes, without the search for a good one."""
    return plan_frame(plan_for(here, seed), here.loaded, here.space.tilts)


def searched(config: Any) -> xd.RunResult:
    """A run that ends where its plans are known: without bounds, and without what they hide, which take longest."""
    known: list[xd.RunResult] = []
    return xd.run(config, searched=known.append, ended=lambda: bool(known))


def recorded(here: DesignProblem, plan_seed: int = 2, **options: Any) -> pd.DataFrame:
    """What `simulate` records of a random plan."""
    return xd.simulate(here, plan_frame(plan_for(here, plan_seed), here.loaded, False), **options).frame


def priced(pose_change: float = 0.0, mass_change: float = 0.0, reading: float = 0.0) -> CostsSection:
    """Minutes of a change of the pose, a change of the load and a reading."""
    return CostsSection(pose_change=pose_change, mass_change=mass_change, reading=reading)
