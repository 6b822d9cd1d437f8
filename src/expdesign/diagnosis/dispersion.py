"""How much less the residuals of a model say than as many independent rows with the stated noise would.

Residuals that exceed their standard deviations, and residuals of consecutive rows that are alike (filtered or densely
sampled recordings, and whatever the model leaves out), carry less information than their number. With lag-one
correlation ρ the effective number of rows is N·(1 − ρ)/(1 + ρ) (first-order autoregression), and the covariance of the
parameters grows by the mean square of the residuals times (1 + ρ)/(1 − ρ).
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.diagnosis.sample import Sample

_STRONGEST = 0.98
_FEWEST = 20
"""Pairs of consecutive rows below which a correlation is not estimated."""


@dataclass(frozen=True)
class Dispersion:
    """Mean square of the residuals (1: noise as stated), correlation of consecutive rows, and the number of rows."""

    mean_square: float
    correlation: float
    rows: int

    @property
    def effective_rows(self) -> float:
        """Number of independent rows that would say as much."""
        return self.rows * (1.0 - self.correlation) / (1.0 + self.correlation)

    @property
    def inflation(self) -> float:
        """Factor on the covariance of the parameters, at least 1."""
        return max(1.0, self.mean_square) * (1.0 + self.correlation) / (1.0 - self.correlation)


def dispersion(residuals: FloatArray, sample: Sample) -> Dispersion:
    """Dispersion of whitened residuals (N, k) over the rows that count, in the order of recording within series."""
    counts = sample.counts
    rows = np.flatnonzero(counts)
    mean_square = float((residuals[rows] ** 2).mean())
    series = sample.recordings.series
    together = (np.diff(rows) == 1) & (series[rows[1:]] == series[rows[:-1]])
    before, after = residuals[rows[:-1][together]], residuals[rows[1:][together]]
    if len(before) < _FEWEST or mean_square == 0.0:
        return Dispersion(mean_square, 0.0, len(rows))
    squares = 0.5 * ((before**2).sum() + (after**2).sum())
    correlation = float((before * after).sum() / max(float(squares), 1e-300))
    return Dispersion(mean_square, float(np.clip(correlation, 0.0, _STRONGEST)), len(rows))
