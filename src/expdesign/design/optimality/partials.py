"""Derivatives of the criteria with respect to what they are functions of: variances at the targets, singular values.

A criterion with a maximum in it is a maximum of smooth pieces; its largest pieces are given one by one, so that
optimisation and optimality conditions need no derivative at a kink. The criteria of this project have their formulas
here; one that is added later as a file of its own is differentiated by complex steps through its own code.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.criteria.assessment import Assessment
from expdesign.criteria.criterion import Criterion
from expdesign.criteria.targets import Targets
from expdesign.design.optimality.sensitivity import DesignState
from expdesign.errors import InputError

PIECES = 6
"""Largest number of pieces of a maximum over targets that are looked at at a time."""


@dataclass(frozen=True)
class Piece:
    """A smooth function of b designs, and its partial derivatives (None where it does not depend on the quantity).

    Attributes:
        value: shape (b,).
        noise: with respect to U_ii, shape (b, t, n).
        force: with respect to (Z·Σ_F·Zᵀ)_ii, shape (b, t, n).
        singular: with respect to the singular values, shape (b, n_p).
    """

    value: FloatArray
    noise: FloatArray | None = None
    force: FloatArray | None = None
    singular: FloatArray | None = None

    def gradient(self, state: DesignState) -> FloatArray:
        """With respect to the genes, shape (b, m, g)."""
        return state.gradient(self.noise, self.force, self.singular)

    def quantity_gradient(self, state: DesignState) -> FloatArray:
        """With respect to every quantity of the measurements, free or fixed, shape (b, m, z)."""
        return state.quantity_gradient(self.noise, self.force, self.singular)


def pieces(criterion: Criterion, state: DesignState) -> list[Piece]:
    """The smooth pieces of a criterion, the largest first; a smooth criterion is its own single piece."""
    known = _FORMULAS.get(criterion.name)
    return known(state) if known is not None else _by_complex_steps(criterion, state)


def _root_mean(name: str) -> Callable[[DesignState], list[Piece]]:
    """DUIR, FEIR or total: √ of the weighted mean, or of each of the largest targets, of Σ_i variance_ii/tol_i²."""

    def formula(state: DesignState) -> list[Piece]:
        targets = state.model.problem.targets
        parts = [] if name == "feir" else [state.noise_variance]
        parts += [] if name == "duir" else [state.force_variance]
        variance = np.where(targets.importance > 0.0, np.sum(parts, axis=0), 0.0)
        squares = (variance * targets.importance).sum(axis=-1)
        found: list[Piece] = []
        for weights in _weights(targets, squares):
            value = np.sqrt((squares * weights).sum(axis=-1))
            partials = (weights / (2.0 * np.maximum(value, 1e-150))[:, None])[..., None] * targets.importance
            found.append(Piece(value, None if name == "feir" else partials, None if name == "duir" else partials, None))
        return found

    return formula


def _weights(targets: Targets, squares: FloatArray) -> list[FloatArray]:
    """Weights of the targets (b, t) in each piece."""
    if targets.aggregate == "mean":
        return [np.broadcast_to(targets.weights / targets.weights.sum(), squares.shape)]
    return _largest(squares)


def _largest(values: FloatArray) -> list[FloatArray]:
    """Selections (b, t) of the largest, the second largest, ... of values (b, t)."""
    count = min(PIECES, values.shape[1])
    order = np.argsort(-np.nan_to_num(values), axis=1, kind="stable")[:, :count]
    return [(np.arange(values.shape[1]) == order[:, i, None]).astype(float) for i in range(count)]


def _o1(state: DesignState) -> list[Piece]:
    values = state.singular_values
    value = np.exp(np.log(values).mean(axis=1)) / np.sqrt(state.count)
    return [Piece(value, singular=value[:, None] / (values.shape[1] * values))]


def _o2(state: DesignState) -> list[Piece]:
    values = state.singular_values
    partials = np.zeros_like(values)
    value = values[:, -1] / values[:, 0]
    partials[:, 0], partials[:, -1] = -value / values[:, 0], 1.0 / values[:, 0]
    return [Piece(value, singular=partials)]


def _o3(state: DesignState) -> list[Piece]:
    partials = np.zeros_like(state.singular_values)
    partials[:, -1] = 1.0
    return [Piece(state.singular_values[:, -1], singular=partials)]


def _o4(state: DesignState) -> list[Piece]:
    values = state.singular_values
    partials = np.zeros_like(values)
    ratio = values[:, -1] / values[:, 0]
    partials[:, 0], partials[:, -1] = -(ratio**2), 2.0 * ratio
    return [Piece(values[:, -1] * ratio, singular=partials)]


def _o5(state: DesignState) -> list[Piece]:
    values = state.singular_values
    value = 1.0 / (1.0 / values).sum(axis=1)
    return [Piece(value, singular=(value[:, None] / values) ** 2)]


def _tested(kind: str) -> Callable[[DesignState], list[Piece]]:
    """O_TP and O_MV: translational variances at the first target, in the mean, or at the largest targets."""

    def formula(state: DesignState) -> list[Piece]:
        targets = state.model.problem.targets
        axes = np.arange(targets.importance.shape[1]) < targets.translations
        variance = np.where(axes, state.noise_variance, 0.0).sum(axis=-1)
        count = variance.shape[1]
        if kind == "o_tp":
            selections: list[FloatArray] = [np.broadcast_to(np.eye(1, count), variance.shape)]
        elif kind == "o_mv":
            selections = [np.full(variance.shape, 1.0 / count)]
        else:
            selections = _largest(variance)
        return [Piece((variance * chosen).sum(axis=1), noise=chosen[..., None] * axes) for chosen in selections]

    return formula


ROOT_MEANS = ("duir", "feir", "total")
"""Criteria that are root mean squares: not differentiable where they vanish."""

_FORMULAS: dict[str, Callable[[DesignState], list[Piece]]] = {
    **{name: _root_mean(name) for name in ROOT_MEANS},
    **{name: _tested(name) for name in ("o_tp", "o_mv", "o_mv_max")},
    "o1": _o1,
    "o2": _o2,
    "o3": _o3,
    "o4": _o4,
    "o5": _o5,
}


class _Perturbed:
    """What a criterion may read of an `Assessment`, with complex numbers in it."""

    def __init__(self, state: DesignState, noise: FloatArray, force: FloatArray, singular: FloatArray) -> None:
        self.targets = state.model.problem.targets
        self.batch, self.count, self.parameters = len(noise), state.count, singular.shape[1]
        self.noise_variance, self.force_variance, self.singular_values = noise, force, singular

    @property
    def condition(self) -> FloatArray:
        return self.singular_values[:, 0] / self.singular_values[:, -1]

    def weighted(self, variance: FloatArray) -> FloatArray:
        return Assessment.weighted(cast(Assessment, self), variance)

    def aggregated(self, squares: FloatArray) -> FloatArray:
        return Assessment.aggregated(cast(Assessment, self), squares)


def _by_complex_steps(criterion: Criterion, state: DesignState) -> list[Piece]:
    """Derivatives to rounding of any analytic criterion: f(x + ih) = f(x) + ih·f′(x), without cancellation."""
    arrays: list[FloatArray] = [state.noise_variance, state.force_variance, state.singular_values]
    flat = np.concatenate([array.reshape(state.batch, -1) for array in arrays], axis=1)
    sizes = np.cumsum([array[0].size for array in arrays])[:-1]
    value = np.empty(state.batch)
    partials = np.empty_like(flat)
    for column in range(flat.shape[1]):
        moved = flat.astype(np.complex128)
        step = 1e-30 * np.maximum(np.abs(flat[:, column]), 1e-200)
        moved[:, column] += 1j * step
        parts = [part.reshape(array.shape) for part, array in zip(np.split(moved, sizes, axis=1), arrays, strict=True)]
        stand_in = cast(Assessment, _Perturbed(state, *cast(list[FloatArray], parts)))
        try:
            result = np.asarray(criterion.values(stand_in))
        except (AttributeError, TypeError) as error:
            remedy = "Leave it out of `objectives`, or switch `optimiser.polish` off."
            what = f"the criterion `{criterion.name}` has no exact derivative ({error})"
            raise InputError(what, remedy=remedy) from None
        value[:] = result.real
        partials[:, column] = result.imag / step
    noise, force, singular = (
        part.reshape(array.shape) for part, array in zip(np.split(partials, sizes, axis=1), arrays, strict=True)
    )
    return [Piece(value, noise, force, singular)]
