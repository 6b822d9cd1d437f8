"""The largest error at the targets that each effect hides, from the sensitivities of a batch of designs.

With Ã the whitened base sensitivities of a plan and B̃_e those of an effect e in units of its prior sizes, the
base model takes up u = Ã⁺B̃_e·x of an effect of size x; R_e·x with R_e = (I − ÃÃ⁺)B̃_e remains in the residuals, and the
compensated robot misses target t by (T_e,t − A_t·Ã⁺B̃_e)·x. Then

    MEIR_e² = max over x of Σ_t w_t·‖W_t^½·(T_e,t − A_t·Ã⁺B̃_e)·x‖²  subject to  ‖R_e·x‖² ≤ λ,  ‖x‖² ≤ 1.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.assurance.model_error.left_out import Omitted, offsets
from expdesign.assurance.model_error.settings import Assumptions, noncentrality
from expdesign.assurance.model_error.two_ellipsoids import largest_along_axes
from expdesign.planning.criteria.information import Information

VISIBLE = 1e-6
"""Singular values of R_e below this fraction of the largest of B̃_e are rounding: that direction is not visible."""


@dataclass(frozen=True)
class Hidden:
    """What b designs hide, for E entries of left-out physics.

    Attributes:
        squares: MEIR_e², shape (b, E); NaN where a design does not identify the base model.
        sizes: x of the worst combination in units of the prior sizes, per entry (b, d_e).
        visible: ‖R_e·x‖²/λ of that combination, shape (b, E): 1 where it is just noticed, 0 where it never is.
        rank: independent directions of each entry that show in the residuals, shape (b, E).
        freedom: degrees of freedom of the residuals, shape (b,).
    """

    squares: FloatArray
    sizes: list[FloatArray]
    visible: FloatArray
    rank: IntArray
    freedom: IntArray


def hidden_errors(
    base: FloatArray,
    directions: FloatArray,
    errors: FloatArray,
    physics: tuple[Omitted, ...],
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
    model = Information.of_measurements(base[:, None])
    orthogonal = base @ model.inverse
    seen_by_base = orthogonal.swapaxes(-1, -2) @ directions
    remaining = directions - orthogonal @ seen_by_base
    missed = errors[..., n_p:] - errors[..., :n_p] @ (model.inverse @ seen_by_base)[:, None]
    scale = (directions**2).sum(axis=1)
    entries, start = len(physics), offsets(physics)
    squares, visible = np.zeros((batch, entries)), np.zeros((batch, entries))
    rank = np.zeros((batch, entries), dtype=np.int64)
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
        point = np.take_along_axis(solved.point.reshape(*shape, width), best[:, None, :, None], axis=1)[:, 0]
        squares[:, chosen] = np.take_along_axis(solved.value.reshape(shape), best[:, None], axis=1)[:, 0]
        visible[:, chosen] = (point**2 * values).sum(axis=-1)
        for place, combination in enumerate(((axes @ point[..., None])[..., 0]).swapaxes(0, 1)):
            sizes[chosen[place]] = combination
    squares[~(finite & model.estimable(errors[..., :n_p]).all(axis=(1, 2)))] = np.nan
    return Hidden(squares, sizes, visible, rank, readings - model.rank)


def _thresholds(rank: IntArray, assumptions: Assumptions) -> FloatArray:
    """λ(rank); that of one degree of freedom where nothing is visible and it does not matter."""
    most = int(rank.max(initial=1))
    table = [noncentrality(max(r, 1), assumptions.level, assumptions.power) for r in range(most + 1)]
    return np.array(table)[rank]
