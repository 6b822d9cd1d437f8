"""Sound inputs, into which mistakes are put: shipped configurations, and recordings of robots that they describe."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import expdesign as xd
from expdesign.chain.chain import Chain
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.io.yaml_reader import YamlDocument, read_yaml
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.sampling import starting_designs
from tests.chain.kinds import KINDS

CONFIGS = Path(__file__).parents[2] / "configs"
PARALLEL = ("hexapod-h1", "hexapod-120kg", "rubin-camera")


@lru_cache(maxsize=16)
def _content(name: str) -> dict[str, Any]:
    content = deepcopy(read_yaml(CONFIGS / f"{name}.yaml").content)
    if isinstance(content["robot"], str):
        content["robot"] = deepcopy(read_yaml(CONFIGS / content["robot"]).content)
    if "urdf" in content["robot"]:
        content["robot"]["urdf"] = str(CONFIGS / "robots" / Path(content["robot"]["urdf"]).name)
    return content


def content_of(name: str) -> dict[str, Any]:
    """A shipped configuration with its robot written out."""
    return deepcopy(_content(name))


def problem_from(content: Mapping[str, Any]) -> DesignProblem:
    return problem_from_document(YamlDocument("config.yaml", CONFIGS, dict(content)))


def truth_of(content: Mapping[str, Any], generator: np.random.Generator, spread: float = 0.15) -> dict[str, Any]:
    """The same with other stiffnesses, which differ from those of the file."""
    result: dict[str, Any] = deepcopy(dict(content))
    stated = np.array(result["robot"]["actuator_stiffness"])
    result["robot"]["actuator_stiffness"] = (stated * np.exp(spread * generator.standard_normal(len(stated)))).tolist()
    return result


def recordings_of(
    content: Mapping[str, Any], seed: int, rows: int = 8, spread: float = 0.15, series: int = 1
) -> pd.DataFrame:
    """Recordings with noise and load errors of a robot whose stiffness is not that of its file.

    Args:
        content: configuration.
        seed: of stiffness, plan, noise and errors.
        rows: how many there are.
        spread: standard deviation of the logarithm of the stiffness.
        series: rows at every pose.
    """
    generator = np.random.default_rng(seed)
    truth = truth_of(content, generator, spread)
    truth["experiment"]["measurements"] = rows
    case = problem_from(truth)
    decisions = case.space.canonical(starting_designs(case, 1, generator))
    poses, loads = case.space.decode(decisions[0])
    frame = plan_frame(Plan(poses, loads, np.arange(1, rows + 1)), case.loaded, case.space.tilts)
    if series > 1:
        frame = in_series(frame, case.loaded.robot, generator, series)
    return xd.simulate(case, frame, seed=seed).frame


def with_wrenches(content: Mapping[str, Any]) -> dict[str, Any]:
    """The same with forces and moments of the size of its payloads, in place of them."""
    result: dict[str, Any] = deepcopy(dict(content))
    experiment = result["experiment"]
    mass = experiment["load"].get("mass_kg")
    if mass is None:
        return result
    force = 9.81 * float(np.max(mass["choices"] if isinstance(mass, dict) else mass))
    size = dict.fromkeys(("fx_N", "fy_N", "fz_N"), force) | dict.fromkeys(("mx_Nm", "my_Nm", "mz_Nm"), 0.15 * force)
    experiment["load"] = {"kind": "wrench", **{name: [-most, most] for name, most in size.items()}}
    experiment["load_error"] = []
    return result


def in_series(frame: pd.DataFrame, robot: Robot, generator: np.random.Generator, rows: int) -> pd.DataFrame:
    """Plans have one row at a pose; here every pose has some, with times and temperatures."""
    frame = frame.copy()
    first = np.arange(len(frame)) // rows * rows
    for name in robot.configuration:
        frame[name] = frame[name].to_numpy()[first]
    frame["series"] = first // rows + 1
    frame["time_s"] = np.cumsum(generator.uniform(20.0, 200.0, len(frame)))
    frame["temperature_degC"] = 20.0 + np.cumsum(generator.normal(scale=0.1, size=len(frame)))
    return frame


def concealing(recordings: Recordings, robot: Robot, generator: np.random.Generator) -> Recordings:
    """Recordings into which a physics that the base model lacks is put, at up to the size that is typical of it.

    It adds to the deflections no more than the load makes of them, as it does in robots that serve.
    """
    kinds = [kind for kind in KINDS if kind.candidates(robot, recordings)]
    kind = kinds[int(generator.integers(len(kinds)))]
    effect = kind.candidates(robot, recordings)[0]
    chain, rows = Chain(robot, (effect,)), row_data(recordings, robot)
    neutral = effect.neutral()
    sizes = np.array([parameter.scale for parameter in effect.parameters])
    values = neutral + sizes * generator.uniform(-1.0, 1.0, len(sizes))
    ones = np.ones(chain.compliances)
    change = chain.predict(rows, np.concatenate([ones, values])) - chain.predict(rows, np.concatenate([ones, neutral]))
    if not np.isfinite(change).all():
        return recordings
    change = change[:, recordings.axes]
    largest = np.sqrt((change**2).mean(axis=0)) / np.sqrt((recordings.deflections**2).mean(axis=0))
    return replace(recordings, deflections=recordings.deflections + change / max(1.0, float(largest.max())))


def read_out(recordings: Recordings) -> Recordings:
    """Readings in steps of a power of ten of at most a standard deviation, as an instrument's display has them."""
    step = 10.0 ** np.floor(np.log10(recordings.deviations.min(axis=0)))
    return replace(recordings, deflections=np.round(recordings.deflections / step) * step)
