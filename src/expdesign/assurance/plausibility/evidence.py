"""Recordings of deflections, as they are or read otherwise, and how well the base model fits them.

The misfit of a fit is the share of the readings that it leaves over, Σ w²r² / Σ w²y², so that it depends on no unit.
Two weightings are asked: by the stated standard deviations, and with translations and rotations each in parts of their
own size, which serves where no deviation is stated or the deviations themselves are mistaken.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.special import chdtrc

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.points import hanging
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.gaussian import Gaussian
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.robots.robot import Robot

Weighting = Callable[[Recordings], FloatArray]
"""Weights (N, k) of the readings of recordings."""
SHOWN = 1e-6
"""Part of the largest column of sensitivities below which a compliance does not show."""
CHANCE = 1e-6
"""Probability by which structure in the numbers (copies, rounding, scatter) may be accident."""
REPEATABILITY = 10.0
"""How many times better than stated readings may repeat."""
ODDS = 1e4
"""How much likelier than chance a mistake must be, for each alternative that is tried."""
GAIN = 10.0
"""Factor by which an alternative must reduce the misfit."""
REFUTED, CONSISTENT = 1e-6, 0.01
"""p-values of χ² below which recordings do not fit the robot with their stated noise, and above which they do."""
FAIR, SENSELESS = 0.1, 0.5
"""Misfits below which the signs and sizes of compliances mean something, and from which on stiffness means nothing."""
MOST = 0.8
"""Share of the compliances of one sign that makes it the sign of all."""
_ROWS = 3000
"""Beyond which further ones are not looked at."""


@dataclass(frozen=True)
class Alternative:
    """Another reading of the same recordings.

    Attributes:
        sentence: what was mistaken, and what to do.
        sample: the recordings read so.
        where: row and column, where it concerns one.
        tried: of how many alternatives of its kind it was the most promising, without fitting the others.
        placed: whether the instrument is registered although the robot file states its pose.
    """

    sentence: str
    sample: Recordings
    where: str = ""
    tried: int = 1
    placed: bool = False


@dataclass(frozen=True)
class Fitted:
    """The base model fitted to a sample.

    Attributes:
        model: the fit of the weighted readings.
        compliances: in parts of those of the robot file, shape (n_p,); NaN where no load shows them.
        positive: whether no compliance is negative beyond its uncertainty.
        weights: of the readings, shape (N, k).
    """

    model: Gaussian
    compliances: FloatArray
    positive: bool
    weights: FloatArray

    @property
    def chi2(self) -> float:
        """The weighted sum of squares that is left over."""
        return self.model.chi2

    @property
    def dof(self) -> int:
        """Readings less compliances."""
        return len(self.model.readings) - self.model.rank

    @property
    def misfit(self) -> float:
        """Share of the readings that is left over."""
        return self.chi2 / float((self.model.readings**2).sum())

    @property
    def residuals(self) -> FloatArray:
        """What is left of every reading, shape (N, k); 0 where readings have no weight."""
        left = self.model.projected.reshape(self.weights.shape)
        return np.divide(left, self.weights, out=np.zeros_like(left), where=self.weights > 0.0)

    @property
    def ratio(self) -> float:
        """Median of the compliances in parts of those of the robot file."""
        shown = self.compliances[self.compliances > 0.0]
        return float(np.median(shown)) if shown.size else float("nan")

    @property
    def alike(self) -> tuple[float, float] | None:
        """Mean and standard deviation of the logarithms of what all compliances are multiplied by; None where any is
        negative, or one alone shows.
        """
        shown = self.compliances[np.isfinite(self.compliances)]
        if len(shown) < 2 or np.any(shown <= 0.0):
            return None
        return float(np.log(shown).mean()), float(np.log(shown).std(ddof=1))

    @property
    def share_positive(self) -> float:
        """How many of the compliances that show are positive, in parts of all of them."""
        shown = self.compliances[np.isfinite(self.compliances)]
        return float((shown > 0.0).mean()) if shown.size else 0.0

    @property
    def p_value(self) -> float:
        """Probability of a larger χ², where the weights are reciprocals of standard deviations."""
        return float(chdtrc(self.dof, self.chi2)) if self.dof > 0 else 1.0


@dataclass(frozen=True)
class Evidence:
    """Recordings beside the robot that they are of.

    Attributes:
        recordings: rows that may be fitted, as they are.
        robot: the robot.
    """

    recordings: Recordings
    robot: Robot
    _observations: dict[tuple[int, int], tuple[Recordings, FloatArray]] = field(default_factory=dict, repr=False)

    @cached_property
    def linear(self) -> BoolArray:
        """Which of the measured axes are translations, shape (k,)."""
        linear: BoolArray = self.axes < self.robot.coordinates.translations
        return linear

    @property
    def axes(self) -> IntArray:
        """Indices of the measured axes, shape (k,)."""
        return self.recordings.axes

    @property
    def names(self) -> list[str]:
        """Columns of the readings."""
        components = self.recordings.components(self.robot.coordinates)
        return [components[axis] for axis in self.axes]

    @cached_property
    def weightings(self) -> tuple[Weighting, ...]:
        """By the stated standard deviations, where there are some, and by size."""
        return (self._by_size,) if self.recordings.deviations is None else (_by_deviation, self._by_size)

    @cached_property
    def fits(self) -> tuple[Fitted | None, ...]:
        """The recordings as they are, fitted under each weighting."""
        return tuple(self.fit(self.recordings, weighting) for weighting in self.weightings)

    @property
    def noise_stated(self) -> bool:
        """Whether χ² of the first weighting has the distribution of that name."""
        return self.recordings.deviations is not None

    def _by_size(self, sample: Recordings) -> FloatArray:
        weights = np.ones_like(sample.deflections)
        for kind in (self.linear, ~self.linear):
            size = np.sqrt((sample.deflections[:, kind] ** 2).mean()) if kind.any() else 0.0
            weights[:, kind] = 1.0 / size if size > 0.0 else 0.0
        return weights

    def observation(self, sample: Recordings) -> FloatArray:
        """Sensitivities of the readings to relative compliances, shape (N, k, n_p); kept for samples alike."""
        key = (id(sample.configurations), id(sample.wrenches))
        if key not in self._observations:
            jacobians = self.robot.jacobians(sample.configurations)
            matrix = observation_matrix(jacobians, sample.wrenches)[:, self.axes] * self.robot.compliance
            self._observations[key] = sample, matrix  # the sample is kept so that its arrays keep their identity
        return self._observations[key][1]

    def fit(self, sample: Recordings, weighting: Weighting) -> Fitted | None:
        """Least squares under a weighting; None where nothing can be fitted."""
        weights = weighting(sample)
        rows = (self.observation(sample) * weights[..., None]).reshape(weights.size, -1)
        right, scale = (sample.deflections * weights).ravel(), np.linalg.norm(rows, axis=0)
        kept = scale > SHOWN * scale.max(initial=0.0)
        if not np.isfinite(scale).all() or not kept.any() or not right.any():
            return None
        model = Gaussian(rows[:, kept], right, np.full(kept.sum(), np.inf))
        compliances = np.full(len(kept), np.nan)
        compliances[kept] = model.estimate
        spread = np.sqrt(model.chi2 / len(right)) / scale[kept] * np.sqrt(kept.sum())
        positive = bool((model.estimate > -3.0 * spread).all() and model.estimate.sum() > 0.0)
        return Fitted(model, compliances, positive, weights)

    def scores(self, blocks: IntArray) -> FloatArray:
        """How far blocks of readings (N·k,) are from what the others say: √F of leaving each out, shape (B,).

        χ² falls by rᵀ(I − H)⁻¹r where a block with residuals r and leverage H is left out (Cook and Weisberg 1982).
        No scores with too few readings.
        """
        first = self.fits[0]
        if first is None or first.dof <= 2 * len(self.axes):
            return np.zeros(0)
        parts = first.model.projected * np.nan_to_num(first.model.left_out(blocks))
        falls, count = np.bincount(blocks, parts), np.bincount(blocks)
        left = np.maximum(first.chi2 - falls, 1e-12 * first.chi2) / np.maximum(first.dof - count, 1)
        score: FloatArray = np.sqrt(falls / count / np.maximum(left, 1e-300))
        return score

    @cached_property
    def row_scores(self) -> FloatArray:
        """`scores` of rows, shape (N,)."""
        return self.scores(np.repeat(np.arange(len(self.recordings)), len(self.axes)))

    @cached_property
    def reading_scores(self) -> FloatArray:
        """The same of single readings, shape (N, k)."""
        return self.scores(np.arange(self.recordings.deflections.size)).reshape(-1, len(self.axes))

    def readings(self, matrix: FloatArray) -> Recordings:
        """The readings of every row times a matrix (k, k), their standard deviations with them."""
        stated = self.recordings
        deviations = None if stated.deviations is None else stated.deviations @ np.abs(matrix).T
        return replace(stated, deflections=stated.deflections @ matrix.T, deviations=deviations)

    def centres(self, matrix: FloatArray) -> Recordings:
        """The centres of mass of every row times a matrix (d, d)."""
        payload = self.recordings.payload
        assert payload is not None
        return self.hung(payload=np.column_stack([payload[:, 0], payload[:, 1:] @ matrix.T]))

    def hung(self, recordings: Recordings | None = None, **columns: FloatArray) -> Recordings:
        """Recordings with other commands, payloads or gravity: weights act as they then hang."""
        other = replace(recordings or self.recordings, **columns)  # type: ignore[arg-type]
        if other.payload is None:
            return other
        return replace(other, wrenches=hanging(self.robot, other.configurations, other.payload, other.gravity))

    def where(self, row: int, column: str = "") -> str:
        """`row 7`, as the file counts, and its column."""
        return f"row {self.recordings.lines[row]}" + (f", column {column}" if column else "")


def _by_deviation(sample: Recordings) -> FloatArray:
    assert sample.deviations is not None
    return 1.0 / sample.deviations


def evidence_of(recordings: Recordings, robot: Robot) -> Evidence:
    """The rows of recordings that may be fitted, without references, which measure nothing."""
    unloaded = (recordings.wrenches == 0.0).all(axis=1) & (recordings.deflections == 0.0).all(axis=1)
    rows = np.flatnonzero(~recordings.test & ~unloaded)[:_ROWS]
    return Evidence(recordings.rows(rows), robot)
