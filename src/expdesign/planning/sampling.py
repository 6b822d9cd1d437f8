"""Measurements and designs at random, within what the robot can reach; how much of what a configuration allows can be
reached, and identifies enough.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from expdesign.arrays import FloatArray
from expdesign.counted import counted
from expdesign.errors import InfeasibleError, NotIdentifiableError
from expdesign.mechanics.robots.robot import CONDITION_LIMIT
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.problem import DesignProblem

_BATCH, _BATCHES = 2000, 25
"""Measurements drawn at a time, and how often at most until none is known that can be reached."""
_TESTED, _TESTED_MEASUREMENTS = 100, 20_000
"""Random designs on which identifiability is tested."""


def reachable_measurements(problem: DesignProblem, count: int, generator: np.random.Generator) -> FloatArray:
    """Genes (count, g) of measurements within the robot's limits and away from singularities.

    Raises:
        InfeasibleError: none was found by sampling and by descending from the best samples; says which limit is in
            the way.
    """
    space = problem.space
    found: list[FloatArray] = []
    total = 0
    for _ in range(_BATCHES):
        decisions = space.sample(_BATCH, generator)
        kept = decisions[problem.reachable(decisions)]
        found.append(kept)
        total += len(kept)
        if total >= count:
            break
    if total == 0:
        found = [_descend(problem, generator)]
        if problem.constraints is not None and not problem.reachable(found[0]).all():
            tried = space.sample(_BATCH, generator)
            tried = tried[problem.loaded.robot.usable(space.decode(tried)[0])]
            tried = tried if len(tried) else found[0]
            binding = problem.constraints.binding(problem.loaded, *space.decode(tried))
            what = f"no measurement was found that `experiment.constraints` allows; broken is {binding}"
            raise InfeasibleError(what, where=problem.source, remedy="Widen the poses, or what is named there.")
    pool = np.concatenate(found)
    return pool[generator.integers(len(pool), size=count)] if len(pool) < count else pool[:count]


def extreme_measurements(
    problem: DesignProblem, count: int, share: float, generator: np.random.Generator
) -> FloatArray:
    """Reachable measurements (count, g) with a share of their continuous variables at ends of the ranges, as what a
    measurement tells is largest there; those of the pose where it is still reached.
    """
    space, drawn = problem.space, reachable_measurements(problem, count, generator)
    ends = np.where(generator.random(drawn.shape) < 0.5, space.lower, space.upper)
    moved = ~space.discrete & (generator.random(drawn.shape) < share)
    found = np.where(moved, ends, drawn)
    return np.where(space.of_pose & ~problem.reachable(found)[:, None], drawn, found)


def starting_designs(problem: DesignProblem, count: int, generator: np.random.Generator) -> FloatArray:
    """Designs (count, m, g) whose every measurement can be reached.

    Where it counts how often poses are set, each has a number of them at random, from as few as may be to all.
    """
    space, m = problem.space, problem.space.measurements
    designs = reachable_measurements(problem, count * m, generator).reshape(count, m, space.decisions)
    if space.settings is not None:
        fewest = 0 if problem.constraints is None else problem.constraints.distinct_poses
        poses = generator.integers(max(fewest, 1), m + 1, size=(count, 1))
        of = generator.integers(m, size=(count, m)) % poses
        of[:, :fewest] = np.arange(fewest)
        designs = np.where(space.of_pose, np.take_along_axis(designs, of[..., None], axis=1), designs)
    return space.canonical(designs)


def require_identifiable(problem: DesignProblem, decisions: FloatArray) -> float:
    """Share of random designs (b, m, g) that identify what the targets need.

    Raises:
        NotIdentifiableError: none does, and either they have fewer readings than what the targets depend on, or all
            their measurements together do not, or the variables are continuous, so that random designs are as good
            as any in this respect.
    """
    configurations, loads = problem.space.decode(decisions)
    assessment = problem.assessed(decisions)
    share = float(assessment.identifies_targets.mean())
    if share > 0.0:
        return share
    _require_enough_readings(problem, assessment)
    flat = configurations.reshape(1, -1, configurations.shape[-1]), loads.reshape(1, -1, loads.shape[-1])
    together = problem.assess(*flat, np.arange(1, flat[0].shape[1] + 1)[None])
    for candidate, count in ((together, together.count), (assessment, assessment.count)):
        error = problem.unidentified(candidate)
        if error is not None and (candidate is together or not problem.space.choices.any()):
            what = f"no design can serve the targets; with {count} measurements tried, {error.what}"
            raise NotIdentifiableError(what, where=problem.source, remedy=error.remedy)
    return share


def _require_enough_readings(problem: DesignProblem, assessment: Assessment) -> None:
    """Raise where the measurements of a design have fewer readings than what the targets depend on has dimensions: no
    choice of poses and loads helps.
    """
    if problem.known is not None:
        return
    targets, each = problem.targets, len(problem.noise.axes)
    needed = int(np.linalg.matrix_rank(targets.observation[targets.importance > 0.0]))
    least = -(-needed // each)
    if assessment.count < least:
        noun = problem.loaded.regressor.noun
        what = (
            f"at least {least} measurements are needed: the targets depend on {needed} combinations of the {noun}, and "
            f"{counted(assessment.count, 'measurement')} with {counted(each, 'measured axis', 'measured axes')} "
            f"{'has' if assessment.count == 1 else 'have'} {counted(assessment.count * each, 'reading')}"
        )
        remedy = "Raise `experiment.measurements`, or state the noise of further axes that are measured."
        raise NotIdentifiableError(what, where=problem.source, remedy=remedy)


def _descend(problem: DesignProblem, generator: np.random.Generator) -> FloatArray:
    """One reachable measurement (1, g), sought by minimising the excess over the limits."""
    space, robot = problem.space, problem.loaded.robot

    def excess(decisions: FloatArray) -> float:
        poses = space.decode(decisions)[0]
        condition = float(robot.jacobians(poses).condition)
        beyond = max(0.0, np.log10(min(condition, 1e300) / CONDITION_LIMIT))
        return max(float(robot.limit_excess(poses)), 0.0) + beyond

    samples = space.sample(_BATCH, generator)
    scores = np.array([excess(sample) for sample in samples])
    best = samples[np.argsort(scores, kind="stable")[:5]]
    bounds = list(zip(space.lower, space.upper, strict=True))
    for start in best:
        if not space.choices.any() and space.decisions:
            result = minimize(excess, start, method="Nelder-Mead", bounds=bounds, options={"maxiter": 2000})
            start[:] = result.x
        if bool(robot.usable(space.decode(start)[0])):
            return start[None, :]
    pose = space.decode(best[int(np.argmin([excess(decisions) for decisions in best]))])[0]
    if float(robot.limit_excess(pose)) > 0.0:
        nearest = robot.limit_message(pose)
        what = f"no pose in `experiment.poses` is within the robot's limits; at the nearest one found {nearest}"
    else:
        what = "the robot is singular, or nearly so, at every pose in `experiment.poses`"
    raise InfeasibleError(what, where=problem.source, remedy="Widen the poses, or correct the robot file.")


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


def feasibility(problem: DesignProblem) -> Feasibility:
    """Sample the design space.

    Raises:
        InfeasibleError: no pose can be reached.
        NotIdentifiableError: no design identifies what the targets need.
    """
    count = min(_TESTED, max(2, _TESTED_MEASUREMENTS // problem.space.measurements))
    designs = starting_designs(problem, count, np.random.default_rng(problem.optimiser.seed))
    identifying = require_identifiable(problem, designs)
    generator = np.random.default_rng(problem.optimiser.seed)
    reached = problem.reachable(problem.space.sample(_BATCH, generator))
    return Feasibility(float(reached.mean()), identifying)
