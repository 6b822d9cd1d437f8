"""Recordings of deflections, as they are or under a hypothesis, and how well the base model fits them.

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
from expdesign.chain.recordings.recordings import Recordings
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.loads.load import Payload
from expdesign.mechanics.robots.robot import Robot

Weighting = Callable[["Hypothesis"], FloatArray]
"""Weights (N, k) of the readings of a sample."""


@dataclass(frozen=True)
class MistakeOptions:
    """Thresholds, which lie far outside what sound recordings of machines with any physics reach.

    Attributes:
        gain: factor by which an alternative reading must reduce the misfit.
        poor: misfit below which nothing needs an explanation by a mistake where noise is not stated.
        fair: misfit below which the signs and sizes of compliances mean something.
        most: share of the compliances of one sign that makes it the sign of all.
        odds: how much likelier than chance a mistake must be, for each alternative that is tried.
        refuted: p-value of χ² below which the recordings as they are do not fit the robot with their stated noise.
        consistent: p-value above which they do under an alternative; it is then named whatever the gain.
        unit_ratio: factor between identified and stated stiffness beyond which a unit is suspected.
        alike: standard deviation of the logarithms of the actuators' factors below which they are one factor.
        near: distance of the logarithm of that factor from a known one within which it is that one.
        exact: the same two for factors near 1, which robots may have as well: their common distance and spread.
        chance: probability by which structure in the numbers (copies, rounding, scatter) may be accident.
        repeatability: how many times better than stated readings may repeat.
        noisy: bounds on the factor by which all columns scatter more than stated, when that is a mistake of the unit.
        enough: degrees of freedom from which on the scatter of rows and columns is compared.
        slip: standard deviations from what the others say beyond which slips are tried for a row or a reading.
        candidates: of these so many, the most conspicuous ones.
        columns: whose scatter is compared at least.
        senseless: misfit from which on stiffness means nothing.
        shown: part of the largest column of sensitivities below which a compliance does not show.
        spare: readings beyond the compliances that a judgement takes at least.
        rows: rows beyond which further ones are not looked at.
    """

    gain: float = 10.0
    poor: float = 1e-3
    fair: float = 0.1
    most: float = 0.8
    odds: float = 1e4
    refuted: float = 1e-6
    consistent: float = 0.01
    unit_ratio: float = 30.0
    alike: float = 0.35
    near: float = 0.15
    exact: float = 0.04
    chance: float = 1e-6
    repeatability: float = 10.0
    noisy: float = 0.2
    enough: float = 40.0
    slip: float = 3.0
    candidates: int = 4
    columns: int = 3
    senseless: float = 0.5
    shown: float = 1e-6
    spare: int = 4
    rows: int = 3000


DEFAULT = MistakeOptions()
"""What commands use."""


@dataclass(frozen=True)
class Hypothesis:
    """Recordings under a hypothesis.

    Attributes:
        configurations: commands, shape (N, n_q).
        wrenches: loads, shape (N, n).
        readings: deflections of the measured axes, shape (N, k).
        deviations: their standard deviations, shape (N, k), or None where they are not stated.
    """

    configurations: FloatArray
    wrenches: FloatArray
    readings: FloatArray
    deviations: FloatArray | None

    def under(self, wrenches: FloatArray) -> "Hypothesis":
        """The same under other loads (N, n)."""
        return replace(self, wrenches=wrenches)


@dataclass(frozen=True)
class Alternative:
    """Another reading of the same recordings.

    Attributes:
        sentence: what was mistaken, and what to do.
        sample: the recordings read so.
        where: row and column, where it concerns one.
        tried: of how many alternatives of its kind it was the most promising, without fitting the others.
    """

    sentence: str
    sample: Hypothesis
    where: str = ""
    tried: int = 1


@dataclass(frozen=True)
class Fitted:
    """The base model fitted to a sample.

    Attributes:
        misfit: share of the readings that is left over.
        chi2: the weighted sum of squares that is left over.
        dof: readings less compliances.
        compliances: in parts of those of the robot file, shape (n_p,); NaN where no load shows them.
        positive: whether no compliance is negative beyond its uncertainty.
        residuals: what is left of every reading, shape (N, k).
    """

    misfit: float
    chi2: float
    dof: int
    compliances: FloatArray
    positive: bool
    residuals: FloatArray

    @property
    def ratio(self) -> float:
        """Median of the compliances in parts of those of the robot file."""
        shown = self.compliances[self.compliances > 0.0]
        return float(np.median(shown)) if shown.size else float("nan")

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
        recordings: rows that may be fitted.
        robot: the robot.
        options: thresholds.
    """

    recordings: Recordings
    robot: Robot
    options: MistakeOptions = DEFAULT
    _observations: dict[tuple[int, int], tuple[Hypothesis, FloatArray]] = field(default_factory=dict, repr=False)

    @cached_property
    def stated(self) -> Hypothesis:
        """The recordings as they are."""
        data = self.recordings
        return Hypothesis(data.configurations, data.wrenches, data.deflections, data.deviations)

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
        return (self._by_size,) if self.stated.deviations is None else (_by_deviation, self._by_size)

    @cached_property
    def fits(self) -> tuple[Fitted | None, ...]:
        """The recordings as they are, fitted under each weighting."""
        return tuple(self.fit(self.stated, weighting) for weighting in self.weightings)

    @property
    def noise_stated(self) -> bool:
        """Whether χ² of the first weighting has the distribution of that name."""
        return self.stated.deviations is not None

    def _by_size(self, sample: Hypothesis) -> FloatArray:
        weights = np.ones_like(sample.readings)
        for kind in (self.linear, ~self.linear):
            size = np.sqrt((sample.readings[:, kind] ** 2).mean()) if kind.any() else 0.0
            weights[:, kind] = 1.0 / size if size > 0.0 else 0.0
        return weights

    def observation(self, sample: Hypothesis) -> FloatArray:
        """Sensitivities of the readings to relative compliances, shape (N, k, n_p); kept for samples alike."""
        key = (id(sample.configurations), id(sample.wrenches))
        if key not in self._observations:
            jacobians = self.robot.jacobians(sample.configurations)
            matrix = observation_matrix(jacobians, sample.wrenches)[:, self.axes] * self.robot.compliance
            self._observations[key] = sample, matrix  # the sample is kept so that its arrays keep their identity
        return self._observations[key][1]

    def fit(self, sample: Hypothesis, weighting: Weighting) -> Fitted | None:
        """Least squares under a weighting; None where nothing can be fitted."""
        if not np.isfinite(self.observation(sample)).all():
            return None
        weights = weighting(sample)
        rows, scale, kept = self._columns(sample, weights)
        right = (sample.readings * weights).ravel()
        total = float((right**2).sum())
        if not kept.any() or total == 0.0:
            return None
        values, _, _, _ = np.linalg.lstsq(rows[:, kept] / scale[kept], right, rcond=1e-8)
        left = right - rows[:, kept] / scale[kept] @ values
        compliances = np.full(len(kept), np.nan)
        compliances[kept] = values / scale[kept]
        spread = np.sqrt((left**2).mean()) / scale[kept] * np.sqrt(kept.sum())
        positive = bool((compliances[kept] > -3.0 * spread).all() and compliances[kept].sum() > 0.0)
        known = np.where(kept, compliances, 0.0)
        residuals = sample.readings - self.observation(sample) @ known
        chi2 = float((left**2).sum())
        return Fitted(chi2 / total, chi2, len(right) - int(kept.sum()), compliances, positive, residuals)

    def _columns(self, sample: Hypothesis, weights: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Weighted sensitivities of all readings (N·k, n_p), the norm of each column, and which show anything."""
        rows = (self.observation(sample) * weights[..., None]).reshape(weights.size, -1)
        scale = np.linalg.norm(rows, axis=0)
        return rows, scale, scale > self.options.shown * scale.max(initial=0.0)

    def reach(self, weights: FloatArray) -> FloatArray:
        """An orthonormal basis (N, k, r) of the readings that the fit with weights (N, k) can reach."""
        rows, scale, kept = self._columns(self.stated, weights)
        return np.linalg.qr(rows[:, kept] / scale[kept])[0].reshape(*weights.shape, -1)

    @cached_property
    def _deletion(self) -> tuple[FloatArray, FloatArray, Fitted] | None:
        """Weighted residuals (N, k), an orthonormal basis of what the fit can reach (N, k, r), and the fit."""
        first = self.fits[0]
        if first is None or first.dof <= 2 * len(self.axes):
            return None
        weights = self.weightings[0](self.stated)
        return first.residuals * weights, self.reach(weights), first

    @cached_property
    def row_scores(self) -> FloatArray | None:
        """How far each row is from what the others say, shape (N,): √F of leaving it out (Cook and Weisberg 1982).

        χ² falls by rᵀ(I − H)⁻¹r where a row with residuals r and leverage H is left out. None with too few readings.
        """
        if self._deletion is None:
            return None
        residuals, basis, fitted = self._deletion
        own = np.eye(residuals.shape[1]) - basis @ basis.swapaxes(-1, -2)
        falls = np.einsum("ni,nij,nj->n", residuals, np.linalg.pinv(own, rcond=1e-9, hermitian=True), residuals)
        return _score(falls, residuals.shape[1], fitted)

    @cached_property
    def reading_scores(self) -> FloatArray | None:
        """The same for single readings, shape (N, k)."""
        if self._deletion is None:
            return None
        residuals, basis, fitted = self._deletion
        return _score(residuals**2 / np.maximum(1.0 - (basis**2).sum(axis=-1), 1e-9), 1, fitted)

    def readings(self, matrix: FloatArray) -> Hypothesis:
        """The readings of every row times a matrix (k, k), their standard deviations with them."""
        stated = self.stated
        deviations = None if stated.deviations is None else stated.deviations @ np.abs(matrix).T
        return replace(stated, readings=stated.readings @ matrix.T, deviations=deviations)

    def wrenches(self, matrix: FloatArray) -> Hypothesis:
        """The loads of every row times a matrix (n, n)."""
        return self.stated.under(self.stated.wrenches @ matrix.T)

    def centres(self, matrix: FloatArray) -> Hypothesis:
        """The centres of mass of every row times a matrix (d, d)."""
        payload = self.recordings.payload
        assert payload is not None
        return self.with_payload(np.column_stack([payload[:, 0], payload[:, 1:] @ matrix.T]))

    def commands(self, matrix: FloatArray) -> Hypothesis:
        """The commands of every row times a matrix (n_q, n_q)."""
        return self.at(self.stated.configurations @ matrix.T)

    def at(self, configurations: FloatArray, payload: FloatArray | None = None) -> Hypothesis:
        """The recordings at other commands (N, n_q): weights act where the platform would then be."""
        payload = self.recordings.payload if payload is None else payload
        other = replace(self.stated, configurations=configurations)
        return other if payload is None else replace(other, wrenches=self._weights(configurations, payload))

    def with_payload(self, payload: FloatArray, gravity: FloatArray | None = None) -> Hypothesis:
        """The recordings under payloads (N, 4), and under another gravity (N, d) where it is given."""
        return replace(self.stated, wrenches=self._weights(self.stated.configurations, payload, gravity))

    @cached_property
    def _payload(self) -> Payload:
        return Payload(self.robot.coordinates)

    def _weights(self, commands: FloatArray, payload: FloatArray, gravity: FloatArray | None = None) -> FloatArray:
        gravity = self.recordings.gravity if gravity is None else gravity
        rotation = self.robot.jacobians(commands).rotation
        return self._payload.wrenches(rotation, np.concatenate([payload, gravity], axis=1))

    def where(self, row: int, column: str = "") -> str:
        """`row 7`, as the file counts, and its column."""
        return f"row {self.recordings.lines[row]}" + (f", column {column}" if column else "")


def _by_deviation(sample: Hypothesis) -> FloatArray:
    assert sample.deviations is not None
    return 1.0 / sample.deviations


def _score(falls: FloatArray, count: int, fitted: Fitted) -> FloatArray:
    """√F of leaving out `count` readings, by which χ² falls."""
    left = np.maximum(fitted.chi2 - falls, 1e-12 * fitted.chi2) / max(fitted.dof - count, 1)
    score: FloatArray = np.sqrt(falls / count / np.maximum(left, 1e-300))
    return score


def evidence_of(recordings: Recordings, robot: Robot, options: MistakeOptions = DEFAULT) -> Evidence:
    """The rows of recordings that may be fitted, without references, which measure nothing."""
    unloaded = (recordings.wrenches == 0.0).all(axis=1) & (recordings.deflections == 0.0).all(axis=1)
    rows = np.flatnonzero(~recordings.test & ~unloaded)[: options.rows]
    return Evidence(recordings.rows(rows), robot, options)
