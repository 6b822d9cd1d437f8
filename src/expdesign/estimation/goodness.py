"""Whether a model accounts for recordings to within their noise: one test, one threshold and one sentence.

`check`, `identify`, `diagnose` and `verify` say of the same rows the same. The test is χ² of the readings' residuals at
their stated standard deviations, with readings minus all that was fitted as degrees of freedom (`Fit.freedom`). Where
the noise is estimated it is the F-test of what the model leaves over against the scatter of replicates, if there are
some; what is left and whether it is alike in neighbouring rows need no noise at all (`left_over`). Both tails count: a
χ² far too small says that the stated standard deviations are too large.
"""

from dataclasses import dataclass
from math import sqrt
from typing import Any, Literal

from scipy.special import chdtr, chdtrc, fdtrc

from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.fit import Fit
from expdesign.estimation.left_over import LeftOver
from expdesign.estimation.noise_level import NoiseLevel, pure_error, replicate_groups
from expdesign.estimation.outlying import Outlying, outlying_rows
from expdesign.estimation.whitening import Whitening
from expdesign.probabilities import p_text

Verdict = Literal["not refuted", "refuted", "too good", "noise estimated", "not tested"]


REFUTED = 0.01
"""P-value below which recordings refute a model. The consistency check of key comparisons takes 0.05 (Cox, Metrologia
39, 2002, 589); one in a hundred refutes a right model five times less often, and physics that matters at the targets
stays far below it."""
_TOO_GOOD = 0.001
"""Probability of as small a χ² below which the stated noise is too large; smaller, as the model is not at stake."""
_OVERSTATED = 1.25
"""Factor by which the stated standard deviations have to be too large for that to be worth a word: an interval that is
wider by a quarter."""
_EXACT = 1e-12
"""Mean square (of residuals in stated deviations) below which residuals are rounding: readings that were simulated
without noise, which say nothing of the noise that they would have."""


def p_value_of(value: float, dof: float) -> float:
    """Probability of a larger χ² if model and noise are right."""
    return float(chdtrc(dof, value))


def allows(value: float, dof: float) -> bool:
    """Whether a χ² against stated noise does not refute the model."""
    return p_value_of(value, dof) >= REFUTED


def noise_ratio(value: float, dof: int) -> float:
    """√(χ²/ν) where χ² speaks against the stated noise, in either direction, else 1: the noise that readings have."""
    if dof < 1 or value <= _EXACT * dof:
        return 1.0
    beyond = not allows(value, dof) or float(chdtr(dof, value)) < _TOO_GOOD
    return sqrt(value / dof) if beyond else 1.0


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
class WorstRow:
    """The row that fits worst.

    Attributes:
        where: file and line.
        column: of the reading that stands out.
        size: of its residual, in standard deviations.
        outliers: file and line of the rows that no model explains, worst first.
        without: p-value of χ² without these rows; None where there are none, or no test.
    """

    where: str
    column: str
    size: float
    outliers: tuple[str, ...] = ()
    without: float | None = None

    @property
    def sentence(self) -> str:
        """It in words."""
        named = f"{self.where} ({self.column}, {self.size:.3g} standard deviations)"
        rest = "" if self.without is None else f"; without {'it' if len(self.outliers) == 1 else 'them'} "
        rest = rest and rest + p_text(self.without or 0.0)
        if not self.outliers:
            return f"The worst row is {named}."
        if len(self.outliers) == 1:
            return f"{named} is an outlier{rest}. Check that reading."
        more = ", ".join(self.outliers)
        return f"{len(self.outliers)} rows are outliers: {more}; the worst is {named}{rest}. Check these readings."

    @property
    def record(self) -> dict[str, Any]:
        """It as in JSON files."""
        return {
            "where": self.where,
            "column": self.column,
            "standard_deviations": self.size,
            "outliers": list(self.outliers),
            "p_value_without_outliers": self.without,
        }


