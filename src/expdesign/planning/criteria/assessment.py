"""The pieces that all criteria share, computed once for a batch of designs.

theory.md 3-5: with the whitened observation matrix Ã = G·A_M = Q·R, the information is M = ÃᵀÃ = RᵀR, the estimator's
gain is M⁻¹A_MᵀGᵀG = R⁻¹QᵀG, and nothing needs M itself, whose condition number would be squared. Where Ã is rank
deficient, only functions of the compliances that lie in its row space can be estimated; what cannot be is NaN here, and
never the number that a pseudo-inverse would put in its place. A design with a measurement at a singular configuration,
whose maps do not exist, is NaN as a whole, and the other designs of its batch are not touched by it.

All of it is NumPy that can be differentiated (`differentiation.py`): on recorded measurements, the same lines give the
gradients of every criterion. A design whose matrix is rank deficient, or does not exist, has none (`differentiable`).
"""

from functools import cached_property

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.instrument.deflection_noise import DeflectionNoise, reference_whitener
from expdesign.mechanics.differentiation import plain, product_transposed, sum_of_squares
from expdesign.mechanics.elastostatics.measurements import Measurements
from expdesign.planning.criteria.target_variances import TargetVariances
from expdesign.planning.criteria.targets import Targets

RANK_TOLERANCE = 1e-9
"""Singular values below this fraction of the largest count as zero (rounding of the maps is about 1e-13)."""


