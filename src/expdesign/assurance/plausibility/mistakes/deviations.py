"""Standard deviations that contradict the scatter of the readings, or that belong to no reading."""

from collections.abc import Iterator

import numpy as np
from scipy.stats import chi2 as chi_squared

from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.evidence import Evidence
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.mistakes.mistake import Mistake
from expdesign.assurance.plausibility.options import MistakeOptions

_FACTORS = (10.0, 100.0, 1000.0)
"""By which deviations come out too small where a unit is mistaken."""
_COLUMNS = 3
"""Columns whose scatter is compared at least."""


class WithoutReading(Mistake):
    """A column of standard deviations whose reading is missing."""

    def findings(self, evidence: Evidence) -> Iterator[Implausibility]:
        coordinates = evidence.robot.coordinates
        readings = evidence.recordings.components(coordinates)
        for reading, deviation in zip(readings, coordinates.deviation, strict=False):
            if deviation in evidence.recordings.extra.columns:
                what = f"{deviation} stands there without its reading {reading}"
                yield Implausibility(what, f"Add {reading} (is it spelt otherwise?), or leave {deviation} out.")


class Scatter(Mistake):
    """Columns that scatter far less than they say, or all of them more by one power of ten.

    Physics that the model lacks makes readings scatter more, never less, and not all columns by one factor.
    """

    def findings(self, evidence: Evidence) -> Iterator[Implausibility]:
        stated, fitted = evidence.stated, evidence.fits[0]
        if stated.deviations is None or fitted is None or fitted.dof <= 0:
            return
        of_readings, freedoms = (fitted.residuals / stated.deviations) ** 2, self._freedom(evidence, stated.deviations)
        squares, freedom = of_readings.sum(axis=0), freedoms.sum(axis=0)
        usable = freedom > 1.0
        scatter = np.sqrt(squares / np.maximum(freedom, 1e-12))
        accident = chi_squared.cdf(squares, np.maximum(freedom, 1e-12))
        small = usable & (accident < evidence.options.chance / len(squares)) & (scatter < 0.5)
        exact = fitted.misfit < 1e-20  # a prediction without noise says nothing of an instrument
        if small.any() and not exact:
            named = [evidence.names[i] for i in np.flatnonzero(small)]
            factor = float(np.exp(-np.log(scatter[small]).mean()))
            what = f"the readings of {', '.join(named)} scatter {factor:.2g} times less than their standard deviations"
            yield Implausibility(what, "Are these too large: in another unit, or multiplied by 10? Correct them.")
        elif not small.any():
            yield from self._all_larger(of_readings, freedoms, evidence.options)

    @staticmethod
    def _freedom(evidence: Evidence, deviations: FloatArray) -> FloatArray:
        """Degrees of freedom of each reading (N, k): what the fit leaves of it."""
        observation = evidence.observation(evidence.stated) / deviations[..., None]
        rows = observation.reshape(-1, observation.shape[-1])
        scale = np.linalg.norm(rows, axis=0)
        kept = scale > 1e-6 * scale.max(initial=0.0)
        basis = np.linalg.qr(rows[:, kept] / scale[kept])[0]
        freedom: FloatArray = 1.0 - (basis**2).sum(axis=1).reshape(observation.shape[:2])
        return freedom

    @staticmethod
    def _all_larger(squares: FloatArray, freedom: FloatArray, options: MistakeOptions) -> Iterator[Implausibility]:
        """That rows and columns alike scatter more than stated by one power of ten, as they do by no physics."""
        if freedom.sum() < options.enough or freedom.shape[1] < _COLUMNS:
            return
        factor = float(np.sqrt(squares.sum() / freedom.sum()))
        alike = all(_alike(squares.sum(axis=axis), freedom.sum(axis=axis)) > options.consistent for axis in (0, 1))
        for known in _FACTORS:
            if alike and abs(np.log(factor / known)) < options.noisy:
                what = f"all readings scatter {factor:.3g} times more than their standard deviations"
                likely = f"Are the standard deviations {known:g} times too small: in another unit, or divided twice?"
                yield Implausibility(what, likely)


def _alike(squares: FloatArray, freedom: FloatArray) -> float:
    """p-value of Bartlett's test (1937) that sums of squares with their degrees of freedom have one variance."""
    freedom = np.maximum(freedom, 1e-9)
    pooled = squares.sum() / freedom.sum()
    statistic = freedom.sum() * np.log(pooled) - (freedom * np.log(np.maximum(squares / freedom, 1e-300))).sum()
    correction = 1.0 + ((1.0 / freedom).sum() - 1.0 / freedom.sum()) / (3.0 * (len(freedom) - 1.0))
    return float(chi_squared.sf(statistic / correction, len(freedom) - 1))