@dataclass(frozen=True)
class StatementOfFit:
    """Whether a model accounts for recordings.

    Attributes:
        chi2: sum of squared whitened residuals, or None where the noise level was estimated from them.
        dof: readings minus all that was fitted.
        p_value: probability of a larger χ² if model and noise are right, or None where the noise was estimated.
        lack_of_fit: where there are replicates.
        worst: the row that fits worst, or None where no row is looked at.
        origin: of the noise: `recordings`, `replicates` or `residuals`.
        mean_square: of the whitened residuals, per degree of freedom.
        without_load_errors: χ² where the recorded loads are taken as exact; None where no errors of them are declared.
        left: what the model leaves of the readings; None where it is not looked at.
        exceeded: χ², degrees of freedom and p-value at stated standard deviations that the residuals exceed, so that
            the noise was estimated; else None.
    """

    chi2: float | None
    dof: int
    p_value: float | None
    lack_of_fit: LackOfFit | None = None
    worst: WorstRow | None = None
    origin: str = "recordings"
    mean_square: float = 1.0
    without_load_errors: float | None = None
    left: LeftOver | None = None
    exceeded: tuple[float, int, float] | None = None

    @classmethod
    def of_chi2(cls, value: float, dof: int, worst: WorstRow | None = None) -> "StatementOfFit":
        """The statement of a χ² against stated noise."""
        p_value = p_value_of(value, dof) if dof > 0 else None
        return cls(value, dof, p_value, worst=worst, mean_square=value / max(dof, 1))

    @property
    def verdict(self) -> Verdict:
        """Of the test; `too good`: the stated noise is too large; `not tested`: there are no degrees of freedom."""
        if self.exceeded is not None or (self.left is not None and self.left.beyond):
            return "refuted"
        if self.p_value is None:
            lack, alike = self.lack_of_fit, self.left is not None and self.left.alike
            against = alike or (lack is not None and lack.p_value < REFUTED)
            return "refuted" if against and self.chi2 is None else self._untested
        if self.p_value < REFUTED:
            return "refuted"
        small = self.chi2 is not None and float(chdtr(self.dof, self.chi2)) < _TOO_GOOD
        return "too good" if small and self.overstated >= _OVERSTATED else "not refuted"

    @property
    def _untested(self) -> Verdict:
        return "noise estimated" if self.chi2 is None else "not tested"

    @property
    def refuted(self) -> bool:
        """Whether the recordings speak against the model."""
        return self.verdict == "refuted"

    @property
    def only_outliers(self) -> bool:
        """Whether the model is refuted by single rows alone."""
        return self.refuted and self.worst is not None and (self.worst.without or 0.0) >= REFUTED

    @property
    def overstated(self) -> float:
        """√(ν/χ²): by so much the stated standard deviations exceed the residuals."""
        return sqrt(self.dof / max(self.chi2, 1e-300)) if self.chi2 is not None and self.dof > 0 else 1.0

    @property
    def birge_ratio(self) -> float:
        """√(χ²/ν) where the model is refuted, else 1: by so much the deviations of the readings are too small for it.

        Standard deviations of a refuted fit are multiplied by it (R. T. Birge, Physical Review 40, 1932, 207); those
        that residuals show are large enough.
        """
        return sqrt(max(self.mean_square, 1.0)) if self.refuted and self.origin != "residuals" else 1.0

    @property
    def reading_ratio(self) -> float:
        """By so much the noise of a reading is larger, or smaller, than stated (`noise_ratio`)."""
        return self.birge_ratio if self.chi2 is None else noise_ratio(self.chi2, self.dof)

    @property
    def tested(self) -> str:
        """The test in figures."""
        if self.chi2 is not None:
            freedom = f"chi2 {self.chi2:.6g} for {self.dof} degrees of freedom"
            if self.without_load_errors is not None:
                freedom += f" with the declared load errors ({self.without_load_errors:.6g} with exact loads)"
            return freedom if self.p_value is None else f"{freedom}, {p_text(self.p_value)}"
        if self.exceeded is not None:
            value, dof, p_value = self.exceeded
            return f"chi2 {value:.6g} for {dof} degrees of freedom at the stated noise, {p_text(p_value)}"
        if self.lack_of_fit is None:
            return f"The noise is estimated from the {self.origin}"
        return f"Lack of fit against replicates: {p_text(self.lack_of_fit.p_value)}"

    def sentence(self, model: str = "the base model", of: str = "these recordings") -> str:
        """What the test says of a model, in words."""
        left = "" if self.left is None or self.chi2 is not None else f"; {self.left.sentence} are left"
        if self.left is not None and self.left.beyond:
            return f"{self.left.sentence} are left; {self.left.against}: {model} is refuted."
        if self.chi2 is not None and self.p_value is None:
            return f"{self.tested}: as many parameters as readings are fitted, so that {model} cannot be tested."
        if self.refuted and self.left is not None and self.left.alike and self.exceeded is None and self.chi2 is None:
            return f"{self.tested}{left}; {self.left.against}: {model} is refuted."
        if self.verdict == "noise estimated" and self.lack_of_fit is None:
            return f"{self.tested}, so that {model} cannot be tested{left}."
        said = {
            "not refuted": f"{model} explains {of} to within their noise",
            "refuted": f"{model} does not explain {of} to within their noise and is refuted",
            "too good": (
                f"the stated standard deviations of {of} are about {self.overstated:.3g} times too large for what "
                f"{model} leaves. Intervals of readings have the noise that the residuals show; others are too wide "
                "until it is stated"
            ),
            "noise estimated": f"{model} explains {of} to within the scatter of their replicates",
        }
        return f"{self.tested}: {said[self.verdict]}{left}."

    @property
    def widened(self) -> str:
        """What a refuted fit does to standard deviations, in words; empty where it does nothing."""
        if self.birge_ratio == 1.0:
            return ""
        return f"Intervals and predicted standard deviations are {self.birge_ratio:.3g} times (Birge ratio) wider."

    @property
    def record(self) -> dict[str, Any]:
        """What JSON files say under `statement`."""
        return {
            "verdict": self.verdict,
            "chi2": self.chi2,
            "dof": self.dof,
            "p_value": self.p_value,
            "birge_ratio": self.birge_ratio,
            "chi2_with_exact_loads": self.without_load_errors,
            "threshold": REFUTED,
            "left_over": None if self.left is None else self.left.record,
            "worst_row": None if self.worst is None else self.worst.record,
        }


