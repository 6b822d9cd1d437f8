"""The script that the program is compared with computes the same: a second, independent implementation."""

from pathlib import Path

import numpy as np
import pytest
from benchmarks.optimality.hypervolume import agreement
from benchmarks.optimality.ordinary_script import OrdinaryScript

from expdesign.planning.problem_file import read_problem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.start import starting_designs

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.mark.parametrize("name", ["hexapod-h1", "closed-loop"])
def test_script_and_program_agree(name: str) -> None:
    path = CONFIGS / f"{name}.yaml"
    # Central differences of leg lengths with steps of 1e-6 are good to about 1e-9.
    assert agreement(read_problem(path), OrdinaryScript(path)) < 1e-7


def test_leg_limits_agree() -> None:
    path = CONFIGS / "hexapod-h1.yaml"
    problem, script = read_problem(path), OrdinaryScript(path)
    vectors = starting_designs(problem, 10, np.random.default_rng(3))
    vectors[:, 2] = 0.02
    vectors[:, 3] = 0.15
    vectors[:, 4] = 0.15
    population = DesignPopulation(problem)
    excess = population.objectives(population.decisions(vectors))[1][:, 0]
    np.testing.assert_allclose(script.evaluate(vectors, return_values_of=["G"])[:, 0], excess, atol=1e-10)
    assert (excess > 0.0).any()
