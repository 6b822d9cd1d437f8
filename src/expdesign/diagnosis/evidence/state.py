"""Evidence for laws: y = A·c + Σ_k Φ_k·w_k + e with c unknown, w_k ~ N(0, σ_k²·I) and e ~ N(0, I).

The precision projected on what c cannot do, P = V⁻¹ − V⁻¹A(AᵀV⁻¹A)⁻¹AᵀV⁻¹ with V = I + Σ σ_k²·Φ_k·Φ_kᵀ, is I − F·Fᵀ
with F = H·L⁻ᵀ, H = [A, Φ_1, ...], L·Lᵀ = HᵀH + diag(prior precisions). The restricted log evidence (Patterson and
Thompson 1971) is −½(yᵀPy + ln det(HᵀH + D) + Σ f_k·ln σ_k²) up to a constant.

Where the noise is not known, e ~ N(0, s²·I) and w_k ~ N(0, s²·σ_k²·I): s² = yᵀPy/(M − p) maximises the evidence, in
which (M − p)·(1 + ln s²) stands in the place of yᵀPy, p being the directions of c.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dtrtri
from scipy.optimize import minimize

from expdesign.arrays import BoolArray, FloatArray, IntArray, as_matrix
from expdesign.estimation.fit import Data, Fit

_LEAST, _MOST = 1e-3, 1e6
"""Bounds of σ²: mean variance of the readings by a law, in variances of the noise."""
_ALONE = 1.0 + 1e-9
"""Diagonal of I − F·Fᵀ, so that a reading that nothing else predicts leaves it regular."""
_ROUNDING = 1e-12
"""Share of yᵀPy below which what is left of it is rounding."""


@dataclass(frozen=True)
class Present:
    """Laws that are present with their sizes, conditional on which others are judged.

    Attributes:
        base: whitened directions of what has no prior (or whose precision is given), shape (M, p).
        precision: prior precision of those, shape (p,).
        readings: whitened, shape (M,).
        laws: directions of every law, shape (M, f_k).
        variances: σ_k², in variances of the noise.
        known_noise: whether the noise is as stated, s² = 1.
    """

    base: FloatArray
    precision: FloatArray
    readings: FloatArray
    laws: tuple[FloatArray, ...] = ()
    variances: tuple[float, ...] = ()
    known_noise: bool = True

    @cached_property
    def _products(self) -> tuple[FloatArray, FloatArray]:
        """HᵀH and Hᵀy, which do not change with the sizes."""
        design = self.design
        return design.T @ design, design.T @ self.readings

    @property
    def design(self) -> FloatArray:
        """H, shape (M, r)."""
        return np.hstack([self.base, *self.laws])

    @cached_property
    def lower(self) -> FloatArray:
        """L with L·Lᵀ = HᵀH + diag(prior precisions), shape (r, r)."""
        sizes = zip(self.laws, self.variances, strict=True)
        precision = [self.precision, *(np.full(law.shape[1], 1.0 / size) for law, size in sizes)]
        normal = self._products[0] + np.diag(np.concatenate(precision))
        normal[np.diag_indices_from(normal)] *= 1.0 + 1e-10
        result: FloatArray = np.linalg.cholesky(normal)
        return result

    @cached_property
    def reduced(self) -> FloatArray:
        """Fᵀy = L⁻¹·Hᵀy, shape (r,)."""
        return np.asarray(solve_triangular(self.lower, self._products[1], lower=True, check_finite=False))

    @property
    def factor(self) -> FloatArray:
        """F with P = I − F·Fᵀ, which is too large to be kept with every state of a search, shape (M, r)."""
        return np.asarray(solve_triangular(self.lower, self.design.T, lower=True, check_finite=False)).T

    @cached_property
    def projected(self) -> FloatArray:
        """P·y = y − H·w with the posterior means w of c and all weights, shape (M,)."""
        return self.readings - self.design @ self.weights

    @cached_property
    def scatter(self) -> float:
        """yᵀPy."""
        return max(float(self.readings @ self.readings - self.reduced @ self.reduced), 1e-300)

    @property
    def freedom(self) -> int:
        """M − p: readings beyond what the base takes up, at least 1."""
        return max(len(self.readings) - self.base.shape[1], 1)

    @property
    def noise_variance(self) -> float:
        """s²: 1 where the noise is known."""
        return 1.0 if self.known_noise else self.scatter / self.freedom

    @cached_property
    def log_evidence(self) -> float:
        """Up to a constant that depends on the base alone."""
        volume = 2.0 * float(np.log(self.lower.diagonal()).sum())
        volume += sum(law.shape[1] * np.log(v) for law, v in zip(self.laws, self.variances, strict=True))
        misfit = self.scatter if self.known_noise else self.freedom * (1.0 + np.log(self.noise_variance))
        return -0.5 * (misfit + volume)

    @cached_property
    def weights(self) -> FloatArray:
        """Posterior mean of c and all weights."""
        return np.asarray(solve_triangular(self.lower, self.reduced, lower=True, trans=1, check_finite=False))

    @property
    def posterior_variances(self) -> FloatArray:
        """Of c and all weights, in variances of the noise."""
        inverse, _ = dtrtri(self.lower, lower=1)
        return np.asarray(np.einsum("ij,ij->j", inverse, inverse))

    def posterior(self, index: int) -> tuple[FloatArray, FloatArray]:
        """Mean (f,) and covariance (f, f) of the weights of one law, the latter in variances of the noise."""
        inverse, _ = dtrtri(self.lower, lower=1)
        own = inverse[:, self._part(index)]
        return self.weights_of(index), own.T @ own

    def weights_of(self, index: int) -> FloatArray:
        """Posterior mean of the weights of one law, shape (f,)."""
        return self.weights[self._part(index)]

    def moved(self, index: int) -> FloatArray:
        """What one law does to the readings, shape (M,)."""
        found: FloatArray = self.laws[index] @ self.weights_of(index)
        return found

    @property
    def shares(self) -> FloatArray:
        """Share of each law in what all explain together, (P₀y)ᵀΦ_k·w_k/(yᵀP₀y − yᵀPy), shape (number of laws,).

        P₀ is P without laws. P₀·Σ_k Φ_k·w_k = P₀y − Py, so that shares add up to 1, whichever laws stand in for each
        other; a negative one compensates another law.
        """
        without = self.alone.projected
        taken = np.array([without @ self.moved(index) for index in range(len(self.laws))])
        found: FloatArray = taken / max(float(taken.sum()), 1e-300)
        return found

    def determined(self, index: int) -> float:
        """How many weights of one law the readings determine, Σ (1 − C_ii/σ²)."""
        return float((1.0 - self.posterior_variances[self._part(index)] / self.variances[index]).sum())

    def _part(self, index: int) -> slice:
        first = self.base.shape[1] + sum(law.shape[1] for law in self.laws[:index])
        return slice(first, first + self.laws[index].shape[1])

    def with_variances(self, variances: Sequence[float]) -> "Present":
        """The same laws with other sizes."""
        return self._with(self.laws, variances, self._products)

    @property
    def alone(self) -> "Present":
        """What has no prior, without laws."""
        return replace(self, laws=(), variances=())

    def beside(self, law: FloatArray, variance: float) -> "Present":
        """With one more law."""
        (gram, right), cross = self._products, self.design.T @ law
        products = np.block([[gram, cross], [cross.T, law.T @ law]]), np.append(right, law.T @ self.readings)
        return self._with((*self.laws, law), (*self.variances, variance), products)

    def of_rows(self, rows: BoolArray) -> "Present":
        """The same beside some of the readings alone, shape (M,)."""
        laws = tuple(law[rows] for law in self.laws)
        return replace(self, base=self.base[rows], readings=self.readings[rows], laws=laws)

    def without(self, index: int) -> "Present":
        """With one law less."""
        widths = [self.base.shape[1], *(law.shape[1] for law in self.laws)]
        kept = np.repeat(np.arange(len(widths)) != index + 1, widths)
        products = self._products[0][np.ix_(kept, kept)], self._products[1][kept]
        variances = self.variances[:index] + self.variances[index + 1 :]
        return self._with(self.laws[:index] + self.laws[index + 1 :], variances, products)

    def _with(
        self, laws: tuple[FloatArray, ...], variances: Sequence[float], products: tuple[FloatArray, FloatArray]
    ) -> "Present":
        changed = replace(self, laws=laws, variances=tuple(variances))
        changed.__dict__["_products"] = products
        return changed

    def refitted(self) -> "Present":
        """With the sizes that maximise the evidence together (L-BFGS-B on ln σ²).

        ∂/∂ln σ² = ½(w̄ᵀw̄/σ² + tr C/σ² − f) with w̄ and C mean and covariance of the law's weights.
        """
        widths = [law.shape[1] for law in self.laws]
        if not sum(widths):
            return self
        first = self.base.shape[1]
        edges = first + np.concatenate([[0], np.cumsum(widths)])

        def misfit(logs: FloatArray) -> tuple[float, FloatArray]:
            state = self.with_variances(np.exp(logs).tolist())
            variance, weights, noise = state.posterior_variances, state.weights, state.noise_variance
            slope = []
            for k, width in enumerate(widths):
                part = slice(edges[k], edges[k + 1])
                squares = float(weights[part] @ weights[part]) / noise + float(variance[part].sum())
                slope.append(0.5 * (squares / np.exp(logs[k]) - width))
            return -state.log_evidence, -np.array(slope)

        bounds = [(np.log(_LEAST), np.log(_MOST))] * len(widths)
        found = minimize(
            misfit, np.log(self.variances), jac=True, method="L-BFGS-B", bounds=bounds,
            options={"maxiter": 15, "ftol": 1e-6},
        )  # fmt: skip
        return self.with_variances(np.exp(found.x).tolist())

    def gain(self, law: FloatArray) -> tuple[float, float]:
        """Largest gain of log evidence by one more law, and its σ² (`largest_gains`).

        Args:
            law: its directions Φ, shape (M, f).
        """
        through = solve_triangular(self.lower, self.design.T @ law, lower=True, check_finite=False)
        slope = law.T @ self.readings - through.T @ self.reduced
        gains, variances = self.largest_gains((law.T @ law - through.T @ through)[None], slope[None])
        return float(gains[0]), float(variances[0])

    def largest_gains(self, grams: FloatArray, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Largest gains of log evidence by single laws, and the σ² that reach them, shape (n,) each.

        With Φᵀ·P·Φ = U·Λ·Uᵀ and w = Uᵀ·Φᵀ·P·y, yᵀPy falls by q = Σ_i σ²·w_i²/(1 + σ²·λ_i) and the evidence rises by
        ½·(q − Σ_i ln(1 + σ²·λ_i)); where the noise is not known, by −(M − p)·ln(1 − q/yᵀPy) in the place of q.

        Args:
            grams: ΦᵀPΦ of every law, shape (n, f, f).
            slopes: ΦᵀPy, shape (n, f).
        """
        values, vectors = np.linalg.eigh(grams)
        values = np.maximum(values, 0.0)[:, None]
        squares = np.matmul(slopes[:, None], vectors) ** 2
        first = np.arange(len(grams))

        def best_of(logs: FloatArray) -> tuple[IntArray, FloatArray]:
            variance = np.exp(logs)[..., None]
            share = 1.0 + variance * values
            fall = (variance * squares / share).sum(axis=-1)
            if not self.known_noise:
                fall = -self.freedom * np.log(np.maximum(1.0 - fall / self.scatter, _ROUNDING))
            gains = 0.5 * (fall - np.log(share).sum(axis=-1))
            best = np.argmax(gains, axis=1)
            return best, gains[first, best]

        grid = np.linspace(np.log(_LEAST), np.log(_MOST), 42)
        best, coarse = best_of(grid[None])
        ends = grid[np.maximum(best - 1, 0)], grid[np.minimum(best + 1, len(grid) - 1)]
        fine = np.linspace(*ends, 15, axis=1)
        best, gains = best_of(fine)
        there = coarse > 0.0
        return np.where(there, gains, 0.0), np.where(there, np.exp(fine[first, best]), _LEAST)

    def left_out(self, blocks: IntArray) -> FloatArray:
        """Errors of readings predicted without the block that they belong to, e_B = (P_BB)⁻¹(P·y)_B, shape (M,).

        (Leave-one-group-out of a linear smoother; Rasmussen and Williams 2006, section 5.4.2 for single readings.)

        Args:
            blocks: block of every reading, shape (M,).
        """
        errors = np.empty_like(self.readings)
        for inside, own, inverse in self._left_out(blocks):
            readings = self.projected[inside]
            errors[inside] = (readings + own @ (inverse @ (own.T @ readings))) / _ALONE
        return errors

    def left_out_variances(self, blocks: IntArray) -> FloatArray:
        """Variances of `left_out` where the model is right, noise included: diagonals of s²·(P_BB)⁻¹, shape (M,)."""
        variances = np.empty_like(self.readings)
        for inside, own, inverse in self._left_out(blocks):
            variances[inside] = self.noise_variance * (1.0 + ((own @ inverse) * own).sum(axis=1)) / _ALONE
        return variances

    def _left_out(self, blocks: IntArray) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
        """Readings of every block, R and K with (P_BB)⁻¹ = I + R·K·Rᵀ.

        P_BB = I − F_B·F_Bᵀ is regular however little the other blocks determine. With more readings than parameters
        R = F_B and K = (I − F_Bᵀ·F_B)⁻¹ (Woodbury), else R = I.
        """
        factor = self.factor
        for block in np.unique(blocks):
            inside = np.flatnonzero(blocks == block)
            own = factor[inside]
            if len(inside) > own.shape[1]:
                yield inside, own, np.linalg.inv(_ALONE * np.eye(own.shape[1]) - own.T @ own)
            else:
                one = np.eye(len(inside))
                yield inside, one, _ALONE * np.linalg.inv(_ALONE * one - own @ own.T) - one


