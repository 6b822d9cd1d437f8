"""What measurements say about the parameters, as something that can be added and asked for accuracy.

With whitened readings Ã_j, and G·D_j·L_j their change per standard deviation of each load error, measurements add

    M = Σ Ã_jᵀÃ_j , S = Σ Ã_jᵀ·G·D_jL_j of the shared and N = Σ Ã_jᵀ·G·D_jL_j·(…)ᵀ of the independent load errors,

and the parameters estimated by least squares have the covariance M⁻¹ due to noise and M⁻¹·(N + S·Sᵀ)·M⁻¹ due to load
errors (theory.md 4.2, 5.3). DUIR² and FEIR² are what these give along the axes of the targets (`propagated`).

There are two forms. `Information` holds roots: with Ã = Q·R, R and the parts Qᵀ·G·D·L of the load errors that reach the
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
from expdesign.mechanics.differentiation import plain, sum_of_squares

RANK_TOLERANCE = 1e-9
"""Singular values below this fraction of the largest count as zero (rounding of the maps is about 1e-13)."""
LOST = 1e3 * RANK_TOLERANCE
"""Part of a target's row that may lie along directions that are not identified, as rounding."""


def propagated(
    gain: FloatArray, rows: FloatArray, errors: FloatArray, spread: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Variances along the axes of targets due to noise and to load errors: the diagonals of T·M⁻¹·Tᵀ and of
    T·M⁻¹·(N + S·Sᵀ)·M⁻¹·Tᵀ, shape (..., t, r) each.

    Args:
        gain: T·M⁻¹ in any coordinates of the parameters, shape (..., t, r, p).
        rows: T in the same coordinates.
        errors: S, shape (..., p, d); with root-free coordinates all errors may stand here.
        spread: N, shape (..., p, p).
    """
    noise: FloatArray = (gain * rows).sum(axis=-1)
    force = sum_of_squares(gain @ errors[..., None, :, :], -1)
    return noise, force if spread is None else force + ((gain @ spread[..., None, :, :]) * gain).sum(axis=-1)


class Information:
    """Square root of the information of a set of measurements, with any batch dimensions in front.

    Args:
        root: R with RᵀR = M, shape (..., p, p).
        errors: what shows of the errors of each source of load error in the directions of the root, QᵀG·D·L per
            standard deviation, shape (..., p, f) each.
        shared: whether the measurements have the errors of a source in common; else each has its own, one after the
            other in f.
    """

    def __init__(self, root: FloatArray, errors: tuple[FloatArray, ...] = (), shared: tuple[bool, ...] = ()) -> None:
        self.root, self.errors, self.shared = root, errors, shared

    @classmethod
    def of_measurements(
        cls,
        rows: FloatArray,
        errors: tuple[FloatArray, ...] = (),
        shared: tuple[bool, ...] = (),
        across: FloatArray | None = None,
        known: "Information | None" = None,
    ) -> "Information":
        """Of m measurements.

        Args:
            rows: whitened reading per parameter, shape (..., m, k, p).
            errors: whitened reading per standard deviation of each source of load error, shape (..., m, k, d) each.
            shared: whether the measurements have the errors of a source in common.
            across: what whitens across measurements that share their reference, shape (..., m, m), or None.
            known: from other measurements, of the same batch or of one for all; errors of shared sources are the same.
        """
        *batch, m, k, p = rows.shape
        flat = rows.reshape(*batch, m, k * p)
        stacked = [(flat if across is None else across @ flat).reshape(*batch, m * k, p)]
        if known is not None:
            stacked.append(np.broadcast_to(known.root, (*batch, p, p)))
        elif m * k < p:  # rows of zeros make up for fewer readings than parameters
            stacked.append(np.zeros((*batch, p - m * k, p)))
        orthogonal, root = np.linalg.qr(stacked[0] if len(stacked) == 1 else np.concatenate(stacked, axis=-2))
        turned = orthogonal if len(stacked) == 1 else orthogonal[..., : m * k, :]
        if errors and across is not None:
            turned = across.swapaxes(-1, -2) @ turned.reshape(*batch, m, k * p)
        turned = turned.reshape(*batch, m, k, p).swapaxes(-1, -2)
        seen = []
        for each, common in zip(errors, shared, strict=True):
            by_measurement = turned @ each
            if common:
                seen.append(by_measurement.sum(axis=-3))
            else:
                seen.append(by_measurement.swapaxes(-3, -2).reshape(*batch, p, m * each.shape[-1]))
        if known is not None and known.errors:
            before = [orthogonal[..., m * k :, :].swapaxes(-1, -2) @ each for each in known.errors]
            seen = [
                mine + theirs if common else np.concatenate([theirs, mine], axis=-1)
                for mine, theirs, common in zip(seen, before, shared, strict=True)
            ]
        return cls(root, tuple(seen), shared)

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
        p = self.root.shape[-1]
        stacked = [_below(self.root, other.root, batch)]
        further = other.errors or tuple(np.zeros_like(each) for each in self.errors)
        for mine, theirs, common in zip(self.errors, further, self.shared, strict=True):
            if common:
                stacked.append(_below(mine, theirs, batch))
            else:
                stacked.append(_below(mine, np.zeros_like(mine[..., :p, :]), batch))
                stacked[-1] = np.concatenate([stacked[-1], _below(np.zeros_like(theirs), theirs, batch)], axis=-1)
        edges = np.cumsum([part.shape[-1] for part in stacked])[:-1]
        root, *errors = np.split(_triangle(np.concatenate(stacked, axis=-1), p), edges, axis=-1)
        kept = [part if common else _few(part) for part, common in zip(errors, self.shared, strict=True)]
        return Information(root, tuple(kept), self.shared)

    def in_units(self, scale: FloatArray) -> "Information":
        """Of the parameters in units of a scale (p,)."""
        return Information(self.root * scale, self.errors, self.shared)

    def part(self, index: int | slice | BoolArray | IntArray) -> "Information":
        """Members of a batch."""
        return Information(self.root[index], tuple(each[index] for each in self.errors), self.shared)

    @cached_property
    def _scale(self) -> FloatArray:
        """Column norms of the root (..., p), which make the rank independent of the parameters' units."""
        sizes = np.linalg.norm(plain(self.root), axis=-2)
        largest = sizes.max(axis=-1, keepdims=True)
        scale: FloatArray = np.where(sizes > RANK_TOLERANCE * largest, sizes, np.where(largest > 0.0, largest, 1.0))
        return scale

    @cached_property
    def rank(self) -> IntArray:
        """How many combinations of the parameters are identified, shape (...)."""
        values = np.linalg.svd(plain(self.root) / self._scale[..., None, :], compute_uv=False)
        rank: IntArray = (values > RANK_TOLERANCE * np.maximum(values[..., :1], 1e-300)).sum(axis=-1)
        return rank

    @cached_property
    def full(self) -> BoolArray:
        """Whether all parameters are identified, so that what is estimated is differentiable, shape (...)."""
        full: BoolArray = np.asarray(self.rank == self.root.shape[-1])
        return full

    @cached_property
    def _truncated(self) -> tuple[FloatArray, FloatArray]:
        """Where not all is identified: B, and the directions (in rows, scaled) that are not; else zero."""
        inverse, lost = np.zeros(self.root.shape), np.zeros(self.root.shape)
        scale = self._scale[~self.full]
        left, values, right = np.linalg.svd(plain(self.root)[~self.full] / scale[..., None, :])
        kept = (np.arange(values.shape[-1]) < self.rank[~self.full][..., None])[..., None]
        turned = np.where(kept, right / np.where(kept, values[..., None], 1.0), 0.0).swapaxes(-1, -2)
        inverse[~self.full] = (turned / scale[..., None]) @ left.swapaxes(-1, -2)
        lost[~self.full] = np.where(kept, 0.0, right)
        return inverse, lost

    @cached_property
    def inverse(self) -> FloatArray:
        """B with M⁻¹ = B·Bᵀ on what is identified, shape (..., p, p)."""
        if self.full.all():
            found: FloatArray = np.linalg.inv(self.root)
            return found
        full = self.full[..., None, None]
        regular = np.linalg.inv(np.where(full, self.root, np.eye(self.root.shape[-1])))
        return np.where(full, regular, self._truncated[0])

    def estimable(self, targets: FloatArray) -> BoolArray:
        """Whether rows (t, r, p) depend on nothing but what is identified, shape (..., t, r)."""
        if self.full.all():
            return np.ones((*self.full.shape, *targets.shape[:2]), dtype=bool)
        scaled = targets / self._scale[..., None, None, :]
        lost = np.linalg.norm(scaled @ self._truncated[1].swapaxes(-1, -2)[..., None, :, :], axis=-1)
        found: BoolArray = lost <= LOST * np.maximum(np.linalg.norm(scaled, axis=-1), 1e-300)
        return found

    def noise_root(self, targets: FloatArray) -> FloatArray:
        """T·B, whose Gram matrix is U (theory.md 4.2), at targets (t, r, p), shape (..., t, r, p); NaN rows where not
        estimable.
        """
        root = targets @ self.inverse[..., None, :, :]
        estimable = self.estimable(targets)
        return root if estimable.all() else np.where(estimable[..., None], root, np.nan)

    def force_root(self, targets: FloatArray) -> FloatArray:
        """T·B·QᵀG·D·L of all load errors, whose Gram matrix is Z·Σ_F·Zᵀ (theory.md 5.3), (..., t, r, f); NaN rows."""
        return self.noise_root(targets) @ self._together[..., None, :, :]

    @cached_property
    def _together(self) -> FloatArray:
        found = self.errors or (np.zeros((*self.root.shape[:-1], 1)),)
        return found[0] if len(found) == 1 else np.concatenate(found, axis=-1)

    def variances(self, targets: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Variances along the axes of targets (t, r, p) due to noise and to load errors, shape (..., t, r) each; NaN
        where not estimable.
        """
        gain = self.noise_root(targets)
        return propagated(gain, gain, self._together)

    def source_variances(self, targets: FloatArray) -> FloatArray:
        """What each source of load error adds to the variances, shape (..., t, r, s): the budget of errors."""
        gain = self.noise_root(targets)
        found = [propagated(gain, gain, each)[1] for each in self.errors]
        return np.stack(found, axis=-1) if found else np.zeros((*gain.shape[:-1], 0))


@dataclass(frozen=True)
class Sums:
    """M, N and S of sets of measurements, with any batch dimensions in front.

    Attributes:
        matrix: M, shape (..., p, p).
        own: N, shape (..., p, p).
        shared: S, shape (..., p, d).
    """

    matrix: FloatArray
    own: FloatArray
    shared: FloatArray

    @classmethod
    def of_measurements(cls, rows: FloatArray, errors: FloatArray, shared: BoolArray) -> "Sums":
        """Of single ones, with whitened rows (..., k, p) and errors (..., k, d), some of them shared (d,)."""
        transposed = rows.swapaxes(-1, -2)
        reach = transposed @ errors[..., ~shared]
        return cls(transposed @ rows, reach @ reach.swapaxes(-1, -2), transposed @ errors[..., shared])

    @classmethod
    def of_information(cls, known: Information) -> "Sums":
        """Of what is known, its errors of shared sources joined in their order."""
        transposed = known.root.swapaxes(-1, -2)
        own, shared = (
            transposed @ np.concatenate([known.root[..., :0], *parts], axis=-1)
            for parts in (
                [each for each, common in zip(known.errors, known.shared, strict=True) if not common],
                [each for each, common in zip(known.errors, known.shared, strict=True) if common],
            )
        )
        return cls(transposed @ known.root, own @ own.swapaxes(-1, -2), shared)

    def eliminated(self, nuisance: int, prior: float) -> "Sums":
        """Without the last parameters, which are only a nuisance, each with so much prior information."""
        kept = self.matrix.shape[-1] - nuisance
        among = self.matrix[..., kept:, kept:] + prior * np.eye(nuisance)
        answer = np.linalg.solve(among, self.matrix[..., kept:, :kept]).swapaxes(-1, -2)
        least = np.concatenate([np.broadcast_to(np.eye(kept), (*answer.shape[:-1], kept)), -answer], axis=-1)
        back = least.swapaxes(-1, -2)
        matrix = self.matrix[..., :kept, :kept] - answer @ self.matrix[..., kept:, :kept]
        return Sums(matrix, least @ self.own @ back, least @ self.shared)

    def gain(self, targets: FloatArray) -> FloatArray:
        """T·M⁻¹ of targets (t, r, p), shape (..., t, r, p)."""
        # A ridge far below rounding of a regular matrix keeps a singular one from stopping the batch.
        size = np.trace(self.matrix, axis1=-2, axis2=-1)[..., None, None]
        inverse = np.linalg.inv(self.matrix + 1e-14 * np.maximum(size, 1e-300) * np.eye(self.matrix.shape[-1]))
        found: FloatArray = targets @ inverse[..., None, :, :]
        return found

    def variances(self, targets: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Variances along the axes of targets (t, r, p) due to noise and to load errors, shape (..., t, r) each."""
        return propagated(self.gain(targets), targets, self.shared, self.own)


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
