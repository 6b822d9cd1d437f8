"""The largest error at the targets that each effect hides, from the sensitivities of a batch of designs.

With Ã the whitened base sensitivities of a plan and B̃_e those of an effect e in units of its prior sizes, the
base model takes up u = Ã⁺B̃_e·x of an effect of size x; R_e·x with R_e = (I − ÃÃ⁺)B̃_e remains in the residuals, and the
compensated robot misses target t by (T_e,t − A_t·Ã⁺B̃_e)·x. Then

    MEIR_e² = max over x of Σ_t w_t·‖W_t^½·(T_e,t − A_t·Ã⁺B̃_e)·x‖²  subject to  ‖R_e·x‖² ≤ λ,  ‖x‖² ≤ 1.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.assurance.model_error.left_out import LeftOut, offsets
from expdesign.assurance.model_error.noticeable import noncentrality
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.assurance.model_error.two_ellipsoids import largest_along_axes
from expdesign.mechanics.differentiation import plain
from expdesign.planning.criteria.information import RANK_TOLERANCE

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
) -> Hidden:
    """MEIR of every entry.

    Args:
        base: Ã of b designs in units of 1/apK, shape (b, M, n_p).
        directions: B̃ in units of the prior sizes, shape (b, M, D).
        errors: weighted errors √w_t·W_t^½·[A_t, T_t] of the targets in blocks of which the worst counts, shape
            (blocks, q, n_p + D).
        physics: whose columns D are.
        assumptions: level and power of the test.
    """
    batch, readings, n_p = base.shape
    finite: BoolArray = np.logical_and.reduce(np.isfinite(np.concatenate([base, directions], axis=2)), axis=(1, 2))
    base = np.where(finite[:, None, None], base, 0.0)
    directions = np.where(finite[:, None, None], directions, 0.0)
    model = BaseModel.of(base)
    seen_by_base = model.orthogonal.swapaxes(-1, -2) @ directions
    remaining = directions - model.orthogonal @ seen_by_base
    missed = errors[..., n_p:] - errors[..., :n_p] @ (model.root @ seen_by_base)[:, None]
    scale = (directions**2).sum(axis=1)
    entries, start = len(physics), offsets(physics)
    squares, detection, visible = (np.zeros((batch, entries)) for _ in range(3))
    target, rank = (np.zeros((batch, entries), dtype=np.int64) for _ in range(2))
    sizes: list[FloatArray] = [np.zeros((0, 0))] * entries
    for width in np.unique(np.diff(start)):
        chosen = np.flatnonzero(np.diff(start) == width)
        columns = start[chosen][:, None] + np.arange(width)
        seen = remaining[:, :, columns].transpose(0, 2, 1, 3)  # (b, e, M, d)
        values, axes = np.linalg.eigh(seen.swapaxes(-1, -2) @ seen)
        shown = values > VISIBLE**2 * scale[:, columns].sum(axis=-1)[..., None]
        rank[:, chosen] = shown.sum(axis=-1)
        threshold = _thresholds(rank[:, chosen], assumptions)
        values = np.where(shown, values, 0.0) / threshold[..., None]
        forms = missed[..., columns].transpose(0, 1, 3, 2, 4) @ axes[:, None]  # (b, blocks, e, q, d)
        shape = forms.shape[:3]
        repeated = np.broadcast_to(values[:, None], (*shape, width))
        solved = largest_along_axes(forms.reshape(-1, *forms.shape[3:]), repeated.reshape(-1, width))
        best: IntArray = solved.value.reshape(shape).argmax(axis=1)
        worst, share, bound = (
            np.take_along_axis(each.reshape(shape), best[:, None], axis=1)[:, 0]
            for each in (solved.value, solved.share, solved.bound)
        )
        point = np.take_along_axis(solved.point.reshape(*shape, width), best[:, None, :, None], axis=1)[:, 0]
        squares[:, chosen], target[:, chosen] = worst, best
        detection[:, chosen] = bound * share / threshold
        visible[:, chosen] = (point**2 * values).sum(axis=-1)
        for place, combination in enumerate(((axes @ point[..., None])[..., 0]).swapaxes(0, 1)):
            sizes[chosen[place]] = combination
    squares[~(finite & model.estimates(base, errors[..., :n_p].reshape(-1, n_p)))] = np.nan
    return Hidden(squares, target, sizes, detection, visible, rank, readings - model.rank)


@dataclass(frozen=True)
class BaseModel:
    """The base model's sensitivities Ã = Q·B⁻¹ of b designs.

    Attributes:
        orthogonal: Q, zero beyond the rank, shape (b, M, r).
        root: B, with B·Bᵀ the pseudo-inverse of ÃᵀÃ on what is identified, shape (b, n_p, r).
        scale: sizes of the columns of Ã, that of the largest for columns that are rounding, shape (b, n_p).
        kept: which of r are within the rank, shape (b, r).
    """

    orthogonal: FloatArray
    root: FloatArray
    scale: FloatArray
    kept: BoolArray

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
        return cls(left * kept[:, None, :], root, scale, kept)

    @property
    def rank(self) -> IntArray:
        """Combinations of compliances that are identified, shape (b,)."""
        return self.kept.sum(axis=1)

    def estimates(self, base: FloatArray, rows: FloatArray) -> BoolArray:
        """Whether rows (q, n_p) of the targets are combinations of those of Ã, shape (b,)."""
        scale = self.scale[:, None, :]
        scaled = rows / scale
        within = (rows @ self.root) @ (self.orthogonal.swapaxes(-1, -2) @ base) / scale
        small = 1e3 * RANK_TOLERANCE * np.maximum(np.linalg.norm(scaled, axis=-1), 1e-300)
        estimated: BoolArray = (np.linalg.norm(scaled - within, axis=-1) <= small).all(axis=-1)
        return estimated


def _thresholds(rank: IntArray, assumptions: Assumptions) -> FloatArray:
    """λ(rank); that of one degree of freedom where nothing is visible and it does not matter."""
    most = int(rank.max(initial=1))
    table = [noncentrality(max(r, 1), assumptions.level, assumptions.power) for r in range(most + 1)]
    return np.array(table)[rank]


def recorded_square(
    base: FloatArray, moved: FloatArray, model: BaseModel, square: FloatArray, detection: FloatArray, block: FloatArray
) -> FloatArray:
    """MEIR_e² of one entry per design, recorded: its Lagrangian at the optimum (b,), with the value that it has.

    At the optimum size and multipliers count as constant (the envelope theorem), so that an expression in what is
    recorded, Ã and B̃_e·x, has the derivative of the maximum.

    Args:
        base: Ã, recorded.
        moved: B̃_e·x, recorded, shape (b, M, 1).
        model: of the numbers of Ã.
        square: the value (b,).
        detection: multiplier of the detection constraint (b,).
        block: weighted errors of the worst block of targets, [A_t, T_t·x], shape (b, q, n_p + 1).
    """
    reduced = base @ model.root
    gram = reduced.swapaxes(-1, -2) @ reduced + np.eye(model.kept.shape[1]) * ~model.kept[:, None, :]
    taken = model.root @ (np.linalg.inv(gram) @ (reduced.swapaxes(-1, -2) @ moved))
    remaining = moved - base @ taken
    missed = block[:, :, -1:] - block[:, :, :-1] @ taken
    lagrangian = (missed**2).sum(axis=(1, 2)) - detection * (remaining**2).sum(axis=(1, 2))
    return lagrangian + (square - plain(lagrangian))
