"""How much worse a plan becomes when a pose or load of it is not met exactly.

With δ the deviation of one quantity of one measurement, total(δ) ≈ total + g·δ + ½·h·δ². The gradient g is exact; it
vanishes where the optimum lies inside the range of the quantity, and then the curvature h decides, a second difference
of the exact value. Quantities that the plan does not choose (a pose held fixed, the mass of a weight) can be missed
like any other. What was really met is supposed to be recorded and used; errors of the load that nobody knows of are
FEIR's.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.differentiated import Differentiated, shared_series
from expdesign.planning.problem import DesignProblem

_STEP = 1e-3
"""Step of the second difference, in parts of the quantity's scale: rounding and the next order both stay below 1e-5."""
_STATED = 1e-2
"""The stated deviation, in parts of the quantity's scale, before it is rounded."""
_BATCH = 20_000
"""Measurements that are evaluated together, about."""


@dataclass(frozen=True)
class Deviations:
    """Derivatives of total of b designs of m measurements with respect to each of z quantities.

    Attributes:
        names: columns of a plan, or tilts, with their units; length z.
        total: shape (b,), NaN where a design does not identify every stiffness.
        gradient: per unit of the quantity, shape (b, m, z).
        curvature: per unit squared, shape (b, m, z).
        scale: largest size that each quantity takes, in its unit, shape (z,); the expansion means nothing beyond.
    """

    names: tuple[str, ...]
    total: FloatArray
    gradient: FloatArray
    curvature: FloatArray
    scale: FloatArray

    @property
    def stated(self) -> FloatArray:
        """A small deviation of each quantity: 1, 2 or 5 times a power of ten, at most 1 % of its scale; shape (z,)."""
        wanted = _STATED * self.scale
        power = 10.0 ** np.floor(np.log10(wanted))
        lead = wanted / power
        return np.where(lead >= 5.0, 5.0, np.where(lead >= 2.0, 2.0, 1.0)) * power

    def allowed(self, growth: float) -> FloatArray:
        """Deviation of one quantity alone, in its worse direction, at which total has grown by the share `growth`.

        Shape (b, m, z); `inf` where no deviation up to the quantity's scale does.
        """
        rise = growth * self.total[:, None, None]
        slope = np.abs(self.gradient)
        inside = slope**2 + 2.0 * self.curvature * rise
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(np.where(inside >= 0.0, inside, np.nan))
            allowed = 2.0 * rise / (slope + root)
        allowed = np.where(inside >= 0.0, allowed, np.where(np.isnan(inside), np.nan, np.inf))
        result: FloatArray = np.where(allowed > self.scale, np.inf, allowed)
        return result

    def growth(self, deviation: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviation of total's relative growth when every quantity is off at random.

        Args:
            deviation: standard deviation of each quantity, independent in every measurement, shape (z,).

        Returns:
            ½·Σ h·σ² / total and √(Σ (g·σ)²) / total, shape (b,) each.
        """
        mean = 0.5 * (self.curvature * deviation**2).sum(axis=(1, 2)) / self.total
        spread = np.sqrt(((self.gradient * deviation) ** 2).sum(axis=(1, 2))) / self.total
        return mean, spread


def plan_deviations(problem: DesignProblem, variables: FloatArray) -> Deviations:
    """Derivatives of total of designs with variables (b, m, g).

    Where total is a maximum over targets they are those of the largest target. Measurements that share their unloaded
    measurement are taken to keep sharing it.
    """
    space, names = problem.space, _names(problem)
    kept = len(names)
    total = known_criteria()["total"]
    quantities = space.quantities(variables)
    series = shared_series(problem, quantities)
    piece = Differentiated(problem, quantities, series).pieces(total)[0]
    values, gradient = piece.value, piece.quantity_gradient()[..., :kept]
    scale = _scales(names, quantities[..., :kept], len(problem.loaded.robot.configuration))
    batch, count = quantities.shape[:2]
    curvature = np.empty((batch, count, kept))
    together, steps = (
        max(1, _BATCH // (2 * count * kept)),
        (_STEP * scale)[:, None] * np.eye(kept, quantities.shape[-1]),
    )
    for design in range(batch):
        for first in range(0, count, together):
            rows = np.arange(first, min(first + together, count))
            moved = np.broadcast_to(quantities[design], (2, len(rows), kept, *quantities.shape[1:])).copy()
            moved[0, np.arange(len(rows)), :, rows] += steps
            moved[1, np.arange(len(rows)), :, rows] -= steps
            kept_series = None if series is None else np.repeat(series[design][None], 2 * len(rows) * kept, axis=0)
            neighbours = problem.assess(*space.split(moved.reshape(-1, *quantities.shape[1:])), kept_series)
            near = np.where(neighbours.differentiable, total.values(neighbours), np.nan).reshape(2, len(rows), kept)
            curvature[design, rows] = (near.sum(axis=0) - 2.0 * values[design]) / (_STEP * scale) ** 2
    return Deviations(tuple(names), values, gradient, curvature, scale)


def evaluations(problem: DesignProblem, count: int) -> int:
    """How many measurements are evaluated for the derivatives of one design of so many."""
    return 2 * count**2 * len(_names(problem))


def _names(problem: DesignProblem) -> list[str]:
    """Quantities of a measurement that can be missed."""
    space, robot, load = problem.space, problem.loaded.robot, problem.loaded.load
    names = [*robot.configuration, *load.columns[: space.n_load]]
    return [*names, *robot.coordinates.tilt] if space.tilts else names


def _scales(names: list[str], quantities: FloatArray, n_pose: int) -> FloatArray:
    """Largest size of each quantity; where it is always 0, of those of its unit in poses or in loads; shape (z,)."""
    largest = np.abs(quantities).max(axis=(0, 1))
    groups = [(index < n_pose, name.rsplit("_", 1)[-1]) for index, name in enumerate(names)]
    by_group = {group: max(largest[i] for i, other in enumerate(groups) if other == group) for group in groups}
    fallback = {"m": 0.1, "rad": 0.1}
    return np.array([by_group[group] or fallback.get(group[1], 1.0) for group in groups])
