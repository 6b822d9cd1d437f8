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

from expdesign.arrays import BoolArray, FloatArray

_STEPS = 80
_FARTHEST = 30.0
"""Largest |log(μ/(1 − μ))|; where something is not visible at all, D(1) is singular and s is infinite."""
_SMALL, _CLOSE = 1e-12, 1e-11
"""Excess, and width of the bracket of log(μ/(1 − μ)), at which the search ends."""


_SHARES = (0.0, 0.1, 0.5, 0.9, 0.99)
"""μ at which the bounds are taken."""


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


def bounds_along_axes(forms: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lower and upper bounds of the largest value without an eigenvalue problem, shape (...) each.

    The best feasible point on one axis, and the least trace of C·D(μ)⁻¹·Cᵀ over some μ, which is never below s(μ).
    They agree for one unknown.

    Args:
        forms: C, shape (..., q, d).
        values: diagonal of H, not negative, shape (..., d).
    """
    squares = (forms**2).sum(axis=-2)
    lower: FloatArray = (squares / np.maximum(values, 1.0)).max(axis=-1)
    if forms.shape[-1] == 1:
        return lower, lower
    traces = [(squares / (share * values + 1.0 - share)).sum(axis=-1) for share in _SHARES]
    return lower, np.min(traces, axis=0)


def _one(forms: FloatArray, values: FloatArray) -> Largest:
    """One unknown: the tighter of the two constraints."""
    weight = np.maximum(values[:, 0], 1.0)
    value = (forms[:, :, 0] ** 2).sum(axis=1) / weight
    return Largest(value, value, 1.0 / np.sqrt(weight)[:, None], (values[:, 0] > 1.0).astype(float))


def _several(forms: FloatArray, values: FloatArray) -> Largest:
    """Several unknowns: the root of the excess over t = log(μ/(1 − μ)), on which it changes at an even pace."""
    count = len(forms)
    low, high = np.full(count, -_FARTHEST), np.full(count, _FARTHEST)
    below, above = _top(forms, values, np.zeros(count)), _top(forms, values, _share(high))
    # The excess xᵀ(H − I)x of the maximiser falls with μ from where xᵀHx is too large to where xᵀx is.
    left, right = _excess(below, values), _excess(above, values)
    prior, detection = left <= 0.0, (left > 0.0) & (right >= 0.0)
    above = np.where(prior[:, None], below, above)
    below = np.where(detection[:, None], above, below)
    share = np.where(prior, 0.0, np.where(detection, _share(high), np.nan))
    third, far = low.copy(), left.copy()
    step = np.full(count, 0.5)
    active = np.flatnonzero(np.isnan(share))
    for _ in range(_STEPS):
        if active.size == 0:
            break
        t = low[active] + step[active] * (high[active] - low[active])
        point = _top(forms[active], values[active], _share(t))
        excess = _excess(point, values[active])
        up, down = active[excess > 0.0], active[excess <= 0.0]
        rising, falling = excess > 0.0, excess <= 0.0
        third[up], far[up], third[down], far[down] = low[up], left[up], high[down], right[down]
        low[up], left[up], below[up] = t[rising], excess[rising], point[rising]
        high[down], right[down], above[down] = t[falling], excess[falling], point[falling]
        step[active] = _chandrupatla(low[active], high[active], third[active], left[active], right[active], far[active],
                                     excess > 0.0)  # fmt: skip
        active = active[(np.abs(excess) > _SMALL) & (high[active] - low[active] > _CLOSE)]
    share = np.where(np.isnan(share), _share(np.where(np.abs(left) < np.abs(right), low, high)), share)
    scaled = forms / np.sqrt(_weights(values, share))[:, None, :]
    bound = np.linalg.norm(scaled, ord=2, axis=(-2, -1)) ** 2
    point = _between(below, above, values)
    size = np.maximum((point**2).sum(axis=1), (point**2 * values).sum(axis=1))
    point = point / np.sqrt(np.maximum(size, 1e-300))[:, None]
    value = ((forms @ point[..., None])[..., 0] ** 2).sum(axis=1)
    return Largest(bound, value, point, share)


def _share(t: FloatArray) -> FloatArray:
    """μ of t."""
    return 1.0 / (1.0 + np.exp(-t))


def _chandrupatla(
    low: FloatArray,
    high: FloatArray,
    third: FloatArray,
    left: FloatArray,
    right: FloatArray,
    far: FloatArray,
    rising: BoolArray,
) -> FloatArray:
    """Where between `low` and `high` (0 to 1) to look next: inverse quadratic where it is safe, else the middle.

    Chandrupatla (1997). `third` is the end of the bracket that was given up last; the newest is `low` where `rising`.
    """
    newest, other = np.where(rising, low, high), np.where(rising, high, low)
    f1, f2, f3 = np.where(rising, left, right), np.where(rising, right, left), far
    with np.errstate(divide="ignore", invalid="ignore"):
        xi, phi = (newest - other) / (third - other), (f1 - f2) / (f3 - f2)
        safe = (phi**2 < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
        slope = (third - newest) / (other - newest)
        along = f1 / (f2 - f1) * f3 / (f2 - f3) + slope * f1 / (f3 - f1) * f2 / (f3 - f2)
    along = np.clip(np.where(safe & np.isfinite(along), along, 0.5), 1e-6, 1.0 - 1e-6)
    return np.where(rising, along, 1.0 - along)


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
