"""What measurements say about the parameters, as something that can be added and asked for accuracy.

Two estimators can be asked (`Estimator`). With whitened readings Ã_j, and B_j = G·D_j·L_j their change per standard
deviation of each load error,

- `weighted` least squares weigh the instrument's noise alone: the covariance of the parameters is M⁻¹ due to noise and
  M⁻¹·(N + S·Sᵀ)·M⁻¹ due to load errors (theory.md 4.2, 5.3), with

      M = Σ Ã_jᵀÃ_j , S = Σ Ã_jᵀ·B_j of the shared and N = Σ Ã_jᵀ·B_j·(…)ᵀ of the independent load errors;

- `generalised` least squares (Aitken 1936) weigh the load errors as well: independent ones are in the weights of each
  measurement, (I + B_jB_jᵀ)^(−½), and shared ones are estimated beside the parameters with their own covariance as
  prior (theory.md 10.4). The covariance of the parameters, P, is that of noise and load errors together. Of it the load
  errors cause P·(N + S·Sᵀ)·P, where S picks the shared ones, and the noise what is left (Joseph's form).

DUIR² and FEIR² are what noise and load errors give along the axes of the targets.

There are two forms. `Information` holds roots: with [B, Ã] = Q·R, R and the parts QᵀB of the load errors that reach the
parameters, as a square-root information filter has them (Bierman 1977), so that no condition is squared. `Sums` hold
M, N and S themselves, which add up at no cost, for the ranking of very many plans.

The readings of a series share the one of its unloaded reference. That one is a nuisance parameter ρ with the prior
information 2·I in whitened units, of which every reading of the series has a row; eliminated, it leaves
2·(Σ a_iᵀa_i − āᵀΣa_i) with ā = Σa_i/(n + 1) of n rows (theory.md 10.6). In the roots, where a series is complete, this
is the inverse Cholesky factor of ½(I + 11ᵀ) across its rows.

The roots are NumPy that can be differentiated (`differentiation.py`).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.estimation.load_errors import Estimator
from expdesign.mechanics.differentiation import inverse_root, plain, product_transposed, sum_of_squares

RANK_TOLERANCE = 1e-9
"""Singular values below this fraction of the largest count as zero (rounding of the maps is about 1e-13)."""
LOST = 1e3 * RANK_TOLERANCE
"""Part of a target's row that may lie along directions that are not identified, as rounding."""
Parts = tuple[FloatArray, FloatArray]
"""Variances due to noise and due to load errors."""
_ROUNDING = 1e-14
"""Least share of the noise in a variance: what differences of rounded numbers leave."""


def parted(
    gain: FloatArray, rows: FloatArray, reach: FloatArray, own: FloatArray | None, estimator: Estimator
) -> Parts:
    """Variances along the axes of targets due to noise and to load errors, shape (..., t, r) each.

    Args:
        gain: T·M⁻¹ in any coordinates of the parameters, shape (..., t, r, q).
        rows: T in the same coordinates.
        reach: S, shape (..., q, d); with coordinates that are free of roots all errors may stand here.
        own: N, shape (..., q, q), or None.
        estimator: whose M it is: of `generalised` T·M⁻¹·Tᵀ holds the load errors too.
    """
    whole: FloatArray = (gain * rows).sum(axis=-1)
    force = sum_of_squares(gain @ reach[..., None, :, :], -1)
    if own is not None:
        force = force + ((gain @ own[..., None, :, :]) * gain).sum(axis=-1)
    if estimator == "weighted":
        return whole, force
    noise, least = whole - force, _ROUNDING * np.abs(plain(whole))
    return np.where(plain(noise) > least, noise, least), force


