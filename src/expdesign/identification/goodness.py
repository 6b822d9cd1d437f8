"""Whether the model accounts for the recordings to within their noise."""

from dataclasses import dataclass
from math import sqrt

from scipy.stats import chi2, f

from expdesign.identification.fit import Fit
from expdesign.identification.noise_level import NoiseLevel
from expdesign.identification.replicates import pure_error, replicate_groups
from expdesign.recordings.recordings import Recordings

REFUTED = 0.01
"""p-value of χ² below which the recordings refute the model at the stated noise."""


@dataclass(frozen=True)
class LackOfFit:
    """F-test of what the model leaves over against the scatter of replicates (theory.md 10.5).

    F = (RSS − SS_PE)/(ν − ν_PE) / (SS_PE/ν_PE); it needs no knowledge of the noise level.
    """

    ratio: float
    dof: int
    pure_dof: int
    p_value: float


@dataclass(frozen=True)
class Goodness:
    """Tests of a fit.

    Attributes:
        chi2: sum of squared whitened residuals, or None where the noise level was estimated from them.
        dof: readings minus rank.
        p_value: of chi2 where the noise is known, or None.
        lack_of_fit: where there are replicates.
    """

    chi2: float | None
    dof: int
    p_value: float | None
    lack_of_fit: LackOfFit | None

    @property
    def birge_ratio(self) -> float:
        """√(χ²/ν) where χ² refutes the model, else 1: by so much the stated deviations are too small for it.

        Standard deviations of a refuted fit are multiplied by it (R. T. Birge, Physical Review 40, 1932, 207).
        """
        if self.chi2 is None or self.p_value is None or self.p_value >= REFUTED:
            return 1.0
        return sqrt(self.chi2 / self.dof)


def goodness_of_fit(fit: Fit, recordings: Recordings, noise: NoiseLevel, *, shared_reference: bool) -> Goodness:
    """The tests that these recordings allow."""
    p_value = float(chi2.sf(fit.chi2, fit.dof)) if noise.known and fit.dof > 0 else None
    lack = _lack_of_fit(fit, recordings, noise, shared_reference=shared_reference)
    return Goodness(fit.chi2 if noise.known else None, fit.dof, p_value, lack)


def _lack_of_fit(fit: Fit, recordings: Recordings, noise: NoiseLevel, *, shared_reference: bool) -> LackOfFit | None:
    groups = replicate_groups(recordings, shared_reference=shared_reference)
    error = pure_error(recordings, noise.deviations, groups, shared_reference=shared_reference)
    squares, pure_dof = float(error.squares.sum()), error.dof * len(recordings.axes)
    dof = fit.dof - pure_dof
    if pure_dof == 0 or dof <= 0 or squares <= 0.0:
        return None
    ratio = max(fit.chi2 - squares, 0.0) / dof / (squares / pure_dof)
    return LackOfFit(ratio, dof, pure_dof, float(f.sf(ratio, dof, pure_dof)))
