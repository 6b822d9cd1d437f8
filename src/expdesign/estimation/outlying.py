"""Rows that stand out from the others: the worst is set aside and the model fitted again, until none stands out.

A row that a shift of its own readings is added to says nothing more about the model. With whitened residuals r, the
residual maker Q = I − S·P·Sᵀ of the fit and the whitened directions D of the row's readings, the shift lowers χ² by
(Dᵀr)ᵀ·(DᵀQD)⁻¹·(Dᵀr), and fitting it leaves Q − QD·(DᵀQD)⁻¹·DᵀQ (mean-shift model: Cook and Weisberg, Residuals and
Influence in Regression, 1982, section 2.2.2; exact for a linear model). The readings that remain set the scale where
they scatter more than their noise: a row is compared with the other rows, and not with a noise that all of them exceed.

`influence` says what every row contributed: leverage, whether it stands out, and which actuator it informed.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.special import chdtrc, fdtrc

from expdesign.arrays import BoolArray, FloatArray
from expdesign.estimation.fit import Fit
from expdesign.estimation.whitening import Whitening

_ROUNDING = 1e-9
"""Share of a reading's variance that a fit leaves it below which the reading alone determines a parameter."""


_LEVEL = 0.01
"""Chance that recordings without mistakes have a row flagged (shared among the rows, Bonferroni)."""
_SHARE, _FEWEST = 0.05, 3
"""Of the rows, and rows however few there are, that may be set aside; where more would have to, they are no single
mistakes and none is."""


@dataclass(frozen=True)
class Outlying:
    """The rows of a fit by how they stand out.

    Attributes:
        worst: the row whose removal lowers χ² the most.
        reading: which of its readings stands out the most, index into the measured components.
        size: that reading's residual in standard deviations of what it would be by noise.
        aside: outliers, worst first; empty where there is none, or where they are too many for single mistakes.
        chi2: of the readings without them.
        dof: of the same.
    """

    worst: int
    reading: int
    size: float
    aside: tuple[int, ...]
    chi2: float
    dof: int


@dataclass
class _Rows:
    """Residuals (N, k) and residual maker of a fit, as rows are set aside.

    Attributes:
        residuals: r, shape (N, k).
        basis: B with Q = I − B·Bᵀ, shape (N, k, m).
        whitening: of the rows.
    """

    residuals: FloatArray
    basis: FloatArray
    whitening: Whitening
    room: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self.room = self.whitening.precision
        self._occupy(self.basis)

    def _occupy(self, columns: FloatArray) -> None:
        turned = self.whitening.scores(columns)
        self.room = self.room - turned @ turned.swapaxes(1, 2)

    def shifts(self) -> tuple[FloatArray, FloatArray]:
        """What a shift of each row lowers χ² by, shape (N,), and its readings in standard deviations (N, k)."""
        scores = self.whitening.scores(self.residuals)
        room = np.maximum(np.einsum("nkk->nk", self.room), _ROUNDING)
        floor = _ROUNDING * np.eye(self.residuals.shape[1])
        lowered = (scores * np.linalg.solve(self.room + floor, scores[..., None])[..., 0]).sum(axis=1)
        tiny = np.linalg.norm(self.residuals, axis=1) <= _ROUNDING**0.5
        return np.where(tiny, 0.0, np.maximum(lowered, 0.0)), scores / np.sqrt(room)

    def set_aside(self, row: int) -> None:
        """Fit a shift of a row."""
        count, readings = self.residuals.shape
        unit = np.zeros((count, readings, readings))
        unit[row] = np.eye(readings)
        shift = self.whitening.decorrelated(unit)
        flat = self.basis.reshape(count * readings, -1)
        left = shift.reshape(count * readings, readings)
        left = left - flat @ (flat.T @ left)
        root = np.linalg.cholesky(left.T @ left + _ROUNDING * np.eye(readings))
        added = np.linalg.solve(root, left.T).T
        self.residuals = self.residuals - (added @ (added.T @ self.residuals.ravel())).reshape(count, readings)
        added = added.reshape(count, readings, readings)
        self.basis = np.concatenate([self.basis, added], axis=2)
        self._occupy(added)


