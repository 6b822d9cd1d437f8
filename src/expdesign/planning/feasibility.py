"""How much of what a configuration allows can be reached, and how much of it identifies what the targets need."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.problem import DesignProblem
from expdesign.planning.start import require_identifiable, starting_designs

DESIGNS = 100
"""Random designs on which identifiability is tested."""
POSES = 2000
"""Random poses on which the robot's limits are tested."""


@dataclass(frozen=True)
class Feasibility:
    """Shares of random samples of the design space.

    Attributes:
        reachable: share of poses within the robot's limits and those of `experiment.constraints`, and away from
            singularities.
        identifying: share of designs of reachable measurements that identify what the targets need.
    """

    reachable: float
    identifying: float


def random_designs(problem: DesignProblem) -> FloatArray:
    """`DESIGNS` designs whose every measurement can be reached, by the configuration's seed, shape (b, m, g)."""
    generator = np.random.default_rng(problem.optimiser.seed)
    space = problem.space
    return starting_designs(problem, DESIGNS, generator).reshape(DESIGNS, space.measurements, space.decisions)


def feasibility(problem: DesignProblem) -> Feasibility:
    """Sample the design space.

    Raises:
        InfeasibleError: no pose can be reached.
        NotIdentifiableError: no design identifies what the targets need.
    """
    identifying = require_identifiable(problem, random_designs(problem))
    generator = np.random.default_rng(problem.optimiser.seed)
    reached = problem.reachable(problem.space.sample(POSES, generator))
    return Feasibility(float(reached.mean()), identifying)
