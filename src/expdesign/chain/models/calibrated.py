"""What a model was calibrated with: ranges of the commands and loads recorded, beyond which it extrapolates."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.mechanics.robots.robot import Robot

FORCE, MOMENT, MASS = "force_N", "moment_Nm", "mass_kg"
SIZES = (FORCE, MOMENT, MASS)
"""Quantities whose range begins at 0: without a load nothing deflects, which needs no recording."""
MARGIN = 0.05
"""Part of a recorded range by which a value may lie outside of it and not count as extrapolated."""


@dataclass(frozen=True)
class Beyond:
    """A value of one row outside the range of the recordings, SI; `name` is its column, or that of a magnitude."""

    name: str
    value: float
    low: float
    high: float

    def __str__(self) -> str:
        recorded = f"up to {self.high:.4g}" if self.name in SIZES else f"{self.low:.4g} to {self.high:.4g}"
        return f"{self.name} {self.value:.4g} (recorded {recorded})"


@dataclass(frozen=True)
class Calibrated:
    """Ranges by the names of columns, and of the magnitudes of force and moment at the origin of P (SI).

    Attributes:
        ranges: smallest and largest value of each.
    """

    ranges: Mapping[str, tuple[float, float]]

    @classmethod
    def of(cls, points: LoadedPoints, robot: Robot) -> "Calibrated":
        """The ranges of some points."""
        ranges: dict[str, tuple[float, float]] = {}
        for name, values in quantities(points, robot).items():
            known = values[np.isfinite(values)]
            if known.size:
                low = 0.0 if name in SIZES else float(known.min())
                ranges[name] = low, float(known.max())
        return cls(ranges)

    def including(self, other: "Calibrated | None") -> "Calibrated":
        """The ranges that hold both, of what both know."""
        if other is None:
            return self
        both = {name: (*own, *other.ranges[name]) for name, own in self.ranges.items() if name in other.ranges}
        return Calibrated({name: (min(values), max(values)) for name, values in both.items()})

    def beyond(self, points: LoadedPoints, robot: Robot) -> list[tuple[Beyond, ...]]:
        """What lies outside the ranges at every point, in the order of the points.

        A payload acts by its force and moment alone: its mass stands for its force, and the place of its centre counts
        where the moment is outside.
        """
        found: list[list[Beyond]] = [[] for _ in range(len(points))]
        for name, values in quantities(points, robot).items():
            if name not in self.ranges:
                continue
            low, high = self.ranges[name]
            allowed = MARGIN * (high - low) + 1e-9 * max(abs(low), abs(high))
            outside = (values < low - allowed) | (values > high + allowed)
            for row in np.flatnonzero(outside & np.isfinite(values)):
                found[row].append(Beyond(name, float(values[row]), low, high))
        centre = robot.coordinates.centre_of_mass
        return [tuple(_without_repetition(row, centre)) for row in found]


def _without_repetition(row: list[Beyond], centre: tuple[str, ...]) -> list[Beyond]:
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
