"""KKT proximity measure: how far a design is from satisfying the conditions of Pareto optimality.

Deb & Abouhawwash (2016): a design is reached as the minimiser of an achievement function along its own direction, i.e.
of t subject to (f_k − f_k(x))/span_k ≤ t, with bounds and limits g ≤ 0. The measure is the least violation of its KKT
conditions over all multipliers u ≥ 0,

    min_u ‖Σ u_j·∇φ_j + Σ u_l·∇g_l‖² + (1 − Σ u_j)² + Σ (u_l·g_l)² ,

here solved exactly as a non-negative least-squares problem. It lies between 0 (a KKT point) and 1. Design variables
are in parts of their range, objectives in parts of their span over the front; discrete variables are held.
"""

import numpy as np
from scipy.optimize import nnls

from expdesign.arrays import FloatArray
from expdesign.planning.optimality.differentiated import Differentiated, shared_series
from expdesign.planning.optimality.objectives import Objectives, tied
from expdesign.planning.optimality.sqp import MARGIN, Limits
from expdesign.planning.problem import DesignProblem
from expdesign.planning.scalarisation import spans

_VANISHING = 1e-4
"""Part of an objective's span below which a root of a sum of squares is as small as it can be."""
_NEAR, _TURNS = 0.5, 20
"""Part of a range beyond which a constraint does not matter, and how often the bounds pointed at may change."""


_LARGEST = 1000
"""Variables of a design beyond which the least-squares problem takes longer than it tells."""


def kktpm(problem: DesignProblem, variables: FloatArray) -> FloatArray:
    """KKT proximity (d,) of the designs of a front, variables (d, m, g); NaN where a design has no gradient.

    The spans of the objectives are those of the designs given: a front should be given whole.
    """
    objectives = Objectives(problem)
    if len(variables) == 0 or not objectives.differentiable[: objectives.count].all():
        return np.full(len(variables), np.nan)
    space = problem.space
    designs = Differentiated.of_designs(problem, variables)
    found = [objectives.pieces(k, designs) for k in range(objectives.count)]
    values = np.stack([pieces[0].value for pieces in found], axis=1)
    span = spans(values)
    free = (~space.discrete) & (space.upper > space.lower)
    width = np.where(free, space.upper - space.lower, 0.0)
    tie = tied(space, shared_series(problem, designs.quantities))
    columns, slack = [], []
    for k, pieces in enumerate(found):
        for piece in pieces:
            gradient = piece.gradient() * width
            if tie is not None:
                gradient = tie(gradient, np.arange(len(variables)))
            # A root mean square that vanishes, but for rounding of the design, has zero among its subgradients.
            vanishing = problem.objectives[k].root_mean_square and np.abs(piece.value) <= _VANISHING * span[k]
            gradient = np.where(np.reshape(vanishing, (-1, 1, 1)), 0.0, gradient)
            columns.append(gradient[:, :, free] / span[k])
            slack.append((piece.value - values[:, k]) / span[k])
    limits, limit_gradients = Limits(problem).rows(variables)
    scaled_limits = (limit_gradients * width)[..., free]
    position = ((variables - space.lower) / np.where(free, space.upper - space.lower, 1.0))[..., free]
    measure = np.full(len(variables), np.nan)
    if position[0].size > _LARGEST:
        return measure
    # Where a criterion has a kink that it does not state, its gradient is not finite.
    smooth = np.logical_and.reduce([np.isfinite(column).all(axis=(1, 2)) for column in columns])
    for index in np.flatnonzero(designs.regular & smooth):
        measure[index] = _violation(
            np.stack([column[index].ravel() for column in columns], axis=1),
            np.array([gap[index] for gap in slack]),
            limits[index] - MARGIN,
            scaled_limits[index],
            position[index].ravel(),
        )
    return measure


def _violation(
    gradients: FloatArray, slack: FloatArray, limits: FloatArray, limit_gradients: FloatArray, position: FloatArray
) -> float:
    """The least-squares value for one design.

    Args:
        gradients: of the pieces of the objectives, columns, shape (n, j).
        slack: how far each piece is below its objective, ≤ 0, shape (j,).
        limits: rows g ≤ 0 of the measurements, shape (m, r).
        limit_gradients: shape (m, r, free).
        position: free variables in parts of their range, shape (n,).
    """
    n, j = gradients.shape
    m, r, width = limit_gradients.shape
    rows = np.zeros((n, m * r))
    for i in range(m):
        rows[i * width : (i + 1) * width, i * r : (i + 1) * r] = limit_gradients[i].T
    norms, gaps = np.linalg.norm(rows, axis=0), limits.ravel()
    useful = (norms > 0.0) & (gaps > -_NEAR * np.maximum(norms, 1.0))
    stationary = np.concatenate([gradients, rows[:, useful]], axis=1)
    gaps = np.concatenate([slack, gaps[useful]])
    fixed = np.vstack([np.arange(len(gaps)) < j, np.diag(gaps)])
    right = np.zeros(n + len(fixed))
    right[n] = 1.0
    # A bound with the gap g takes what it can of a component ρ that points at it: min over v of (ρ − v)² + (v·g)².
    left, least = stationary[:, :j].sum(axis=1), np.inf
    lower, upper = (np.where(gap < _NEAR, gap**2 / (1.0 + gap**2), 1.0) for gap in (position, 1.0 - position))
    for _ in range(_TURNS):
        towards = left > 0.0
        weight = np.where(towards, lower, upper)
        multipliers, residual = nnls(np.vstack([np.sqrt(weight)[:, None] * stationary, fixed]), right)
        left = stationary @ multipliers
        change = (np.where(left > 0.0, lower, upper) - weight) @ left**2
        least = min(least, float(residual**2 + change))
        if ((left > 0.0) == towards).all():
            break
    return least
