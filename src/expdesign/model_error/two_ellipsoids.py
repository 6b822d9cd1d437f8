"""The largest value of a quadratic form on the intersection of two ellipsoids about the origin, for whole batches.

    maximise ‖C·x‖²  subject to  xᵀ·H·x ≤ 1  and  xᵀ·x ≤ 1      (H positive semidefinite, perhaps singular)

Lagrange's dual has one multiplier per constraint; with y₁ = s·μ and y₂ = s·(1 − μ) it is

    min over μ in [0, 1] of s(μ),  s(μ) = λ_max(C·D(μ)⁻¹·Cᵀ),  D(μ) = μ·H + (1 − μ)·I.

1/s(μ) = max{t : t·CᵀC ⪯ D(μ)} is concave, because the matrix inequality is linear in t and μ together: the dual is a
search for the sign of one derivative. It is tight in every dimension: the semidefinite relaxation has two constraints
besides positive semidefiniteness, so that it has a solution of rank r with r·(r + 1)/2 ≤ 2, that is of rank one
(Barvinok 1995; Pataki 1998; for two quadratic constraints Ye and Zhang 2003). Convexity of the joint range of three
forms, which Polyak (1998) has for three dimensions and more, is not needed.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray

_STEPS = 60
_NEVER = 1.0 - 1e-13
"""Largest μ; where something is not visible at all, D(1) is singular and s is infinite."""
_CLOSE = 1e-12
"""Width of the bracket of μ, relative to its distance from either end, at which the search ends."""


@dataclass(frozen=True)
class Largest:
    """Solution of a batch of problems, d unknowns each.

    Attributes:
        bound: s at the best μ, an upper bound whatever the accuracy of the search, shape (...).
        value: ‖C·x‖² at `point`, which is feasible, shape (...); equal to `bound` up to rounding.
        point: x, shape (..., d).
        share: μ, shape (...): 0 where only xᵀx ≤ 1 binds, 1 where only xᵀHx ≤ 1 does.
    """

    bound: FloatArray
    value: FloatArray
    point: FloatArray
    share: FloatArray


def largest(forms: FloatArray, visible: FloatArray) -> Largest:
    """Solve a batch of problems.

    Args:
        forms: C, shape (..., q, d).
        visible: H, shape (..., d, d).
    """
    batch, (q, d) = forms.shape[:-2], forms.shape[-2:]
    values, axes = np.linalg.eigh(visible.reshape(-1, d, d))
    solution = largest_along_axes(forms.reshape(-1, q, d) @ axes, np.maximum(values, 0.0))
    return Largest(
        solution.bound.reshape(batch),
        solution.value.reshape(batch),
        (axes @ solution.point[..., None])[..., 0].reshape(*batch, d),
        solution.share.reshape(batch),
    )


def largest_along_axes(forms: FloatArray, values: FloatArray) -> Largest:
    """Solve problems whose H is diagonal.

    Args:
        forms: C, shape (b, q, d).
        values: diagonal of H, not negative, shape (b, d).
    """
    if forms.shape[2] == 1:
        return _one(forms, values)
    return _several(forms, values)


def _one(forms: FloatArray, values: FloatArray) -> Largest:
    """One unknown: the tighter of the two constraints."""
    weight = np.maximum(values[:, 0], 1.0)
    value = (forms[:, :, 0] ** 2).sum(axis=1) / weight
    return Largest(value, value, 1.0 / np.sqrt(weight)[:, None], (values[:, 0] > 1.0).astype(float))


def _several(forms: FloatArray, values: FloatArray) -> Largest:
    """Several unknowns."""
    low, high = np.zeros(len(forms)), np.full(len(forms), _NEVER)
    below, above = _top(forms, values, low), _top(forms, values, high)
    # The excess xᵀ(H − I)x of the maximiser falls with μ from where xᵀHx is too large to where xᵀx is.
    start, end = _excess(below, values), _excess(above, values)
    inside = (start > 0.0) & (end < 0.0)
    high = np.where(start <= 0.0, low, high)
    above = np.where((start <= 0.0)[:, None], below, above)
    low = np.where((start > 0.0) & (end >= 0.0), high, low)
    below = np.where(((start > 0.0) & (end >= 0.0))[:, None], above, below)
    left, right = start.copy(), end.copy()
    for step in range(_STEPS):
        active = np.flatnonzero(inside & (high - low > _CLOSE * np.minimum(high, 1.0 - low)))
        if active.size == 0:
            break
        middle = _next(low[active], high[active], left[active], right[active], step)
        point = _top(forms[active], values[active], middle)
        excess = _excess(point, values[active])
        rising = excess > 0.0
        up, down = active[rising], active[~rising]
        low[up], below[up], left[up] = middle[rising], point[rising], excess[rising]
        high[down], above[down], right[down] = middle[~rising], point[~rising], excess[~rising]
        done = active[np.abs(excess) < 1e-13]
        inside[done] = False
        low[done] = high[done] = middle[np.abs(excess) < 1e-13]
        below[done] = above[done] = point[np.abs(excess) < 1e-13]
    share = np.where(np.abs(left) < np.abs(right), low, high)
    scaled = forms / np.sqrt(_weights(values, share))[:, None, :]
    bound = np.linalg.norm(scaled, ord=2, axis=(-2, -1)) ** 2
    point = _between(below, above, values)
    size = np.maximum((point**2).sum(axis=1), (point**2 * values).sum(axis=1))
    point = point / np.sqrt(np.maximum(size, 1e-300))[:, None]
    value = ((forms @ point[..., None])[..., 0] ** 2).sum(axis=1)
    return Largest(bound, value, point, share)


def _next(low: FloatArray, high: FloatArray, left: FloatArray, right: FloatArray, step: int) -> FloatArray:
    """The next μ: false position on the excess, every third step the middle (of logarithms near the ends)."""
    if step % 3 == 2:
        # Either end is approached over many orders of magnitude where H is nearly singular or large.
        from_zero = np.sqrt(np.maximum(low, 1e-14) * np.maximum(high, 1e-14))
        from_one = 1.0 - np.sqrt((1.0 - low) * (1.0 - high))
        middle = np.where(high < 0.1, from_zero, np.where(low > 0.9, from_one, 0.5 * (low + high)))
    else:
        # Near the root, left and right have opposite signs; bounded excesses keep the secant inside.
        middle = low + (high - low) * left / (left - right)
    margin = 1e-3 * (high - low) if step % 3 != 2 else 0.0
    return np.clip(middle, low + margin, high - margin)


def _weights(values: FloatArray, share: FloatArray) -> FloatArray:
    """Diagonal of D(μ), (b, d)."""
    return share[:, None] * values + (1.0 - share)[:, None]


def _top(forms: FloatArray, values: FloatArray, share: FloatArray) -> FloatArray:
    """Maximiser of ‖C·x‖² under xᵀ·D(μ)·x ≤ 1, (b, d)."""
    weights = _weights(values, share)
    scaled = forms / np.sqrt(weights)[:, None, :]
    if forms.shape[1] < forms.shape[2]:
        _, vectors = np.linalg.eigh(scaled @ scaled.swapaxes(-1, -2))
        right = (vectors[:, None, :, -1] @ scaled)[:, 0]
    else:
        _, vectors = np.linalg.eigh(scaled.swapaxes(-1, -2) @ scaled)
        right = vectors[:, :, -1]
    norm = np.linalg.norm(right, axis=1, keepdims=True)
    right = np.where(norm > 0.0, right / np.where(norm > 0.0, norm, 1.0), 0.0)
    return right / np.sqrt(weights)


def _excess(point: FloatArray, values: FloatArray) -> FloatArray:
    """xᵀ(H − I)x relative to xᵀ(H + I)x: between −1 and 1."""
    squares = point**2
    total: FloatArray = ((values - 1.0) * squares).sum(axis=1)
    return total / np.maximum(((values + 1.0) * squares).sum(axis=1), 1e-300)


def _between(below: FloatArray, above: FloatArray, values: FloatArray) -> FloatArray:
    """The point between two maximisers at which both constraints bind.

    Where the largest eigenvalue at the best μ is simple, both are that point already; where it is not, the excess jumps
    from one sign to the other within its eigenspace, and the point lies between them.
    """
    sign = np.where((below * above).sum(axis=1, keepdims=True) < 0.0, -1.0, 1.0)
    above = sign * above
    form = values - 1.0
    a = (form * below**2).sum(axis=1)
    b = (form * below * above).sum(axis=1)
    c = (form * above**2).sum(axis=1)
    # (1 − t)²·a + 2·t·(1 − t)·b + t²·c = 0 with a ≥ 0 ≥ c has one root in [0, 1].
    mixed = (a > 0.0) & (c < 0.0)
    root = np.sqrt(np.maximum(b**2 - a * c, 0.0))
    denominator = np.where(mixed, a - b + root, 1.0)
    t = np.clip(np.where(mixed, a / np.where(denominator == 0.0, 1.0, denominator), 0.0), 0.0, 1.0)
    t = np.where((a <= 0.0) | mixed, t, 1.0)
    return (1.0 - t)[:, None] * below + t[:, None] * above
