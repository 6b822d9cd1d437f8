"""Exact derivatives of batched NumPy code: reverse-mode automatic differentiation (Griewank & Walther 2008, ch. 3).

The method's formulas are written once, in NumPy. Evaluated on an `independent` array, every operation is recorded, and
one backward pass through the record gives the gradient of a result to rounding. What NumPy code calls beside NumPy
states its own adjoint: CasADi's functions (`symbolic.py`), and rules of linear algebra.

The operations of which every evaluation consists have their adjoints here, because a record costs as much as the small
matrices in it; all other functions of NumPy take them from the library autograd.

Code that is to be differentiated creates its results and does not write into arrays. `plain` gives the numbers of what
only decides (ranks, masks, orders).
"""

from collections.abc import Callable, Sequence
from functools import cache
from heapq import heappop, heappush
from itertools import count
from typing import Any, cast

import autograd.numpy as library
import numpy as np
from autograd.core import VJPNode
from autograd.numpy.numpy_boxes import ArrayBox
from autograd.tracer import notrace_primitives, trace_primitives_map
from numpy.lib.mixins import NDArrayOperatorsMixin

from expdesign.arrays import FloatArray

Adjoint = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""(result, argument, partial derivatives with respect to the result) → partial derivatives for the argument."""
_TRACE = 0


_following = count(1).__next__


class _Node(VJPNode):  # type: ignore[misc]
    """One recorded operation.

    Attributes:
        parents: where its arguments came from.
        vjp: its adjoint, from partial derivatives with respect to the result to those with respect to the arguments.
        number: of the operation in the order in which they were recorded; every parent's is smaller.
        seed: partial derivatives with respect to the result, as far as a backward pass has summed them up.
    """

    __slots__ = ("number", "seed")

    def __init__(self, value: Any, fun: Any, args: Any, kwargs: Any, argnums: Any, parents: Any) -> None:
        super().__init__(value, fun, args, kwargs, argnums, parents)
        self.number, self.seed = _following(), None


notrace_primitives[_Node] = notrace_primitives[VJPNode]


def _node(parents: Sequence[Any], vjp: Callable[[Any], Sequence[Any]]) -> Any:
    node = _Node.__new__(_Node)
    node.parents, node.vjp, node.number, node.seed = parents, vjp, _following(), None
    return node


class _Recorded(NDArrayOperatorsMixin, ArrayBox):  # type: ignore[misc]
    """A recorded array that NumPy's functions accept, so that code need not know whether it is differentiated."""

    __slots__ = ()

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method != "__call__" or "out" in kwargs:
            return NotImplemented
        rule = _OPERATIONS.get(function) or trace_primitives_map.get(function)
        return NotImplemented if rule is None else rule(*inputs, **kwargs)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        module = library.linalg if function.__module__ == "numpy.linalg" else library
        rule = _OPERATIONS.get(function) or getattr(module, function.__name__, None)
        return NotImplemented if rule is None else rule(*args, **kwargs)

    def __getitem__(self, index: Any) -> Any:
        value = self._value[index]
        shape = self._value.shape
        view = np.may_share_memory(value, self._value)
        if view and value.size == self._value.size and value.flags.c_contiguous and self._value.flags.c_contiguous:
            return _box(value, (self._node,), lambda seed: (seed.reshape(shape),))

        def pull(seed: FloatArray) -> tuple[FloatArray]:
            result = np.zeros(shape)
            if view:
                result[index] = seed
            else:
                np.add.at(result, index, seed)
            return (result,)

        return _box(value, (self._node,), pull)


for _kind in (np.ndarray, np.float64):
    _Recorded.register(_kind)


def _box(value: Any, parents: Sequence[Any], vjp: Callable[[Any], Sequence[Any]]) -> Any:
    # As the constructors of both would, in half the time.
    node = _Node.__new__(_Node)
    node.parents, node.vjp, node.number, node.seed = parents, vjp, _following(), None
    box = _Recorded.__new__(_Recorded)
    box._value, box._trace, box._node = value, _TRACE, node
    return box


def independent(values: FloatArray) -> FloatArray:
    """An array with respect to which results can be differentiated."""
    return cast(FloatArray, _box(values, (), lambda seed: ()))


def plain(values: FloatArray) -> FloatArray:
    """The numbers of an array, recorded or not."""
    return cast(FloatArray, values._value) if type(values) is _Recorded else values


def is_recorded(values: object) -> bool:
    """Whether a result depends on an independent array."""
    return type(values) is _Recorded


def _numbers(values: Any) -> Any:
    if type(values) is _Recorded:
        return values._value
    return values if type(values) is np.ndarray else np.asarray(values)


