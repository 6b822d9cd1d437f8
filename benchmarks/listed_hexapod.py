"""Small random configurations by number: lists of poses for the hexapod of `configs/hexapod-h1.yaml`."""

from pathlib import Path

import numpy as np
import yaml

from expdesign.design.problem import DesignProblem
from expdesign.design.problem_file import problem_from_document
from expdesign.files.yaml_reader import parse_yaml

CONFIGS = Path(__file__).parents[1] / "configs"


def problem(number: int, folder: Path = CONFIGS) -> DesignProblem:
    """Problem `number`: 10 to 40 poses, three to six measurements, shared references in every second one."""
    generator = np.random.default_rng(number)
    document = yaml.safe_load((CONFIGS / "hexapod-h1.yaml").read_text(encoding="utf-8"))
    experiment = document["experiment"]
    low, high = np.array(list(experiment["poses"]["bounds"].values())).T
    poses = generator.uniform(low, high, (int(generator.integers(10, 41)), len(low)))
    experiment["poses"] = {"candidates": poses.round(5).tolist()}
    experiment["measurements"] = int(generator.integers(3, 7))
    experiment["deflection_noise"]["shared_reference"] = number % 2 == 0
    document["aggregate"] = "max" if number % 3 == 0 else "mean"
    document["optimiser"]["seed"] = number
    return problem_from_document(parse_yaml(yaml.safe_dump(document, sort_keys=False), "listed", CONFIGS))
