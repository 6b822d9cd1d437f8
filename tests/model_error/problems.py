"""Design problems and random plans for the tests of MEIR."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.meir import Meir
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem

CONFIGS = Path(__file__).parents[2] / "configs"
FEW = {
    "hexapod-h1": ("platform_compliance", "leg_coupling", "leg_backlash", "payload_com_offset"),
    "bipod": ("leg_coupling", "leg_backlash", "passive_joint_compliance", "joint_position_error"),
    "ur5": ("joint_compliance", "link_compliance", "joint_backlash", "joint_position_error"),
}
"""Physics with one and with several parameters, in the load, the actuators, the structure and the geometry."""
ROBOTS = tuple(FEW)


@cache
def problem(name: str) -> DesignProblem:
    return read_problem(CONFIGS / f"{name}.yaml")


@cache
def impact(name: str) -> Meir:
    """MEIR of some physics, whose functions are quick to make; errors of the loads are not weighed."""
    return Meir(replace(problem(name), estimator="weighted"), Assumptions(physics=frozenset(FEW[name])))


def plans(name: str, count: int, measurements: int = 6, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """Random plans: configurations (count, m, n_q) and loads (count, m, k)."""
    generator = np.random.default_rng(seed)
    decisions = np.stack([problem(name).space.sample(measurements, generator) for _ in range(count)])
    return problem(name).space.decode(decisions)


def assessed(meir: Meir, configurations: FloatArray, loads: FloatArray) -> Assessment:
    """The pieces of every criterion, for plans (b, m, n_q) and (b, m, k)."""
    return meir.problem.assess(configurations, loads)
