"""Designs as differentiable functions: from the maps of m measurements to the variances at the targets, and back.

With the whitened observation matrix Ã = Q·R, the estimator P = R⁻¹·Qᵀ and the load errors E = P·B, every variance is
Σ‖a·P‖² or Σ‖a·E‖² over rows a of A_D (theory.md 4.2, 5.3). The adjoint of the pseudo-inverse is
Ā = −Pᵀ·P̄·Pᵀ + (I − Ã·P)·P̄ᵀ·P·Pᵀ (Golub & Pereyra 1973), in which nothing has more than the condition of Ã itself;
cost and memory are linear in measurements and targets.
"""

from functools import cached_property

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.criteria.assessment import RANK_TOLERANCE
from expdesign.design.optimality.measurement_maps import MeasurementMaps, Tape
from expdesign.design.problem import DesignProblem
from expdesign.instrument.deflection_noise import reference_whitener, series_by_pose


class DesignModel:
    """Forward evaluations of a problem's designs that can be differentiated."""

    def __init__(self, problem: DesignProblem) -> None:
        self.problem = problem
        self.maps = MeasurementMaps(problem)
        space = problem.space
        self.continuous: BoolArray = ~space.discrete
        columns = [variable.columns[0] for variable in space.variables]
        self._columns = np.array(columns, dtype=np.int64)[self.continuous]
        self.rows: FloatArray = problem.targets.observation.reshape(-1, problem.targets.observation.shape[-1])

    def series(self, genes: FloatArray) -> IntArray | None:
        """Series numbers (b, m) of designs (b, m, g) whose measurements share their reference, else None."""
        if not self.problem.noise.shared_reference:
            return None
        return series_by_pose(self.problem.space.decode(genes)[0])

    def run(self, genes: FloatArray, series: IntArray | None = None) -> "DesignState":
        """Evaluate designs, genes (b, m, g); the series follow from the poses where they are not given."""
        series = self.series(genes) if series is None else series
        return self.run_quantities(self.problem.space.quantities(genes), series)

    def run_quantities(self, quantities: FloatArray, series: IntArray | None) -> "DesignState":
        """Evaluate designs given by all quantities of their measurements (b, m, z), wherever the genes may go."""
        tape = self.maps.run(quantities.reshape(-1, quantities.shape[-1]))
        return DesignState(self, tape, quantities.shape[:2], series)

    def to_genes(self, by_quantities: FloatArray) -> FloatArray:
        """Gradients with respect to quantities (..., z) as gradients with respect to genes (..., g); 0 if discrete."""
        gradient = np.zeros((*by_quantities.shape[:-1], self.problem.space.genes))
        gradient[..., self.continuous] = by_quantities[..., self._columns]
        return gradient


