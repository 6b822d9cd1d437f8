"""The first designs of a search: drawn at random from the measurements that the robot can reach, rounded from the
convex relaxation's optimal weights (theory.md 10.1, 10.4), of every structure that a budget allows, or all that there
are where the space is small enough; and how much of what a configuration allows can be reached and identifies enough.

The relaxation is solved for DUIR² + s²·FEIR² with a ladder of factors s, so that the designs lie along the whole front.
The roundings are improved by exchanging measurements, which finds better plans than gradients do from the roundings.
"""

from dataclasses import dataclass
from itertools import combinations_with_replacement
from math import comb

import numpy as np
from scipy.optimize import minimize

from expdesign.arrays import FloatArray
from expdesign.errors import InfeasibleError, NotIdentifiableError
from expdesign.mechanics.robots.robot import CONDITION_LIMIT
from expdesign.planning.front import non_dominated
from expdesign.planning.optimality.certificate import Certificate
from expdesign.planning.optimality.exchange import Exchange, rounded
from expdesign.planning.optimality.pool import BRIEF
from expdesign.planning.options import START
from expdesign.planning.problem import DesignProblem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.scalarisation import Aims


def reachable_measurements(problem: DesignProblem, count: int, generator: np.random.Generator) -> FloatArray:
    """Genes (count, g) of measurements within the robot's limits and away from singularities.

    Raises:
        InfeasibleError: none was found by sampling and by descending from the best samples; says which limit is in
            the way.
    """
    space = problem.space
    found: list[FloatArray] = []
    total = 0
    for _ in range(START.batches):
        decisions = space.sample(START.batch, generator)
        kept = decisions[problem.reachable(decisions)]
        found.append(kept)
        total += len(kept)
        if total >= count:
            break
    if total == 0:
        found = [_descend(problem, generator)]
        if problem.constraints is not None and not problem.reachable(found[0]).all():
            tried = space.sample(START.batch, generator)
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
    """Gene vectors (count, m·g) of designs whose every measurement can be reached.

    Where it counts how often poses are set, each has a number of them at random, from one to all.
    """
    space, m = problem.space, problem.space.measurements
    designs = reachable_measurements(problem, count * m, generator).reshape(count, m, space.decisions)
    if space.settings is not None:
        poses = generator.integers(1, m + 1, size=(count, 1))
        of = generator.integers(m, size=(count, m)) % poses
        designs = np.where(space.of_pose, np.take_along_axis(designs, of[..., None], axis=1), designs)
    return space.canonical(designs).reshape(count, -1)


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

    samples = space.sample(START.batch, generator)
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


def relaxed_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) rounded from optimal weights, the best few of many roundings for each factor."""
    space, (rounds, draws, kept) = problem.space, problem.optimiser.roundings
    found: list[FloatArray] = []
    known: FloatArray | None = None  # as designs of one measurement each
    # Where variables can be refined afterwards a short list will do.
    listed = START.listed[0] if (~space.discrete).any() else START.listed[1]
    for factor in START.ladder if problem.loaded.sources else START.ladder[:1]:
        certificate = Certificate(problem, factor, BRIEF, tolerance=1e-3)
        refined = list(certificate.refine(known, rounds))
        if not refined:
            break
        last = refined[-1]
        known = last.shortlist[last.weights > 0.0][:, None]
        generator = np.random.default_rng([problem.optimiser.seed, int(100 * factor)])
        exchange = Exchange(problem, ("total",), factor)
        plans = rounded(last.weights[:listed], space.measurements, draws, generator)
        designs = last.shortlist[np.unique(np.sort(plans, axis=1), axis=0)]
        best = np.argsort(exchange.scores(designs, _total(len(designs))), kind="stable")[:kept]
        better = exchange.singles(designs[best], _total(len(best)), last.shortlist[:listed])
        # Rounding to what can be set must not take a measurement at the robot's limits beyond them.
        found.append(problem.settable(np.concatenate([designs[best], better])))
    return np.concatenate(found) if found else np.zeros((0, space.measurements, space.decisions))


def repeated_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) of one or two measurements, repeated, with the least FEIR and `total` of those drawn.

    Load errors of their own in every measurement average out over repetitions, so that such plans are the best towards
    FEIR's end, and among designs at random there are none.
    """
    space = problem.space
    if not problem.loaded.sources or problem.budget is not None or problem.constraints is not None:
        return np.zeros((0, space.measurements, space.decisions))
    generator = np.random.default_rng([problem.optimiser.seed, 2])
    number, paired, kept = START.repeated
    drawn = extreme_measurements(problem, number, 0.5, generator)
    aims = Aims(np.zeros((2, 2)), np.eye(2))
    return problem.settable(Exchange(problem, ("feir", "total")).repeated(drawn, aims, kept, paired)[0])


