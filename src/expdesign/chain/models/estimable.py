"""What a fit knows of its parameters: a covariance on the estimable subspace, and the directions outside it.

Where two parameters do alike what the readings show, neither is determined but their sum is. With the singular value
decomposition Ã·D = U·Σ·Vᵀ of the sensitivities in units D = diag(1/‖ã_j‖) of the conditional standard deviations,

    P = D·V₁·Σ₁⁻²·V₁ᵀ·D,   N = D·V₂,

V₂ spanning the kernel. A linear combination sᵀθ is estimable if and only if sᵀN = 0, and has the variance sᵀ·P·s then,
whichever generalised inverse P is (Rao, Linear Statistical Inference, 2nd ed. 1973, section 4a); otherwise its variance
is infinite.

What a model file says of combinations of parameters, where not every parameter is determined by itself.

What a model was calibrated with: ranges of the commands and loads recorded, beyond which it extrapolates.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.models.checked import AGAIN, covariance_of
from expdesign.chain.models.matrix_rows import MatrixRows, matrix_rows
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.io.schema import Section
from expdesign.mechanics.robots.robot import Robot

_SHARE = 1e-6
"""Share of a combination outside the estimable subspace, in conditional standard deviations, that is rounding."""


@dataclass(frozen=True)
class Estimable:
    """Covariance of every estimable combination of p parameters.

    Attributes:
        generalised: P, a covariance that is right for estimable combinations, shape (p, p), finite.
        directions: N, along which the readings say nothing, shape (p, d).
        resolution: D, standard deviation of each parameter if all others were known; for those that no reading shows,
            their typical size. Shape (p,).
    """

    generalised: FloatArray
    directions: FloatArray
    resolution: FloatArray

    @classmethod
    def from_covariance(cls, covariance: FloatArray) -> "Estimable":
        """Of a covariance (p, p) whose infinite rows mark parameters that are not determined, each for itself."""
        known = np.isfinite(np.diag(covariance))
        generalised = np.where(known[:, None] & known, covariance, 0.0)
        deviations = np.sqrt(np.maximum(np.diag(generalised), 0.0))
        return cls(generalised, np.eye(len(known))[:, ~known], np.where(known & (deviations > 0.0), deviations, 1.0))

    @property
    def determined(self) -> BoolArray:
        """Parameters that are estimable by themselves, shape (p,)."""
        outside = np.linalg.norm(self.directions, axis=1)
        determined: BoolArray = outside <= _SHARE * self.resolution
        return determined

    @cached_property
    def covariance(self) -> FloatArray:
        """P with infinite rows and columns of parameters that are not determined by themselves, shape (p, p)."""
        known = self.determined
        covariance: FloatArray = np.where(known[:, None] & known, self.generalised, np.inf)
        return covariance

    def deviations(self, sensitivities: FloatArray) -> FloatArray:
        """√(sᵀPs) of combinations s (..., p), infinite where they are not estimable; shape (...)."""
        variance = ((sensitivities @ self.generalised) * sensitivities).sum(axis=-1)
        deviation = np.sqrt(np.maximum(variance, 0.0))
        if self.directions.shape[1] == 0:
            return deviation
        outside = np.linalg.norm(sensitivities @ self.directions, axis=-1)
        whole = np.linalg.norm(sensitivities * self.resolution, axis=-1)
        found: FloatArray = np.where(outside > _SHARE * whole, np.inf, deviation)
        return found

    def distance(self, chosen: IntArray, away: FloatArray) -> float:
        """√(dᵀ·C⁻¹·d) of steps d (m,) of the chosen parameters (m,), in their estimable combinations alone.

        0 where the readings determine none (Wald 1943).
        """
        units = self.resolution[chosen]
        hidden = self.directions[chosen] / units[:, None]
        across, sizes, _ = np.linalg.svd(hidden)
        shown = across[:, int((sizes > _SHARE).sum()) :].T / units
        covariance = shown @ self.generalised[np.ix_(chosen, chosen)] @ shown.T
        step = shown @ away
        return float(np.sqrt(max(float(step @ np.linalg.pinv(covariance, hermitian=True) @ step), 0.0)))

    def given(self, chosen: IntArray) -> "Estimable":
        """Of all parameters where the chosen ones (m,) are as they are: P − P_c·P_cc⁻¹·P_cᵀ."""
        scale = np.sqrt(np.diag(self.generalised)[chosen])
        across = self.generalised[:, chosen] / scale
        inner = np.linalg.pinv(across[chosen] / scale[:, None], hermitian=True)
        left: FloatArray = self.generalised - across @ inner @ across.T
        left[chosen] = left[:, chosen] = 0.0
        return replace(self, generalised=0.5 * (left + left.T))  # a product of three is symmetric but for rounding

    def scaled(self, factor: float) -> "Estimable":
        """The same with all variances multiplied."""
        return replace(self, generalised=factor * self.generalised)

    def in_units(self, units: FloatArray) -> "Estimable":
        """Of parameters multiplied by `units` (p,)."""
        return Estimable(
            self.generalised * np.outer(units, units), self.directions * units[:, None], self.resolution * units
        )


class EstimableSection(Section):
    """Covariance of the estimable combinations (p×p), kernel (d×p) and conditional standard deviations (p)."""

    covariance: MatrixRows
    undetermined: MatrixRows
    resolution: list[float]


def estimable_entry(estimable: Estimable) -> dict[str, object]:
    """The key `estimable` of a model file; nothing where every parameter is determined."""
    if estimable.directions.shape[1] == 0:
        return {}
    section = {
        "covariance": matrix_rows(estimable.generalised),
        "undetermined": matrix_rows(estimable.directions.T),
        "resolution": estimable.resolution.tolist(),
    }
    return {"estimable": section}


def subspace_of(section: EstimableSection | None, count: int, units: FloatArray) -> Estimable | None:
    """What the section says, its `count` parameters multiplied by `units` (p,); None where the file says nothing.

    Raises:
        InputError: the section does not fit the parameters.
    """
    if section is None:
        return None
    rows = (*section.covariance, *section.undetermined, section.resolution)
    if {len(row) for row in rows} != {count} or not np.isfinite([x for row in rows for x in row]).all():
        what = f"rows of {count} finite numbers are needed here, and {count} rows of `covariance`"
        raise section.where().fault(what, AGAIN)
    if min(section.resolution, default=1.0) <= 0.0:
        raise section.where("resolution").fault("a standard deviation is positive", AGAIN)
    covariance = covariance_of(section.covariance, count, section.where("covariance"))
    directions = np.array(section.undetermined).reshape(-1, count).T
    found = Estimable(covariance, directions, np.array(section.resolution))
    return found.in_units(units)


FORCE, MOMENT, MASS = "force_N", "moment_Nm", "mass_kg"
SIZES = (FORCE, MOMENT, MASS)
"""Quantities whose range begins at 0: without a load nothing deflects, which needs no recording."""
MARGIN = 0.05
"""Part of a recorded range by which a value may lie outside of it and not count as extrapolated."""


@dataclass(frozen=True)
class OutsideRange:
    """A value of one row outside the range of the recordings, SI; `name` is its column, or that of a magnitude."""

    name: str
    value: float
    low: float
    high: float

    @property
    def outside(self) -> float:
        """By how much it is outside of the range."""
        return max(self.low - self.value, self.value - self.high)

    def __str__(self) -> str:
        recorded = f"up to {self.high:.4g}" if self.name in SIZES else f"{self.low:.4g} to {self.high:.4g}"
        return f"{self.name} {self.value:.4g} (recorded {recorded})"


SEQUENCE = "sequence"
"""Range of the order of recording, in models that depend on it."""


@dataclass(frozen=True)
class Calibrated:
    """Ranges by the names of columns, and of the magnitudes of force and moment at the origin of P (SI).

    Attributes:
        ranges: smallest and largest value of each.
    """

    ranges: Mapping[str, tuple[float, float]]

    @classmethod
    def of(cls, points: LoadedPoints, robot: Robot, *, ordered: bool = False) -> "Calibrated":
        """The ranges of some points; `ordered` ones with their place in the order of recording (`SEQUENCE`)."""
        ranges: dict[str, tuple[float, float]] = {}
        for name, values in quantities(points, robot).items():
            known = values[np.isfinite(values)]
            if known.size:
                low = 0.0 if name in SIZES else float(known.min())
                ranges[name] = low, float(known.max())
        if ordered:
            ranges[SEQUENCE] = float(points.sequence.min()), float(points.sequence.max())
        return cls(ranges)

    def including(self, other: "Calibrated | None") -> "Calibrated":
        """The ranges that hold both, of what both know."""
        if other is None:
            return self
        both = {name: (*own, *other.ranges[name]) for name, own in self.ranges.items() if name in other.ranges}
        return Calibrated({name: (min(values), max(values)) for name, values in both.items()})

    def beyond(self, points: LoadedPoints, robot: Robot) -> list[tuple[OutsideRange, ...]]:
        """What lies outside the ranges at every point, in the order of the points.

        A payload acts by its force and moment alone: its mass stands for its force, and the place of its centre counts
        where the moment is outside.
        """
        found: list[list[OutsideRange]] = [[] for _ in range(len(points))]
        for name, values in quantities(points, robot).items():
            if name not in self.ranges:
                continue
            low, high = self.ranges[name]
            allowed = MARGIN * (high - low) + 1e-9 * max(abs(low), abs(high))
            outside = (values < low - allowed) | (values > high + allowed)
            for row in np.flatnonzero(outside & np.isfinite(values)):
                found[row].append(OutsideRange(name, float(values[row]), low, high))
        centre = robot.coordinates.centre_of_mass
        return [tuple(_without_repetition(row, centre)) for row in found]


def _without_repetition(row: list[OutsideRange], centre: tuple[str, ...]) -> list[OutsideRange]:
    names = {each.name for each in row}
    needless = {FORCE} if MASS in names else set()
    if MOMENT not in names:
        needless |= set(centre)
    return [each for each in row if each.name not in needless]


def quantities(points: LoadedPoints, robot: Robot) -> dict[str, FloatArray]:
    """Values (N,) by name: commands, magnitudes of force and moment, and the payload; NaN where there is none."""
    names, split = robot.configuration, robot.coordinates.translations
    found = {name: points.configurations[:, axis] for axis, name in enumerate(names) if name.endswith(("_m", "_rad"))}
    found[FORCE] = np.linalg.norm(points.wrenches[:, :split], axis=1)
    if robot.coordinates.rotations:
        found[MOMENT] = np.linalg.norm(points.wrenches[:, split:], axis=1)
    if points.payload is not None:
        found[MASS] = points.payload[:, 0]
        centres = np.where(points.payload[:, :1] > 0.0, points.payload[:, 1:], np.nan)
        found |= {name: centres[:, axis] for axis, name in enumerate(robot.coordinates.centre_of_mass)}
    return found
