"""What a diagnosis says of a fit: the statement of `identify` on the same rows, and by what it widens predictions."""

from dataclasses import dataclass, replace
from math import sqrt

from expdesign.diagnosis.dispersion import dispersion
from expdesign.diagnosis.sample import Sample
from expdesign.estimation.fit import Fit
from expdesign.estimation.goodness import StatementOfFit, noise_ratio, squares_of, statement_of_fit
from expdesign.estimation.load_errors import DeclaredLoadErrors
from expdesign.estimation.noise_level import NoiseLevel


def statement(
    fit: Fit, sample: Sample, noise: NoiseLevel, load_errors: DeclaredLoadErrors | None = None
) -> StatementOfFit:
    """Whether a model accounts for the rows that count, `noise` being that of all rows."""
    counts, recordings = sample.counts, sample.recordings
    columns = recordings.components(fit.chain.robot.coordinates)
    whitening = sample.whitening.rows(counts)
    of_rows = replace(noise, deviations=noise.deviations[counts])
    return statement_of_fit(fit.seen_by(counts), recordings.rows(counts), of_rows, whitening, columns, load_errors)


def tested(fit: Fit, sample: Sample) -> tuple[float, int]:
    """χ² of the rows that count, and its degrees of freedom, at least 1."""
    value, dof = squares_of(fit.seen_by(sample.counts))
    return value, max(dof, 1)


@dataclass(frozen=True)
class Widening:
    """By what the residuals of a fit widen its predictions.

    Attributes:
        readings: factor on the standard deviation of a reading (the Birge ratio, smaller than 1 where the stated one is
            too large; where the noise is estimated, what the model leaves over).
        parameters: factor on those of the parameters: the same, and what consecutive rows that are alike do not say.
    """

    readings: float = 0.0
    parameters: float = 0.0

    def at_least(self, other: "Widening") -> "Widening":
        """The larger of both, each."""
        return Widening(max(self.readings, other.readings), max(self.parameters, other.parameters))


NONE = Widening()


def widening(fit: Fit, sample: Sample, *, known_noise: bool, left_out: Widening = NONE) -> Widening:
    """The widening that the rows which count ask for.

    Args:
        fit: the model.
        sample: the rows that it was fitted to.
        known_noise: whether the standard deviations of the readings are stated.
        left_out: what blocks ask for that were left out, where that is known: readings of a machine with many small
            errors scatter about its predictions as these do, and not as fitted ones.
    """
    value, dof = tested(fit, sample)
    ratio = noise_ratio(value, dof) if known_noise else sqrt(value / dof)
    spread = dispersion(fit.residuals, sample)
    alike = sqrt((1.0 + spread.correlation) / (1.0 - spread.correlation))
    # Where the noise was learnt with the parameters, they are known by it as well, else no better than stated.
    level = max(ratio, 1.0) if known_noise and left_out == NONE else ratio
    return Widening(ratio, level * alike).at_least(left_out)


def widened(fit: Fit, by: Widening) -> Fit:
    """The fit with the covariance that predictions are made with; what is in it already is not taken twice."""
    factor = max(by.parameters**2 / fit.inflation, 1.0) if fit.inflation != 1.0 else by.parameters**2
    return replace(fit.known_as(fit.estimable.scaled(factor)), inflation=fit.inflation * factor)