def structured_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) of every structure that a budget allows: the most measurements at each number of settings, the
    best few of those drawn, at better poses and after exchanges of their measurements. Exchanges of a plan with another
    structure hardly ever come to them.
    """
    space, budget, settings = problem.space, problem.budget, problem.space.settings
    m = space.measurements
    found: list[FloatArray] = [np.zeros((0, m, space.decisions))]
    if budget is None or settings is None:
        return found[0]
    generator, exchange = np.random.default_rng([problem.optimiser.seed, 3]), Exchange(problem, ("total",))
    number, kept = START.structured
    offered = extreme_measurements(problem, 2 * number, 0.5, generator)
    counts = np.arange(1, m + 1)
    for poses in range(1, min(m, budget.poses or m) + 1):
        fit = counts[(budget.minutes_of(counts, poses) <= budget.minutes) & (counts >= poses)]
        if not fit.size:
            break
        drawn = extreme_measurements(problem, number * m, 0.5, generator).reshape(number, m, -1)
        designs = np.where(space.of_pose, drawn[:, np.arange(m) % poses], drawn)
        designs[..., settings.gene] = np.where(np.arange(m) < fit.max(), settings.first, 0.0)
        designs = problem.settable(designs)
        best = designs[np.argsort(exchange.scores(designs, _total(number)), kind="stable")[:kept]]
        best = exchange.moved(best, _total(len(best)), offered)
        found.append(problem.settable(exchange.singles(best, _total(len(best)), offered)))
    return np.concatenate(found)


def _total(count: int) -> Aims:
    return Aims(np.zeros((count, 1)), np.ones((count, 1)))


def every_design(problem: DesignProblem) -> FloatArray | None:
    """The designs (d, m, g) that no other one dominates, in a space of finitely many; None where they are too many."""
    space = problem.space
    if (
        not space.discrete.all()
        or (space.settings is not None and space.settings.budget is not None)
        or space.required.poses
        or space.required.masses
    ):
        return None
    levels = [int(high) + 1 for high in space.upper]
    count, m = int(np.prod(levels, dtype=np.float64)), space.measurements
    if comb(count + m - 1, m) > problem.optimiser.enumerable:
        return None
    axes = np.meshgrid(*(np.arange(number, dtype=float) for number in levels), indexing="ij")
    measurements = np.stack([axis.ravel() for axis in axes], axis=1)
    measurements = measurements[problem.loaded.robot.usable(space.decode(measurements)[0])]
    plans = np.array(list(combinations_with_replacement(range(len(measurements)), m)), dtype=np.int64)
    population, best = DesignPopulation(problem), np.zeros((0, m, space.decisions))
    for start in range(0, len(plans), START.together):
        listed = np.unique(space.canonical(measurements[plans[start : start + START.together]]), axis=0)
        designs = np.concatenate([best, listed])
        values, violations = population.objectives(designs)
        feasible = (violations <= 0.0).all(axis=1)
        designs, values = designs[feasible], values[feasible]
        best = designs[non_dominated(values)] if len(designs) else best
    return best


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
    """Designs whose every measurement can be reached, by the configuration's seed, shape (b, m, g)."""
    generator = np.random.default_rng(problem.optimiser.seed)
    space = problem.space
    return starting_designs(problem, START.tested, generator).reshape(START.tested, space.measurements, space.decisions)


def feasibility(problem: DesignProblem) -> Feasibility:
    """Sample the design space.

    Raises:
        InfeasibleError: no pose can be reached.
        NotIdentifiableError: no design identifies what the targets need.
    """
    identifying = require_identifiable(problem, random_designs(problem))
    generator = np.random.default_rng(problem.optimiser.seed)
    reached = problem.reachable(problem.space.sample(START.batch, generator))
    return Feasibility(float(reached.mean()), identifying)
