"""Evidence for laws: y = A·c + Σ_k Φ_k·w_k + e with c unknown, w_k ~ N(0, σ_k²·I) and e ~ N(0, I).

The precision projected on what c cannot do, P = V⁻¹ − V⁻¹A(AᵀV⁻¹A)⁻¹AᵀV⁻¹ with V = I + Σ σ_k²·Φ_k·Φ_kᵀ, is I − F·Fᵀ
with F = H·L⁻ᵀ, H = [A, Φ_1, ...], L·Lᵀ = HᵀH + diag(prior precisions). The restricted log evidence (Patterson and
Thompson 1971) is −½(yᵀPy + ln det(HᵀH + D) + Σ f_k·ln σ_k²) up to a constant.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from expdesign.arrays import FloatArray, IntArray

_LEAST, _MOST = 1e-3, 1e6
"""Bounds of σ²: mean variance of the readings by a law, in variances of the noise."""


@dataclass(frozen=True)
class Present:
    """Laws that are present with their sizes, conditional on which others are judged.

    Attributes:
        base: whitened directions of what has no prior (or whose precision is given), shape (M, p).
        precision: prior precision of those, shape (p,).
        readings: whitened, shape (M,).
        laws: directions of every law, shape (M, f_k).
        variances: σ_k².
    """

    base: FloatArray
    precision: FloatArray
    readings: FloatArray
    laws: tuple[FloatArray, ...] = ()
    variances: tuple[float, ...] = ()

    @cached_property
    def _factors(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """H, prior precisions, lower L, and F with P = I − F·Fᵀ."""
        design = np.hstack([self.base, *self.laws])
        widths = [law.shape[1] for law in self.laws]
        precision = np.concatenate(
            [self.precision, *(np.full(w, 1.0 / v) for w, v in zip(widths, self.variances, strict=True))]
        )
        normal = design.T @ design + np.diag(precision)
        normal[np.diag_indices_from(normal)] *= 1.0 + 1e-10
        lower = np.linalg.cholesky(normal)
        return design, precision, lower, solve_triangular(lower, design.T, lower=True).T

    @property
    def factor(self) -> FloatArray:
        """F with P = I − F·Fᵀ, shape (M, r)."""
        return self._factors[3]

    @cached_property
    def projected(self) -> FloatArray:
        """P·y, shape (M,)."""
        result: FloatArray = self.readings - self.factor @ (self.factor.T @ self.readings)
        return result

    @cached_property
    def log_evidence(self) -> float:
        """Up to a constant that depends on the base alone."""
        _, _, lower, _ = self._factors
        volume = 2.0 * float(np.log(lower.diagonal()).sum())
        volume += sum(law.shape[1] * np.log(v) for law, v in zip(self.laws, self.variances, strict=True))
        return -0.5 * (float(self.readings @ self.projected) + volume)

    @cached_property
    def weights(self) -> FloatArray:
        """Posterior mean of c and all weights."""
        _, _, lower, factor = self._factors
        return np.asarray(solve_triangular(lower.T, factor.T @ self.readings))

    def with_variances(self, variances: Sequence[float]) -> "Present":
        """The same laws with other sizes."""
        return Present(self.base, self.precision, self.readings, self.laws, tuple(variances))

    def beside(self, law: FloatArray, variance: float) -> "Present":
        """With one more law."""
        laws, variances = (*self.laws, law), (*self.variances, variance)
        return Present(self.base, self.precision, self.readings, laws, variances)

    def without(self, index: int) -> "Present":
        """With one law less."""
        laws = self.laws[:index] + self.laws[index + 1 :]
        variances = self.variances[:index] + self.variances[index + 1 :]
        return Present(self.base, self.precision, self.readings, laws, variances)

    def refitted(self) -> "Present":
        """With the sizes that maximise the evidence together (L-BFGS-B on ln σ²).

        ∂/∂ln σ² = ½(w̄ᵀw̄/σ² + tr C/σ² − f) with w̄ and C mean and covariance of the law's weights.
        """
        if not self.laws:
            return self
        widths = [law.shape[1] for law in self.laws]
        first = self.base.shape[1]
        edges = first + np.concatenate([[0], np.cumsum(widths)])

        def misfit(logs: FloatArray) -> tuple[float, FloatArray]:
            state = self.with_variances(np.exp(logs).tolist())
            lower = state._factors[2]
            inverse = solve_triangular(lower, np.eye(len(lower)), lower=True)
            variance = (inverse**2).sum(axis=0)
            weights = state.weights
            slope = []
            for k, width in enumerate(widths):
                part = slice(edges[k], edges[k + 1])
                slope.append(
                    0.5
                    * ((float(weights[part] @ weights[part]) + float(variance[part].sum())) / np.exp(logs[k]) - width)
                )
            return -state.log_evidence, -np.array(slope)

        bounds = [(np.log(_LEAST), np.log(_MOST))] * len(widths)
        found = minimize(
            misfit, np.log(self.variances), jac=True, method="L-BFGS-B", bounds=bounds,
            options={"maxiter": 15, "ftol": 1e-7},
        )  # fmt: skip
        return self.with_variances(np.exp(found.x).tolist())

    def gain(self, law: FloatArray) -> tuple[float, float]:
        """Largest gain of log evidence by one more law, and its σ² (section 3 of the note on laws).

        With Φᵀ·P·Φ = U·Λ·Uᵀ and w = Uᵀ·Φᵀ·P·y: ½·Σ_i [σ²·w_i²/(1 + σ²·λ_i) − ln(1 + σ²·λ_i)].

        Args:
            law: its directions Φ, shape (M, f).
        """
        through = self.factor.T @ law
        values, vectors = np.linalg.eigh(law.T @ law - through.T @ through)
        values = np.maximum(values, 0.0)
        squares = (vectors.T @ (law.T @ self.projected)) ** 2

        def of(logs: FloatArray) -> FloatArray:
            variance = np.exp(logs)[:, None]
            share = 1.0 + variance * values
            result: FloatArray = 0.5 * (variance * squares / share - np.log(share)).sum(axis=1)
            return result

        grid = np.linspace(np.log(_LEAST), np.log(_MOST), 42)
        gains = of(grid)
        best = int(np.argmax(gains))
        if gains[best] <= 0.0:
            return 0.0, _LEAST
        low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
        fine = np.linspace(low, high, 15)
        gains = of(fine)
        best = int(np.argmax(gains))
        return float(gains[best]), float(np.exp(fine[best]))

    def left_out(self, blocks: IntArray) -> FloatArray:
        """Errors of readings predicted without the block that they belong to, e_B = (P_BB)⁻¹(P·y)_B, shape (M,).

        (Leave-one-group-out of a linear smoother; Rasmussen and Williams 2006, section 5.4.2 for single readings.)

        Args:
            blocks: block of every reading, shape (M,).
        """
        errors = np.empty_like(self.readings)
        for inside, precision in self._precisions(blocks):
            errors[inside] = np.linalg.solve(precision, self.projected[inside])
        return errors

    def left_out_variances(self, blocks: IntArray) -> FloatArray:
        """Variances of `left_out` where the model is right, the noise included: diagonals of (P_BB)⁻¹, shape (M,)."""
        variances = np.empty_like(self.readings)
        for inside, precision in self._precisions(blocks):
            variances[inside] = np.linalg.inv(precision).diagonal()
        return variances

    def _precisions(self, blocks: IntArray) -> Iterator[tuple[IntArray, FloatArray]]:
        """Readings of every block and their P_BB = I − F_B·F_Bᵀ, regular however little the other blocks determine."""
        for block in np.unique(blocks):
            inside = np.flatnonzero(blocks == block)
            own = self.factor[inside]
            yield inside, (1.0 + 1e-9) * np.eye(len(inside)) - own @ own.T
