"""Evaluate CasADi expressions on whole NumPy batches without copying, and build each of them once."""

import math
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from functools import wraps
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.differentiation import is_recorded, plain, recorded_parts, unbroadcast

_LARGEST_MAP = 2048
"""Most samples of one call to the engine. Maps are made for powers of two up to it, because making the map of every
size that occurs costs more than a few calls more."""

_Result = TypeVar("_Result")
_REMEMBERED = 16
"""Expressions of one kind that an object keeps: an expression of one row asks for a handful, many times."""
_known: WeakKeyDictionary[Any, dict[str, OrderedDict[Hashable, tuple[Any, Any]]]] = WeakKeyDictionary()


def remembered(method: Callable[..., _Result]) -> Callable[..., _Result]:
    """A method of expressions that gives the same expression for the same symbols, so that all who use it share it.

    Arguments are positional: expressions, which are the same where their elements are, or hashable. What it returns is
    not to be changed.
    """

    @wraps(method)
    def shared(self: Any, *given: Any) -> _Result:
        results = _known.setdefault(self, {}).setdefault(method.__name__, OrderedDict())
        key = tuple(_elements(each) if isinstance(each, ca.SX) else each for each in given)
        if key not in results:
            # The arguments are kept with it: an element that ends may leave its hash to another one.
            results[key] = (given, method(self, *given))
            if len(results) > _REMEMBERED:
                results.popitem(last=False)
        results.move_to_end(key)
        found: _Result = results[key][1]
        return found

    return shared


def _elements(expression: ca.SX) -> tuple[Hashable, ...]:
    return expression.shape, *(element.element_hash() for element in expression.elements())  # type: ignore[attr-defined]


def evaluate_through(
    buffered: tuple[ca.FunctionBuffer, Callable[[], None]], given: Sequence[FloatArray], results: Sequence[FloatArray]
) -> None:
    """Evaluate a function by its buffers (`Function.buffer`), without copies.

    Args:
        buffered: the buffers, and what evaluates them.
        given: contiguous inputs, columns first as CasADi stores them.
        results: contiguous arrays that are filled, likewise.
    """
    buffer, evaluate = buffered
    for index, array in enumerate(given):
        buffer.set_arg(index, memoryview(array))  # type: ignore[call-arg, arg-type]
    for index, array in enumerate(results):
        buffer.set_res(index, memoryview(array))  # type: ignore[call-arg, arg-type]
    evaluate()


class BatchFunction:
    """Symbolic expressions as a function of NumPy arrays with leading batch dimensions.

    Args:
        name: identifier for messages of the engine.
        inputs: symbolic column vectors.
        outputs: expressions of the inputs, matrices or column vectors.
    """

    def __init__(self, name: str, inputs: Sequence[ca.SX], outputs: Sequence[ca.SX]) -> None:
        dense = [ca.densify(output) for output in outputs]
        self._symbols, self._dense = list(inputs), dense
        self._function = ca.Function(name, list(inputs), dense)
        self._widths = [symbol.shape[0] for symbol in inputs]
        self._shapes = [output.shape for output in dense]
        self._adjoints: dict[tuple[int, ...], BatchFunction] = {}
        self._mapped: dict[int, tuple[ca.FunctionBuffer, Callable[[], None]]] = {}

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_mapped": {}}  # buffers are made again where they are needed

    def _map(self, count: int) -> tuple[ca.FunctionBuffer, Callable[[], None]]:
        """The buffers of `count` samples at once, and what evaluates them."""
        if count not in self._mapped:
            self._mapped[count] = self._function.map(count).buffer()
        return self._mapped[count]

    @property
    def function(self) -> ca.Function:
        """The CasADi function of one sample."""
        return self._function

    def __call__(self, *arrays: FloatArray) -> tuple[FloatArray, ...]:
        """Evaluate.

        Args:
            arrays: one per input, shape (..., width); their batch dimensions are broadcast against each other.

        Returns:
            One array per output, shape (..., rows, columns), or (..., rows) for a column vector. Results of recorded
            arrays are recorded; their adjoint is CasADi's.
        """
        if any(is_recorded(array) for array in arrays):
            return self._recorded(arrays)
        return self._evaluated(*arrays)

    def _recorded(self, arrays: tuple[FloatArray, ...]) -> tuple[FloatArray, ...]:
        numbers = [plain(array) for array in arrays]
        values = self._evaluated(*numbers)
        batch = values[0].shape[: values[0].ndim - (1 if self._shapes[0][1] == 1 else 2)]

        def pull(seeds: dict[int, FloatArray]) -> list[FloatArray]:
            wanted = tuple(sorted(seeds))
            found = self.adjoint(wanted)(*numbers, *(seeds[index].reshape(*batch, -1) for index in wanted))
            return [unbroadcast(part, number.shape) for part, number in zip(found, numbers, strict=True)]

        return recorded_parts(values, arrays, pull)

    def adjoint(self, wanted: tuple[int, ...]) -> "BatchFunction":
        """Vector-Jacobian products: of inputs and one seed per wanted output (rows first) to one gradient per input."""
        if wanted not in self._adjoints:
            seeds = [ca.SX.sym(f"seed{index}", self._dense[index].numel()) for index in wanted]
            stacked = ca.vertcat(*(ca.vec(self._dense[index].T) for index in wanted))
            products = ca.jtimes(stacked, ca.vertcat(*self._symbols), ca.vertcat(*seeds), True)
            parts = ca.vertsplit(ca.cse(products), np.cumsum([0, *self._widths]).tolist())
            name = f"{self._function.name()}_adjoint"
            self._adjoints[wanted] = BatchFunction(name, [*self._symbols, *seeds], parts)
        return self._adjoints[wanted]

    def _evaluated(self, *arrays: FloatArray) -> tuple[FloatArray, ...]:
        batch = arrays[0].shape[:-1]
        if any(array.shape[:-1] != batch for array in arrays):
            batch = np.broadcast_shapes(*(array.shape[:-1] for array in arrays))
        count = math.prod(batch)
        flat = [
            np.ascontiguousarray(_spread(array, (*batch, width)), dtype=np.float64).reshape(count, width)
            for array, width in zip(arrays, self._widths, strict=True)
        ]
        # CasADi stores columns first, so a sample's matrix appears transposed in a C-ordered array.
        results = [np.empty((count, columns, rows)) for rows, columns in self._shapes]
        start = 0
        while start < count:
            size = min(_LARGEST_MAP, 1 << ((count - start).bit_length() - 1))
            part = slice(start, start + size)
            start += size
            evaluate_through(self._map(size), [array[part] for array in flat], [result[part] for result in results])
        return tuple(
            result.reshape(*batch, rows) if columns == 1 else result.swapaxes(-1, -2).reshape(*batch, rows, columns)
            for result, (rows, columns) in zip(results, self._shapes, strict=True)
        )


def _spread(array: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    return array if array.shape == shape else np.broadcast_to(array, shape)
