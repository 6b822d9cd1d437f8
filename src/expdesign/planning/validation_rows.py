"""Rows of a plan that are kept for validation (`split: test`): far from those that are fitted, and from each other.

They are chosen by the maximin distance (Johnson, Moore & Ylvisaker, J. Stat. Plan. Inference 26 (1990) 131), greedily,
out of measurements within all limits: each further one is the farthest from all before it, poses and loads alike scaled
to their ranges. Criteria do not see them.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.problem import DesignProblem
from expdesign.planning.start import reachable_measurements

_POOL = 400


def validation_decisions(problem: DesignProblem, decisions: FloatArray) -> FloatArray:
    """Genes (v, g) of the rows for validation of a design (m, g); the same design and seed give the same rows."""
    space = problem.space.alone()
    if problem.validation == 0 or space.decisions == 0:
        return (
            np.zeros((0, space.decisions))
            if problem.validation == 0
            else np.repeat(decisions[:1], problem.validation, 0)
        )
    generator = np.random.default_rng([problem.optimiser.seed, 2])
    pool = reachable_measurements(problem, _POOL, generator)
    robot = problem.loaded.robot
    pool = space.settable(pool[:, None], robot.limit_excess)[:, 0]
    poses, loads = space.decode(pool)
    allowed = robot.usable(poses)
    if problem.constraints is not None:
        allowed &= problem.constraints.allowed(problem.loaded, poses, loads)
    pool = pool[allowed]
    span = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
    distance = np.linalg.norm((pool[:, None] - decisions[None]) / span, axis=-1).min(axis=1)
    chosen: list[int] = []
    for _ in range(problem.validation):
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm((pool - pool[chosen[-1]]) / span, axis=-1))
    return pool[chosen]
