"""Sound inputs, into which mistakes are put: shipped configurations, and recordings of robots that they describe."""

from collections.abc import Mapping
from copy import deepcopy
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import expdesign as xd
from expdesign.design.plan import Plan, plan_frame
from expdesign.design.problem import DesignProblem
from expdesign.design.problem_file import problem_from_document
from expdesign.design.start import starting_designs
from expdesign.files.yaml_reader import YamlDocument, read_yaml

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


def recordings_of(content: Mapping[str, Any], seed: int, rows: int = 8, spread: float = 0.15) -> pd.DataFrame:
    """Recordings with noise and load errors of a robot whose stiffness is not that of its file."""
    generator = np.random.default_rng(seed)
    truth = truth_of(content, generator, spread)
    truth["experiment"]["measurements"] = rows
    case = problem_from(truth)
    decisions = case.space.canonical(starting_designs(case, 1, generator).reshape(1, rows, case.space.decisions))
    poses, loads = case.space.decode(decisions[0])
    frame = plan_frame(Plan(poses, loads, np.arange(1, rows + 1)), case.loaded, case.space.tilts)
    return xd.simulate(case, frame, seed=seed).frame
