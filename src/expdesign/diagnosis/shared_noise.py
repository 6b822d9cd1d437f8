"""Noise that readings share: what nobody asks for, left out of the parameters by its marginal covariance.

What a group of readings shares is Z·v with v ~ N(0, φ·I), so that their noise has the covariance

    V = I + φ·Z·Zᵀ,   V^(−1/2) = I + U·diag((1 + φ·s²)^(−1/2) − 1)·Uᵀ,   Z = U·diag(s)·Wᵀ,

and the estimates of all other parameters are those with v among the parameters.

`settling` takes the motion of the whole machine against the instrument from one series to the next for such noise. It
predicts nothing, but without it whatever moves whole series would be laid to effects that happen to differ between
them. With J_k the derivatives of the readings of series k by the pose of the instrument, its motions are random with
the deviations D, and are noise of the covariance I + φ·J_k·D²·J_kᵀ (`shared_noise`), so that many series cost no more
than one. Evidence sets φ. A series at one pose says nothing of it: its motion is not
told from an error of the machine at that pose.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.diagnosis.cross_validation import readings_of
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.sample import Sample, rms


@dataclass(frozen=True)
class SharedNoise:
    """Noise that groups of readings share.

    Attributes:
        groups: readings of every group, shape (n_k,).
        turned: U of each, shape (n_k, r_k).
        squares: s² of each, shape (r_k,).
        ratio: φ; 0 where nothing is shared.
    """

    groups: tuple[IntArray, ...] = ()
    turned: tuple[FloatArray, ...] = ()
    squares: tuple[FloatArray, ...] = ()
    ratio: float = 0.0

    @classmethod
    def of_laws(cls, laws: Sequence[FloatArray], variances: Sequence[float]) -> Self:
        """What laws do of which only the sizes are known.

        Args:
            laws: directions of each, shape (M, f_k).
            variances: σ_k², in variances of the noise.
        """
        if not laws:
            return cls()
        shared = np.hstack([law * np.sqrt(variance) for law, variance in zip(laws, variances, strict=True)])
        left, singular, _ = np.linalg.svd(shared, full_matrices=False)
        return cls((np.arange(len(shared)),), (left,), (singular**2,), 1.0)

    def whitened(self, readings: FloatArray) -> FloatArray:
        """V^(−1/2) times readings (M,) or derivatives of them (M, p)."""
        return self._scaled(readings, -0.5)

    def unwhitened(self, readings: FloatArray) -> FloatArray:
        """V^(1/2) times readings (M,)."""
        return self._scaled(readings, 0.5)

    def of_state(self, state: Present) -> Present:
        """The base model and laws with this noise in their whitening."""
        laws = tuple(self.whitened(law) for law in state.laws)
        base, readings = self.whitened(state.base), self.whitened(state.readings)
        return replace(state, base=base, readings=readings, laws=laws)

    def of_sample(self, sample: Sample) -> Sample:
        """The sample with this noise in its whitening."""
        return sample if self.ratio == 0.0 else _Sharing(**vars(sample), shared=self)

    def _scaled(self, readings: FloatArray, power: float) -> FloatArray:
        if self.ratio == 0.0:
            return readings
        scaled = readings.copy()
        for rows, turned, squares in zip(self.groups, self.turned, self.squares, strict=True):
            change = (1.0 + self.ratio * squares) ** power - 1.0
            scaled[rows] += (turned * change) @ (turned.T @ readings[rows])
        return scaled


@dataclass(frozen=True)
class _Sharing(Sample):
    """A sample whose readings share a part of the noise."""

    shared: SharedNoise = field(default_factory=SharedNoise, kw_only=True)

    def residuals(self, chain: Chain, values: FloatArray) -> FloatArray:
        return self._whitened(super().residuals(chain, values))

    def residuals_with_sensitivities(self, chain: Chain, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        residuals, slopes = super().residuals_with_sensitivities(chain, values)
        return self._whitened(residuals), self._whitened(slopes)

    def _whitened(self, values: FloatArray) -> FloatArray:
        """Of readings (N, k, ...), of which those that count are whitened."""
        flat = values.reshape(values.shape[0] * values.shape[1], *values.shape[2:]).copy()
        kept = np.repeat(self.counts, values.shape[1])
        flat[kept] = self.shared.whitened(flat[kept])
        return flat.reshape(values.shape)


_RATIOS = tuple(float(ratio) for ratio in np.geomspace(1e-4, 10.0, 11))
"""φ that are compared, deviations being such that each motion alone would show as much as the base model misses."""
_SINGULAR = 1e-9
"""Directions of a series' motion that move its readings by a smaller share than the largest are none."""


@dataclass(frozen=True)
class Settling(SharedNoise):
    """Noise that the readings of a series share, whose ratio evidence sets."""

    def most_evident(self, state: Present) -> "Settling":
        """The same with the φ of largest evidence beside some laws; none moved where that is not worth its prior."""
        best = (-np.inf, replace(self, ratio=0.0))
        for ratio in (0.0, *_RATIOS) if self.groups else ():
            one = replace(self, ratio=ratio)
            volume = sum(float(np.log1p(ratio * squares).sum()) for squares in self.squares)
            evidence = one.of_state(state).log_evidence - 0.5 * volume
            best = max(best, (evidence, one), key=lambda item: item[0])
        return best[1]


def settling(chain: Chain, sample: Sample, present: Present) -> Settling:
    """What may have moved, for `ratio` to be set.

    Args:
        chain: with the pose of the instrument among the parameters of its reading.
        sample: rows that count.
        present: the base model, to first order.
    """
    names = [parameter.name for parameter in chain.parameters[: chain.base]]
    pose = [i for i, name in enumerate(names) if name.startswith("instrument ")]
    moving = [np.flatnonzero(readings_of(rows, sample)) for rows in _moving(sample)]
    if len(moving) < OPTIONS.groups or not pose:
        return Settling()
    directions = present.base[:, pose]
    shows = np.sqrt((directions**2).mean(axis=0))
    directions = directions * (rms(present.readings) / np.maximum(shows, 1e-9 * max(float(shows.max()), 1e-300)))
    turned, squares = [], []
    for rows in moving:
        left, singular, _ = np.linalg.svd(directions[rows], full_matrices=False)
        there = singular > _SINGULAR * singular.max(initial=1e-300)
        turned.append(left[:, there])
        squares.append(singular[there] ** 2)
    return Settling(tuple(moving), tuple(turned), tuple(squares))


def _moving(sample: Sample) -> list[BoolArray]:
    """Rows of every series that was read at several poses, shape (N,) each."""
    poses = sample.recordings.configurations
    ranges = OPTIONS.slight * np.ptp(poses[sample.counts], axis=0)
    found = []
    for number in np.unique(sample.rows.series[sample.counts]):
        rows: BoolArray = (sample.rows.series == number) & sample.counts
        if (np.ptp(poses[rows], axis=0) > ranges).any():
            found.append(rows)
    return found
