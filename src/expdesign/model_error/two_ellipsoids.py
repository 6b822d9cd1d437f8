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

_STEPS = 80
_FARTHEST = 30.0
"""Largest |log(μ/(1 − μ))|; where something is not visible at all, D(1) is singular and s is infinite."""
_CLOSE = 1e-10
"""Imbalance log(xᵀHx/xᵀx), and width of the bracket of log(μ/(1 − μ)), at which the search ends."""
_GAP = 1e-10
"""Relative difference of the bound from what is attained at which it ends as well."""
_SMOOTH = 4
"""Steps after which Newton's method has ended where the largest eigenvalue is simple."""


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


def largest_along_axes(forms: FloatArray, values: FloatArray, least: FloatArray | None = None) -> Largest:
    """Solve problems whose H is diagonal.

    Args:
        forms: C, shape (b, q, d).
        values: diagonal of H, not negative, shape (b, d).
        least: what a value has to reach to be of interest, shape (b,): a problem whose bound falls below is left with
            the bound and the feasible point that it has then.
    """
    if forms.shape[2] == 1:
        return _one(forms, values)
    if forms.shape[1] > forms.shape[2]:
        forms = np.asarray(np.linalg.qr(forms, mode="r"))  # ‖C·x‖ = ‖R·x‖
    return _several(forms, values, np.full(len(forms), -np.inf) if least is None else least)


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


def _several(forms: FloatArray, values: FloatArray, least: FloatArray) -> Largest:
    """Several unknowns: the least of s(μ) over t = log(μ/(1 − μ)), within a bracket.

    Newton's method for the root of the imbalance, which falls with μ; where two eigenvalues cross at the least, and the
    imbalance jumps, the point where the tangents of the concave 1/s from both sides meet (Kelley 1960).
    """
    count = len(forms)
    share = np.zeros(count)
    # At μ = 0, that is without the first constraint, the maximiser may satisfy it already.
    bound, point, imbalance, _, ends = _top(forms, values, share)
    below, above = point, point.copy()
    low, high, t = np.full(count, -_FARTHEST), np.full(count, _FARTHEST), np.zeros(count)
    left, right, last = ends, np.full((count, 3), np.nan), np.full(count, np.inf)
    active = np.flatnonzero((imbalance > 0.0) & (bound >= least))
    for turn in range(_STEPS):
        if active.size == 0:
            break
        here = _share(t[active])
        top, point, imbalance, slope, ends = _top(forms[active], values[active], here)
        rising = imbalance > 0.0
        up, down = active[rising], active[~rising]
        low[up], below[up], left[up] = t[up], point[rising], ends[rising]
        high[down], above[down], right[down] = t[down], point[~rising], ends[~rising]
        better = top < bound[active]
        bound[active[better]], share[active[better]] = top[better], here[better]
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = t[active] - imbalance / slope
        middle = 0.5 * (low[active] + high[active])
        following = middle if turn % 3 == 2 else _meeting(left[active], right[active], middle)
        usable = np.isfinite(newton) & (np.abs(imbalance) < 0.5 * last[active])
        following = np.where(usable, newton, following)
        inside = (following > low[active]) & (following < high[active])
        t[active], last[active] = np.where(inside, following, middle), np.abs(imbalance)
        going = (np.abs(imbalance) > _CLOSE) & (high[active] - low[active] > _CLOSE) & (bound[active] >= least[active])
        if turn > _SMOOTH:
            part = active[going]
            _, reached = _feasible(forms[part], values[part], below[part], above[part])
            going[going] = bound[part] - reached > _GAP * bound[part]
        active = active[going]
    # Where detection alone binds, the upper end of the bracket has never been left.
    above = np.where((high == _FARTHEST)[:, None], below, above)
    point, value = _feasible(forms, values, below, above)
    return Largest(bound, value, point, share)


def _share(t: FloatArray) -> FloatArray:
    """μ of t."""
    share: FloatArray = 1.0 / (1.0 + np.exp(-t))
    return share


def _meeting(left: FloatArray, right: FloatArray, middle: FloatArray) -> FloatArray:
    """Where (t) the tangents of 1/s at both ends of a bracket meet, from (μ, 1/s, its slope); else its middle."""
    with np.errstate(divide="ignore", invalid="ignore"):
        gap = right[:, 1] - left[:, 1] - right[:, 2] * (right[:, 0] - left[:, 0])
        share = left[:, 0] + gap / (left[:, 2] - right[:, 2])
        t = np.log(share / (1.0 - share))
    met: FloatArray = np.where(np.isfinite(t), t, middle)
    return met


def _feasible(
    forms: FloatArray, values: FloatArray, below: FloatArray, above: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The point between two maximisers at which both constraints bind, made feasible, (b, d), and its value (b,)."""
    point = _between(below, above, values)
    size = np.maximum((point**2).sum(axis=1), (point**2 * values).sum(axis=1))
    point = point / np.sqrt(np.maximum(size, 1e-300))[:, None]
    value: FloatArray = ((forms @ point[..., None])[..., 0] ** 2).sum(axis=1)
    return point, value


def _top(
    forms: FloatArray, values: FloatArray, share: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """At D(μ), of problems with q ≤ d rows: s (b,), the maximiser x (b, d), its imbalance log(xᵀHx/xᵀx) and the
    imbalance's derivative with respect to t, (b,) each; and μ, 1/s and the derivative of 1/s, (b, 3).

    With S = C·D⁻¹·Cᵀ and its first eigenvector v, x is y = D⁻¹Cᵀv up to its length, and
    v' = Σ_k v_k·(v_kᵀS'v)/(s − s_k), S' = −C·D⁻¹D'D⁻¹·Cᵀ (Rellich; the others' eigenvalues s_k simple against s).
    """
    mu = share[:, None]
    weights = mu * values + (1.0 - mu)
    change = (values - 1.0) * mu * (1.0 - mu) / weights
    spectrum, vectors = np.linalg.eigh((forms / weights[:, None, :]) @ forms.swapaxes(-1, -2))
    first, others = vectors[:, :, -1], vectors[:, :, :-1]
    y = (first[:, None, :] @ forms)[:, 0] / weights
    turned = -((forms @ (change * y)[..., None])[..., 0][:, None, :] @ others)[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        mixed = np.where(spectrum[:, -1:] > spectrum[:, :-1], turned / (spectrum[:, -1:] - spectrum[:, :-1]), 0.0)
    dy = ((others @ mixed[..., None])[:, None, :, 0] @ forms)[:, 0] / weights - change * y
    seen, size = (values * y**2).sum(axis=1), (y**2).sum(axis=1)
    none = size <= 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        imbalance = np.log(seen / size)
        slope = 2.0 * (values * y * dy).sum(axis=1) / seen - 2.0 * (y * dy).sum(axis=1) / size
    imbalance[none | (seen <= 0.0)] = -np.inf
    length = np.sqrt(np.where(none, 1.0, (weights * y**2).sum(axis=1)))
    top = spectrum[:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        tangent = np.stack([share, 1.0 / top, (seen - size) / top**2], axis=1)
    return top, y / length[:, None], imbalance, slope, tangent


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
