"""One Gaussian model of everything that is uncertain: fits, criteria, bounds, evidence and decisions follow from it.

    r = Σ_k B_k·w_k + e,   e ~ N(0, I),   w_k ~ N(m_k, S_k), or flat,

r being whitened readings less what is predicted at the point of linearisation. What is declared once as a `Term` is
used in every answer: stiffnesses and frames have a flat prior, errors of loads the declared one, named physics its
size.

The computation is an orthogonal factorisation of the stacked roots. With S_k = L_k·L_kᵀ and w_k = m_k + L_k·u_k,

    | B_s·L_s   A |   (u)     (r)
    |   I       0 | · (a)  ≈  (0),

s being the terms with a proper prior and A the flat ones (theory.md 3; Golub and Van Loan, Matrix Computations,
4th ed. 2013, section 6.1). Normal equations, which square the condition number, are never formed. With
C = I + Σ B_s·S_s·B_sᵀ the triangular factor R has ln|C| + ln|AᵀC⁻¹A| as twice the logarithm of its diagonal, and the
upper rows F of the orthogonal factor give Q = C⁻¹ − C⁻¹A(AᵀC⁻¹A)⁻¹AᵀC⁻¹ = I − F·Fᵀ.

What flat terms do alike is not determined: their estimable subspace, from the singular values of A in units of its
columns, is kept apart from the directions along which the readings say nothing (`Estimable`).
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import ndtr

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.models.estimable import Estimable

NOISE = "noise"
"""Source of the instrument's part in a budget."""
RANK_TOLERANCE = 1e-9
"""Singular values of the flat terms below this fraction of the largest, in units of their columns, count as zero."""
_UNPREDICTED = 1e-10
"""Eigenvalue of Q_BB below which a block alone determines some parameter, so that nothing predicts it."""

Scope = Literal["machine", "campaign", "surroundings", "target"]
"""What a term belongs to: the robot; the recordings (frames, test weights, references); both the recordings and the
targets without being the robot's (gravity, the weights where a target carries them); or a target's own payload."""


@dataclass(frozen=True)
class Term:
    """One uncertain quantity, with what it does to the readings and at the targets.

    Attributes:
        name: of the term, unique within a model.
        columns: whitened derivatives of the readings, shape (M, f).
        at_targets: the same at the targets (in the targets' own units), shape (T, f); None where it does not act there.
        root: prior root L with S = L·Lᵀ, shape (f, f), or standard deviations, shape (f,); None for a flat prior.
        mean: of the prior, relative to the point of linearisation, shape (f,); None for 0.
        source: part of the budget that the term counts to; its name where left out.
        scope: what it belongs to.
    """

    name: str
    columns: FloatArray
    at_targets: FloatArray | None = None
    root: FloatArray | None = None
    mean: FloatArray | None = None
    source: str = ""
    scope: Scope = "machine"

    @property
    def size(self) -> int:
        """f, how many parameters it has."""
        return self.columns.shape[1]

    @property
    def proper(self) -> bool:
        """Whether it has a prior that is not flat."""
        return self.root is not None

    @property
    def part(self) -> str:
        """The part of the budget that it counts to."""
        return self.source or self.name

    @property
    def prior_mean(self) -> FloatArray:
        """m, shape (f,)."""
        return np.zeros(self.size) if self.mean is None else self.mean

    @property
    def prior_root(self) -> FloatArray:
        """L, shape (f, f); of a proper prior."""
        if self.root is None:
            raise ValueError(f"the prior of `{self.name}` is flat")
        return np.diag(self.root) if self.root.ndim == 1 else self.root

    def targets(self, count: int) -> FloatArray:
        """Derivatives at `count` rows of targets, 0 where it does not act there, shape (T, f)."""
        return np.zeros((count, self.size)) if self.at_targets is None else self.at_targets

    def scaled(self, factor: float) -> "Term":
        """The same with a prior whose standard deviations are multiplied."""
        return self if self.root is None else replace(self, root=factor * self.root)


