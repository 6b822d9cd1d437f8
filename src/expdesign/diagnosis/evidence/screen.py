"""All laws of a dictionary weighed beside some that are present, from products that are taken once.

With T = L⁻¹·HᵀΦ of `evidence`, ΦᵀPΦ = ΦᵀΦ − TᵀT and ΦᵀPy = Φᵀy − TᵀL⁻¹Hᵀy: given HᵀΦ no reading is touched again,
and HᵀΦ is put together from the products of the laws that are present. Laws of equal width are weighed in one go.
"""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dtrsm

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.diagnosis.evidence.columns import Columns
from expdesign.diagnosis.evidence.dictionary import Atom
from expdesign.diagnosis.evidence.state import Present

_UNSEEN = 1e-4
"""Sum of squares of a combination of weights, at unit variance, below which no law is large enough to show it."""
_KEPT = 16
"""Laws whose products with all others are kept."""
_CENTRES = 6
"""Fits about which the problem was linearised whose products with all laws are kept."""


@dataclass(frozen=True)
class _Batch:
    """Laws of which readings show equally many combinations of weights.

    Attributes:
        numbers: of the laws, shape (n,).
        turns: (f, w) of each: the combinations of its weights; None where all are seen.
        columns: of each law's directions, one after the other.
        start: of its columns among those of all batches.
        grams: ΦᵀΦ, shape (n, w, w).
        one_sided: whether a law of one weight cannot be negative, shape (n,).
    """

    numbers: IntArray
    turns: tuple[FloatArray | None, ...]
    columns: tuple[Columns, ...]
    start: int
    grams: FloatArray
    one_sided: BoolArray

    @property
    def width(self) -> int:
        """Combinations of weights of one law."""
        return self.grams.shape[1]

    def columns_of(self, chosen: IntArray) -> IntArray:
        """Columns of some of its laws, in order."""
        found: IntArray = (self.start + chosen[:, None] * self.width + np.arange(self.width)).ravel()
        return found


class Screen:
    """Gains of log evidence by every law, beside any others and about any fit.

    Args:
        atoms: the laws.
    """

    def __init__(self, atoms: Sequence[Atom]) -> None:
        self._batches: list[_Batch] = []
        self._atoms: list[Atom] = []
        self._width = 0
        self._products: OrderedDict[int, FloatArray] = OrderedDict()
        self._matrices: dict[int, FloatArray] = {}
        self._partial: dict[tuple[int, bytes], FloatArray] = {}
        self._centres: OrderedDict[int, tuple[FloatArray, FloatArray, FloatArray]] = OrderedDict()
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
            sided = np.array([self._atoms[number].one_sided for number in numbers])
            self._batches.append(_Batch(np.array(numbers), turns, columns, self._width, np.stack(grams), sided))
            self._width += width * len(numbers)

    def directions(self, index: int) -> FloatArray:
        """Those of one law (M, f), made once for all that ask."""
        if index not in self._matrices:
            self._matrices[index] = self._atoms[index].directions
        return self._matrices[index]

    def gains(
        self, present: Present, named: int, indices: Sequence[int], only: Sequence[int] | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Largest gains and the σ² that reach them, shape (n,) each.

        Args:
            present: what is there.
            named: how many of its laws, the first ones, are none of these.
            indices: numbers of the others, in order.
            only: numbers of the laws to weigh, ascending; all where left out.
        """
        gains, variances = np.zeros((2, len(self._atoms)))
        if not self._batches:
            return gains, variances
        wanted = np.arange(len(self._atoms)) if only is None else np.asarray(only)
        asked = [(batch, np.flatnonzero(np.isin(batch.numbers, wanted, assume_unique=True))) for batch in self._batches]
        columns = np.concatenate([batch.columns_of(chosen) for batch, chosen in asked])
        centre = self._centre(present, named)[columns]
        design = [centre[:, :-1], *(self._product(i, columns, asked, only is None) for i in indices)]
        through = dtrsm(1.0, present.lower, np.hstack(design).T, lower=1, overwrite_b=1).T
        slopes = centre[:, -1] - through @ present.reduced
        start = 0
        for batch, chosen in asked:
            if chosen.size and batch.width:
                shape, part = (len(chosen), batch.width), slice(start, start + len(chosen) * batch.width)
                start = part.stop
                by_law = through[part].reshape(*shape, -1)
                grams = batch.grams[chosen] - np.matmul(by_law, by_law.swapaxes(1, 2))
                numbers = batch.numbers[chosen]
                own = slopes[part].reshape(shape)
                best, variances[numbers] = present.largest_gains(grams, own)
                if batch.width == 1:
                    best = np.where(batch.one_sided[chosen] & (own[:, 0] <= 0.0), 0.0, best)
                gains[numbers] = best
        return gains[wanted], variances[wanted]

    def _centre(self, present: Present, named: int) -> FloatArray:
        """Products of all laws with what a problem is linear in about its fit, and readings, shape (columns, p + 1)."""
        key = id(present.base)
        matrix: FloatArray = np.zeros((0, 0))
        known: FloatArray = matrix
        if key in self._centres:
            _, matrix, known = self._centres.pop(key)
        if not matrix.size:
            matrix = np.column_stack([present.base, *present.laws[:named], present.readings])
            known = np.zeros((0, matrix.shape[1]))
        if len(known) < self._width:
            known = self._extended(known, matrix)
        # With the array whose identity is the key, so that no other gets it.
        self._centres[key] = present.base, matrix, known
        while len(self._centres) > _CENTRES:
            self._centres.popitem(last=False)
        return known

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
