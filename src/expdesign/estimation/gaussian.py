"""One Gaussian model of everything that is uncertain: evidence, intervals and decisions follow from it.

    r = B·w + e,   e ~ N(0, I),   w ~ N(m, S), or flat,

r being whitened readings less what is predicted at the point of linearisation. Stiffnesses and frames have a flat
prior, errors of loads the declared one, named physics its size.

The computation is an orthogonal factorisation of the stacked roots. With w_s = m_s + S^(½)·u of the parameters that
have a prior, and the columns A of the flat ones,

    | B_s·S^(½)   A |   (u)     (r)
    |   I         0 | · (a)  ≈  (0)

(theory.md 3; Golub and Van Loan, Matrix Computations, 4th ed. 2013, section 6.1). Normal equations, which square the
condition number, are never formed. With C = I + B_s·S·B_sᵀ the triangular factor R has ln|C| + ln|AᵀC⁻¹A| as twice the
logarithm of its diagonal, and the upper rows F of the orthogonal factor give
Q = C⁻¹ − C⁻¹A(AᵀC⁻¹A)⁻¹AᵀC⁻¹ = I − F·Fᵀ.

What flat parameters do alike is not determined: their estimable subspace, from the singular values of A in units of its
columns, is kept apart from the directions along which the readings say nothing (`Estimable`).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.models.estimable import Estimable

RANK_TOLERANCE = 1e-9
"""Singular values of flat columns below this fraction of the largest, in units of their lengths, count as zero."""
_UNPREDICTED = 1e-10
"""Eigenvalue of Q_BB below which a block alone determines some parameter, so that nothing predicts it."""


@dataclass(frozen=True)
class _Factorised:
    """The factorisation in coordinates z = (u, a): u of parameters with a prior, a of the estimable subspace of others.

    Attributes:
        orthogonal: F, shape (M, z).
        inverse: R⁻¹, shape (z, z).
        reduced: Fᵀ·r, shape (z,).
        to_parameters: dw/dz, shape (n, z).
        kernel: directions of w along which the readings say nothing, shape (n, d).
        units: logarithm of the units in which the flat columns were factorised, which |AᵀC⁻¹A| is corrected by.
    """

    orthogonal: FloatArray
    inverse: FloatArray
    reduced: FloatArray
    to_parameters: FloatArray
    kernel: FloatArray
    units: float


@dataclass(frozen=True)
class Gaussian:
    """The Gaussian model of some whitened readings.

    Attributes:
        columns: B, whitened derivatives of the readings, shape (M, n).
        readings: r, whitened, shape (M,).
        deviation: √S of the priors, shape (n,); infinite where one is flat.
        mean: m of the priors, relative to the point of linearisation, shape (n,); None for 0.
        at_targets: T, derivatives at the targets in units of their own, shape (T, n); 0 where a parameter does not act
            there, None without targets.
    """

    columns: FloatArray
    readings: FloatArray
    deviation: FloatArray
    mean: FloatArray | None = None
    at_targets: FloatArray | None = None

    @cached_property
    def proper(self) -> IntArray:
        """Parameters whose prior is not flat."""
        return np.flatnonzero(np.isfinite(self.deviation))

    @cached_property
    def _away(self) -> FloatArray:
        """Readings less those at the means, shape (M,)."""
        return self.readings if self.mean is None else self.readings - self.columns @ self.mean

    @cached_property
    def _factorised(self) -> _Factorised:
        inner, flat = len(self.proper), np.flatnonzero(~np.isfinite(self.deviation))
        basis, kernel, units = _estimable_basis(self.columns[:, flat])
        to_parameters = np.zeros((len(self.deviation), inner + basis.shape[1]))
        to_parameters[self.proper, np.arange(inner)] = self.deviation[self.proper]
        to_parameters[flat, inner:] = basis
        stacked = np.vstack([self.columns @ to_parameters, np.eye(inner, inner + basis.shape[1])])
        orthogonal, triangular = np.linalg.qr(stacked)
        inverse = solve_triangular(triangular, np.eye(len(triangular)), check_finite=False)
        orthogonal = orthogonal[: len(self.readings)]
        whole = np.zeros((len(self.deviation), kernel.shape[1]))
        whole[flat] = kernel
        return _Factorised(orthogonal, inverse, orthogonal.T @ self._away, to_parameters, whole, units)

    # --- posterior --------------------------------------------------------------------------------------------------
    @cached_property
    def root(self) -> FloatArray:
        """W with the posterior covariance P = W·Wᵀ on the estimable subspace, shape (n, z)."""
        found: FloatArray = self._factorised.to_parameters @ self._factorised.inverse
        return found

    @cached_property
    def estimate(self) -> FloatArray:
        """Posterior mean of all parameters, shape (n,), as small as possible along what nothing determines."""
        found: FloatArray = self.root @ self._factorised.reduced
        return found if self.mean is None else self.mean + found

    @cached_property
    def gain(self) -> FloatArray:
        """K = P·Bᵀ, with which the estimate is m + K·(r − B·m), shape (n, M)."""
        found: FloatArray = self.root @ self._factorised.orthogonal.T
        return found

    @cached_property
    def estimable(self) -> Estimable:
        """Posterior covariance of all combinations of parameters that readings and priors determine."""
        with np.errstate(divide="ignore"):
            precision = (self.columns**2).sum(axis=0) + 1.0 / self.deviation**2
        shown = precision > 0.0
        resolution = np.where(shown, 1.0 / np.sqrt(np.where(shown, precision, 1.0)), 1.0)
        return Estimable(self.root @ self.root.T, self._factorised.kernel, resolution)

    # --- what is left out of the model ------------------------------------------------------------------------------
    def joined(
        self, columns: FloatArray, at_targets: FloatArray, deviation: float
    ) -> tuple[float, FloatArray, FloatArray]:
        """What the readings say of parameters that join the model, and of the error at the targets while they are out.

        Args:
            columns: whitened derivatives of the readings, shape (M, f).
            at_targets: the same at the targets, shape (T, f).
            deviation: of their priors about 0.

        Returns:
            By how much the log evidence rises; the posterior mean of the error, shape (T,); and a root of its
            covariance beyond that of the model, shape (T, f).
        """
        scaled = columns * deviation
        left = left_of(scaled.T @ self.projection(scaled))
        size = left.T @ (scaled.T @ self.projected)
        missed = self.unexplained(columns, at_targets) @ (deviation * left)
        return float(np.linalg.slogdet(left)[1] + 0.5 * size @ size), missed @ size, missed

    def unexplained(self, columns: FloatArray, at_targets: FloatArray) -> FloatArray:
        """T_h − T·K·B_h, error at the targets per unit of a parameter that is left out, shape (T, f)."""
        assert self.at_targets is not None
        found: FloatArray = at_targets - self.at_targets @ (self.gain @ columns)
        return found

    # --- evidence ---------------------------------------------------------------------------------------------------
    @property
    def rank(self) -> int:
        """Directions of the flat parameters that the readings determine."""
        return self._factorised.to_parameters.shape[1] - len(self.proper)

    @cached_property
    def projected(self) -> FloatArray:
        """Q·r, shape (M,): for flat priors alone the residuals."""
        found: FloatArray = self._away - self._factorised.orthogonal @ self._factorised.reduced
        return found

    def projection(self, columns: FloatArray) -> FloatArray:
        """Q·B of columns (M, f)."""
        orthogonal = self._factorised.orthogonal
        found: FloatArray = columns - orthogonal @ (orthogonal.T @ columns)
        return found

    @cached_property
    def chi2(self) -> float:
        """rᵀ·Q·r: squares of the residuals and of the parameters in units of their priors, at the estimate."""
        # Q is idempotent on what the priors leave; the product keeps digits that differences of squares lose.
        return max(float(self._away @ self.projected), 0.0)

    @property
    def log_evidence(self) -> float:
        """Restricted log likelihood without constants, −½·(rᵀ·Q·r + ln|C| + ln|AᵀC⁻¹A|).

        (Patterson and Thompson, Biometrika 58, 1971, 545.)
        """
        diagonal = np.abs(self._factorised.inverse.diagonal())
        return -0.5 * self.chi2 + float(np.log(diagonal).sum()) + self._factorised.units

    @property
    def determined(self) -> FloatArray:
        """How far the readings determine each of `proper`, diag(I − S^(−½)·P·S^(−½)), shape (s,)."""
        return np.asarray(1.0 - (self._factorised.inverse[: len(self.proper)] ** 2).sum(axis=1))

    @property
    def standardised(self) -> FloatArray:
        """Posterior mean u of each of `proper` in units of its prior, shape (s,).

        The log evidence changes by Σ u² − `determined` with the logarithm of a factor on the deviations of some.
        """
        found: FloatArray = self._factorised.inverse[: len(self.proper)] @ self._factorised.reduced
        return found

    # --- rows that are left out -------------------------------------------------------------------------------------
    def left_out(self, blocks: IntArray) -> FloatArray:
        """Errors of readings predicted without their block, (Q_BB)⁻¹·(Q·r)_B, shape (M,).

        NaN for a block that nothing else predicts (Rasmussen and Williams 2006, section 5.4.2, by blocks).

        Args:
            blocks: block of every reading, shape (M,).
        """
        errors = np.full_like(self.readings, np.nan)
        for block in np.unique(blocks):
            inside = np.flatnonzero(blocks == block)
            own = self._factorised.orthogonal[inside]
            values, vectors = np.linalg.eigh(np.eye(len(inside)) - own @ own.T)
            if values[0] >= _UNPREDICTED:
                errors[inside] = (vectors / values @ vectors.T) @ self.projected[inside]
        return errors


def _estimable_basis(columns: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Basis of the estimable subspace (p, a) and of the kernel (p, d) of flat columns (M, p), and the units' logarithm.

    With A·D = U·Σ·Vᵀ, D = diag(1/‖a_j‖), they are D·V₁ and D·V₂. The logarithm is that of the volume of D over the
    columns that any reading shows, so that |AᵀC⁻¹A| is that of the parameters themselves where all are estimable.
    """
    lengths = np.linalg.norm(columns, axis=0)
    shown = lengths > 0.0
    units = np.where(shown, 1.0 / np.where(shown, lengths, 1.0), 1.0)
    if not columns.shape[1]:
        return np.empty((0, 0)), np.empty((0, 0)), 0.0
    triangular = np.linalg.qr(columns * units, mode="r")
    _, singular, right = np.linalg.svd(triangular)
    singular = np.append(singular, np.zeros(columns.shape[1] - len(singular)))
    kept: BoolArray = singular > RANK_TOLERANCE * max(singular[0], 1e-300)
    basis = units[:, None] * right.T
    return basis[:, kept], basis[:, ~kept], float(np.log(units[shown]).sum())


def left_of(information: FloatArray) -> FloatArray:
    """Root of (I + V)⁻¹, what readings with information V leave of unit normal parameters, shape (..., f, f)."""
    values, axes = np.linalg.eigh(information)
    root: FloatArray = axes / np.sqrt(1.0 + np.maximum(values, 0.0))[..., None, :]
    return root
