"""Optimal weights of candidate measurements: the convex design problem (theory.md 10.1, 10.2, 10.4).

    min over w ≥ 0, Σw = 1 of  max_t tr(C_t·(P + m·Σ_j w_j·N_j)⁻¹),   N_j = R_jᵀ·R_j ,

with N_j the information of one measurement at candidate j and P prior information (of load errors that are estimated
along with the compliances). For *any* matrix Q and mixture π of the targets the optimum is at least

    tr(L·Q)² / (tr(QᵀPQ) + m·max_j ‖R_j·Q‖²) ,   LᵀL = Σ_t π_t·C_t ,

by weak duality, 2·tr(LQ) − tr(QᵀXQ) ≤ tr(L·X⁻¹·Lᵀ), with the best scale of Q. Rounding, or weights that are not
optimal, can therefore make the bound weaker but not wrong.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.optimality.quadratic import Programs, solve

_TOGETHER = 50_000
"""Candidates whose sensitivities are computed together."""
_TURNS, _ADDED, _STEPS = 60, 20, 40
"""Times that candidates may join, how many do at most, and Newton steps in between."""
_REGULARISATION = 1e-7
"""Part of the mean eigenvalue of an information that is added to all of them: where the optimum leaves parameters
unidentified that no target needs, Q would hang on weights that count for nothing. The bound holds for any Q."""


@dataclass(frozen=True)
class Relaxation:
    """The convex problem for plans of m measurements, in scaled parameters.

    Attributes:
        targets: L_t with C_t = L_tᵀ·L_t for every alternative t of the maximum, shape (t, r, q).
        prior: P, shape (q, q).
        count: m.
    """

    targets: FloatArray
    prior: FloatArray
    count: int


@dataclass(frozen=True)
class Dual:
    """What a lower bound is made of: Q, and numbers that do not depend on the candidates.

    Attributes:
        matrix: Q, shape (q, r).
        values: tr(C_t·X⁻¹) of every target at the weights, shape (t,).
        gain: tr(L·Q).
        prior: tr(QᵀPQ).
        count: m.
    """

    matrix: FloatArray
    values: FloatArray
    gain: float
    prior: float
    count: int

    @property
    def value(self) -> float:
        """The squared criterion at the weights."""
        return float(self.values.max())

    def bound(self, largest: float) -> float:
        """Lower bound on the squared criterion when no candidate has a larger ‖R·Q‖² than `largest`."""
        return self.gain**2 / (self.prior + self.count * largest)

    def sensitivities(self, rows: FloatArray) -> FloatArray:
        """D = ‖R·Q‖² of candidates R (j, ..., k, q), shape (j, ...)."""
        parts = np.split(rows, range(_TOGETHER, len(rows), _TOGETHER))
        values: FloatArray = np.concatenate([((part @ self.matrix) ** 2).sum(axis=(-2, -1)) for part in parts])
        return values


def optimal_weights(
    relaxation: Relaxation, rows: FloatArray, tolerance: float = 1e-7, known: FloatArray | None = None
) -> tuple[FloatArray, Dual]:
    """Weights (j,) that solve the relaxation over candidates with maps R (j, k, q), and the dual there.

    Few candidates have weight at a time, and others enter as their sensitivities call for it, so that the cost of a
    step is linear in their number. It ends when the bound over all candidates is within the tolerance of the value,
    relative, both squares. It begins with `known` weights (j,) where they are given.
    """
    weights = _start(relaxation, rows) if known is None else known.copy()
    for _ in range(_TURNS):
        chosen = np.flatnonzero(weights)
        own, mixture = _solved(relaxation, rows[chosen], weights[chosen], 1e-2 * tolerance)
        dual = dual_of(relaxation, rows[chosen], own, mixture)
        sensitivities = dual.sensitivities(rows)
        weights[chosen] = np.where(own > 1e-6, own, 0.0)
        added = np.setdiff1d(np.argsort(-sensitivities, kind="stable")[:_ADDED], np.flatnonzero(weights))
        if dual.bound(float(sensitivities.max())) >= (1.0 - tolerance) * dual.value or not added.size:
            break
        weights[added] = 0.05 / len(added)
    return weights / weights.sum(), dual


def _start(relaxation: Relaxation, rows: FloatArray) -> FloatArray:
    """Weights (j,) of a few candidates that together identify everything: those of an even sample that matter to its
    optimum, by multiplicative steps (Silvey, Titterington & Torsney 1978).
    """
    sample = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), 400)).round().astype(np.int64))
    weights, mixture = np.full(len(sample), 1.0 / len(sample)), np.full(len(relaxation.targets), 1.0)
    for _ in range(30):
        weights = weights * np.sqrt(dual_of(relaxation, rows[sample], weights, mixture).sensitivities(rows[sample]))
        weights /= weights.sum()
    found = np.zeros(len(rows))
    found[sample[np.argsort(-weights, kind="stable")[:60]]] = 1.0
    return found


def _solved(
    relaxation: Relaxation, rows: FloatArray, weights: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Optimal weights (j,) of few candidates, and the mixture (t,): damped Newton steps, each a quadratic program."""
    number, targets = len(weights), len(relaxation.targets)
    level = np.append(np.ones(targets), 0.0)  # the last row: weights add up to 1
    own, mixture = weights / weights.sum(), np.full(targets, 1.0 / targets)
    values = dual_of(relaxation, rows, own, mixture).values
    for _ in range(_STEPS):
        # Where few candidates identify all that the targets need, X is nearly singular and its inverse indefinite.
        sizes, axes = np.linalg.eigh(_information(relaxation, rows, own))
        root = axes / np.sqrt(np.maximum(sizes, 1e-14 * sizes[-1]))
        products = [rows @ (root @ root.T @ target.T) for target in relaxation.targets]
        size = float(values.max())
        gradients = -relaxation.count / size * np.array([(each**2).sum(axis=(1, 2)) for each in products])
        hessian = np.zeros((number, number))
        for part, each in zip(mixture, products, strict=True):
            turned = ((rows @ root).swapaxes(1, 2) @ each).reshape(number, -1)
            hessian += 2.0 * part * relaxation.count**2 / size * (turned @ turned.T)
        program = Programs(
            hessian=(hessian + 1e-9 * (1.0 + np.trace(hessian) / number) * np.eye(number))[None],
            values=np.append(values / size, 0.0)[None],
            rows=np.concatenate([gradients, np.ones((1, number))])[None],
            level=level[None],
            penalty=np.where(level > 0.0, 2.0, 1e2)[None],
            low=-own[None] - 1e-12,
            high=np.maximum(1.0 - own, 1e-3)[None],
        )
        step, multipliers = solve(program)
        mixture = np.maximum(multipliers[0, :targets], 0.0)
        mixture = mixture / mixture.sum()
        for length in 0.5 ** np.arange(20):
            trial = np.maximum(own + length * step[0], 0.0)
            found = dual_of(relaxation, rows, trial / trial.sum(), mixture).values
            if found.max() < size:
                break
        else:
            break
        own, values = trial / trial.sum(), found
        if size - float(values.max()) < tolerance * size:
            break
    return own, mixture


def _information(relaxation: Relaxation, rows: FloatArray, weights: FloatArray) -> FloatArray:
    stacked = (np.sqrt(weights)[:, None, None] * rows).reshape(-1, rows.shape[-1])
    matrix = relaxation.prior + relaxation.count * (stacked.T @ stacked)
    return matrix + _REGULARISATION * np.trace(matrix) / len(matrix) * np.eye(len(matrix))


def dual_of(relaxation: Relaxation, rows: FloatArray, weights: FloatArray, mixture: FloatArray) -> Dual:
    """Q = X⁻¹·Lᵀ at the given weights (j,) of candidates (j, k, q) and mixture (t,) of the targets."""
    inverse = np.linalg.inv(_information(relaxation, rows, weights))
    values = np.einsum("trq,qs,trs->t", relaxation.targets, inverse, relaxation.targets)
    root = (np.sqrt(mixture)[:, None, None] * relaxation.targets).reshape(-1, len(inverse))
    matrix = inverse @ root.T
    prior = float(np.trace(matrix.T @ relaxation.prior @ matrix))
    return Dual(matrix, values, float(mixture @ values), prior, relaxation.count)
