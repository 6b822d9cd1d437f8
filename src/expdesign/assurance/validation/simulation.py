"""Many repetitions of experiment, identification and exact compensation (theory.md 8)."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import ExactCompensation
from expdesign.assurance.validation.geometry import GeometricPlant
from expdesign.assurance.validation.plants import ExplicitPlant, Plant
from expdesign.errors import ArgumentError
from expdesign.mechanics.elastostatics.measurements import Distribution, LoadedRobot
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem

_BATCH = 10_000
"""Repetitions that are computed at once, which bounds the memory."""


@dataclass(frozen=True)
class Repetitions:
    """Some of the repetitions: errors (s, t, n), estimates (s, n_p) and the residual as in `Simulation`."""

    errors: FloatArray
    estimates: FloatArray
    residual: float


@dataclass(frozen=True)
class Simulation:
    """What s repetitions attained at t targets, beside what theory predicts.

    Attributes:
        errors: attained minus wanted pose (m, rad), along the axes of the tolerances, shape (s, t, n).
        estimates: ĉ (m/N or rad/(N·m)), shape (s, n_p), or all parameters that are calibrated, shape (s, p).
        assessment: of the plan; its criteria are the prediction.
        noise: whether the readings had noise.
        load_errors: whether the loads had errors.
        residual: largest remaining error of the predicted pose at a command (m, rad).
    """

    errors: FloatArray
    estimates: FloatArray
    assessment: Assessment
    noise: bool
    load_errors: bool
    residual: float

    @property
    def predicted_covariance(self) -> FloatArray:
        """U and Z·Σ_F·Zᵀ, as far as their causes were drawn, shape (t, n, n)."""
        total = np.zeros((*self.errors.shape[1:], self.errors.shape[-1]))
        if self.noise:
            root = self.assessment.noise_root[0]
            total += root @ root.swapaxes(-1, -2)
        if self.load_errors:
            root = self.assessment.force_root[0]
            total += root @ root.swapaxes(-1, -2)
        return total


def simulate(
    problem: DesignProblem,
    plan: Plan,
    samples: int,
    seed: int,
    *,
    noise: bool = True,
    load_errors: bool = True,
    plant: type[Plant] = ExplicitPlant,
    distribution: Distribution = "normal",
    truth: LoadedRobot | None = None,
) -> Simulation:
    """Repeat the experiment of a plan `samples` times, identify, and compensate at every target.

    The true compliances are those of the robot file, or of the model that the robot was found to be; so are its
    effects. Every batch has a seed of its own, and noise and load errors have streams of their own: switching one off
    does not change the other.

    Args:
        problem: robot, noise, load errors and targets.
        plan: what is measured.
        samples: number of repetitions.
        seed: of all random numbers.
        noise: whether the readings have noise.
        load_errors: whether the loads have errors.
        plant: what is measured and commanded.
        distribution: of the load errors.
        truth: the robot that is really measured and commanded; the problem's own where left out.

    Raises:
        NotIdentifiableError: the plan does not identify what a target needs.
        ConvergenceError: a compensation has no command, or a robot does not come to rest.
    """
    drawn, every = (noise, load_errors), batch_sizes(samples)
    found = simulated(problem, plan, every, seed, *drawn, plant=plant, distribution=distribution, truth=truth)
    return joined(problem, plan, [found], *drawn)


def batch_sizes(samples: int) -> list[tuple[int, int]]:
    """Number and repetitions of every batch."""
    return [(number, min(_BATCH, samples - start)) for number, start in enumerate(range(0, samples, _BATCH))]


def joined(
    problem: DesignProblem, plan: Plan, batches: list[Repetitions], noise: bool, load_errors: bool
) -> Simulation:
    """The simulation whose repetitions are those of `batches`, in this order."""
    whole = (
        batches[0]
        if len(batches) == 1
        else Repetitions(
            np.concatenate([batch.errors for batch in batches]),
            np.concatenate([batch.estimates for batch in batches]),
            max(batch.residual for batch in batches),
        )
    )
    assessment = _assessed(problem, plan)
    return Simulation(whole.errors, whole.estimates, assessment, noise, load_errors, whole.residual)


def _assessed(problem: DesignProblem, plan: Plan) -> Assessment:
    """The plan's assessment; raises where it does not identify what a target needs."""
    assessment = problem.assess(plan.configurations[None], plan.loads[None], plan.series[None])
    error = problem.unidentified(assessment)
    if error is not None:
        raise error
    return assessment


