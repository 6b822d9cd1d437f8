"""The parts of a work on a design problem, done by an engine.

A problem holds symbolic expressions, which cannot be sent. It travels as its resolved configuration, from which a
worker makes the same problem, once for all parts that it is given.
"""

import copy
import json
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from expdesign.app.sweeps.engine import Engine
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.parts import Done, Parts, unnoticed
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document

R = TypeVar("R")


def by_engine(problem: DesignProblem, engine: Engine) -> Parts:
    """Does the parts of a work on `problem`, which came from a configuration, by an engine."""
    travelling = json.dumps([problem.source, _travelling(problem)])

    def execute(work: Callable[..., R], arguments: Sequence[tuple[Any, ...]], done: Done = unnoticed) -> list[R]:
        results: dict[int, R] = {}
        for index, result in engine.execute(part, [(work, travelling, each) for each in arguments]):
            results[index] = result
            done(index)
        return [results[index] for index in range(len(arguments))]

    return execute


def part(task: tuple[Callable[..., R], str, tuple[Any, ...]]) -> R:
    """One part, in a worker."""
    work, travelling, arguments = task
    return work(_arrived(travelling), *arguments)


@lru_cache(maxsize=8)
def _arrived(travelling: str) -> DesignProblem:
    source, config = json.loads(travelling)
    return problem_from_document(YamlDocument(source, Path(), config))


def _travelling(problem: DesignProblem) -> dict[str, Any]:
    """The resolved configuration, with the place of a URDF file written out."""
    config = copy.deepcopy(problem.config)
    folder = Path(problem.robot_file or problem.source).parent
    for robot in (config["robot"], config["robot"].get("robot")):
        if isinstance(robot, dict) and isinstance(robot.get("urdf"), str):
            robot["urdf"] = str((folder / robot["urdf"]).resolve())
    return config
