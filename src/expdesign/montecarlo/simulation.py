"""Many repetitions of experiment, identification and exact compensation (theory.md 8)."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.criteria.assessment import Assessment
from expdesign.design.plan import Plan
from expdesign.design.problem import DesignProblem
from expdesign.montecarlo.compensation import ExactCompensation
from expdesign.montecarlo.draws import Distribution, drawn_load_errors, drawn_noise

_BATCH = 10_000


@dataclass(frozen=True)
class Simulation:
    """What s repetitions attained at t targets, beside what theory predicts.

    Attributes:
        errors: attained minus wanted pose (m, rad), shape (s, t, n).
        estimates: ĉ (m/N or rad/(N·m)), shape (s, n_p).
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
    distribution: Distribution = "normal",
) -> Simulation:
    """Repeat the experiment of a plan `samples` times with the explicit plant (P1) and compensate at every target.

    The true compliances are those of the robot file. Batches have seeds of their own, so that the first repetitions of
    a longer simulation are those of a shorter one.

    Raises:
        NotIdentifiableError: the plan does not identify what a target needs.
        ConvergenceError: a compensation has no command.
    """
    problem.require_elastostatic("experiments can be repeated")
    assessment = problem.assess(plan.configurations[None], plan.loads[None], plan.series[None])
    error = problem.unidentified(assessment)
    if error is not None:
        raise error
    robot = problem.loaded.robot
    true = robot.compliance
    measurements = problem.loaded.measure(plan.configurations, plan.loads)
    nominal = measurements.observation @ true
    gain = assessment.gain[0].transpose(0, 2, 1).reshape(-1, len(true))
    errors = np.empty((samples, *problem.targets.configurations.shape))
    estimates = np.empty((samples, len(true)))
    for start in range(0, samples, _BATCH):
        count = min(_BATCH, samples - start)
        generator = np.random.default_rng([seed, start // _BATCH])
        deflections = np.broadcast_to(nominal, (count, *nominal.shape)).copy()
        if load_errors and problem.loaded.sources:
            added = drawn_load_errors(problem.loaded, plan, count, generator, distribution)
            deflections += (measurements.compliance @ added[..., None])[..., 0]
        if noise:
            deflections[..., problem.noise.axes] += drawn_noise(
                problem.noise, plan.series, count, generator, measurements.pose_map
            )
        estimates[start : start + count] = deflections.reshape(count, -1) @ gain
    residual = 0.0
    pairs = zip(problem.targets.configurations, problem.target_wrenches, strict=True)
    for index, (target, wrench) in enumerate(pairs):
        attained = ExactCompensation(robot, target, wrench, true).attained(estimates)
        errors[:, index] = attained.errors
        residual = max(residual, attained.residual)
    return Simulation(errors, estimates, assessment, noise, load_errors, residual)