def simulated(
    problem: DesignProblem,
    plan: Plan,
    batches: list[tuple[int, int]],
    seed: int,
    noise: bool,
    load_errors: bool,
    *,
    plant: type[Plant] = ExplicitPlant,
    distribution: Distribution = "normal",
    truth: LoadedRobot | None = None,
) -> Repetitions:
    """Some batches of `simulate`, given as in `batch_sizes`; the other arguments are the same."""
    assessment = _assessed(problem, plan)
    if not problem.loaded.regressor.referenced:
        _require_nominal(plant, truth)
        return _of_geometry(problem, plan, batches, (seed, noise, load_errors), assessment, distribution)
    robot = plant(truth or problem.loaded, plan)
    gain = assessment.gain[0].transpose(0, 2, 1).reshape(-1, len(robot.true))
    pairs = list(zip(problem.targets.configurations, problem.target_wrenches, strict=True))
    own_physics = any(one is not None and one.under_load is not None for one in (problem.loaded, truth))
    at_targets = problem.target_loads if own_physics else ((problem.loaded, None),) * len(pairs)
    compensations = [
        ExactCompensation(
            loaded, target, wrench, robot.true, parameters, None if truth is None else truth.under(loaded.load)
        )
        for (target, wrench), (loaded, parameters) in zip(pairs, at_targets, strict=True)
    ]
    # Estimates are corrections of the known compliances; where the model is linear in them their value cancels.
    model = robot if truth is None else plant(problem.loaded, plan)
    known, origin = model.true, model.model().reshape(-1)
    if problem.loaded.under_load is None:
        known, origin = np.zeros_like(known), np.zeros_like(origin)
    samples = sum(count for _, count in batches)
    errors = np.empty((samples, len(pairs), problem.loaded.robot.coordinates.n))
    estimates = np.empty((samples, len(robot.true)))
    residual, axes, start = 0.0, problem.targets.axes, 0
    for number, count in batches:
        rows = slice(start, start + count)
        start += count
        readings = _readings(problem, plan, robot, count, (seed, number), noise, load_errors, distribution)
        estimates[rows] = known + (readings.reshape(count, -1) - origin) @ gain
        for index, (compensation, (target, wrench)) in enumerate(zip(compensations, pairs, strict=True)):
            attained = compensation.attained(estimates[rows])
            found = robot.errors(attained, target, wrench)
            errors[rows, index] = found if axes is None else found @ axes[index].T
            residual = max(residual, attained.residual)
    return Repetitions(errors, estimates, residual)


def _require_nominal(plant: type[Plant], truth: LoadedRobot | None) -> None:
    """Raise where a plant or a truth is asked for that geometric calibrations are not repeated with."""
    if plant is not ExplicitPlant:
        what = f"a geometric calibration is repeated with non-linear kinematics, not with the plant `{plant.name}`"
        raise ArgumentError(what, argument="plant", remedy="Leave it out.")
    if truth is not None:
        what = "a geometric calibration is repeated with the robot of the configuration"
        raise ArgumentError(what, argument="truth", remedy="Use `simulate` and `identify` for single experiments.")


def _of_geometry(
    problem: DesignProblem,
    plan: Plan,
    batches: list[tuple[int, int]],
    how: tuple[int, bool, bool],
    assessment: Assessment,
    distribution: Distribution,
) -> Repetitions:
    """The same for a calibration of the geometry, alone or with the stiffness; `how`: seed, noise, load errors."""
    seed, noise, load_errors = how
    machine, axes = GeometricPlant(problem, plan), problem.targets.axes
    gain = assessment.gain[0].transpose(0, 2, 1).reshape(-1, assessment.parameters)
    samples = sum(count for _, count in batches)
    errors = np.empty((samples, *problem.targets.importance.shape))
    estimates = np.empty((samples, assessment.parameters))
    residual, start = 0.0, 0
    for batch, count in batches:
        rows = slice(start, start + count)
        start += count
        readings = _readings(problem, plan, machine, count, (seed, batch), noise, load_errors, distribution)
        estimates[rows] = readings.reshape(count, -1) @ gain
        pairs = zip(problem.targets.configurations, problem.target_wrenches, strict=True)
        for index, (target, wrench) in enumerate(pairs):
            found, step = machine.attained(estimates[rows], target, wrench)
            errors[rows, index] = found if axes is None else found @ axes[index].T
            residual = max(residual, step)
    nominal = problem.loaded.regressor.nominal(problem.loaded.robot)
    return Repetitions(errors, nominal + estimates, residual)


def _readings(
    problem: DesignProblem,
    plan: Plan,
    plant: Plant | GeometricPlant,
    count: int,
    seeds: tuple[int, int],
    noise: bool,
    load_errors: bool,
    distribution: Distribution,
) -> FloatArray:
    """Measured deflections of `count` repetitions, or what is wrong with measured poses, shape (count, m, n)."""
    if load_errors and problem.loaded.sources:
        generator = np.random.default_rng([*seeds, 1])
        where = (plan.configurations, plan.loads)
        added = problem.loaded.drawn_errors(*where, count, generator, distribution)
        readings = plant.deflections(added)
    else:
        # The deflections without errors are those of every repetition.
        nothing = np.zeros((1, len(plan), problem.loaded.robot.coordinates.n))
        readings = np.repeat(plant.deflections(nothing), count, axis=0)
    if noise:
        pose_map = problem.loaded.robot.jacobians(plan.configurations).pose
        drawn = problem.noise.drawn(plan.series, count, np.random.default_rng([*seeds, 2]), pose_map)
        readings[..., problem.noise.axes] += drawn
    return readings