class Information:
    """Square root of the information of a set of measurements, with any batch dimensions in front.

    Args:
        root: R, shape (..., r, q): RᵀR is the information about q unknowns, the load errors that are estimated first
            and then the p parameters.
        errors: what shows of the errors of each source of load error in the directions of the root, QᵀB per standard
            deviation, shape (..., r, f) each, without columns where they are estimated.
        shared: whether the measurements have the errors of a source in common; else each has its own, one after the
            other in f.
        estimated: how many load errors of each source are among the unknowns.
        estimator: by which estimator it is asked.
        closed: whether what is known beforehand of the load errors that are estimated is in the root.
    """

    def __init__(
        self,
        root: FloatArray,
        errors: tuple[FloatArray, ...] = (),
        shared: tuple[bool, ...] = (),
        estimated: tuple[int, ...] = (),
        estimator: Estimator = "weighted",
        closed: bool = False,
    ) -> None:
        self.root, self.errors, self.shared, self.estimated = root, errors, shared, estimated
        self.estimator, self.closed = estimator, closed

    @classmethod
    def of_measurements(
        cls,
        rows: FloatArray,
        errors: tuple[FloatArray, ...] = (),
        shared: tuple[bool, ...] = (),
        across: FloatArray | None = None,
        known: "Information | None" = None,
        estimator: Estimator = "weighted",
        *,
        closed: bool = False,
    ) -> "Information":
        """Of m measurements.

        Args:
            rows: whitened reading per parameter, shape (..., m, k, p); for `generalised` least squares whitened by
                the load errors too that each measurement has of its own.
            errors: whitened likewise, reading per standard deviation of each source of load error, (..., m, k, d) each.
            shared: whether the measurements have the errors of a source in common.
            across: what whitens across measurements, shape (..., m·k, m·k), or None.
            known: from other measurements, of the same batch or of one for all; errors of shared sources are the same,
                and those that stand last here may be missing there.
            estimator: by which it is asked.
            closed: whether to take in what is known beforehand of load errors; only once in what is added.
        """
        *batch, m, k, _ = rows.shape
        chosen = [common and estimator == "generalised" for common in shared]
        estimated = tuple(each.shape[-1] * among for each, among in zip(errors, chosen, strict=True))
        first = [each for each, among in zip(errors, chosen, strict=True) if among]
        unknowns = np.concatenate([*first, rows], axis=-1) if first else rows
        q = unknowns.shape[-1]
        flat = unknowns.reshape(*batch, m * k, q)
        stacked = [flat if across is None else across @ flat]
        if known is not None:
            stacked.append(np.broadcast_to(known.root, (*batch, *known.root.shape[-2:])))
        if closed and first and (known is None or not known.closed):
            stacked.append(np.broadcast_to(np.eye(q)[: sum(estimated)], (*batch, sum(estimated), q)))
        missing = q - sum(part.shape[-2] for part in stacked)
        if missing > 0:  # rows of zeros make up for fewer readings than unknowns
            stacked.append(np.zeros((*batch, missing, q)))
        orthogonal, root = np.linalg.qr(stacked[0] if len(stacked) == 1 else np.concatenate(stacked, axis=-2))
        turned = orthogonal if len(stacked) == 1 else orthogonal[..., : m * k, :]
        if errors and across is not None:
            turned = across.swapaxes(-1, -2) @ turned
        turned = turned.reshape(*batch, m, k, q).swapaxes(-1, -2)
        seen = []
        for each, common, among in zip(errors, shared, chosen, strict=True):
            by_measurement = turned @ (each[..., :0] if among else each)
            if common:
                seen.append(by_measurement.sum(axis=-3))
            else:
                seen.append(by_measurement.swapaxes(-3, -2).reshape(*batch, q, m * each.shape[-1]))
        if known is not None and known.errors:
            place = slice(m * k, m * k + known.root.shape[-2])
            before = [orthogonal[..., place, :].swapaxes(-1, -2) @ each for each in known.errors]
            before += [np.zeros((*batch, q, 0))] * (len(seen) - len(before))
            seen = [
                mine + theirs if common else np.concatenate([theirs, mine], axis=-1)
                for mine, theirs, common in zip(seen, before, shared, strict=True)
            ]
        closed = closed or (known is not None and known.closed)
        return cls(root, tuple(seen), shared, estimated, estimator, closed)

    @classmethod
    def beside(cls, rows: FloatArray, nuisance: FloatArray, prior: FloatArray) -> "Information":
        """Of whitened rows (..., r, p) whose readings change with nuisance parameters too, which are eliminated.

        Args:
            rows: change of the readings with the parameters.
            nuisance: with the nuisance parameters, shape (..., r, s).
            prior: one over the standard deviation of each of those, as it is known beforehand, shape (s,).
        """
        (count,), parameters = prior.shape, rows.shape[-1]
        known = np.concatenate([np.diag(prior), np.zeros((count, parameters))], axis=1)
        known = np.broadcast_to(known, (*rows.shape[:-2], *known.shape))
        together = np.concatenate([known, np.concatenate([nuisance, rows], axis=-1)], axis=-2)
        return cls(_triangle(together, count + parameters)[..., count:, count:])

    def plus(self, other: "Information") -> "Information":
        """Both together; they have the errors of shared sources in common, and the other one may have no errors."""
        batch = np.broadcast_shapes(self.root.shape[:-2], other.root.shape[:-2])
        q = self.root.shape[-1]
        stacked = [_below(self.root, other.root, batch)]
        further = other.errors or tuple(np.zeros((*other.root.shape[:-1], 0)) for _ in self.errors)
        for mine, theirs, common in zip(self.errors, further, self.shared, strict=True):
            if common and mine.shape[-1] == theirs.shape[-1]:
                stacked.append(_below(mine, theirs, batch))
            else:
                nothing = np.zeros((*self.root.shape[:-1], theirs.shape[-1]))
                stacked.append(_below(mine, np.zeros((*other.root.shape[:-1], mine.shape[-1])), batch))
                stacked[-1] = np.concatenate([stacked[-1], _below(nothing, theirs, batch)], axis=-1)
        edges = np.cumsum([part.shape[-1] for part in stacked])[:-1]
        root, *errors = np.split(_triangle(np.concatenate(stacked, axis=-1), q), edges, axis=-1)
        kept = tuple(part if common else _few(part) for part, common in zip(errors, self.shared, strict=True))
        return Information(root, kept, self.shared, self.estimated, self.estimator, self.closed or other.closed)

    def _with(self, root: FloatArray, errors: tuple[FloatArray, ...]) -> "Information":
        return Information(root, errors, self.shared, self.estimated, self.estimator, self.closed)

    def in_units(self, scale: FloatArray) -> "Information":
        """Of the parameters in units of a scale (p,)."""
        return self._with(self.root * np.concatenate([np.ones(sum(self.estimated)), scale]), self.errors)

    def part(self, index: int | slice | BoolArray | IntArray) -> "Information":
        """Members of a batch."""
        return self._with(self.root[index], tuple(each[index] for each in self.errors))

    def repeated(self, times: FloatArray) -> "Information":
        """Of so many copies (k,) of the measurements, in which the errors of a shared source are the same, (k, ...)."""
        root = np.sqrt(times)[:, None, None]
        pairs = zip(self.errors, self.shared, strict=True)
        return self._with(root * self.root, tuple(each * (root if common else root**0) for each, common in pairs))

    def without_readings(self) -> "Information":
        """What is known of the same unknowns where nothing is measured."""
        widths = (each.shape[-1] * common for each, common in zip(self.errors, self.shared, strict=True))
        return self._with(np.zeros(self.root.shape), tuple(np.zeros((*self.root.shape[:-1], w)) for w in widths))

    def with_readings(self, rows: FloatArray) -> "Information":
        """With further readings of the parameters alone, whitened, shape (..., r, p)."""
        nothing = np.zeros((*rows.shape[:-1], sum(self.estimated)))
        return self.plus(Information(np.concatenate([nothing, rows], axis=-1)))

    @cached_property
    def _complete(self) -> "Information":
        """The same with what is known beforehand of the load errors that are estimated."""
        count = sum(self.estimated)
        if self.closed or count == 0:
            return self
        return self.plus(Information(np.eye(self.root.shape[-1])[:count], closed=True))

    @cached_property
    def parameters_root(self) -> FloatArray:
        """Root of the information about the parameters, all load errors being unknown, shape (..., p, p)."""
        count = sum(self.estimated)
        return self._complete.root[..., count:, count:] if count else self.root

    @cached_property
    def _scale(self) -> FloatArray:
        """Column norms of the root (..., p), which make the rank independent of the parameters' units."""
        sizes = np.linalg.norm(plain(self.parameters_root), axis=-2)
        largest = sizes.max(axis=-1, keepdims=True)
        scale: FloatArray = np.where(sizes > RANK_TOLERANCE * largest, sizes, np.where(largest > 0.0, largest, 1.0))
        return scale

    @cached_property
    def rank(self) -> IntArray:
        """How many combinations of the parameters are identified, shape (...)."""
        values = np.linalg.svd(plain(self.parameters_root) / self._scale[..., None, :], compute_uv=False)
        rank: IntArray = (values > RANK_TOLERANCE * np.maximum(values[..., :1], 1e-300)).sum(axis=-1)
        return rank

    @cached_property
    def full(self) -> BoolArray:
        """Whether all parameters are identified, so that what is estimated is differentiable, shape (...)."""
        full: BoolArray = np.asarray(self.rank == self.parameters_root.shape[-1])
        return full

    @cached_property
    def _truncated(self) -> tuple[FloatArray, FloatArray]:
        """Where not all is identified: B, and the directions (in rows, scaled) that are not; else zero."""
        shape = self.parameters_root.shape
        inverse, lost = np.zeros(shape), np.zeros(shape)
        scale = self._scale[~self.full]
        left, values, right = np.linalg.svd(plain(self.parameters_root)[~self.full] / scale[..., None, :])
        kept = (np.arange(values.shape[-1]) < self.rank[~self.full][..., None])[..., None]
        turned = np.where(kept, right / np.where(kept, values[..., None], 1.0), 0.0).swapaxes(-1, -2)
        inverse[~self.full] = (turned / scale[..., None]) @ left.swapaxes(-1, -2)
        lost[~self.full] = np.where(kept, 0.0, right)
        return inverse, lost

    @cached_property
    def inverse(self) -> FloatArray:
        """B with M⁻¹ = B·Bᵀ on what is identified, shape (..., p, p)."""
        root = self.parameters_root
        if self.full.all():
            found: FloatArray = np.linalg.inv(root)
            return found
        full = self.full[..., None, None]
        regular = np.linalg.inv(np.where(full, root, np.eye(root.shape[-1])))
        return np.where(full, regular, self._truncated[0])

    @cached_property
    def whole_inverse(self) -> FloatArray:
        """R⁻¹ of all unknowns with what is known of the load errors, which stand first, shape (..., q, q); 0 along
        combinations of parameters that are not determined.
        """
        count, root = sum(self.estimated), self._complete.root
        if not count:
            return self.inverse
        first = np.linalg.inv(root[..., :count, :count])
        above = np.concatenate([first, -first @ root[..., :count, count:] @ self.inverse], axis=-1)
        below = np.concatenate([np.zeros((*self.inverse.shape[:-1], count)), self.inverse], axis=-1)
        return np.concatenate([above, below], axis=-2)

    def estimable(self, targets: FloatArray) -> BoolArray:
        """Whether rows (t, r, p) depend on nothing but what is identified, shape (..., t, r)."""
        if self.full.all():
            return np.ones((*self.full.shape, *targets.shape[:2]), dtype=bool)
        scaled = targets / self._scale[..., None, None, :]
        lost = np.linalg.norm(scaled @ self._truncated[1].swapaxes(-1, -2)[..., None, :, :], axis=-1)
        found: BoolArray = lost <= LOST * np.maximum(np.linalg.norm(scaled, axis=-1), 1e-300)
        return found

    def gain(self, targets: FloatArray) -> FloatArray:
        """T·B at targets (t, r, p), shape (..., t, r, p); NaN rows where not estimable."""
        root = targets @ self.inverse[..., None, :, :]
        estimable = self.estimable(targets)
        return root if estimable.all() else np.where(estimable[..., None], root, np.nan)

    def noise_root(self, targets: FloatArray) -> FloatArray:
        """What has U (theory.md 4.2) for its Gram matrix, at targets (t, r, p), shape (..., t, r, p); NaN rows where
        not estimable.
        """
        gain = self.gain(targets)
        if self.estimator == "weighted" or not self.reach:
            return gain
        left = np.eye(gain.shape[-1]) * (1.0 + 10.0 * _ROUNDING) - product_transposed(self._together, self._together)
        return gain @ np.linalg.inv(inverse_root(left))[..., None, :, :]

    def force_root(self, targets: FloatArray) -> FloatArray:
        """T·B·QᵀB of all load errors, whose Gram matrix is Z·Σ_F·Zᵀ (theory.md 5.3), (..., t, r, f); NaN rows."""
        return self.gain(targets) @ self._together[..., None, :, :]

    @cached_property
    def reach(self) -> tuple[FloatArray, ...]:
        """What the errors of each source do in the directions of the parameters' root, (..., p, f) each."""
        start, count, found = 0, sum(self.estimated), []
        if count == 0:
            return self.errors
        # The prior's rows of Q: what their readings, which have the errors of one standard deviation, do.
        among = self.whole_inverse[..., :count, count:]
        for own, each in zip(self._complete.errors, self.estimated, strict=True):
            found.append(among[..., start : start + each, :].swapaxes(-1, -2) if each else own[..., count:, :])
            start += each
        return tuple(found)

    @cached_property
    def _together(self) -> FloatArray:
        found = self.reach or (np.zeros((*self.parameters_root.shape[:-1], 1)),)
        return found[0] if len(found) == 1 else np.concatenate(found, axis=-1)

    def variances(self, targets: FloatArray) -> Parts:
        """Variances along the axes of targets (t, r, p) due to noise and to load errors, shape (..., t, r) each; NaN
        where not estimable.
        """
        gain = self.gain(targets)
        return parted(gain, gain, self._together, None, self.estimator)

    def budget(self, targets: FloatArray, acting: tuple[FloatArray, ...]) -> tuple[FloatArray, FloatArray]:
        """Variances of what is attained at targets (t, r, p) where errors of the load act at them as well, as
        (T·K·B_s − T_s)·(…)ᵀ has them: due to noise, shape (..., t, r), and to each source, shape (..., t, r, s).

        Load errors that are estimated are corrected at the targets as well; DUIR and FEIR are of the estimate alone.

        Args:
            targets: T of the parameters.
            acting: T_s of each source that measurements share, per standard deviation, (t, r, f) each; 0 where it does
                not act at a target.
        """
        chosen = [each for each, width in zip(acting, self.estimated, strict=True) if width]
        rows = np.concatenate([np.zeros((*targets.shape[:-1], 0)), *chosen, targets], axis=-1)
        gain = rows @ self.whole_inverse[..., None, :, :]
        gain = np.where(self.estimable(targets)[..., None], gain, np.nan)
        parts, start = np.zeros((*gain.shape[:-1], len(acting))), 0
        for index, (errors, width) in enumerate(zip(self._complete.errors, self.estimated, strict=True)):
            if width:  # the prior's rows of Q
                missed = gain @ self.whole_inverse[..., None, start : start + width, :].swapaxes(-1, -2)
                start += width
            else:
                missed = gain @ errors[..., None, :, :]
                missed = missed - acting[index] if self.shared[index] else missed
            parts[..., index] = sum_of_squares(missed, -1)
        whole = sum_of_squares(gain, -1)
        if self.estimator == "weighted":
            return whole, parts
        return np.maximum(whole - parts.sum(axis=-1), _ROUNDING * whole), parts


