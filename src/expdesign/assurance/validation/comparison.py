"""Moments of samples with their standard errors, whatever the distribution."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray


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