@dataclass(frozen=True)
class _Factorised:
    """The factorisation in coordinates z = (u, a) of proper terms and of the estimable subspace of flat ones.

    Attributes:
        orthogonal: F, shape (M, z).
        inverse: R⁻¹, shape (z, z).
        reduced: Fᵀ·r, shape (z,).
        to_parameters: dw/dz, shape (n, z).
        kernel: directions of w along which the readings say nothing, shape (n, d).
        units: logarithm of the units in which the flat terms were factorised, which |AᵀC⁻¹A| is corrected by.
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
        terms: what is uncertain; parameters stand in their order.
        readings: r, whitened, shape (M,); zeros where nothing was measured yet, for a plan.
    """

    terms: tuple[Term, ...]
    readings: FloatArray

    @classmethod
    def planned(cls, terms: Sequence[Term]) -> "Gaussian":
        """The model of measurements that are planned: all but what needs readings follows from the terms."""
        return cls(tuple(terms), np.zeros(len(terms[0].columns)))

    # --- parameters -------------------------------------------------------------------------------------------------
    @cached_property
    def slices(self) -> dict[str, slice]:
        """Where the parameters of every term stand, by name."""
        ends = np.cumsum([0, *(term.size for term in self.terms)])
        return {term.name: slice(ends[i], ends[i + 1]) for i, term in enumerate(self.terms)}

    @property
    def size(self) -> int:
        """n, how many parameters there are."""
        return sum(term.size for term in self.terms)

    @cached_property
    def columns(self) -> FloatArray:
        """B, shape (M, n)."""
        return np.hstack([np.empty((len(self.readings), 0)), *(term.columns for term in self.terms)])

    @cached_property
    def at_targets(self) -> FloatArray:
        """T of all terms, shape (T, n); without rows where no term acts at a target."""
        rows = max((len(term.at_targets) for term in self.terms if term.at_targets is not None), default=0)
        return np.hstack([np.empty((rows, 0)), *(term.targets(rows) for term in self.terms)])

    @cached_property
    def _means(self) -> FloatArray:
        return np.concatenate([np.empty(0), *(term.prior_mean for term in self.terms)])

    @cached_property
    def _factorised(self) -> _Factorised:
        proper = [term for term in self.terms if term.proper]
        inner = sum(term.size for term in proper)
        flat: IntArray = np.concatenate(
            [
                np.empty(0, dtype=np.int64),
                *(np.arange(self.size)[self.slices[t.name]] for t in self.terms if not t.proper),
            ]
        )
        basis, kernel, units = _estimable_basis(self.columns[:, flat])
        to_parameters = np.zeros((self.size, inner + basis.shape[1]))
        first = 0
        for term in proper:
            to_parameters[self.slices[term.name], first : first + term.size] = term.prior_root
            first += term.size
        to_parameters[flat, inner:] = basis
        stacked = np.vstack([self.columns @ to_parameters, np.eye(inner, inner + basis.shape[1])])
        orthogonal, triangular = np.linalg.qr(stacked)
        inverse = solve_triangular(triangular, np.eye(len(triangular)), check_finite=False)
        orthogonal = orthogonal[: len(self.readings)]
        reduced = orthogonal.T @ (self.readings - self.columns @ self._means)
        whole = np.zeros((self.size, kernel.shape[1]))
        whole[flat] = kernel
        return _Factorised(orthogonal, inverse, reduced, to_parameters, whole, units)

    # --- posterior --------------------------------------------------------------------------------------------------
    @cached_property
    def root(self) -> FloatArray:
        """W with the posterior covariance P = W·Wᵀ on the estimable subspace, shape (n, z)."""
        found: FloatArray = self._factorised.to_parameters @ self._factorised.inverse
        return found

    @cached_property
    def estimate(self) -> FloatArray:
        """Posterior mean of all parameters, shape (n,), as small as possible along what nothing determines."""
        found: FloatArray = self._means + self.root @ self._factorised.reduced
        return found

    @cached_property
    def gain(self) -> FloatArray:
        """K = P·Bᵀ, with which the estimate is m + K·(r − B·m), shape (n, M)."""
        found: FloatArray = self.root @ self._factorised.orthogonal.T
        return found

    @cached_property
    def estimable(self) -> Estimable:
        """Posterior covariance of all combinations of parameters that readings and priors determine."""
        precision = (self.columns**2).sum(axis=0)
        for term in self.terms:
            if term.proper:
                with np.errstate(divide="ignore"):
                    precision[self.slices[term.name]] += 1.0 / (term.prior_root**2).sum(axis=1)
        shown = precision > 0.0
        resolution = np.where(shown, 1.0 / np.sqrt(np.where(shown, precision, 1.0)), 1.0)
        return Estimable(self.root @ self.root.T, self._factorised.kernel, resolution)

    @property
    def covariance(self) -> FloatArray:
        """P, with infinite rows and columns of parameters that are not determined by themselves, shape (n, n)."""
        return self.estimable.covariance

    def of(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Posterior mean (f,) and covariance (f, f) of one term."""
        part = self.slices[name]
        return self.mean_of(name), self.covariance[part, part]

    def mean_of(self, name: str) -> FloatArray:
        """Posterior mean of one term, shape (f,)."""
        return self.estimate[self.slices[name]]

    # --- targets ----------------------------------------------------------------------------------------------------
    @cached_property
    def error(self) -> FloatArray:
        """T·P·Tᵀ, mean square errors at the targets, shape (T, T); infinite where the readings do not determine one."""
        through = self.at_targets @ self.root
        return self._infinite(through @ through.T)

    @property
    def budget(self) -> dict[str, FloatArray]:
        """Parts of `error` by source, shape (T, T) each, which add up to it (Joseph's form of P).

        The noise gives T·K·Kᵀ·Tᵀ, every term s with a proper prior (T·K·B_s − T_s)·S_s·(T·K·B_s − T_s)ᵀ, and flat ones
        nothing.
        """
        through = self.at_targets @ self.gain
        parts = {NOISE: self._infinite(through @ through.T)}
        for term in self.terms:
            if term.proper:
                mean_square = self.mean_square(term)
                parts[term.part] = parts[term.part] + mean_square if term.part in parts else mean_square
        return parts

    def bias(self, term: Term, values: FloatArray) -> FloatArray:
        """(T_h − T·K·B_h)·w_h: error at the targets by a term h with given values (f, ...), in the model or not."""
        found: FloatArray = self.unexplained(term) @ values
        return found

    def mean_square(self, term: Term) -> FloatArray:
        """Mean square errors at the targets by a term at its prior size, in the model or not, shape (T, T)."""
        through = self.unexplained(term) @ term.prior_root
        return self._infinite(through @ through.T)

    def joined(self, term: Term) -> tuple[float, FloatArray, FloatArray]:
        """What the readings say of a term that joins the model, and of the error at the targets while it is left out.

        Returns:
            By how much the log evidence rises; the posterior mean of the error, shape (T,); and a root of its
            covariance beyond that of the model, shape (T, f).
        """
        scaled = term.columns @ term.prior_root
        left = left_of(scaled.T @ self.projection(scaled))
        size = left.T @ (scaled.T @ self.projected)
        missed = self.unexplained(term) @ term.prior_root @ left
        return float(np.linalg.slogdet(left)[1] + 0.5 * size @ size), missed @ size, missed

    def unexplained(self, term: Term) -> FloatArray:
        """T_h − T·K·B_h, error at the targets per unit of a term that is left out, shape (T, f)."""
        found: FloatArray = term.targets(len(self.at_targets)) - self.at_targets @ (self.gain @ term.columns)
        return found

    def _infinite(self, squares: FloatArray) -> FloatArray:
        """Mean squares (T, T) with infinite rows and columns of targets that are not estimable."""
        known: BoolArray = np.isfinite(self.estimable.deviations(self.at_targets))
        if known.all():
            return squares
        return np.where(known[:, None] & known, squares, np.inf)

    # --- evidence ---------------------------------------------------------------------------------------------------
    @property
    def rank(self) -> int:
        """Directions of the flat terms that the readings determine."""
        return self._factorised.to_parameters.shape[1] - sum(term.size for term in self.terms if term.proper)

    @property
    def freedom(self) -> int:
        """Readings beyond what the flat terms take up; the prior of a proper term counts as readings of it."""
        return len(self.readings) - self.rank

    @cached_property
    def projected(self) -> FloatArray:
        """Q·r, shape (M,): for flat terms alone the residuals."""
        factorised = self._factorised
        found: FloatArray = self.readings - self.columns @ self._means - factorised.orthogonal @ factorised.reduced
        return found

    def projection(self, columns: FloatArray) -> FloatArray:
        """Q·B of columns (M, f)."""
        orthogonal = self._factorised.orthogonal
        found: FloatArray = columns - orthogonal @ (orthogonal.T @ columns)
        return found

    @cached_property
    def chi2(self) -> float:
        """rᵀ·Q·r: squares of the residuals and of the proper terms in units of their priors, at the estimate."""
        away = self.readings - self.columns @ self._means
        # Q is idempotent on what the proper terms leave; the product keeps digits that differences of squares lose.
        return max(float(away @ self.projected), 0.0)

    @property
    def volume(self) -> float:
        """ln|C| + ln|AᵀC⁻¹A|."""
        diagonal = np.abs(self._factorised.inverse.diagonal())
        return -2.0 * float(np.log(diagonal).sum()) - 2.0 * self._factorised.units

    @property
    def log_evidence(self) -> float:
        """Restricted log likelihood without constants, −½·(rᵀ·Q·r + ln|C| + ln|AᵀC⁻¹A|).

        (Patterson and Thompson, Biometrika 58, 1971, 545.)
        """
        return -0.5 * (self.chi2 + self.volume)

    @property
    def noise_variance(self) -> float:
        """s² that maximises the evidence where noise and priors are known up to it, rᵀ·Q·r over degrees of freedom."""
        return self.chi2 / max(self.freedom, 1)

    @property
    def log_evidence_of_unknown_noise(self) -> float:
        """The same at that s²: −½·((M − p)·(1 + ln s²) + ln|C| + ln|AᵀC⁻¹A|)."""
        misfit = max(self.freedom, 1) * (1.0 + float(np.log(max(self.noise_variance, 1e-300))))
        return -0.5 * (misfit + self.volume)

    def determined(self, name: str) -> float:
        """How many parameters of a proper term the readings determine, f − tr(S⁻¹·P)."""
        own = self._factorised.inverse[self._standard(name)]
        return float(len(own) - (own**2).sum())

    def standardised(self, name: str) -> FloatArray:
        """Posterior mean u = L⁻¹·(w − m) of a proper term in units of its prior, shape (f,).

        The log evidence changes by |u|² − `determined` with the logarithm of a factor on the prior's root.
        """
        found: FloatArray = self._factorised.inverse[self._standard(name)] @ self._factorised.reduced
        return found

    def _standard(self, name: str) -> slice:
        """Where the standardised parameters u of a proper term stand."""
        first = 0
        for term in self.terms:
            if term.name == name and term.proper:
                return slice(first, first + term.size)
            first += term.size if term.proper else 0
        raise ValueError(f"there is no term `{name}` with a proper prior")

    # --- rows that are left out -------------------------------------------------------------------------------------
    def left_out(self, blocks: IntArray) -> FloatArray:
        """Errors of readings predicted without their block, (Q_BB)⁻¹·(Q·r)_B, shape (M,).

        NaN for a block that nothing else predicts (Rasmussen and Williams 2006, section 5.4.2, by blocks).

        Args:
            blocks: block of every reading, shape (M,).
        """
        errors = np.empty_like(self.readings)
        for inside, inverse in self._blocks(blocks):
            errors[inside] = np.nan if inverse is None else inverse @ self.projected[inside]
        return errors

    def left_out_variances(self, blocks: IntArray) -> FloatArray:
        """Variances of `left_out` where the model is right, noise included, shape (M,)."""
        variances = np.empty_like(self.readings)
        for inside, inverse in self._blocks(blocks):
            variances[inside] = np.inf if inverse is None else inverse.diagonal()
        return variances

    def _blocks(self, blocks: IntArray) -> Iterator[tuple[IntArray, FloatArray | None]]:
        """Readings of every block, and (Q_BB)⁻¹ or None where it is singular."""
        for block in np.unique(blocks):
            inside = np.flatnonzero(blocks == block)
            own = self._factorised.orthogonal[inside]
            values, vectors = np.linalg.eigh(np.eye(len(inside)) - own @ own.T)
            yield inside, None if values[0] < _UNPREDICTED else vectors / values @ vectors.T

    # --- explanations -----------------------------------------------------------------------------------------------
    def without(self, names: Collection[str]) -> "Gaussian":
        """The same readings without some terms."""
        return replace(self, terms=tuple(term for term in self.terms if term.name not in names))

    def beside(self, *terms: Term) -> "Gaussian":
        """The same readings with further terms."""
        return replace(self, terms=(*self.terms, *terms))

    def shares(self, names: Sequence[str]) -> dict[str, float]:
        """Shares of terms in what they explain together beyond the others; they add up to 1.

        (P₀·r)ᵀ·B_k·w_k over their sum, P₀ being Q without the terms that are named; a negative share compensates
        another one. All are 0 where nothing is explained.
        """
        left = self.without(names).projected
        moved = {name: float(left @ (self.columns[:, self.slices[name]] @ self.mean_of(name))) for name in names}
        together = sum(moved.values())
        return {name: value / together if together != 0.0 else 0.0 for name, value in moved.items()}


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


@dataclass(frozen=True)
class Mixture:
    """Several Gaussian models of one thing, with their probabilities.

    Attributes:
        weights: of the models, which add up to 1, shape (m,).
        means: of every model, shape (m, T).
        covariances: shape (m, T, T).
    """

    weights: FloatArray
    means: FloatArray
    covariances: FloatArray

    @classmethod
    def of(
        cls, models: Sequence[Gaussian], *, temperature: float = 1.0, log_prior: FloatArray | None = None
    ) -> "Mixture":
        """What models of the same readings say at the same targets, weighed by their evidence.

        Args:
            models: with the same flat terms, or flat terms that are comparable.
            temperature: that differences of log evidence are divided by.
            log_prior: logarithms of prior probabilities, shape (m,); all alike if left out.
        """
        logs = np.array([model.log_evidence for model in models]) / temperature
        logs = logs if log_prior is None else logs + log_prior
        weights = np.exp(logs - logs.max())
        means = np.stack([model.at_targets @ model.estimate for model in models])
        return cls(weights / weights.sum(), means, np.stack([model.error for model in models]))

    @property
    def mean(self) -> FloatArray:
        """Shape (T,)."""
        return self.weights @ self.means

    @property
    def covariance(self) -> FloatArray:
        """Mean of the covariances and covariance of the means, shape (T, T)."""
        away = self.means - self.mean
        found: FloatArray = np.einsum("m,mij->ij", self.weights, self.covariances)
        return found + np.einsum("m,mi,mj->ij", self.weights, away, away)

    def beyond(self, limits: FloatArray, corrected: FloatArray | None = None) -> FloatArray:
        """Probability that what is left after a correction lies beyond ± limits (T,), row by row, shape (T,).

        Args:
            limits: shape (T,).
            corrected: what the correction takes away, shape (T,); the mean if left out.
        """
        left = self.means - (self.mean if corrected is None else corrected)
        deviations = np.sqrt(np.maximum(np.diagonal(self.covariances, axis1=1, axis2=2), 1e-300))
        outside = ndtr((-limits - left) / deviations) + ndtr((left - limits) / deviations)
        found: FloatArray = self.weights @ outside
        return found