@dataclass(frozen=True)
class Sums:
    """M, N and S of sets of measurements, with any batch dimensions in front, in one array, which adds up.

    Attributes:
        packed: [M, N, S] side by side, M and N of q unknowns, shape (..., q, 2·q + d).
        estimated: how many of the last unknowns are load errors, known beforehand to one standard deviation each; they
            have the place of S, as they do what they are.
    """

    packed: FloatArray
    estimated: int = 0

    @property
    def unknowns(self) -> int:
        """q, how many there are."""
        return self.packed.shape[-2]

    @property
    def matrix(self) -> FloatArray:
        """M, shape (..., q, q)."""
        return self.packed[..., : self.unknowns]

    @property
    def own(self) -> FloatArray:
        """N, shape (..., q, q)."""
        return self.packed[..., self.unknowns : 2 * self.unknowns]

    @property
    def shared(self) -> FloatArray:
        """S, shape (..., q, d)."""
        if not self.estimated:
            return self.packed[..., 2 * self.unknowns :]
        ones = np.eye(self.unknowns)[:, self.unknowns - self.estimated :]
        return np.broadcast_to(ones, (*self.packed.shape[:-2], *ones.shape))

    @classmethod
    def of_measurements(cls, rows: FloatArray, own: FloatArray, shared: FloatArray) -> "Sums":
        """Of single ones, with whitened rows (..., k, q), and readings per standard deviation of the load errors that
        each has of its own (..., k, e) and of those that all have in common (..., k, d).
        """
        transposed = rows.swapaxes(-1, -2)
        reach = transposed @ own
        return cls(np.concatenate([transposed @ rows, reach @ reach.swapaxes(-1, -2), transposed @ shared], axis=-1))

    @classmethod
    def of_information(cls, known: Information) -> "Sums":
        """Of what is known, its errors of shared sources joined in their order; parameters stand first here."""
        root = np.roll(known.root, -sum(known.estimated), axis=-1)
        sources = list(zip(known.errors, known.shared, strict=True))
        own, shared = (
            np.concatenate([root[..., :0], *(each for each, common in sources if common is wanted)], axis=-1)
            for wanted in (False, True)
        )
        return cls.of_measurements(root, own, shared)

    def eliminated(self, nuisance: int, prior: float) -> "Sums":
        """Without the last parameters, which are only a nuisance, each with so much prior information."""
        kept = self.unknowns - nuisance
        among = self.matrix[..., kept:, kept:] + prior * np.eye(nuisance)
        answer = np.linalg.solve(among, self.matrix[..., kept:, :kept]).swapaxes(-1, -2)
        least = np.concatenate([np.broadcast_to(np.eye(kept), (*answer.shape[:-1], kept)), -answer], axis=-1)
        matrix = self.matrix[..., :kept, :kept] - answer @ self.matrix[..., kept:, :kept]
        parts = matrix, least @ self.own @ least.swapaxes(-1, -2), least @ self.shared
        return Sums(np.concatenate(parts, axis=-1), self.estimated)

    def variances(self, targets: FloatArray, estimator: Estimator) -> Parts:
        """Variances along the axes of targets (t, r, q) due to noise and to load errors, shape (..., t, r) each."""
        matrix = self.matrix + np.diag((np.arange(self.unknowns) >= self.unknowns - self.estimated).astype(float))
        # A ridge far below rounding of a regular matrix keeps a singular one from stopping the batch.
        size = np.trace(matrix, axis1=-2, axis2=-1)[..., None, None]
        inverse = np.linalg.inv(matrix + 1e-14 * np.maximum(size, 1e-300) * np.eye(self.unknowns))
        return parted(targets @ inverse[..., None, :, :], targets, self.shared, self.own, estimator)


def _below(first: FloatArray, second: FloatArray, batch: tuple[int, ...]) -> FloatArray:
    """Rows of one above those of the other."""
    parts = [np.broadcast_to(part, (*batch, *part.shape[-2:])) for part in (first, second)]
    return np.concatenate(parts, axis=-2)


def _triangle(rows: FloatArray, count: int) -> FloatArray:
    """The first rows of R of rows (..., r, c) = Q·R, as many as there are parameters; zeros where R has fewer."""
    triangle = np.asarray(np.linalg.qr(rows, mode="r"))[..., :count, :]
    missing = count - triangle.shape[-2]
    return np.concatenate([triangle, np.zeros((*triangle.shape[:-2], missing, triangle.shape[-1]))], axis=-2)


def _few(errors: FloatArray) -> FloatArray:
    """Errors (..., p, f) with the same Gram matrix and no more columns than rows."""
    if errors.shape[-1] <= errors.shape[-2]:
        return errors
    return np.asarray(np.linalg.qr(errors.swapaxes(-1, -2), mode="r")).swapaxes(-1, -2)