def statement_of_fit(
    fit: Fit,
    recordings: Recordings,
    noise: NoiseLevel,
    whitening: Whitening,
    columns: tuple[str, ...],
    exact: float | None = None,
) -> StatementOfFit:
    """The statement that these recordings allow.

    Args:
        fit: whose residuals are of these rows, and of no others.
        recordings: the rows that were fitted.
        noise: of the same rows.
        whitening: of the same rows.
        columns: of what the instrument reads, whether it was measured or not.
        exact: χ² where the recorded loads are taken as exact; None where no errors of them are declared.
    """
    value, dof = squares_of(fit)
    exact = exact if noise.known else None
    p_value = p_value_of(value, dof) if noise.known and dof > 0 else None
    lack = _lack_of_fit(value, dof, recordings, noise)
    worst = None
    # Where errors of the loads account for the misfit, they are in the rows as well, and no row is a mistake.
    loads_alone = exact is not None and p_value is not None and p_value >= REFUTED and not allows(exact, dof)
    if fit.residuals.size and not loads_alone:
        outlying = outlying_rows(fit, whitening, noise_known=noise.known)
        measured = tuple(columns[axis] for axis in recordings.axes)
        worst = _worst_row(outlying, recordings, measured, noise_known=noise.known)
    mean_square = value / max(dof, 1)
    chi2 = value if noise.known else None
    return StatementOfFit(chi2, dof, p_value, lack, worst, noise.origin, mean_square, exact)


def squares_of(fit: Fit) -> tuple[float, int]:
    """Sum of the squared residuals of a fit, and its degrees of freedom."""
    return float((fit.residuals**2).sum()), fit.freedom


def _worst_row(outlying: Outlying, recordings: Recordings, columns: tuple[str, ...], *, noise_known: bool) -> WorstRow:
    without = None
    if outlying.aside and noise_known and outlying.dof > 0:
        without = p_value_of(outlying.chi2, outlying.dof)
    return WorstRow(
        recordings.where(outlying.worst),
        columns[outlying.reading],
        outlying.size,
        tuple(recordings.where(row) for row in outlying.aside),
        without,
    )


def _lack_of_fit(value: float, freedom: int, recordings: Recordings, noise: NoiseLevel) -> LackOfFit | None:
    groups = replicate_groups(recordings)
    error = pure_error(recordings, noise.deviations, groups)
    squares, pure_dof = float(error.squares.sum()), error.dof * len(recordings.axes)
    dof = freedom - pure_dof
    if pure_dof == 0 or dof <= 0 or squares <= 0.0:
        return None
    ratio = max(value - squares, 0.0) / dof / (squares / pure_dof)
    return LackOfFit(ratio, dof, pure_dof, float(fdtrc(dof, pure_dof, ratio)))
