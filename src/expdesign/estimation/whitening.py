"""Scaling of residuals to independent unit variance (theory.md 3).

Readings have noise of their own, rows that share an unloaded reading its noise, and declared errors of the recorded
loads move many rows together (model of generalised least squares): with D of standard deviations, S of shared
references, and the columns G of load errors in standard deviations of each,

    C = D·S·D + Σ G·Gᵀ,   W = M_s·M_o·M_r·D⁻¹,   W·C·Wᵀ = I,

M_r = S^(−½), M_o = (I + G_o·G_oᵀ)^(−½) of what every row has for itself, one block for the rows of each reference, and
M_s the same of what rows share, which has few columns. All three are symmetric.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray, TextArray, as_matrix
from expdesign.chain.recordings.references import groups
from expdesign.estimation.shared_noise import SharedNoise


@dataclass(frozen=True)
class LoadColumns:
    """What one standard deviation of every error of the loads does to the readings (m, rad).

    Attributes:
        shared: of errors that rows share, shape (N, k, d).
        own: of errors that every row has for itself, shape (N, k, e).
    """

    shared: FloatArray
    own: FloatArray

    def rows(self, chosen: BoolArray | IntArray) -> "LoadColumns":
        """Of some rows."""
        return LoadColumns(self.shared[chosen], self.own[chosen])

    def among(self, counts: BoolArray) -> "LoadColumns":
        """The same of the rows that count (N,), and nothing of others."""
        apart = counts[:, None, None]
        return LoadColumns(self.shared * apart, self.own * apart)

    @property
    def as_shared(self) -> "LoadColumns":
        """The same, with errors of single rows as columns of their own."""
        count, readings, width = self.own.shape
        apart = np.zeros((count, readings, count, width))
        apart[np.arange(count), :, np.arange(count)] = self.own
        columns = apart.reshape(count, readings, count * width)
        return LoadColumns(np.concatenate([self.shared, columns], axis=2), self.own[..., :0])


class Whitening:
    """Divides by standard deviations and decorrelates rows that share an unloaded reading or errors of their loads.

    Args:
        deviations: of every reading, shape (N, k).
        references: name of every row's unloaded reading, which carries half of the row's variance, shape (N,)
            (`chain/recordings/references.py`); None where no two rows share one.
        within: M_c, symmetric, which decorrelates the readings of every row in standard deviations, shape (N, k, k),
            the same in rows of one reference; None where readings of a row are independent.
        loads: errors of the loads that are weighed; None where loads are exact.
    """

    def __init__(
        self,
        deviations: FloatArray,
        *,
        references: TextArray | None = None,
        within: FloatArray | None = None,
        loads: LoadColumns | None = None,
    ) -> None:
        self.deviations = deviations
        self.loads = loads
        self._references, self._within = references, within
        self._index = np.arange(len(deviations)) if references is None else groups(references)
        self._sizes = np.bincount(self._index)
        self._own: list[tuple[IntArray, FloatArray]] = []
        self._across: SharedNoise | None = None
        self.log_determinant = 0.0
        """Of what the load errors add to the covariance, in units of the noise."""
        if loads is not None:
            self._weigh(loads)

    def _weigh(self, loads: LoadColumns) -> None:
        """Factorise the covariance of the load errors: M_o by blocks, M_s = I − U·diag(f)·Uᵀ."""
        if loads.own.shape[-1]:
            own = self._in_row(loads.own / self.deviations[..., None])
            for rows in self._together():
                columns = np.einsum("ij,gjke->gikje", _reference_root(rows.shape[1]), own[rows])
                columns = columns.reshape(len(rows), rows.shape[1] * own.shape[1], -1)
                variances, vectors = np.linalg.eigh(columns @ columns.swapaxes(1, 2))
                variances = 1.0 + np.maximum(variances, 0.0)
                self._own.append((rows, (vectors / np.sqrt(variances)[:, None]) @ vectors.swapaxes(1, 2)))
                self.log_determinant += float(np.log(variances).sum())
        if loads.shared.shape[-1]:
            scaled = self._in_row(loads.shared / self.deviations[..., None])
            columns = as_matrix(self._by_row(self._referenced(scaled)))
            self._across = SharedNoise.of(columns)
            self.log_determinant += self._across.log_determinant

    def _together(self) -> Iterator[IntArray]:
        """The rows of each reference, those of r rows together, shape (g, r)."""
        order = np.argsort(self._index, kind="stable")
        for size in np.unique(self._sizes):
            yield order[self._sizes[self._index[order]] == size].reshape(-1, size)

    def apply(self, values: FloatArray) -> FloatArray:
        """Whitened values; rows N, readings k, and any further dimensions: (N, k, ...) to the same shape."""
        extra = (1,) * (values.ndim - 2)
        return self.decorrelated(values / self.deviations.reshape(*self.deviations.shape, *extra))

    def decorrelated(self, scaled: FloatArray) -> FloatArray:
        """M_s·M_o·M_r·M_c of values (N, k, ...) in standard deviations."""
        return self._shared(self._by_row(self._referenced(self._in_row(scaled))))

    def scores(self, whitened: FloatArray) -> FloatArray:
        """M_c·M_r·M_o·M_s, the transpose, of whitened values (N, k, ...): C⁻¹ of values in standard deviations."""
        return self._in_row(self._referenced(self._by_row(self._shared(whitened))))

    def _in_row(self, scaled: FloatArray) -> FloatArray:
        """M_c of values (N, k, ...)."""
        if self._within is None:
            return scaled
        found: FloatArray = np.einsum("nij,nj...->ni...", self._within, scaled)
        return found

    def _referenced(self, scaled: FloatArray) -> FloatArray:
        """M_r of values (N, k, ...).

        The scaled readings of r rows with one reference have covariance S = ½(I + 11ᵀ), whose symmetric inverse root is
        √2·(I − (1 − 1/√(1+r))·11ᵀ/r); for r = 1 it is 1.
        """
        if len(self._sizes) == len(scaled):  # no two rows share one
            return scaled
        sums = np.zeros((len(self._sizes), *scaled.shape[1:]))
        np.add.at(sums, self._index, scaled)
        sizes = self._sizes.reshape(-1, *(1,) * (scaled.ndim - 1))
        means = sums / sizes * (1.0 - 1.0 / np.sqrt(1.0 + sizes))
        whitened: FloatArray = np.sqrt(2.0) * (scaled - means[self._index])
        return whitened

    def _by_row(self, scaled: FloatArray) -> FloatArray:
        """M_o of values (N, k, ...)."""
        if not self._own:
            return scaled
        found = np.empty_like(scaled)
        for rows, root in self._own:
            part = scaled[rows]
            found[rows] = (root @ part.reshape(*root.shape[:2], -1)).reshape(part.shape)
        return found

    def _shared(self, scaled: FloatArray) -> FloatArray:
        """M_s of values (N, k, ...)."""
        if self._across is None:
            return scaled
        return self._across.whitened(scaled.reshape(len(self._across.turned), -1)).reshape(scaled.shape)

    @property
    def without_shared(self) -> "Whitening":
        """The same noise with the load errors alone that every row has for itself."""
        loads = self.loads
        return self if loads is None else self.weighing(LoadColumns(loads.shared[..., :0], loads.own))

    def unshared(self, whitened: FloatArray) -> FloatArray:
        """Whitened values (N, k, ...) as they are without the load errors that rows share: M_s⁻¹ of them."""
        if self._across is None:
            return whitened
        return self._across.restored(whitened.reshape(len(self._across.turned), -1)).reshape(whitened.shape)

    @property
    def precision(self) -> FloatArray:
        """Diagonal blocks of C⁻¹ in standard deviations, shape (N, k, k).

        Of a row whose reference r rows have, itself among them, it is 2·r/(1 + r) without load errors.
        """
        sizes = self._sizes[self._index].astype(float)
        readings = self.deviations.shape[1]
        blocks = (2.0 * sizes / (1.0 + sizes))[:, None, None] * np.eye(readings)
        for rows, root in self._own:
            parted = root.reshape(*root.shape[:2], rows.shape[1], readings)
            parted = np.einsum("gaik,ij->gajk", parted, _reference_root(rows.shape[1]))
            blocks[rows] = np.einsum("gajk,gajl->gjkl", parted, parted)
        if self._across is not None:
            squares = self._across.squares
            root = (self._across.turned * np.sqrt(squares / (1.0 + squares))).reshape(len(blocks), readings, -1)
            root = self._referenced(self._by_row(root))
            blocks = blocks - root @ root.swapaxes(1, 2)
        return blocks if self._within is None else self._within @ blocks @ self._within

    def rows(self, chosen: BoolArray | IntArray) -> "Whitening":
        """The whitening of some rows."""
        references = None if self._references is None else self._references[chosen]
        loads = None if self.loads is None else self.loads.rows(chosen)
        within = None if self._within is None else self._within[chosen]
        return Whitening(self.deviations[chosen], references=references, within=within, loads=loads)

    def weighing(self, loads: LoadColumns | None) -> "Whitening":
        """The same noise with errors of the loads, or without them."""
        return Whitening(self.deviations, references=self._references, within=self._within, loads=loads)


def _reference_root(count: int) -> FloatArray:
    """S^(−½) across the rows of one reference, shape (r, r); see `Whitening._referenced`."""
    root: FloatArray = np.sqrt(2.0) * (np.eye(count) - (1.0 - 1.0 / np.sqrt(1.0 + count)) / count)
    return root