def gradient(result: FloatArray, weights: FloatArray, like: FloatArray) -> FloatArray:
    """Gradient of Σ weights·result with respect to the independent array that `result` came from (zero if from none).

    Args:
        result: of any shape.
        weights: of the same shape.
        like: values of the independent array.
    """
    if type(result) is not _Recorded:
        return np.zeros(like.shape)
    last = result._node
    last.seed = weights
    # Later operations first: then all that depends on an operation has been seen before it.
    waiting = [(-last.number, last)]
    try:
        with np.errstate(all="ignore"):
            while waiting:
                node = heappop(waiting)[1]
                seed, node.seed = node.seed, None
                for parent, part in zip(node.parents, node.vjp(seed)):
                    known = parent.seed
                    if known is None:
                        heappush(waiting, (-parent.number, parent))
                        parent.seed = part
                    else:
                        parent.seed = known | part if type(known) is dict else known + part
    finally:
        for _, node in waiting:
            node.seed = None
    return np.asarray(seed)


def unbroadcast(seed: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """The sum of partial derivatives over the dimensions along which an argument of this shape was repeated."""
    if seed.shape == shape:
        return seed
    if seed.ndim > len(shape):
        seed = seed.sum(axis=tuple(range(seed.ndim - len(shape))))
    repeated = tuple(axis for axis, size in enumerate(shape) if size == 1 and seed.shape[axis] != 1)
    return seed.sum(axis=repeated, keepdims=True) if repeated else seed


def recorded(value: FloatArray, arguments: Sequence[Any], pulls: Sequence[Callable[[FloatArray], FloatArray]]) -> Any:
    """A result whose partial derivatives with respect to each argument are given, as a record where one is recorded."""
    kept = [
        (argument._node, pull) for argument, pull in zip(arguments, pulls, strict=True) if type(argument) is _Recorded
    ]
    if not kept:
        return value
    return _box(value, [node for node, _ in kept], lambda seed: [pull(seed) for _, pull in kept])


def recorded_parts(
    values: Sequence[FloatArray],
    arguments: Sequence[Any],
    pull: Callable[[dict[int, FloatArray]], Sequence[FloatArray]],
) -> tuple[Any, ...]:
    """Several results at once; `pull` gives the derivatives for all arguments from those for the results that matter,
    by their index.
    """
    places = [place for place, argument in enumerate(arguments) if type(argument) is _Recorded]

    def together(seeds: dict[int, FloatArray]) -> list[FloatArray]:
        found = pull(seeds)
        return [found[place] for place in places]

    common = (_node([arguments[place]._node for place in places], together),)

    def part(index: int) -> Callable[[FloatArray], tuple[dict[int, FloatArray]]]:
        return lambda seed: ({index: seed},)

    return tuple(_box(value, common, part(index)) for index, value in enumerate(values))


def with_adjoint(
    adjoint: Adjoint,
) -> Callable[[Callable[[FloatArray], FloatArray]], Callable[[FloatArray], FloatArray]]:
    """Decorator of a function of one array that states its adjoint."""

    def decorated(function: Callable[[FloatArray], FloatArray]) -> Callable[[FloatArray], FloatArray]:
        def recording(argument: FloatArray) -> FloatArray:
            if type(argument) is not _Recorded:
                return function(argument)
            numbers = plain(argument)
            result = function(numbers)
            return cast(FloatArray, recorded(result, [argument], [lambda seed: adjoint(result, numbers, seed)]))

        recording.__doc__, recording.__name__ = function.__doc__, function.__name__
        return recording

    return decorated


def transposed(matrices: FloatArray) -> FloatArray:
    """Transposes of a batch of matrices."""
    return matrices.swapaxes(-1, -2)


Rule = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""(partial derivatives with respect to the result, first, second argument) → those with respect to one of them."""


def _operation(function: Callable[..., Any], to_first: Rule, to_second: Rule) -> Callable[[Any, Any], Any]:
    """A function of two arrays that are broadcast against each other, with its adjoints."""

    def recording(first: Any, second: Any) -> Any:
        a, b = _numbers(first), _numbers(second)
        pulls = (
            lambda seed: unbroadcast(to_first(seed, a, b), a.shape),
            lambda seed: unbroadcast(to_second(seed, a, b), b.shape),
        )
        return recorded(function(a, b), (first, second), pulls)

    return recording


def _inverse_adjoint(inverse: FloatArray, matrices: FloatArray, seed: FloatArray) -> FloatArray:
    return -(transposed(inverse) @ seed @ transposed(inverse))


inverse_with_adjoint = with_adjoint(_inverse_adjoint)
"""Decorator of functions that give inverses of a batch of matrices."""


def _root_adjoint(root: FloatArray, square: FloatArray, seed: FloatArray) -> FloatArray:
    return np.where(root > 0.0, seed / np.where(root > 0.0, 2.0 * root, 1.0), 0.0)


@with_adjoint(_root_adjoint)
def square_root(square: FloatArray) -> FloatArray:
    """√ of sums of squares. Where they vanish the root is at its least: 0 is among its subgradients, and is given."""
    return np.sqrt(square)


def _inverse_root_adjoint(root: FloatArray, covariance: FloatArray, seed: FloatArray) -> FloatArray:
    # For G = L⁻¹: L̄ = −Gᵀ·Ḡ·Gᵀ; for V = L·Lᵀ: V̄ = ½·Gᵀ·(P + Pᵀ)·G, P the lower half of Lᵀ·L̄ = −Ḡ·Gᵀ (Murray 2016).
    half = np.tril(-seed @ transposed(root))
    half *= 1.0 - 0.5 * np.eye(half.shape[-1])
    return 0.5 * transposed(root) @ (half + transposed(half)) @ root


@with_adjoint(_inverse_root_adjoint)
def inverse_root(covariance: FloatArray) -> FloatArray:
    """G with GᵀG = V⁻¹ of a batch of covariances V: the inverse of the Cholesky factor."""
    inverse: FloatArray = np.linalg.inv(np.linalg.cholesky(covariance))
    return inverse


def product_transposed(first: Any, second: Any) -> Any:
    """A·Bᵀ of two batches of matrices of one batch shape."""
    return _product_transposed(first, second)


@with_adjoint(lambda product, matrices, seed: (seed + transposed(seed)) @ matrices)
def one_and_gram(matrices: FloatArray) -> FloatArray:
    """I + X·Xᵀ of a batch of matrices."""
    return np.eye(matrices.shape[-2]) + matrices @ transposed(matrices)


def sum_of_squares(values: FloatArray, axis: int | tuple[int, ...]) -> FloatArray:
    """Σ x² along axes."""
    numbers = plain(values)
    total: FloatArray = (numbers * numbers).sum(axis=axis)
    return cast(FloatArray, recorded(total, [values], [lambda seed: 2.0 * np.expand_dims(seed, axis) * numbers]))


def _qr(matrices: Any) -> tuple[Any, ...]:
    """Q and R; Ā = (Q̄ + Q·copyltu(M))·R⁻ᵀ, M = R·R̄ᵀ − Q̄ᵀ·Q (Walter & Lehmann 2018), for full column rank."""
    orthogonal, triangular = np.linalg.qr(plain(matrices))
    lower = np.tri(triangular.shape[-1])

    @cache
    def inverse_transposed() -> FloatArray:
        # What is not of full rank has no derivative; another factor there keeps it from stopping the batch.
        diagonal = np.abs(np.diagonal(triangular, axis1=-2, axis2=-1))
        regular = (diagonal.min(axis=-1) > 1e-14 * diagonal.max(axis=-1))[..., None, None]
        return transposed(np.linalg.inv(np.where(regular, triangular, np.eye(triangular.shape[-1]))))

    def pull(seeds: dict[int, FloatArray]) -> tuple[FloatArray]:
        by_orthogonal = seeds.get(0, np.zeros(orthogonal.shape))
        by_triangular = seeds.get(1, np.zeros(triangular.shape))
        product = triangular @ transposed(by_triangular) - transposed(by_orthogonal) @ orthogonal
        symmetric = product * lower
        symmetric += transposed(product * (lower - np.eye(len(lower))))
        return ((by_orthogonal + orthogonal @ symmetric) @ inverse_transposed(),)

    return recorded_parts((orthogonal, triangular), (matrices,), pull)


_product_transposed = _operation(
    lambda a, b: a @ transposed(b), lambda seed, a, b: seed @ b, lambda seed, a, b: transposed(seed) @ a
)
_matrix_product = _operation(
    np.matmul, lambda seed, a, b: seed @ transposed(b), lambda seed, a, b: transposed(a) @ seed
)
_OPERATIONS: dict[Any, Any] = {
    np.add: _operation(np.add, lambda seed, a, b: seed, lambda seed, a, b: seed),
    np.subtract: _operation(np.subtract, lambda seed, a, b: seed, lambda seed, a, b: -seed),
    np.multiply: _operation(np.multiply, lambda seed, a, b: seed * b, lambda seed, a, b: seed * a),
    np.matmul: lambda a, b: _matrix_product(a, b) if min(a.ndim, b.ndim) > 1 else library.matmul(a, b),
    np.linalg.qr: _qr,
    np.linalg.inv: inverse_with_adjoint(np.linalg.inv),
}