def linearised(
    about: Fit,
    sample: Data,
    *,
    known_noise: bool = True,
    sized: bool = False,
    seen: tuple[FloatArray, FloatArray] | None = None,
) -> Present:
    """A model to first order about a fit, with what is known of its parameters.

    Where its effects are `sized` they are laws, and a parameter that a bound holds is where it is. The weights of an
    effect are its parameters that are no shapes, from neutral, in units in which each moves the readings as much as the
    others. Otherwise all parameters are of the base.

    Args:
        about: the fit.
        sample: rows of the problem, which need not be those that were fitted.
        known_noise: whether the noise is stated.
        sized: see above.
        seen: whitened residuals there, shape (N, k), and derivatives of the prediction, shape (N, k, p), where known.
    """
    chain, values, kept = about.chain, about.values, sample.kept
    residuals, slopes = seen or sample.residuals_with_sensitivities(chain, values)
    design, readings = as_matrix(slopes)[kept], residuals.ravel()[kept]
    base: FloatArray = design[:, : chain.base] if sized else design
    count, knowledge = base.shape[1], chain.knowledge()
    precision: FloatArray = np.zeros(count)
    if knowledge is not None:
        mean, deviation = knowledge[0][:count], knowledge[1][:count]
        precision, held = 1.0 / deviation**2, np.isfinite(deviation)
        readings = readings + base[:, held] @ (values[:count] - mean)[held]
    low, high = chain.bounds()
    laws, variances = [], []
    for effect, part in zip(chain.effects, chain.slices, strict=True) if sized else ():
        own, away = design[:, part], values[part] - effect.neutral()
        sizes = np.sqrt((own**2).mean(axis=0))
        free = np.array([not p.shape for p in effect.parameters]) & (sizes > 0.0)
        free &= (values[part] > low[part]) & (values[part] < high[part])
        readings = readings + own[:, free] @ away[free]
        scale = 1.0 / (sizes[free] * np.sqrt(max(free.sum(), 1)))
        laws.append(own[:, free] * scale)
        weights = away[free] / scale
        variances.append(float(np.clip((weights**2).mean() if weights.size else 1.0, 1e-2, 1e5)))
    return Present(base, regular(base, precision), readings, tuple(laws), tuple(variances), known_noise=known_noise)


def regular(directions: FloatArray, precision: FloatArray) -> FloatArray:
    """Prior precisions (p,) with which parameters that no row determines do not make the equations singular.

    Args:
        directions: whitened, of the parameters, shape (M, p).
        precision: as known beforehand, 0 where nothing is, shape (p,).
    """
    sizes = (directions**2).sum(axis=0)
    return np.maximum(precision, 1e-12 * np.where(sizes > 0.0, sizes, 1.0))
