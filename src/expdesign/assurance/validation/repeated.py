"""One plan repeated with measurement noise alone, with load errors alone and with both, beside the criteria."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.simulation import BatchSize, Repetitions, Simulation, VirtualExperiment, batch_sizes
from expdesign.mechanics.elastostatics.measurements import Distribution, LoadedRobot
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class Estimate:
    """Estimates from samples with their standard errors, of any shape."""

    value: FloatArray
    standard_error: FloatArray

    def z_score(self, predicted: FloatArray, rounding: float = 0.0) -> FloatArray:
        """(value − predicted) / standard error; 0 where they differ by no more than `rounding`."""
        difference = self.value - predicted
        with np.errstate(divide="ignore", invalid="ignore"):
            score: FloatArray = difference / self.standard_error
        return np.where(np.abs(difference) <= rounding, 0.0, score)


def mean(samples: FloatArray) -> Estimate:
    """Mean over the first axis."""
    return Estimate(samples.mean(axis=0), samples.std(axis=0, ddof=1) / np.sqrt(len(samples)))


def standard_deviation(samples: FloatArray) -> Estimate:
    """Standard deviation over the first axis; its standard error is √((m₄ − s⁴)/N)/(2s), m₄ the fourth moment."""
    centred = samples - samples.mean(axis=0)
    variance = (centred**2).mean(axis=0)
    fourth = (centred**4).mean(axis=0)
    deviation = np.sqrt(variance)
    error = np.sqrt(np.maximum(fourth - variance**2, 0.0) / len(samples))
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(deviation > 0.0, error / (2.0 * deviation), 0.0)
    return Estimate(deviation, relative)


def root_mean_square(samples: FloatArray) -> Estimate:
    """√(mean of squares) over the first axis."""
    squares = mean(samples**2)
    value = np.sqrt(squares.value)
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.where(value > 0.0, squares.standard_error / (2.0 * value), 0.0)
    return Estimate(value, error)


_ROUNDING = 1e-12
"""m, rad: errors below this differ from a prediction of 0 by nothing."""
CAUSES = {"duir": (True, False), "feir": (False, True), "total": (True, True)}
"""Whether noise and load errors are drawn, by the criterion that predicts the result."""

Drawn = tuple[BatchSize, bool, bool]
"""A batch (`batch_sizes`), and whether noise and load errors are drawn in it."""
Elsewhere = Callable[[list[Drawn]], list[Repetitions]]
"""Does batches and returns them in their order."""


@dataclass(frozen=True)
class Repeated:
    """Simulations of one plan.

    Attributes:
        problem: by which the plan is judged.
        plan: what was measured.
        causes: simulations by the criterion that predicts them (`duir`, `feir`, `total`); without sources of load
            error `feir` is missing, and `total` is `duir`.
        distribution: of the load errors.
        seed: of all random numbers.
        truth: file of the true robot, where it is not that of the problem.
    """

    problem: DesignProblem
    plan: Plan
    causes: dict[str, Simulation]
    distribution: str
    seed: int
    truth: str = ""

    @property
    def samples(self) -> int:
        """Number of repetitions."""
        return len(self.causes["total"].errors)

    @property
    def residual(self) -> float:
        """Largest error of the predicted configuration at a command (m, rad)."""
        return max(simulation.residual for simulation in self.causes.values())

    @cached_property
    def bias(self) -> Estimate:
        """Mean error (m, rad) of the attained pose with all causes, shape (t, n)."""
        return mean(self.causes["total"].errors)

    @cached_property
    def deviations(self) -> dict[str, tuple[Estimate, FloatArray]]:
        """Standard deviations (m, rad) of the attained pose by cause, and the predicted ones, shape (t, n)."""
        result = {}
        for cause, simulation in self.causes.items():
            predicted = np.sqrt(np.diagonal(simulation.predicted_covariance, axis1=-2, axis2=-1))
            result[cause] = (standard_deviation(simulation.errors), predicted)
        return result

    @cached_property
    def criteria(self) -> dict[str, tuple[Estimate, float]]:
        """The criteria as they came out (RMS in tolerances, mean or largest over targets), and as predicted."""
        return {cause: self._compared(cause) for cause in self.causes}

    def _compared(self, cause: str) -> tuple[Estimate, float]:
        simulation = self.causes[cause]
        found = root_mean_square(np.sqrt(simulation.squares(self.problem.targets)))
        predicted = float(known_criteria()[cause].values(simulation.assessment)[0])
        return found, predicted

    @property
    def drawn(self) -> tuple[str, ...]:
        """The causes that have a simulation of their own."""
        return tuple(cause for cause in self.causes if cause == "total" or "feir" in self.causes)

    def scores(self) -> FloatArray:
        """Z scores of all compared standard deviations (axes that matter) and criteria, in one row."""
        matters = self.problem.targets.importance > 0.0
        scores = []
        for cause in self.drawn:
            scores.append(self.deviation_score(cause)[matters])
            scores.append(np.atleast_1d(self.criterion_score(cause)))
        return np.concatenate(scores)

    def deviation_score(self, cause: str) -> FloatArray:
        """Z scores of the standard deviations, shape (t, n)."""
        estimate, predicted = self.deviations[cause]
        return estimate.z_score(predicted, _ROUNDING)

    def criterion_score(self, cause: str) -> float:
        """Z score of the criterion."""
        found, predicted = self.criteria[cause]
        finest = np.sqrt(self.problem.targets.importance.max())
        return float(found.z_score(np.asarray(predicted), _ROUNDING * finest))

    def record(self) -> dict[str, Any]:
        """The content of `montecarlo.json`."""
        scores = self.scores()
        return {
            "config": self.problem.config,
            "measurements": len(self.plan),
            "samples": self.samples,
            "seed": self.seed,
            "distribution": self.distribution,
            "criteria": {cause: self._criterion_record(cause) for cause in CAUSES},
            "targets": [self._target(index) for index in range(len(self.problem.targets.configurations))],
            "comparisons": len(scores),
            "largest_z": float(np.abs(scores).max()),
            "beyond_three": int((np.abs(scores) > 3.0).sum()),
            "largest_residual": self.residual,
        }

    def _criterion_record(self, cause: str) -> dict[str, float | None] | None:
        if cause not in self.causes:
            return None
        found, predicted = self.criteria[cause]
        return {
            "rms": float(found.value),
            "standard_error": float(found.standard_error),
            "predicted": predicted,
            "z": _number(self.criterion_score(cause)),
        }

    def _target(self, target: int) -> dict[str, Any]:
        robot, targets = self.problem.loaded.robot, self.problem.targets
        configuration = dict(zip(robot.configuration, targets.configurations[target].tolist(), strict=True))
        bias, axes = self.bias, []
        for axis, name in enumerate(robot.coordinates.deflection):
            importance = targets.importance[target, axis]
            entry: dict[str, Any] = {
                "axis": name,
                "tolerance": float(1.0 / np.sqrt(importance)) if importance > 0.0 else None,
                "mean": float(bias.value[target, axis]),
                "mean_standard_error": float(bias.standard_error[target, axis]),
            }
            for cause in self.causes:
                estimate, predicted = self.deviations[cause]
                entry[cause] = {
                    "std": float(estimate.value[target, axis]),
                    "standard_error": float(estimate.standard_error[target, axis]),
                    "predicted": _number(predicted[target, axis]),
                    "z": _number(self.deviation_score(cause)[target, axis]),
                }
            axes.append(entry)
        return {"configuration": configuration, "axes": axes}


def repeat(
    problem: DesignProblem,
    plan: Plan,
    samples: int,
    seed: int,
    *,
    distribution: Distribution = "normal",
    truth: LoadedRobot | None = None,
    elsewhere: Elsewhere | None = None,
) -> Repeated:
    """Repeat a plan with each cause of error and with both; arguments as of `simulate` and `VirtualExperiment`.

    `elsewhere` does the batches of all causes in any order and place; here, one after another, if left out.
    """
    experiment = VirtualExperiment(problem, plan, distribution=distribution, truth=truth)
    causes, sizes = CAUSES if problem.loaded.sources else {"duir": CAUSES["duir"]}, batch_sizes(samples)
    batches = [(size, *drawn) for drawn in causes.values() for size in sizes]
    done = iter(elsewhere(batches) if elsewhere else (experiment.batch(size, seed, *how) for size, *how in batches))
    simulations = {cause: experiment.joined([next(done) for _ in sizes], *drawn) for cause, drawn in causes.items()}
    simulations.setdefault("total", simulations["duir"])
    return Repeated(problem, plan, simulations, distribution, seed)


def _number(value: FloatArray | float) -> float | None:
    return float(value) if np.isfinite(value) else None