class DesignState:
    """One evaluation of b designs of m measurements.

    Attributes:
        regular: whether the measurements identify every parameter, shape (b,); elsewhere values are NaN and
            derivatives zero.
        values: U_ii and (Z·Σ_F·Zᵀ)_ii at the targets, shape (b, t, n) each.
    """

    def __init__(self, model: DesignModel, tape: Tape, shape: tuple[int, ...], series: IntArray | None) -> None:
        self.model, self.tape = model, tape
        self.batch, self.count = shape[0], shape[1]
        self._across = None if series is None else reference_whitener(series)
        k, p = tape.observation.shape[1:]
        rows = tape.observation.reshape(self.batch, self.count, k, p)
        if self._across is not None:
            rows = np.einsum("bij,bjkp->bikp", self._across, rows)
        self.whitened: FloatArray = rows.reshape(self.batch, -1, p)
        self._factorise(p)

    def _factorise(self, parameters: int) -> None:
        matrix = self.whitened
        finite: BoolArray = np.logical_and.reduce(np.isfinite(matrix), axis=(1, 2))
        matrix = np.where(finite[:, None, None], matrix, 0.0)
        missing = parameters - matrix.shape[1]
        if missing > 0:
            matrix = np.concatenate([matrix, np.zeros((self.batch, missing, parameters))], axis=1)
        orthogonal, triangular = np.linalg.qr(matrix)
        norms = np.linalg.norm(triangular, axis=1)
        scaled = triangular / np.where(norms > 0.0, norms, 1.0)[:, None, :]
        singular = np.linalg.svd(scaled, compute_uv=False)
        self.regular: BoolArray = finite & (singular[:, -1] > RANK_TOLERANCE * singular[:, 0])
        triangular = np.where(self.regular[:, None, None], triangular, np.eye(parameters))
        self._orthogonal, self._triangular = orthogonal, triangular
        self.root: FloatArray = np.linalg.inv(triangular)
        self._full_gain = self.root @ orthogonal.swapaxes(1, 2)
        self.gain: FloatArray = self._full_gain[:, :, : self.whitened.shape[1]]

    @cached_property
    def _gains(self) -> FloatArray:
        """Estimator per measurement in whitened axes, shape (b, m, n_p, k)."""
        gains = self.gain.reshape(self.batch, self.gain.shape[1], self.count, -1)
        if self._across is not None:
            gains = np.einsum("bpik,bij->bpjk", gains, self._across)
        return np.ascontiguousarray(gains.swapaxes(1, 2))

    @cached_property
    def _load_errors(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """B of shared and of independent sources (b, m, k, d), and the parameter errors they make."""
        errors = self.tape.errors.reshape(self.batch, self.count, *self.tape.errors.shape[1:])
        shared = self.model.maps.shared
        common, own = errors[..., shared], errors[..., ~shared]
        return common, own, (self._gains @ common).sum(axis=1), self._gains @ own

    def _invalid(self, values: FloatArray) -> FloatArray:
        result: FloatArray = np.where(self.regular[:, None, None], values, np.nan)
        return result

    @cached_property
    def noise_variance(self) -> FloatArray:
        """U_ii, shape (b, t, n) (m², rad²)."""
        values = ((self.model.rows @ self.root) ** 2).sum(axis=-1)
        return self._invalid(values.reshape(self.batch, *self.model.problem.targets.observation.shape[:2]))

    @cached_property
    def force_variance(self) -> FloatArray:
        """(Z·Σ_F·Zᵀ)_ii, shape (b, t, n) (m², rad²)."""
        _, _, common, own = self._load_errors
        stacked = own.swapaxes(1, 2).reshape(self.batch, own.shape[2], -1)
        rows = self.model.rows
        values = ((rows @ common) ** 2).sum(axis=-1) + ((rows @ stacked) ** 2).sum(axis=-1)
        return self._invalid(values.reshape(self.batch, *self.model.problem.targets.observation.shape[:2]))

    @cached_property
    def _svd(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        left, values, right = np.linalg.svd(self._triangular)
        return left, values, right

    @cached_property
    def singular_values(self) -> FloatArray:
        """Singular values of Ã, falling, shape (b, n_p)."""
        result: FloatArray = np.where(self.regular[:, None], self._svd[1], np.nan)
        return result

    def gradient(
        self,
        by_noise: FloatArray | None = None,
        by_force: FloatArray | None = None,
        by_singular: FloatArray | None = None,
    ) -> FloatArray:
        """Gradient with respect to the genes (b, m, g), the series held, of a function of the values above.

        The arguments are those of `quantity_gradient`.
        """
        return self.model.to_genes(self.quantity_gradient(by_noise, by_force, by_singular))

    def quantity_gradient(
        self,
        by_noise: FloatArray | None = None,
        by_force: FloatArray | None = None,
        by_singular: FloatArray | None = None,
    ) -> FloatArray:
        """Gradient with respect to every quantity of the measurements (b, m, z), free or fixed, the series held.

        Args:
            by_noise: partial derivatives with respect to `noise_variance`, shape (b, t, n).
            by_force: partial derivatives with respect to `force_variance`, shape (b, t, n).
            by_singular: partial derivatives with respect to `singular_values`, shape (b, n_p).
        """
        gain = self.gain
        transposed = gain.swapaxes(1, 2)
        by_matrix = np.zeros_like(self.whitened)
        by_errors = np.zeros((self.batch, self.count, *self.tape.errors.shape[1:]))
        if by_noise is not None:
            inverse = self.root @ self.root.swapaxes(1, 2)
            by_matrix -= 2.0 * transposed @ self._quadratic(by_noise) @ inverse
        if by_force is not None and self.tape.errors.shape[-1]:
            by_gain, by_errors = self._pull_forces(self._quadratic(by_force))
            residual = by_gain.swapaxes(1, 2) - self.whitened @ (gain @ by_gain.swapaxes(1, 2))
            by_matrix += residual @ self.root @ self.root.swapaxes(1, 2) - transposed @ by_gain @ transposed
        if by_singular is not None:
            left, _, right = self._svd
            rotated = (self._orthogonal @ left)[:, : self.whitened.shape[1]]
            by_matrix += (rotated * self._finite(by_singular)[:, None, :]) @ right
        by_rows = by_matrix.reshape(self.batch, self.count, -1, by_matrix.shape[-1])
        if self._across is not None:
            by_rows = np.einsum("bij,bikp->bjkp", self._across, by_rows)
        by_rows = np.where(self.regular[:, None, None, None], by_rows, 0.0)
        flat = by_rows.reshape(self.tape.observation.shape), by_errors.reshape(self.tape.errors.shape)
        gradient = self.model.maps.pull(self.tape, *flat).reshape(self.batch, self.count, -1)
        result: FloatArray = np.where(self.regular[:, None, None], gradient, 0.0)
        return result

    def _finite(self, partials: FloatArray) -> FloatArray:
        return np.nan_to_num(np.where(self.regular.reshape(-1, *[1] * (partials.ndim - 1)), partials, 0.0))

    def _quadratic(self, partials: FloatArray) -> FloatArray:
        """Σ partial_ti·a_tiᵀ·a_ti, shape (b, n_p, n_p)."""
        rows = self.model.rows
        squares = (rows[:, :, None] * rows[:, None, :]).reshape(len(rows), -1)
        return (self._finite(partials).reshape(self.batch, -1) @ squares).reshape(-1, rows.shape[1], rows.shape[1])

    def _pull_forces(self, quadratic: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Partial derivatives with respect to P (b, n_p, m·k) and B (b, m, k, d) of tr(quadratic·E·Eᵀ)."""
        common, own, common_errors, own_errors = self._load_errors
        by_common = 2.0 * (quadratic @ common_errors)[:, None]
        by_own = 2.0 * quadratic[:, None] @ own_errors
        by_gains = by_common @ common.swapaxes(2, 3) + by_own @ own.swapaxes(2, 3)
        by_errors = np.empty((*own.shape[:3], len(self.model.maps.shared)))
        gains = self._gains.swapaxes(2, 3)
        by_errors[..., self.model.maps.shared] = gains @ by_common
        by_errors[..., ~self.model.maps.shared] = gains @ by_own
        by_gains = by_gains.swapaxes(1, 2)
        if self._across is not None:
            by_gains = np.einsum("bpjk,bij->bpik", by_gains, self._across)
        by_errors = np.where(self.regular[:, None, None, None], by_errors, 0.0)
        return by_gains.reshape(self.batch, quadratic.shape[1], -1), by_errors