class Assessment(TargetVariances):
    """Lazily computed quantities of b designs of m measurements, for n_p compliances and t targets.

    Args:
        measurements: linear models with batch shape (b, m).
        noise: noise of the deflections.
        shared: whether each source of load error in `measurements` is shared by all measurements.
        targets: where accuracy is wanted.
        series: series numbers (b, m), needed where the noise has a shared reference; 0 for what is not measured.
        states: configurations (b, m, n_q) and parameters of the loads (b, m, k), for criteria that look beyond the
            linear model of the measurements.
    """

    def __init__(
        self,
        measurements: Measurements,
        noise: DeflectionNoise,
        shared: tuple[bool, ...],
        targets: Targets,
        series: IntArray | None = None,
        states: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        self.measurements = measurements
        self.noise = noise
        self.shared = shared
        self.targets = targets
        self.series = series
        self.states = states
        missing = series is not None and bool((series == 0).any())
        self.present: BoolArray | None = series > 0 if missing and series is not None else None
        self.batch, self.count = measurements.observation.shape[:2]
        self.parameters = measurements.observation.shape[-1]

    @property
    def number(self) -> FloatArray:
        """How many measurements are taken, shape (b,)."""
        return (
            np.full(self.batch, float(self.count)) if self.present is None else self.present.sum(axis=1).astype(float)
        )

    @cached_property
    def _across(self) -> FloatArray | None:
        """Whitener across measurements (b, m, m), or None where they are independent."""
        if not self.noise.shared_reference or self.series is None:
            return None
        return reference_whitener(self.series)

    @cached_property
    def _whitener(self) -> FloatArray:
        """G of each measurement on the axes measured, 0 on others, shape (k, n) or (b, m, k, n)."""
        axes = np.eye(self.measurements.observation.shape[-2])[self.noise.axes]
        return self.noise.whitener_at(self.measurements.jacobians.pose) @ axes

    @cached_property
    def _exists(self) -> BoolArray:
        """Whether the maps of all measurements exist, shape (b,)."""
        exists: BoolArray = np.logical_and.reduce(np.isfinite(plain(self.measurements.observation)), axis=(1, 2, 3))
        return exists

    @cached_property
    def whitened(self) -> FloatArray:
        """Ã = G·A_M, shape (b, m·k, n_p), in N/m; 0 where it does not exist, which identifies nothing."""
        observation = self.measurements.observation
        if not self._exists.all():
            observation = np.where(self._exists[:, None, None, None], observation, 0.0)
        return self.white(observation)

    def white(self, columns: FloatArray) -> FloatArray:
        """G·B of whole deflections B (b, m, n, d), shape (b, m·k, d)."""
        rows = self._whitener @ columns
        if self._across is not None:
            rows = (self._across @ rows.reshape(self.batch, self.count, -1)).reshape(rows.shape)
        if self.present is not None:
            rows = rows * self.present[..., None, None]
        return rows.reshape(self.batch, -1, columns.shape[-1])

    @cached_property
    def _factors(self) -> tuple[FloatArray, FloatArray]:
        """Q and R of Ã; rows of zeros make up for designs with fewer readings than parameters."""
        matrix = self.whitened
        missing = self.parameters - matrix.shape[1]
        if missing > 0:
            matrix = np.concatenate([matrix, np.zeros((self.batch, missing, self.parameters))], axis=1)
        orthogonal, triangular = np.linalg.qr(matrix)
        return orthogonal, triangular

    @cached_property
    def singular_values(self) -> FloatArray:
        """Singular values of Ã, falling, shape (b, n_p); exactly 0 beyond the rank, NaN where Ã does not exist.

        Where two coincide neither is differentiable; the gradient is that of one of the smooth continuations.
        """
        values = np.linalg.svd(self._factors[1], compute_uv=False)
        if (self._exists & (self.rank == self.parameters)).all():
            return values
        clipped = np.where(np.arange(self.parameters) < self.rank[:, None], values, 0.0)
        existing: FloatArray = np.where(self._exists[:, None], clipped, np.nan)
        return existing

    @cached_property
    def right_singular_vectors(self) -> FloatArray:
        """Of Ã, by falling singular value, not recorded, in rows, shape (b, n_p, n_p)."""
        vectors: FloatArray = np.linalg.svd(plain(self.whitened), full_matrices=True)[2]
        return vectors

    @cached_property
    def _scale(self) -> FloatArray:
        """Column norms of R (b, n_p), which make the rank test independent of the actuators' units."""
        norms = np.linalg.norm(plain(self._factors[1]), axis=1)
        largest = norms.max(axis=1, keepdims=True)
        scale: FloatArray = np.where(norms > RANK_TOLERANCE * largest, norms, np.where(largest > 0.0, largest, 1.0))
        return scale

    @cached_property
    def rank(self) -> IntArray:
        """Numerical rank of Ã, shape (b,)."""
        values = np.linalg.svd(plain(self._factors[1]) / self._scale[:, None, :], compute_uv=False)
        rank: IntArray = (values > RANK_TOLERANCE * np.maximum(values[:, :1], 1e-300)).sum(axis=1)
        return rank

    @cached_property
    def _idle(self) -> BoolArray:
        """Parameters (b, n_p) that show in no reading and matter at no target, as a joint about the vertical under
        weights alone.
        """
        norms = np.linalg.norm(plain(self._factors[1]), axis=1)
        shows = norms > RANK_TOLERANCE * norms.max(axis=1, keepdims=True)
        rows = np.abs(self.targets.observation).max(axis=(0, 1))
        matters = rows > RANK_TOLERANCE * rows.max()
        idle: BoolArray = ~shows & ~matters
        return idle

    @cached_property
    def differentiable(self) -> BoolArray:
        """Whether Ã exists and has full rank but for idle parameters, so that all that is estimated from it is
        differentiable, shape (b,).
        """
        return self._exists & (self.rank + self._idle.sum(axis=1) == self.parameters)

    @cached_property
    def _regular_factors(self) -> tuple[FloatArray, FloatArray]:
        """Q and R of Ã with a reading of its own for every idle parameter, which changes nothing else."""
        if not self._idle.any():
            return self._factors
        own = self._idle[:, :, None] * (np.eye(self.parameters) * self._scale[:, :, None])
        orthogonal, triangular = np.linalg.qr(np.concatenate([self.whitened, own], axis=1))
        return orthogonal, triangular

    @cached_property
    def condition(self) -> FloatArray:
        """Condition number of Ã, shape (b,); `inf` where it is rank deficient, NaN where it does not exist."""
        values = self.singular_values
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(values[:, -1] == 0.0, np.inf, values[:, 0] / values[:, -1])
        return ratio

    @cached_property
    def _estimator(self) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Root B with M⁻¹ = B·Bᵀ (b, n_p, n_p), B·Qᵀ (b, n_p, m·k), and which target rows are estimable (b, t, n)."""
        orthogonal, triangular = self._regular_factors
        full = self.differentiable
        if full.all():
            root: FloatArray = np.linalg.inv(triangular)
            gain: FloatArray = product_transposed(root, orthogonal)
        else:
            root, gain = self._of_full_rank(full)
        rows: FloatArray = self.targets.observation
        estimable = np.broadcast_to(full[:, None, None], (self.batch, *rows.shape[:2])).copy()
        for index in np.flatnonzero(~full):
            basis = self._row_space(int(index))
            scaled: FloatArray = rows / self._scale[index]
            outside: FloatArray = np.linalg.norm(scaled - scaled @ basis @ basis.T, axis=-1)
            estimable[index] = outside <= 1e3 * RANK_TOLERANCE * np.maximum(np.linalg.norm(scaled, axis=-1), 1e-300)
        estimable &= self._exists[:, None, None]
        readings = self.whitened.shape[1]
        return root, gain if gain.shape[2] == readings else gain[:, :, :readings], estimable

    def _of_full_rank(self, full: BoolArray) -> tuple[FloatArray, FloatArray]:
        """B and B·Qᵀ where some designs are not of full rank: theirs are truncated, and are held in differentiation."""
        orthogonal, triangular = self._regular_factors
        root = np.linalg.inv(np.where(full[:, None, None], triangular, np.eye(self.parameters)))
        gain = product_transposed(root, orthogonal)
        truncated, of_truncated = np.zeros(root.shape), np.zeros(gain.shape)
        for index in np.flatnonzero(~full):
            left, values, right = np.linalg.svd(plain(triangular)[index] / self._scale[index])
            kept = int(self.rank[index])
            truncated[index, :, :kept] = right[:kept].T / values[:kept] / self._scale[index][:, None]
            of_truncated[index] = truncated[index, :, :kept] @ left[:, :kept].T @ plain(orthogonal)[index].T
        chosen = full[:, None, None]
        return np.where(chosen, root, truncated), np.where(chosen, gain, of_truncated)

    def _row_space(self, index: int) -> FloatArray:
        """Orthonormal basis of the row space of one design's scaled R, shape (n_p, rank)."""
        right = np.linalg.svd(plain(self._factors[1])[index] / self._scale[index])[2]
        return right[: int(self.rank[index])].T

    @cached_property
    def gain(self) -> FloatArray:
        """P with ε_c = Σ_i P_i·ε_ΔX,i (m/N per m or rad), shape (b, m, n_p, n); zero for axes not measured."""
        gains = self._estimator[1]
        if self._across is not None:
            by_measurement = gains.reshape(self.batch, self.parameters, self.count, -1).swapaxes(-1, -2)
            gains = (by_measurement @ self._across[:, None]).swapaxes(-1, -2)
        per_measurement = gains.reshape(self.batch, self.parameters, self.count, -1).swapaxes(1, 2)
        return per_measurement @ self._whitener

    @cached_property
    def estimable(self) -> BoolArray:
        """Whether each pose coordinate at each target can be predicted from the measurements, shape (b, t, n)."""
        return self._estimator[2]

    @cached_property
    def identifies_targets(self) -> BoolArray:
        """Whether every axis that matters at every target can be predicted, shape (b,)."""
        needed = self.targets.importance > 0.0
        identified: BoolArray = np.logical_and.reduce(self.estimable | ~needed, axis=(1, 2))
        return identified

    @cached_property
    def noise_root(self) -> FloatArray:
        """A_D·B, so that U = (A_D·B)(A_D·B)ᵀ, shape (b, t, n, n_p); NaN rows where not estimable."""
        return self._where_estimable(self.targets.observation @ self._estimator[0][:, None])

    @cached_property
    def noise_variance(self) -> FloatArray:  # type: ignore[override]
        """U_ii (theory.md 4.2), variance of the attained pose due to measurement noise, shape (b, t, n); NaN rows."""
        variance: FloatArray = sum_of_squares(self.noise_root, -1)
        return variance

    @cached_property
    def _errors_by_source(self) -> list[FloatArray]:
        """Errors of the compliances per standard deviation of every load error of a source, (b, n_p, ·) each."""
        found = []
        all_errors = self.gain @ (self.measurements.compliance @ self.measurements.load_errors)
        for source, shared in zip(self.measurements.sources, self.shared, strict=True):
            own = all_errors[..., source] if len(self.shared) > 1 else all_errors
            separate = own.swapaxes(1, 2).reshape(self.batch, self.parameters, -1) if not shared else own.sum(axis=1)
            found.append(separate)
        return found

    @cached_property
    def _parameter_error(self) -> FloatArray:
        """Errors of the compliances per standard deviation of every load error, shape (b, n_p, total)."""
        found = self._errors_by_source or [np.zeros((self.batch, self.parameters, 1))]
        return found[0] if len(found) == 1 else np.concatenate(found, axis=-1)

    @cached_property
    def force_root(self) -> FloatArray:
        """A_D·E with E the compliance errors: Z·Σ_F·Zᵀ is its Gram matrix (theory.md 5.3), shape (b, t, n, total);
        NaN rows where not estimable.
        """
        return self._where_estimable(self.targets.observation @ self._parameter_error[:, None])

    @cached_property
    def force_variance(self) -> FloatArray:  # type: ignore[override]
        """(Z·Σ_F·Zᵀ)_ii, variance of the attained pose due to load errors, shape (b, t, n); NaN rows."""
        variance: FloatArray = sum_of_squares(self.force_root, -1)
        return variance

    @cached_property
    def source_variances(self) -> FloatArray:
        """What each source of load error adds to `force_variance`, shape (b, t, n, s); NaN rows."""
        rows = self.targets.observation
        found = [sum_of_squares(self._where_estimable(rows @ part[:, None]), -1) for part in self._errors_by_source]
        return np.stack(found, axis=-1) if found else np.zeros((*self.estimable.shape, 0))

    @cached_property
    def parameter_covariance(self) -> tuple[FloatArray, FloatArray]:
        """Covariances of the identified compliances (m²/N² …) due to noise, M⁻¹, and due to load errors.

        Shape (b, n_p, n_p) each; NaN in the rows and columns of compliances that a design leaves undetermined.
        """
        determined = np.repeat(self._exists[:, None], self.parameters, axis=1)
        for index in np.flatnonzero((self.rank < self.parameters) & self._exists):
            _, _, right = np.linalg.svd(self._factors[1][index] / self._scale[index])
            determined[index] = np.linalg.norm(right[int(self.rank[index]) :], axis=0) <= 1e3 * RANK_TOLERANCE
        known = determined[:, :, None] & determined[:, None, :]
        root, errors = self._estimator[0], self._parameter_error
        noise = np.where(known, root @ root.swapaxes(-1, -2), np.nan)
        return noise, np.where(known, errors @ errors.swapaxes(-1, -2), np.nan)

    def force_sensitivity(self) -> FloatArray:
        """Z = −A_D·Ã⁺·G·blkdiag(D_i) (theory.md 5.1), attained pose per load error, shape (b, t, n, m·n); NaN
        rows where not estimable.
        """
        per_measurement = self.gain @ self.measurements.compliance
        stacked = per_measurement.swapaxes(1, 2).reshape(self.batch, self.parameters, -1)
        return self._where_estimable(-(self.targets.observation @ stacked[:, None]))

    def _where_estimable(self, rows: FloatArray) -> FloatArray:
        """Rows (b, t, n, …) of the pose coordinates, NaN where the coordinate cannot be estimated."""
        if self.estimable.all():
            return rows
        result: FloatArray = np.where(self.estimable[..., None], rows, np.nan)
        return result
