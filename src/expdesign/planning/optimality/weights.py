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

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.optimality.quadratic import Programs, solve

_TOGETHER = 50_000
"""Candidates whose sensitivities are computed together."""
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
    """What a lower bound is made of: Q, and the two numbers that do not depend on the candidates.

    Attributes:
        matrix: Q, shape (q, r).
        gain: tr(L·Q).
        prior: tr(QᵀPQ).
        count: m.
    """

    matrix: FloatArray
    gain: float
    prior: float
    count: int

    def bound(self, largest: float) -> float:
        """Lower bound on the squared criterion when no candidate has a larger ‖R·Q‖² than `largest`."""
        return self.gain**2 / (self.prior + self.count * largest)

    def sensitivities(self, rows: FloatArray) -> FloatArray:
        """D = ‖R·Q‖² of candidates R (j, ..., k, q), shape (j, ...)."""
        values = np.empty(rows.shape[:-2])
        for start in range(0, len(rows), _TOGETHER):
            products = rows[start : start + _TOGETHER] @ self.matrix
            values[start : start + _TOGETHER] = (products**2).sum(axis=(-2, -1))
        return values


@dataclass(frozen=True)
class Weights:
    """Weights w of candidates (j,), the mixture π of the targets (t,), and the value of the relaxation."""

    candidates: FloatArray
    mixture: FloatArray
    value: float


def optimal_weights(
    relaxation: Relaxation, rows: FloatArray, tolerance: float = 1e-7, known: FloatArray | None = None
) -> Weights:
    """Solve the relaxation over candidates with maps R (j, k, q), by Newton's method on few of them at a time.

    Candidates enter as their sensitivities call for it, so that the cost of a step is linear in their number. It ends
    when the bound over these candidates is within the tolerance of the value, relative, both squares. It begins with
    `known` weights (j,) of some of them where they are given.
    """
    count = len(rows)
    mixture = np.full(len(relaxation.targets), 1.0 / len(relaxation.targets))
    if known is None:
        chosen = _start(relaxation, rows)
        weights = np.full(len(chosen), 1.0 / len(chosen))
    else:
        support = np.flatnonzero(known > 0.0)
        sensitivities = dual_of(relaxation, rows[support], known[support], mixture).sensitivities(rows)
        chosen, weights = _joined(support, known[support], sensitivities)
    value = np.inf
    for _ in range(60):
        weights, mixture, value = _newton(relaxation, rows[chosen], weights, 1e-2 * tolerance)
        dual = dual_of(relaxation, rows[chosen], weights, mixture)
        sensitivities = dual.sensitivities(rows)
        largest = float(sensitivities.max())
        if dual.bound(largest) >= (1.0 - tolerance) * value:
            break
        keep = weights > 1e-6
        before = chosen[keep]
        chosen, weights = _joined(before, weights[keep], sensitivities)
        if len(chosen) == len(before):
            break
    full = np.zeros(count)
    full[chosen] = weights
    return Weights(full, mixture, value)


def _joined(chosen: IntArray, weights: FloatArray, sensitivities: FloatArray) -> tuple[IntArray, FloatArray]:
    """Chosen candidates and weights with those that matter most, which share a twentieth of the weight."""
    weights = weights / weights.sum()
    added = np.setdiff1d(np.argsort(-sensitivities, kind="stable")[:20], chosen)
    if added.size:
        chosen = np.concatenate([chosen, added])
        weights = np.concatenate([0.95 * weights, np.full(len(added), 0.05 / len(added))])
    return chosen, weights


def dual_of(relaxation: Relaxation, rows: FloatArray, weights: FloatArray, mixture: FloatArray) -> Dual:
    """Q = X⁻¹·Lᵀ at the given weights (j,) of candidates (j, k, q) and mixture (t,) of the targets."""
    inverse = np.linalg.inv(_information(relaxation, rows, weights))
    root = (np.sqrt(mixture)[:, None, None] * relaxation.targets).reshape(-1, inverse.shape[0])
    matrix = inverse @ root.T
    return Dual(
        matrix, float(np.trace(root @ matrix)), float(np.trace(matrix.T @ relaxation.prior @ matrix)), relaxation.count
    )


