"""What a model leaves of readings, in their own units and in their order: it needs no stated noise.

Two things speak against a model whatever the noise of the instrument is. It leaves more than a tenth of the spread of
positions, or 5°: no machine is off its drawing by as much. Or what it leaves of neighbouring rows is alike: with
whitened residuals r_i in the order of recording and c_i = r_i·r_(i+1), z = Σ c_i / √(Σ c_i²) is nearly standard normal
for independent rows, whatever their variances and the correlations within a row are.
"""

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
from scipy.special import ndtr

from expdesign.arrays import FloatArray, IntArray
from expdesign.probabilities import p_text

SHARE = 0.1
"""Of the spread of positions that no model of the right machine leaves."""
ANGLE = float(np.radians(5.0))
"""rad (RMS) that none leaves of orientations."""
FEWEST = 30
"""Pairs of neighbouring rows below which they are not compared: z is normal for many."""
ALIKE = 1e-3
"""p-value below which neighbouring rows are alike; smaller than that of χ², since z is only nearly normal."""


@dataclass(frozen=True)
class Left:
    """RMS of one kind of reading.

    Attributes:
        kind: `positions`, `orientations`, `translations` or `rotations`.
        before: of the readings less the robot as drawn, registered; of deflections, their own (m or rad).
        after: of what the model leaves (m or rad).
        spread: RMS distance of positions from their mean (m); infinite for what has none.
    """

    kind: str
    before: float
    after: float
    spread: float = inf

    @property
    def beyond(self) -> bool:
        """Whether a model of the right machine leaves less."""
        return self.after > SHARE * self.spread or (self.kind == "orientations" and self.after > ANGLE)

    @property
    def sentence(self) -> str:
        """It in figures, in one unit: `245 of 266 mm (32 % of the spread of the positions)`."""
        size = max(self.before, self.after)
        if self.kind == "orientations" and size > 1e-3:
            unit, factor = "°", float(np.degrees(1.0))
        else:
            prefix, factor = ("m", 1e3) if size >= 1e-3 or self.kind == "positions" else ("µ", 1e6)
            unit = f" {prefix}{'m' if self.kind in ('positions', 'translations') else 'rad'}"
        share = f" ({100.0 * self.after / self.spread:.2g} % of the spread of the positions)" if self.beyond else ""
        text = f"{factor * self.after:.3g} of {factor * self.before:.3g}{unit}"
        return text + (share if np.isfinite(self.spread) else "")


@dataclass(frozen=True)
class Neighbours:
    """Correlation of what is left of neighbouring rows, and the probability of as large a one by chance."""

    correlation: float
    p_value: float


@dataclass(frozen=True)
class LeftOver:
    """What a fit leaves.

    Attributes:
        parts: by kind of reading.
        neighbours: None where there are too few.
    """

    parts: tuple[Left, ...]
    neighbours: Neighbours | None = None

    @property
    def beyond(self) -> bool:
        """Whether the readings are of another machine, or mean something else."""
        return any(part.beyond for part in self.parts)

    @property
    def alike(self) -> bool:
        """Whether neighbouring rows are."""
        return self.neighbours is not None and self.neighbours.p_value < ALIKE

    @property
    def sentence(self) -> str:
        """What is left, in figures."""
        return " and ".join(part.sentence for part in self.parts)

    @property
    def against(self) -> str:
        """What speaks against the model; empty where nothing does."""
        if self.beyond:
            return "no model of the right machine leaves as much"
        if self.alike and self.neighbours is not None:
            found = f"correlation {self.neighbours.correlation:.2f}, {p_text(self.neighbours.p_value)}"
            return f"what is left of neighbouring rows is alike ({found})"
        return ""

    @property
    def record(self) -> dict[str, object]:
        """It as in JSON files (m and rad)."""
        near = self.neighbours
        return {
            "parts": {part.kind: {"before": part.before, "after": part.after} for part in self.parts},
            "neighbours": None if near is None else {"correlation": near.correlation, "p_value": near.p_value},
        }


def left_over(
    errors: tuple[FloatArray, FloatArray],
    axes: IntArray,
    whitened: FloatArray,
    points: FloatArray | None = None,
    translations: int = 3,
) -> LeftOver:
    """From errors of the fitted rows in the order of recording.

    Args:
        errors: of the robot as drawn and of the model (m, rad), shape (N, k) each; NaN where nothing was read.
        axes: components of the columns, shape (k,), translations first; distances and gauges, from 6 on, do not count.
        whitened: residuals of the fit in standard deviations, shape (N, k), 0 where nothing was read.
        points: positions that were read (m), shape (N, 3); None for deflections.
        translations: number of components that are.
    """
    parts = []
    names = ("translations", "rotations") if points is None else ("positions", "orientations")
    for kind, columns in zip(names, (axes < translations, (axes >= translations) & (axes < 6)), strict=True):
        seen = np.isfinite(errors[1][:, columns]).any(axis=1)
        if not seen.any():
            continue
        first, second = (float(np.sqrt(np.nansum(each[seen][:, columns] ** 2, axis=1).mean())) for each in errors)
        parts.append(Left(kind, first, second, _spread(points) if kind == "positions" else inf))
    return LeftOver(tuple(parts), neighbours_of(whitened))


def neighbours_of(whitened: FloatArray) -> Neighbours | None:
    """Whether neighbouring rows of independent residuals (N, k) would be as much alike by chance."""
    products = (whitened[:-1] * whitened[1:]).sum(axis=1)
    squares = float((products**2).sum())
    if len(products) < FEWEST or squares == 0.0:
        return None
    z = float(products.sum()) / sqrt(squares)
    return Neighbours(float(products.sum()) / float((whitened**2).sum()), float(ndtr(-z)))


def _spread(points: FloatArray | None) -> float:
    complete = np.zeros((0, 3)) if points is None else points[np.isfinite(points).all(axis=1)]
    if len(complete) < 2:
        return inf
    return float(np.sqrt(((complete - complete.mean(axis=0)) ** 2).sum(axis=1).mean())) or inf
