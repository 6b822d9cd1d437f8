"""All laws of a dictionary weighed beside some that are present, from products that are taken once.

With T = L⁻¹·HᵀΦ of `evidence`, ΦᵀPΦ = ΦᵀΦ − TᵀT and ΦᵀPy = Φᵀy − TᵀL⁻¹Hᵀy: given HᵀΦ no reading is touched again,
and HᵀΦ is put together from the products of the laws that are present. Laws of equal width are weighed in one go.
"""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dtrsm

from expdesign.arrays import FloatArray, IntArray
from expdesign.diagnosis.evidence.columns import Columns
from expdesign.diagnosis.evidence.dictionary import Atom
from expdesign.diagnosis.evidence.state import Present

_UNSEEN = 1e-4
"""Sum of squares of a combination of weights, at unit variance, below which no law is large enough to show it."""
_KEPT = 16
"""Laws whose products with all others are kept."""


@dataclass(frozen=True)
class _Batch:
    """Laws of which readings show equally many combinations of weights.

    Attributes:
        numbers: of the laws, shape (n,).
        turns: (f, w) of each: the combinations of its weights; None where all are seen.
        columns: of each law's directions, one after the other.
        start: of its columns among those of all batches.
        grams: ΦᵀΦ, shape (n, w, w).
    """

    numbers: IntArray
    turns: tuple[FloatArray | None, ...]
    columns: tuple[Columns, ...]
    start: int
    grams: FloatArray

    @property
    def width(self) -> int:
        """Combinations of weights of one law."""
        return self.grams.shape[1]

    def columns_of(self, chosen: IntArray) -> IntArray:
        """Columns of some of its laws, in order."""
        found: IntArray = (self.start + chosen[:, None] * self.width + np.arange(self.width)).ravel()
        return found


class Screen:
    """Gains of log evidence by every law, beside any others.

    Args:
        base: what is there anyway.
        atoms: the laws.
    """

    def __init__(self, base: Present, atoms: Sequence[Atom]) -> None:
        self._start = base
        self._batches: list[_Batch] = []
        self._atoms: list[Atom] = []
        self._width = 0
        self._products: OrderedDict[int, FloatArray] = OrderedDict()
        self._matrices: dict[int, FloatArray] = {}
        self._partial: dict[tuple[int, bytes], FloatArray] = {}
        self._base = np.zeros((0, base.base.shape[1] + 1))
        self.add(atoms)

    def add(self, atoms: Sequence[Atom]) -> None:
        """Further laws, whose numbers follow those that are known."""
        first = len(self._atoms)
        self._atoms += atoms
        by_width: dict[int, list[tuple[int, FloatArray | None, FloatArray]]] = {}
        for number, atom in enumerate(atoms, first):
            values, vectors = np.linalg.eigh(atom.gram)
            seen = values > _UNSEEN
            turned = (None, atom.gram) if seen.all() else (vectors[:, seen], np.diag(values[seen]))
            by_width.setdefault(int(seen.sum()), []).append((number, *turned))
        for width, group in sorted(by_width.items()):
            numbers, turns, grams = zip(*group, strict=True)
            columns = tuple(self._atoms[number].columns for number in numbers)
            self._batches.append(_Batch(np.array(numbers), turns, columns, self._width, np.stack(grams)))
            self._width += width * len(numbers)
        self._base = self._extended(self._base, np.column_stack([self._start.base, self._start.readings]))

    def directions(self, index: int) -> FloatArray:
        """Those of one law (M, f), made once for all that ask."""
        if index not in self._matrices:
            self._matrices[index] = self._atoms[index].directions
        return self._matrices[index]

    def gains(
        self, present: Present, indices: Sequence[int], only: Sequence[int] | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Largest gains and the σ² that reach them, shape (n,) each.

        Args:
            present: the laws that are there.
            indices: their numbers, in order.
            only: numbers of the laws to weigh, ascending; all where left out.
        """
        gains, variances = np.zeros((2, len(self._atoms)))
        wanted = np.arange(len(self._atoms)) if only is None else np.asarray(only)
        asked = [(batch, np.flatnonzero(np.isin(batch.numbers, wanted, assume_unique=True))) for batch in self._batches]
        columns = np.concatenate([batch.columns_of(chosen) for batch, chosen in asked])
        design = [self._base[columns, :-1], *(self._product(i, columns, asked, only is None) for i in indices)]
        through = dtrsm(1.0, present.lower, np.hstack(design).T, lower=1, overwrite_b=1).T
        slopes = self._base[columns, -1] - through @ present.reduced
        start = 0
        for batch, chosen in asked:
            if chosen.size and batch.width:
                shape, part = (len(chosen), batch.width), slice(start, start + len(chosen) * batch.width)
                start = part.stop
                by_law = through[part].reshape(*shape, -1)
                grams = batch.grams[chosen] - np.matmul(by_law, by_law.swapaxes(1, 2))
                numbers = batch.numbers[chosen]
                gains[numbers], variances[numbers] = present.largest_gains(grams, slopes[part].reshape(shape))
        return gains[wanted], variances[wanted]

    def _product(self, index: int, columns: IntArray, asked: list[tuple[_Batch, IntArray]], every: bool) -> FloatArray:
        """Products of those asked for with one law's directions; kept where these are all, shape (columns, f)."""
        known = self._products.pop(index, None)
        if known is None or len(known) < self._width:
            matrix = self.directions(index)
            if not every:
                key = index, columns.tobytes()
                if key not in self._partial:
                    self._partial = {**dict(list(self._partial.items())[-_KEPT:]), key: _products(asked, matrix)}
                return self._partial[key]
            known = self._extended(np.zeros((0, matrix.shape[1])) if known is None else known, matrix)
        self._products[index] = known
        while len(self._products) > _KEPT:
            self._products.popitem(last=False)
        return known if len(columns) == self._width else known[columns]

    def _extended(self, known: FloatArray, matrix: FloatArray) -> FloatArray:
        """Products of the columns of all batches, of which the first are known, with a matrix (M, m)."""
        new = [(batch, np.arange(len(batch.numbers))) for batch in self._batches if batch.start >= len(known)]
        return np.concatenate([known, _products(new, matrix)])


def _products(asked: list[tuple[_Batch, IntArray]], matrix: FloatArray) -> FloatArray:
    """Products of the columns of laws in batches with a matrix (M, m), shape (columns, m)."""
    carried: dict[int, FloatArray] = {}
    parts = [np.zeros((0, matrix.shape[1]))]
    for batch, chosen in asked:
        for number in chosen:
            turn = batch.turns[number]
            part = batch.columns[number].against(matrix, carried)
            parts.append(part if turn is None else turn.T @ part)
    return np.concatenate(parts)
