"""The largest error at the targets that each effect hides, from the sensitivities of a batch of designs.

With Ã the whitened base sensitivities of a plan and B̃_e those of an effect e in units of its prior sizes, the
base model takes up u = Ã⁺B̃_e·x of an effect of size x; R_e·x with R_e = (I − ÃÃ⁺)B̃_e remains in the residuals, and the
compensated robot misses target t by (T_e,t − A_t·Ã⁺B̃_e)·x. Then

    MEIR_e² = max over x of Σ_t w_t·‖W_t^½·(T_e,t − A_t·Ã⁺B̃_e)·x‖²  subject to  ‖R_e·x‖² ≤ λ,  ‖x‖² ≤ 1.

Everything but the last step is shared by all effects: one decomposition and one product per design.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.criteria.assessment import RANK_TOLERANCE
from expdesign.model_error.directions import offsets
from expdesign.model_error.left_out import LeftOut
from expdesign.model_error.noticeable import noncentrality
from expdesign.model_error.settings import Assumptions
from expdesign.model_error.two_ellipsoids import Largest, bounds_along_axes, largest_along_axes

VISIBLE = 1e-6
"""Singular values of R_e below this fraction of the largest of B̃_e are rounding: that direction is not visible."""


@dataclass(frozen=True)
class Hidden:
    """What b designs hide, for E entries of left-out physics.

    Attributes:
        squares: MEIR_e², shape (b, E); NaN where a design does not identify the base model.
        target: index of the block of targets that is hit hardest, shape (b, E); 0 where targets are averaged.
        sizes: x of the worst combination in units of the prior sizes, per entry (b, d_e).
        detection: multiplier of the detection constraint, dMEIR_e²/dλ, shape (b, E).
        visible: ‖R_e·x‖²/λ of that combination, shape (b, E): 1 where it is just noticed, 0 where it never is.
        rank: independent directions of each entry that show in the residuals, shape (b, E).
        freedom: degrees of freedom of the residuals, shape (b,).
    """

    squares: FloatArray
    target: IntArray
    sizes: list[FloatArray]
    detection: FloatArray
    visible: FloatArray
    rank: IntArray
    freedom: IntArray


def hidden_errors(
    base: FloatArray,
    directions: FloatArray,
    errors: FloatArray,
    physics: tuple[LeftOut, ...],
    assumptions: Assumptions,
    *,
    share: float = 0.0,
) -> Hidden:
    """MEIR of every entry.

    Args:
        base: Ã of b designs in units of 1/apK, shape (b, M, n_p).
        directions: B̃ in units of the prior sizes, shape (b, M, D).
        errors: weighted errors √w_t·W_t^½·[A_t, T_t] of the targets in blocks of which the worst counts, shape
            (blocks, q, n_p + D) or, where prior sizes depend on the design, (b, blocks, q, n_p + D).
        physics: whose columns D are.
        assumptions: level and power of the test.
        share: entries that cannot have this share of the MEIR of a design may have a lower bound in the place of
            MEIR_e²: 0 for the values of all, 1 where only the worst is of interest.
    """
    batch, readings, n_p = base.shape
    finite: BoolArray = np.logical_and.reduce(np.isfinite(np.concatenate([base, directions], axis=2)), axis=(1, 2))
    base = np.where(finite[:, None, None], base, 0.0)
    directions = np.where(finite[:, None, None], directions, 0.0)
    model = _Base.of(base)
    seen_by_base = model.orthogonal.swapaxes(-1, -2) @ directions
    taken, remaining = model.root @ seen_by_base, directions - model.orthogonal @ seen_by_base
    exists = finite & model.estimates(base, errors[..., :n_p].reshape(-1, errors.shape[-3] * errors.shape[-2], n_p))
    missed = errors[..., n_p:] - errors[..., :n_p] @ taken[:, None]
    groups = _groups(remaining, missed, (directions**2).sum(axis=1), physics, assumptions)
    largest = _max_of([group.lower for group in groups])
    entries = len(physics)
    squares, detection, visible = (np.zeros((batch, entries)) for _ in range(3))
    target, rank = (np.zeros((batch, entries), dtype=np.int64) for _ in range(2))
    sizes: list[FloatArray] = [np.zeros((0, 0))] * entries
    # Many parameters first: theirs are the loosest bounds, and what they reach spares the others their search.
    for group in reversed(groups):
        chosen = group.entries
        worst, best = group.worst(share**2 * largest)
        largest = np.maximum(largest, worst.value.max(axis=1))
        squares[:, chosen], target[:, chosen], rank[:, chosen] = worst.value, best, group.rank
        detection[:, chosen] = worst.bound * worst.share / group.threshold
        visible[:, chosen] = (worst.point**2 * group.values).sum(axis=-1)
        points = (group.axes @ worst.point[..., None])[..., 0]
        for place, entry in enumerate(chosen):
            sizes[entry] = points[:, place]
    squares[~exists] = np.nan
    return Hidden(squares, target, sizes, detection, visible, rank, readings - model.rank)


def _max_of(arrays: list[FloatArray]) -> FloatArray:
    """The largest over all but the first dimension of several arrays, shape (b,)."""
    return np.max([array.reshape(len(array), -1).max(axis=1) for array in arrays], axis=0)


@dataclass(frozen=True)
class _Group:
    """The problems of all entries of one width d, in the axes in which what shows is diagonal.

    Attributes:
        entries: indices of the entries, shape (e,).
        forms: what the targets miss per axis, shape (b, blocks, e, q, d).
        values: what shows per axis in units of the threshold, shape (b, e, d).
        axes: shape (b, e, d, d).
        rank: axes that show, shape (b, e).
        threshold: λ, shape (b, e).
        lower, upper: bounds of MEIR_e² in every block of targets, shape (b, blocks, e).
    """

    entries: IntArray
    forms: FloatArray
    values: FloatArray
    axes: FloatArray
    rank: IntArray
    threshold: FloatArray
    lower: FloatArray
    upper: FloatArray

    def worst(self, least: FloatArray) -> tuple[Largest, IntArray]:
        """The largest over the blocks, and which block; where it cannot reach `least` (b,), a lower bound is enough."""
        batch, blocks, entries, _, width = self.forms.shape
        repeated = np.broadcast_to(self.values[:, None], (batch, blocks, entries, width))
        solved = self.upper >= least[:, None, None]
        required = np.broadcast_to(least[:, None, None], solved.shape)[solved]
        solution = largest_along_axes(self.forms[solved], repeated[solved], required)
        value = self.lower.copy()
        value[solved] = np.maximum(solution.value, value[solved])
        best: IntArray = value.argmax(axis=1)

        def pick(found: FloatArray, others: FloatArray) -> FloatArray:
            whole = np.zeros((batch, blocks, entries, *found.shape[1:])) + others[(...,) + (None,) * (found.ndim - 1)]
            whole[solved] = found
            flat = whole.reshape(batch, blocks, entries, -1)
            return np.take_along_axis(flat, best[:, None, :, None], axis=1)[:, 0]

        none = np.zeros(value.shape)
        worst = Largest(
            pick(solution.bound, self.lower)[..., 0],
            pick(solution.value, self.lower)[..., 0],
            pick(solution.point, none),
            pick(solution.share, none)[..., 0],
        )
        return worst, best


def _groups(
    remaining: FloatArray, missed: FloatArray, scale: FloatArray, physics: tuple[LeftOut, ...], assumptions: Assumptions
) -> list[_Group]:
    """The problems by their width, from R (b, M, D), what is missed (b, blocks, q, D) and ‖B̃‖² by column (b, D)."""
    start = offsets(physics)
    widths = np.diff(start)
    groups = []
    for width in np.unique(widths):
        chosen = np.flatnonzero(widths == width)
        columns = start[chosen][:, None] + np.arange(width)
        seen = remaining[:, :, columns].transpose(0, 2, 1, 3)  # (b, e, M, d)
        squares = seen.swapaxes(-1, -2) @ seen
        values, axes = np.linalg.eigh(squares) if width > 1 else (squares[..., 0], np.ones(squares.shape))
        shown = values > VISIBLE**2 * scale[:, columns].sum(axis=-1)[..., None]
        rank = shown.sum(axis=-1)
        threshold = _thresholds(rank, assumptions)
        values = np.where(shown, values, 0.0) / threshold[..., None]
        forms = missed[..., columns].transpose(0, 1, 3, 2, 4) @ axes[:, None]  # (b, blocks, e, q, d)
        lower, upper = bounds_along_axes(forms, values[:, None])
        groups.append(_Group(chosen, forms, values, axes, rank, threshold, lower, upper))
    return groups


@dataclass(frozen=True)
class _Base:
    """The base model's sensitivities Ã = Q·B⁻¹ of b designs.

    Attributes:
        orthogonal: Q, zero beyond the rank, shape (b, M, r).
        root: B, with B·Bᵀ the pseudo-inverse of ÃᵀÃ on what is identified, shape (b, n_p, r).
        scale: sizes of the columns of Ã, that of the largest for columns that are rounding, shape (b, n_p).
        rank: shape (b,).
    """

    orthogonal: FloatArray
    root: FloatArray
    scale: FloatArray
    rank: IntArray

    @classmethod
    def of(cls, base: FloatArray) -> Self:
        """From Ã (b, M, n_p); columns are scaled first, so that the rank does not depend on the actuators' units."""
        norms = np.linalg.norm(base, axis=1)
        largest = norms.max(axis=1, keepdims=True)
        scale = np.where(norms > RANK_TOLERANCE * largest, norms, np.where(largest > 0.0, largest, 1.0))
        left, values, right = np.linalg.svd(base / scale[:, None, :], full_matrices=False)
        kept = values > RANK_TOLERANCE * np.maximum(values[:, :1], 1e-300)
        inverse = np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)
        root = right.swapaxes(-1, -2) * inverse[:, None, :] / scale[:, :, None]
        return cls(left * kept[:, None, :], root, scale, kept.sum(axis=1))

    def estimates(self, base: FloatArray, rows: FloatArray) -> BoolArray:
        """Whether rows (b or 1, q, n_p) of the targets are combinations of those of Ã, shape (b,)."""
        scale = self.scale[:, None, :]
        scaled = rows / scale
        within = (rows @ self.root) @ (self.orthogonal.swapaxes(-1, -2) @ base) / scale
        outside = np.linalg.norm(scaled - within, axis=-1)
        small = 1e3 * RANK_TOLERANCE * np.maximum(np.linalg.norm(scaled, axis=-1), 1e-300)
        estimated: BoolArray = np.logical_and.reduce(outside <= small, axis=-1)
        return estimated


