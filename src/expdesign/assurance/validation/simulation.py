"""Many repetitions of experiment, identification and exact compensation (theory.md 8)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import Attained, ExactCompensation
from expdesign.assurance.validation.geometry import GeometricPlant
from expdesign.errors import ArgumentError
from expdesign.mechanics.elastostatics.measurements import Distribution, LoadedRobot
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem

_BATCH = 10_000
"""Repetitions that are computed at once, which bounds the memory."""
BatchSize = tuple[int, int]
"""Number of a batch and how many repetitions it has."""
Attain = Callable[[FloatArray], tuple[FloatArray, float]]
"""Attained minus wanted pose (s, n) of estimates (s, p) at one target, and the residual as in `Repetitions`."""


@dataclass(frozen=True)
class Repetitions:
    """What s repetitions attained at t targets.

    Attributes:
        errors: attained minus wanted pose (m, rad), along the axes of the tolerances, shape (s, t, n).
        estimates: ĉ (m/N or rad/(N·m)), shape (s, n_p), or all parameters that are calibrated, shape (s, p).
        residual: largest remaining error of the predicted pose at a command (m, rad).
    """

    errors: FloatArray
    estimates: FloatArray
    residual: float

    def squares(self, targets: Targets) -> FloatArray:
        """(error / tolerance)² of every repetition (s,): the mean over targets, or that of the worst target."""
        per_target: FloatArray = (self.errors**2 * targets.importance).sum(axis=-1)
        if targets.aggregate == "max":
            return per_target[:, int(np.argmax(per_target.mean(axis=0)))]
        return per_target @ targets.weights / targets.weights.sum()


@dataclass(frozen=True)
class Simulation(Repetitions):
    """The same beside what theory predicts.

    Attributes:
        assessment: of the plan; its criteria are the prediction.
        noise: whether the readings had noise.
        load_errors: whether the loads had errors.
    """

    assessment: Assessment
    noise: bool
    load_errors: bool

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


class ExplicitPlant:
    """P1: X_loaded = X_cmd + A(X_cmd, ΔF)·c, the mapping on which identification and compensation rest.

    Args:
        loaded: the robot with its true compliances.
        plan: what is measured.
    """

    def __init__(self, loaded: LoadedRobot, plan: Plan) -> None:
        self.loaded, self.plan, self.true = loaded, plan, loaded.robot.compliance

    def deflections(self, added: FloatArray) -> FloatArray:
        """Deflections (s, m, n) under the assumed loads and added wrenches (s, m, n)."""
        return self.loaded.deflections(self.plan.configurations, self.plan.loads, added)

    def errors(self, attained: Attained, target: FloatArray, wrench: FloatArray) -> FloatArray:
        """Attained minus wanted pose (s, n) of commands at a target (n,) under a wrench (n,)."""
        return attained.errors


def simulate(
    problem: DesignProblem,
    plan: Plan,
    samples: int,
    seed: int,
    *,
    noise: bool = True,
    load_errors: bool = True,
    plant: type[ExplicitPlant] = ExplicitPlant,
    distribution: Distribution = "normal",
) -> Simulation:
    """Repeat the experiment of a plan `samples` times, identify, and compensate at every target.

    Args:
        problem: robot, noise, load errors and targets.
        plan: what is measured.
        samples: number of repetitions.
        seed: of all random numbers.
        noise: whether the readings have noise.
        load_errors: whether the loads have errors.
        plant: what is measured and commanded.
        distribution: of the load errors.

    Raises:
        NotIdentifiableError: the plan does not identify what a target needs.
        ConvergenceError: a compensation has no command, or a robot does not come to rest.
    """
    experiment, drawn = VirtualExperiment(problem, plan, plant, distribution), (noise, load_errors)
    return experiment.joined([experiment.batch(size, seed, *drawn) for size in batch_sizes(samples)], *drawn)


def batch_sizes(samples: int) -> list[BatchSize]:
    """Number and repetitions of every batch."""
    return [(number, min(_BATCH, samples - start)) for number, start in enumerate(range(0, samples, _BATCH))]


class VirtualExperiment:
    """The experiment of a plan, to be repeated.

    The true compliances are those of the robot file, or of the model that the robot was found to be; so are its
    effects. Every batch has a seed of its own, and noise and load errors have streams of their own: switching one off
    does not change the other.

    Args:
        problem: robot, noise, load errors and targets.
        plan: what is measured.
        plant: what is measured and commanded.
        distribution: of the load errors.
        truth: the robot that is really measured and commanded; the problem's own where left out.

    Raises:
        NotIdentifiableError: the plan does not identify what a target needs.
        ArgumentError: the truth does not suit what is calibrated.
    """

    def __init__(
        self,
        problem: DesignProblem,
        plan: Plan,
        plant: type[ExplicitPlant] = ExplicitPlant,
        distribution: Distribution = "normal",
        truth: LoadedRobot | None = None,
    ) -> None:
        self.problem = problem
        self.plan = plan
        self.distribution = distribution
        self.assessment = problem.assess(plan.configurations[None], plan.loads[None], plan.series[None])
        error = problem.unidentified(self.assessment)
        if error is not None:
            raise error
        # Estimates are corrections of known parameters, by readings less those that are expected of these.
        self._known = problem.loaded.regressor.nominal(problem.loaded.robot)
        self._nothing: FloatArray = np.zeros((1, len(plan), problem.loaded.robot.coordinates.n))
        self._expected: FloatArray = self._nothing
        if problem.loaded.regressor.referenced:
            self._attain = self._elastic(plant, truth)
        else:
            _require_nominal(truth)
            self._attain = self._geometric()

    @property
    def _targets(self) -> list[tuple[FloatArray, FloatArray]]:
        return list(zip(self.problem.targets.configurations, self.problem.target_wrenches, strict=True))

    def _elastic(self, plant: type[ExplicitPlant], truth: LoadedRobot | None) -> list[Attain]:
        """Set what is measured, and return what estimates of compliances attain at every target."""
        problem = self.problem
        robot = plant(truth or problem.loaded, self.plan)
        self._deflections = robot.deflections
        self._expected = problem.loaded.deflections(self.plan.configurations, self.plan.loads, self._nothing)
        own_physics = any(one is not None and one.under_load is not None for one in (problem.loaded, truth))
        at_targets = problem.target_loads if own_physics else ((problem.loaded, None),) * len(self._targets)

        def attaining(place: tuple[FloatArray, FloatArray], known: LoadedRobot, load: FloatArray | None) -> Attain:
            real = None if truth is None else truth.under(known.load)
            compensation = ExactCompensation(known, *place, robot.true, load, real)

            def attain(estimates: FloatArray) -> tuple[FloatArray, float]:
                attained = compensation.attained(estimates)
                return robot.errors(attained, *place), attained.residual

            return attain

        return [attaining(place, *known) for place, known in zip(self._targets, at_targets, strict=True)]

    def _geometric(self) -> list[Attain]:
        """The same of estimates of the geometry, alone or with the stiffness; readings are what is wrong with poses."""
        machine = GeometricPlant(self.problem, self.plan)
        self._deflections = machine.deflections
        return [partial(machine.attained, target=target, wrench=wrench) for target, wrench in self._targets]

    def batch(self, size: BatchSize, seed: int, noise: bool, load_errors: bool) -> Repetitions:
        """One batch; whether noise and load errors are drawn.

        Raises:
            ConvergenceError: a compensation has no command, or a robot does not come to rest.
        """
        number, count = size
        gain = self.assessment.gain[0].transpose(0, 2, 1).reshape(-1, self.assessment.parameters)
        readings = self._readings(count, (seed, number), noise, load_errors) - self._expected
        estimates = self._known + readings.reshape(count, -1) @ gain
        axes = self.problem.targets.axes
        errors = np.empty((count, *self.problem.targets.importance.shape))
        residual = 0.0
        for index, attain in enumerate(self._attain):
            found, left = attain(estimates)
            errors[:, index] = found if axes is None else found @ axes[index].T
            residual = max(residual, left)
        return Repetitions(errors, estimates, residual)

    def joined(self, batches: Sequence[Repetitions], noise: bool, load_errors: bool) -> Simulation:
        """The simulation whose repetitions are those of `batches`, in this order."""
        errors, estimates = (
            np.concatenate(parts) if len(parts) > 1 else parts[0]
            for parts in ([one.errors for one in batches], [one.estimates for one in batches])
        )
        residual = max(one.residual for one in batches)
        return Simulation(errors, estimates, residual, self.assessment, noise, load_errors)

    def _readings(self, count: int, seeds: tuple[int, int], noise: bool, load_errors: bool) -> FloatArray:
        """Measured deflections of `count` repetitions, or what is wrong with measured poses, shape (count, m, n)."""
        problem, plan = self.problem, self.plan
        if load_errors and problem.loaded.sources:
            generator = np.random.default_rng([*seeds, 1])
            where = (plan.configurations, plan.loads)
            added = problem.loaded.drawn_errors(*where, count, generator, self.distribution)
            readings = self._deflections(added)
        else:
            # The deflections without errors are those of every repetition.
            readings = np.repeat(self._deflections(self._nothing), count, axis=0)
        if noise:
            pose_map = problem.loaded.robot.jacobians(plan.configurations).pose
            drawn = problem.noise.drawn(plan.series, count, np.random.default_rng([*seeds, 2]), pose_map)
            readings[..., problem.noise.axes] += drawn
        return readings


def _require_nominal(truth: LoadedRobot | None) -> None:
    """Raise where a truth is asked for, which geometric calibrations are not repeated with."""
    if truth is not None:
        what = "a geometric calibration is repeated with the robot of the configuration"
        raise ArgumentError(what, argument="truth", remedy="Use `simulate` and `identify` for single experiments.")
