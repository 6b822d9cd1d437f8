"""The pieces that all criteria share, computed once for a batch of designs.

theory.md 3-5: with the whitened observation matrix Ã = G·A_M = Q·R, the information is M = ÃᵀÃ = RᵀR, the estimator's
gain is M⁻¹A_MᵀGᵀG = R⁻¹QᵀG, and nothing needs M itself, whose condition number would be squared. `Information` says how
load errors enter it, by the estimator; criteria of the observation matrix alone do not depend on that. Where Ã is rank
deficient, only functions of the compliances that lie in its row space can be estimated; what cannot be is NaN here, and
never the number that a pseudo-inverse would put in its place. A design with a measurement at a singular configuration,
whose maps do not exist, is NaN as a whole, and the other designs of its batch are not touched by it.

All of it is NumPy that can be differentiated (`differentiation.py`): on recorded measurements, the same lines give the
gradients of every criterion. A design whose matrix is rank deficient, or does not exist, has none (`differentiable`).
"""

from functools import cached_property

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.estimation.load_errors import Estimator
from expdesign.mechanics.differentiation import inverse_root, one_and_gram, plain
from expdesign.mechanics.elastostatics.measurements import Measurements
from expdesign.planning.criteria.information import RANK_TOLERANCE, Information
from expdesign.planning.criteria.targets import Targets, TargetVariances
from expdesign.planning.deflection_noise import DeflectionNoise, reference_whitener


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
        known: of the parameters from elsewhere, or None.
        estimator: which least squares estimate the parameters.
    """

    def __init__(
        self,
        measurements: Measurements,
        noise: DeflectionNoise,
        shared: tuple[bool, ...],
        targets: Targets,
        series: IntArray | None = None,
        states: tuple[FloatArray, FloatArray] | None = None,
        known: Information | None = None,
        estimator: Estimator = "generalised",
    ) -> None:
        self.measurements = measurements
        self.noise = noise
        self.shared = shared
        self.targets = targets
        self.series = series
        self.states = states
        self._known, self.estimator = known, estimator
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

    def _rows(self, columns: FloatArray) -> FloatArray:
        """G·B of whole deflections B (b, m, n, d) of each measurement, shape (b, m, k, d); 0 of what is not taken."""
        rows = self._whitener @ columns
        return rows if self.present is None else rows * self.present[..., None, None]

    def white(self, columns: FloatArray) -> FloatArray:
        """G·B of whole deflections B (b, m, n, d), whitened across measurements too, shape (b, m·k, d)."""
        rows = self._rows(columns)
        if self._across is not None:
            rows = (self._across @ rows.reshape(self.batch, self.count, -1)).reshape(rows.shape)
        return rows.reshape(self.batch, self.count * len(self.noise.axes), columns.shape[-1])

    @cached_property
    def _by_loads(self) -> FloatArray | None:
        """What whitens the whitened readings of all measurements by their load errors too, (b, m·k, m·k); None where
        these are not weighed.
        """
        if self.estimator == "weighted" or not self._load_errors:
            return None
        each = np.eye(self.count)[:, None, :, None]
        errors = [
            columns if common else (columns[..., None, :] * each).reshape(*columns.shape[:3], -1)
            for columns, common in zip(self._load_errors, self.shared, strict=True)
        ]
        return inverse_root(one_and_gram(self.white(np.concatenate(errors, axis=-1))))

    def weighed(self, columns: FloatArray) -> FloatArray:
        """Whole deflections (b, m, n, d) as the estimator weighs them, by noise and load errors, shape (b, m·k, d)."""
        white = self.white(columns)
        return white if self._by_loads is None else self._by_loads @ white

    @cached_property
    def _exists(self) -> BoolArray:
        """Whether the maps of all measurements exist, shape (b,)."""
        exists: BoolArray = np.logical_and.reduce(np.isfinite(plain(self.measurements.observation)), axis=(1, 2, 3))
        return exists

    @cached_property
    def _observation(self) -> FloatArray:
        """A, 0 where it does not exist, which identifies nothing, shape (b, m, n, n_p)."""
        observation = self.measurements.observation
        return observation if self._exists.all() else np.where(self._exists[:, None, None, None], observation, 0.0)

    @cached_property
    def whitened(self) -> FloatArray:
        """Ã = G·A_M, shape (b, m·k, n_p), in N/m; 0 where it does not exist."""
        return self.white(self._observation)

    @cached_property
    def before(self) -> Information | None:
        """What is known beside the readings: also a reading for every parameter that is idle, which shows nowhere and
        matters at no target, as a joint about the vertical under weights alone.
        """
        known = self._known
        sizes, rows = np.linalg.norm(plain(self.whitened), axis=1), np.abs(self.targets.observation).max(axis=(0, 1))
        if known is not None:
            sizes = np.hypot(sizes, np.linalg.norm(known.root[..., -self.parameters :], axis=-2))
        largest = sizes.max(axis=1, keepdims=True)
        idle = ~(sizes > RANK_TOLERANCE * largest) & ~(rows > RANK_TOLERANCE * rows.max())
        if not idle.any():
            return known
        unit = np.where(largest > 0.0, largest, 1.0)[..., None] * np.eye(self.parameters)
        return (known or self.readings.without_readings()).with_readings(idle[..., None] * unit)

    @cached_property
    def _own_errors(self) -> FloatArray:
        """Whitened readings per standard deviation of the load errors that each measurement has of its own, shape
        (b, m, k, e).
        """
        own = [each for each, common in zip(self._load_errors, self.shared, strict=True) if not common]
        nothing = np.zeros((self.batch, self.count, self.measurements.observation.shape[-2], 0))
        return self._rows(np.concatenate([nothing, *own], axis=-1))

    @cached_property
    def _weights(self) -> FloatArray | None:
        """What weighs whitened readings by the load errors that each measurement has of its own, (b, m, k, k)."""
        if self.estimator == "weighted" or self._across is not None or not self._own_errors.shape[-1]:
            return None
        return inverse_root(one_and_gram(self._own_errors))

    @cached_property
    def _mixing(self) -> FloatArray | None:
        """What whitens across measurements that share references (b, m·k, m·k), by their load errors too where these
        are weighed; None where measurements are independent.
        """
        if self._across is None:
            return None
        size, own = self.count * len(self.noise.axes), self._own_errors
        mixing = self._across[:, :, None, :, None] * np.eye(len(self.noise.axes))[:, None, :]
        mixing = mixing.reshape(self.batch, size, size)
        if self.estimator == "weighted" or not own.shape[-1]:
            return mixing
        errors = own[:, :, :, None] * np.eye(self.count)[:, None, :, None]
        return inverse_root(one_and_gram(mixing @ errors.reshape(self.batch, size, -1))) @ mixing

    def _informed(self, errors: tuple[FloatArray, ...], shared: tuple[bool, ...], *, closed: bool) -> Information:
        """What the readings say, and what errors (b, m, n, d) of the deflections do; beside what is known before, where
        that closes it.
        """
        rows, *seen = (
            columns if self._weights is None else self._weights @ columns
            for columns in map(self._rows, (self._observation, *errors))
        )
        known = self.before if closed else None
        return Information.of_measurements(
            rows, tuple(seen), shared, self._mixing, known, self.estimator, closed=closed
        )

    def _of_each(self, errors: FloatArray) -> FloatArray:
        """What errors (b, m, n, d) of the deflections that each measurement has of its own do to the estimate beside
        the declared load errors, in the directions of the parameters' root, shape (b, n_p, m·d).
        """
        found = self._informed((*self._load_errors, errors), (*self.shared, False), closed=True)
        return found.reach[-1][..., -self.count * errors.shape[-1] :]

    @cached_property
    def _load_errors(self) -> tuple[FloatArray, ...]:
        """Deflections per standard deviation of each source of load error, (b, m, n, d) each; 0 without A."""
        errors = self.measurements.compliance @ self.measurements.load_errors
        if not self._exists.all():
            errors = np.where(self._exists[:, None, None, None], errors, 0.0)
        return tuple(errors[..., source] for source in self.measurements.sources)

    @cached_property
    def observed(self) -> Information:
        """What the readings say by the instrument's noise alone, which is Ã."""
        return Information.of_measurements(self.whitened[:, None])

    @cached_property
    def readings(self) -> Information:
        """What the readings say, with their load errors, to be added to others."""
        return self._informed(self._load_errors, self.shared, closed=False)

    @cached_property
    def information(self) -> Information:
        """The same with what is known beside them, from which all is estimated."""
        return self._informed(self._load_errors, self.shared, closed=True)

    @property
    def rank(self) -> IntArray:
        """Numerical rank of Ã, shape (b,)."""
        return self.observed.rank

    @cached_property
    def differentiable(self) -> BoolArray:
        """Whether Ã exists and has full rank but for idle parameters, so that all that is estimated from it is
        differentiable, shape (b,).
        """
        return self._exists & self.information.full

    @cached_property
    def singular_values(self) -> FloatArray:
        """Singular values of Ã, falling, shape (b, n_p); exactly 0 beyond the rank, NaN where Ã does not exist.

        Where two coincide neither is differentiable; the gradient is that of one of the smooth continuations.
        """
        values = np.linalg.svd(self.observed.root, compute_uv=False)
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
    def condition(self) -> FloatArray:
        """Condition number of Ã, shape (b,); `inf` where it is rank deficient, NaN where it does not exist."""
        values = self.singular_values
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(values[:, -1] == 0.0, np.inf, values[:, 0] / values[:, -1])
        return ratio

    @cached_property
    def gain(self) -> FloatArray:
        """P with ε_c = Σ_i P_i·ε_ΔX,i (m/N per m or rad), shape (b, m, n_p, n); zero for axes not measured."""
        n = self._whitener.shape[-1]
        every = np.broadcast_to(np.eye(n), (self.batch, self.count, n, n))
        gains = self.information.inverse @ self._of_each(every)
        return gains.reshape(self.batch, self.parameters, self.count, n).swapaxes(1, 2)

    @cached_property
    def estimable(self) -> BoolArray:
        """Whether each pose coordinate at each target can be predicted from the measurements, shape (b, t, n)."""
        return self.information.estimable(self.targets.observation) & self._exists[:, None, None]

    @cached_property
    def identifies_targets(self) -> BoolArray:
        """Whether every axis that matters at every target can be predicted, shape (b,)."""
        needed = self.targets.importance > 0.0
        identified: BoolArray = np.logical_and.reduce(self.estimable | ~needed, axis=(1, 2))
        return identified

    @cached_property
    def _variances(self) -> tuple[FloatArray, FloatArray]:
        return self.information.variances(self.targets.observation)

    @property
    def noise_variance(self) -> FloatArray:  # type: ignore[override]
        """U_ii (theory.md 4.2), variance of the attained pose due to measurement noise, shape (b, t, n); NaN rows."""
        return self._variances[0]

    @property
    def force_variance(self) -> FloatArray:  # type: ignore[override]
        """(Z·Σ_F·Zᵀ)_ii, variance of the attained pose due to load errors, shape (b, t, n); NaN rows."""
        return self._variances[1]

    @property
    def noise_root(self) -> FloatArray:
        """What has U for its Gram matrix, shape (b, t, n, n_p); NaN rows where not estimable."""
        return self.information.noise_root(self.targets.observation)

    @property
    def force_root(self) -> FloatArray:
        """A_D·E with E the compliance errors: Z·Σ_F·Zᵀ is its Gram matrix (theory.md 5.3), shape (b, t, n, total);
        NaN rows where not estimable.
        """
        return self.information.force_root(self.targets.observation)

    @property
    def parameter_covariance(self) -> tuple[FloatArray, FloatArray]:
        """Covariances of the identified compliances (m²/N² …) due to noise, M⁻¹, and due to load errors.

        Shape (b, n_p, n_p) each; NaN in the rows and columns of compliances that a design leaves undetermined.
        """
        each = np.eye(self.parameters)[None]
        determined = self.observed.estimable(each)[:, 0] & self._exists[:, None]
        roots = (self.information.noise_root(each)[:, 0], self.information.force_root(each)[:, 0])
        noise, force = (np.where(determined[..., None], root, np.nan) for root in roots)
        return noise @ noise.swapaxes(-1, -2), force @ force.swapaxes(-1, -2)

    def force_sensitivity(self) -> FloatArray:
        """Z = −A_D·Ã⁺·G·blkdiag(D_i) (theory.md 5.1), attained pose per load error, shape (b, t, n, m·n); NaN
        rows where not estimable.
        """
        reach = self._of_each(self.measurements.compliance)
        found: FloatArray = -self.information.gain(self.targets.observation) @ reach[:, None]
        return found