def _thresholds(rank: IntArray, assumptions: Assumptions) -> FloatArray:
    """λ(rank); that of one degree of freedom where nothing is visible and it does not matter."""
    most = int(rank.max(initial=1))
    table = [noncentrality(max(r, 1), assumptions.level, assumptions.power) for r in range(most + 1)]
    return np.array(table)[rank]


def seeds(
    hidden: Hidden,
    weights: FloatArray,
    base: FloatArray,
    directions: FloatArray,
    errors: FloatArray,
    physics: tuple[LeftOut, ...],
) -> tuple[FloatArray, FloatArray]:
    """Derivatives of Σ_e weight_e·MEIR_e² with respect to Ã (b, M, n_p) and B̃ (b, M, D).

    The envelope theorem: at the optimum, size and multipliers count as constant, so that with g = −2·A_tᵀ·Lᵀ·L·b,
    h = Ã⁺ᵀ·g, z = (ÃᵀÃ)⁺·g, r = R_e·x and the multiplier y of the detection constraint

        ∂/∂(B̃x) = h − 2·y·r,    ∂/∂Ã = −(h − 2·y·r)·uᵀ + r·zᵀ.

    Args:
        hidden: what `hidden_errors` gave for the arguments that follow.
        weights: shape (b, E).
        base: Ã.
        directions: B̃.
        errors: weighted errors of the targets.
        physics: whose columns D are.
    """
    batch, _, n_p = base.shape
    start = offsets(physics)
    model = _Base.of(base)
    for_base, for_directions = np.zeros_like(base), np.zeros_like(directions)
    blocks = np.broadcast_to(errors, (batch, *errors.shape[-3:]))
    for entry in np.flatnonzero((weights != 0.0).any(axis=0)):
        columns = slice(start[entry], start[entry + 1])
        size = hidden.sizes[entry]
        moved = (directions[:, :, columns] @ size[..., None])[..., 0]
        seen = model.orthogonal.swapaxes(-1, -2) @ moved[..., None]
        taken = (model.root @ seen)[..., 0]
        remaining = moved - (model.orthogonal @ seen)[..., 0]
        block = blocks[np.arange(batch), hidden.target[:, entry]]
        own = block[:, :, n_p + columns.start : n_p + columns.stop]
        missed = (own @ size[..., None] - block[:, :, :n_p] @ taken[..., None])[..., 0]
        slope = -2.0 * (block[:, :, :n_p].swapaxes(-1, -2) @ missed[..., None])
        inner = model.root.swapaxes(-1, -2) @ slope
        through = (model.orthogonal @ inner)[..., 0] - 2.0 * hidden.detection[:, entry, None] * remaining
        turned = (model.root @ inner)[..., 0]
        weight = weights[:, entry, None, None]
        for_directions[:, :, columns] += weight * through[:, :, None] * size[:, None, :]
        for_base += weight * (remaining[:, :, None] * turned[:, None, :] - through[:, :, None] * taken[:, None, :])
    return for_base, for_directions
