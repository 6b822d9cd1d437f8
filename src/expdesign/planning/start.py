"""The first designs of a search: drawn at random from the measurements that the robot can reach."""

import numpy as np
from scipy.optimize import minimize

from expdesign.arrays import BoolArray, FloatArray
from expdesign.errors import InfeasibleError, NotIdentifiableError
from expdesign.mechanics.robots.robot import CONDITION_LIMIT
from expdesign.planning.problem import DesignProblem

_BATCH = 2000
_BATCHES = 25


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
        kept = decisions[_reached(problem, decisions)]
        found.append(kept)
        total += len(kept)
        if total >= count:
            break
    if total == 0:
        found = [_descend(problem, generator)]
        if (
            problem.constraints is not None
            and not problem.constraints.allowed(problem.loaded, *space.decode(found[0])).all()
        ):
            what = "no measurement was found that `experiment.constraints` allows"
            raise InfeasibleError(what, where=problem.source, remedy="Move the boxes, or use lighter loads.")
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
    return np.where(space.of_pose & ~_reached(problem, found)[:, None], drawn, found)


def _reached(problem: DesignProblem, decisions: FloatArray) -> BoolArray:
    """Which measurements (b, g) can be taken."""
    poses, loads = problem.space.decode(decisions)
    usable: BoolArray = problem.loaded.robot.usable(poses)
    if problem.constraints is not None:
        usable &= problem.constraints.allowed(problem.loaded, poses, loads)
    return usable


def starting_designs(problem: DesignProblem, count: int, generator: np.random.Generator) -> FloatArray:
    """Gene vectors (count, m·g) of designs whose every measurement can be reached."""
    space = problem.space
    decisions = reachable_measurements(problem, count * space.measurements, generator)
    designs = space.canonical(decisions.reshape(count, space.measurements, space.decisions))
    return designs.reshape(count, -1)


def require_identifiable(problem: DesignProblem, decisions: FloatArray) -> float:
    """Share of random designs (b, m, g) that identify what the targets need.

    Raises:
        NotIdentifiableError: none does, and either all their measurements together do not, or the variables are
            continuous, so that random designs are as good as any in this respect.
    """
    configurations, loads = problem.space.decode(decisions)
    assessment = problem.assessed(decisions)
    share = float(assessment.identifies_targets.mean())
    if share > 0.0:
        return share
    flat = configurations.reshape(1, -1, configurations.shape[-1]), loads.reshape(1, -1, loads.shape[-1])
    together = problem.assess(*flat, np.arange(1, flat[0].shape[1] + 1)[None])
    for candidate, count in ((together, together.count), (assessment, assessment.count)):
        error = problem.unidentified(candidate)
        if error is not None and (candidate is together or not problem.space.choices.any()):
            what = f"no design can serve the targets; with {count} measurements tried, {error.what}"
            raise NotIdentifiableError(what, where=problem.source, remedy=error.remedy)
    return share


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