def outlying_rows(fit: Fit, whitening: Whitening, *, noise_known: bool) -> Outlying:
    """The worst row of a fit, and its outliers.

    Args:
        fit: whose residuals and sensitivities are of the rows of `whitening`.
        whitening: of these rows.
        noise_known: whether their standard deviations are stated.
    """
    count, readings = fit.residuals.shape
    rows = _Rows(fit.residuals, fit.sensitivities @ _root(fit.estimable.generalised), whitening)
    lowered, sizes = rows.shifts()
    worst = int(lowered.argmax())
    reading = int(np.abs(sizes[worst]).argmax())
    whole = float((fit.residuals**2).sum())
    nothing = Outlying(worst, reading, float(abs(sizes[worst, reading])), (), whole, fit.freedom)
    left, freedom, aside = whole, fit.freedom, list[int]()
    while freedom > readings:
        row = int(lowered.argmax())
        rest = (left - float(lowered[row])) / (freedom - readings)
        if _chance(float(lowered[row]), readings, rest, freedom - readings, noise_known) >= _LEVEL / count:
            break
        aside.append(row)
        if len(aside) > max(_FEWEST, _SHARE * count):
            return nothing
        rows.set_aside(row)
        left, freedom = float((rows.residuals**2).sum()), freedom - readings
        lowered, _ = rows.shifts()
        lowered[aside] = 0.0
    return Outlying(worst, reading, nothing.size, tuple(aside), left, freedom)


def _chance(lowered: float, readings: int, rest: float, freedom: int, noise_known: bool) -> float:
    """How probable it is that noise lets one row lower χ² by as much, the others scattering with variance `rest`."""
    if noise_known and rest <= 1.0:
        return float(chdtrc(readings, lowered))
    return float(fdtrc(readings, freedom, lowered / readings / max(rest, 1e-300)))


def _root(covariance: FloatArray) -> FloatArray:
    """A root R with R·Rᵀ = P, shape (p, p); parameters may differ in unit by orders of magnitude."""
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    safe = np.where(deviations > 0.0, deviations, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(safe, safe))
    root: FloatArray = safe[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    return root


@dataclass(frozen=True)
class Influence:
    """Contributions of N rows.

    Attributes:
        leverage: trace of each row's block of the hat matrix, between 0 and the number of its readings; their sum is
            the number of parameters (less what a prior contributes), shape (N,).
        p_value: of by how much χ² is lower without each row, one row at a time, shape (N,).
        outlier: rows that stand out from the others (`outlying.outlying_rows`), shape (N,).
        share: part of the information on each actuator's compliance that the row holds, shape (N, n_p); columns add up
            to 1.
    """

    leverage: FloatArray
    p_value: FloatArray
    outlier: BoolArray
    share: FloatArray


def influence(fit: Fit, whitening: Whitening, *, noise_known: bool) -> Influence:
    """Contributions of the rows of a fit to its parameters.

    With known noise that is χ²-distributed with one degree of freedom per reading; otherwise it is compared
    with the residuals of all other rows, which makes it F-distributed.
    """
    leverage = ((fit.sensitivities @ fit.estimable.generalised) * fit.sensitivities).sum(axis=(1, 2))
    readings = fit.residuals.shape[1]
    p_value: FloatArray = np.ones(len(leverage))
    lowered, _ = _Rows(fit.residuals, fit.sensitivities @ _root(fit.estimable.generalised), whitening).shifts()
    others = fit.freedom - readings
    if noise_known:
        p_value = chdtrc(readings, lowered)
    elif others > 0:
        rest = np.maximum(float((fit.residuals**2).sum()) - lowered, 1e-300) / others
        p_value = fdtrc(readings, others, lowered / readings / rest)
    outlier = np.zeros(len(leverage), dtype=bool)
    outlier[list(outlying_rows(fit, whitening, noise_known=noise_known).aside)] = True
    information = (fit.sensitivities**2).sum(axis=1)
    total = information.sum(axis=0)
    share = information / np.where(total > 0.0, total, 1.0)
    return Influence(leverage, p_value, outlier, share)