def _start(relaxation: Relaxation, rows: FloatArray) -> IntArray:
    """A few candidates that together identify everything: those of an even sample that matter to its optimum."""
    sample = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), 400)).round().astype(np.int64))
    weights = np.full(len(sample), 1.0 / len(sample))
    mixture = np.full(len(relaxation.targets), 1.0 / len(relaxation.targets))
    for _ in range(30):
        sensitivities = dual_of(relaxation, rows[sample], weights, mixture).sensitivities(rows[sample])
        weights = weights * np.sqrt(sensitivities)
        weights /= weights.sum()
    order = np.argsort(-weights, kind="stable")[:60]
    return np.sort(sample[order])


def _information(relaxation: Relaxation, rows: FloatArray, weights: FloatArray) -> FloatArray:
    stacked = (np.sqrt(np.maximum(weights, 0.0))[:, None, None] * rows).reshape(-1, rows.shape[-1])
    matrix = relaxation.prior + relaxation.count * (stacked.T @ stacked)
    return matrix + _REGULARISATION * np.trace(matrix) / len(matrix) * np.eye(len(matrix))


def _values(relaxation: Relaxation, rows: FloatArray, weights: FloatArray) -> FloatArray:
    inverse = np.linalg.inv(_information(relaxation, rows, weights))
    values: FloatArray = np.einsum("trq,qs,trs->t", relaxation.targets, inverse, relaxation.targets)
    return values


def _newton(
    relaxation: Relaxation, rows: FloatArray, weights: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray, float]:
    """Optimal weights of few candidates, the mixture, and the value: damped Newton steps, each a quadratic program."""
    number = len(weights)
    mixture = np.full(len(relaxation.targets), 1.0 / len(relaxation.targets))
    values = _values(relaxation, rows, weights)
    for _ in range(40):
        # Where few candidates identify all that the targets need, X is nearly singular and its inverse indefinite.
        sizes, axes = np.linalg.eigh(_information(relaxation, rows, weights))
        root = axes / np.sqrt(np.maximum(sizes, 1e-14 * sizes[-1]))
        inverse = root @ root.T
        gradients, curvatures = [], []
        for target in relaxation.targets:
            products = rows @ (inverse @ target.T)
            gradients.append(-relaxation.count * (products**2).sum(axis=(1, 2)))
            turned = ((rows @ root).swapaxes(1, 2) @ products).reshape(number, -1)
            curvatures.append(2.0 * relaxation.count**2 * (turned @ turned.T))
        size = float(values.max())
        hessian = np.einsum("t,tij->ij", mixture, np.array(curvatures)) / size
        hessian = hessian + 1e-9 * (1.0 + np.trace(hessian) / number) * np.eye(number)
        program = Programs(
            hessian=hessian[None],
            values=(values / size)[None],
            gradients=(np.array(gradients) / size)[None],
            limits=np.array([[[float(weights.sum()) - 1.0]]]),
            limit_gradients=np.ones((1, 1, 1, number)),
            low=-weights[None] - 1e-12,
            high=np.maximum(1.0 - weights, 1e-3)[None],
            penalty=np.array([1e2]),
        )
        solution = solve(program)
        mixture = np.maximum(solution.pieces[0], 0.0)
        mixture = mixture / mixture.sum()
        step, length = solution.step[0], 1.0
        while length > 1e-6:
            trial = np.maximum(weights + length * step, 0.0)
            trial /= trial.sum()
            found = _values(relaxation, rows, trial)
            if found.max() < size:
                break
            length *= 0.5
        if length <= 1e-6:
            break
        weights, values = trial, found
        if size - float(values.max()) < tolerance * size:
            break
    return weights, mixture, float(values.max())
