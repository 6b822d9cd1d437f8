"""The largest value of a quadratic form on the intersection of two ellipsoids about the origin, for whole batches.

    maximise ‖C·x‖²  subject to  xᵀ·H·x ≤ 1  and  xᵀ·x ≤ 1      (H positive semidefinite, perhaps singular)

Lagrange's dual has one multiplier per constraint; with y₁ = s·μ and y₂ = s·(1 − μ) it is

    min over μ in [0, 1] of s(μ),  s(μ) = λ_max(C·D(μ)⁻¹·Cᵀ),  D(μ) = μ·H + (1 − μ)·I.

1/s(μ) = max{t : t·CᵀC ⪯ D(μ)} is concave, because the matrix inequality is linear in t and μ together: the dual is a
search for the sign of one derivative. It is tight in every dimension: the semidefinite relaxation has two constraints
besides positive semidefiniteness, so that it has a solution of rank r with r·(r + 1)/2 ≤ 2, that is of rank one
(Barvinok 1995; Pataki 1998; for two quadratic constraints Ye and Zhang 2003).
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray

_HALVINGS = 45
"""Of the bracket of log(μ/(1 − μ)) at most, until it is as wide as rounding."""
_FARTHEST = 30.0
"""Largest |log(μ/(1 − μ))|; where something is not visible at all, D(1) is singular and s is infinite."""
_GAP = 1e-10
"""Relative difference of the bound from what is attained at which the search ends."""


@dataclass(frozen=True)
class Largest:
    """Solution of a batch of problems, d unknowns each.

    Attributes:
        bound: s at the best μ, an upper bound whatever the accuracy of the search, shape (b,).
        value: ‖C·x‖² at `point`, which is feasible, shape (b,); equal to `bound` up to rounding.
        point: x, shape (b, d).
    """

    bound: FloatArray
    value: FloatArray
    point: FloatArray


def largest_along_axes(forms: FloatArray, values: FloatArray) -> Largest:
    """Solve problems with C (b, q, d) whose H is diagonal and not negative, (b, d).

    The least of s(μ) is found by halving a bracket of t = log(μ/(1 − μ)): the imbalance falls with μ.
    """
    if forms.shape[2] == 1:
        weight = np.maximum(values[:, 0], 1.0)  # the tighter of the two constraints
        value = (forms[:, :, 0] ** 2).sum(axis=1) / weight
        return Largest(value, value, 1.0 / np.sqrt(weight)[:, None])
    if forms.shape[1] > forms.shape[2]:
        forms = np.asarray(np.linalg.qr(forms, mode="r"))  # ‖C·x‖ = ‖R·x‖
    # At μ = 0, that is without the first constraint, the maximiser may satisfy it already.
    bound, below, imbalance = _top(forms, values, np.zeros(len(forms)))
    above = below.copy()
    low, high = np.full(len(forms), -_FARTHEST), np.full(len(forms), _FARTHEST)
    active = np.flatnonzero(imbalance > 0.0)
    for _ in range(_HALVINGS):
        if active.size == 0:
            break
        t = 0.5 * (low[active] + high[active])
        top, point, imbalance = _top(forms[active], values[active], 1.0 / (1.0 + np.exp(-t)))
        rising = imbalance > 0.0
        up, down = active[rising], active[~rising]
        low[up], below[up] = t[rising], point[rising]
        high[down], above[down] = t[~rising], point[~rising]
        bound[active] = np.minimum(bound[active], top)
        reached = _feasible(forms[active], values[active], below[active], above[active])[1]
        active = active[bound[active] - reached > _GAP * bound[active]]
    # Where detection alone binds, the upper end of the bracket has never been left.
    above = np.where((high == _FARTHEST)[:, None], below, above)
    point, value = _feasible(forms, values, below, above)
    return Largest(bound, value, point)


def _top(forms: FloatArray, values: FloatArray, share: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """At D(μ), of problems with q ≤ d rows: s (b,), the maximiser x (b, d) and its imbalance log(xᵀHx/xᵀx) (b,)."""
    mu = share[:, None]
    weights = mu * values + (1.0 - mu)
    spectrum, vectors = np.linalg.eigh((forms / weights[:, None, :]) @ forms.swapaxes(-1, -2))
    y = (vectors[:, None, :, -1] @ forms)[:, 0] / weights
    seen, size = (values * y**2).sum(axis=1), (y**2).sum(axis=1)
    none = size <= 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        imbalance = np.where(none | (seen <= 0.0), -np.inf, np.log(seen / size))
    length = np.sqrt(np.where(none, 1.0, (weights * y**2).sum(axis=1)))
    return spectrum[:, -1], y / length[:, None], imbalance


def _feasible(
    forms: FloatArray, values: FloatArray, below: FloatArray, above: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The point between two maximisers at which both constraints bind, made feasible, (b, d), and its value (b,).

    Where the largest eigenvalue at the best μ is simple, both are that point already; where it is not, the excess jumps
    from one sign to the other within its eigenspace, and the point lies between them.
    """
    above = np.where((below * above).sum(axis=1, keepdims=True) < 0.0, -1.0, 1.0) * above
    form = values - 1.0
    a, b, c = ((form * first * second).sum(axis=1) for first, second in
               ((below, below), (below, above), (above, above)))  # fmt: skip
    # (1 − t)²·a + 2·t·(1 − t)·b + t²·c = 0 with a ≥ 0 ≥ c has one root in [0, 1].
    mixed = (a > 0.0) & (c < 0.0)
    denominator = a - b + np.sqrt(np.maximum(b**2 - a * c, 0.0))
    t = np.clip(np.where(mixed, a, 0.0) / np.where(mixed & (denominator != 0.0), denominator, 1.0), 0.0, 1.0)
    t = np.where((a <= 0.0) | mixed, t, 1.0)[:, None]
    point = (1.0 - t) * below + t * above
    size = np.maximum((point**2).sum(axis=1), (point**2 * values).sum(axis=1))
    point = point / np.sqrt(np.maximum(size, 1e-300))[:, None]
    value: FloatArray = ((forms @ point[..., None])[..., 0] ** 2).sum(axis=1)
    return point, value
