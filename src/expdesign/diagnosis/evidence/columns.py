"""Directions of readings with respect to the weights of a law, kept as the factors that they are products of.

What a weight does in a row is its feature there, times the port's map. Thousands of laws share few maps and features,
so that products with all of them are taken through the maps, and a matrix is made only of laws that are chosen.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from expdesign.arrays import BoolArray, FloatArray

_ROUNDING = 1e-12
"""Share of the largest derivative that is rounding."""


class Columns(ABC):
    """Whitened directions Φ, shape (M, f)."""

    width: int

    @abstractmethod
    def matrix(self) -> FloatArray:
        """Φ itself, shape (M, f)."""

    @abstractmethod
    def against(self, other: FloatArray, carried: dict[int, FloatArray]) -> FloatArray:
        """Φᵀ·X for X of shape (M, m), shape (f, m); `carried` keeps what columns share for one X, by their identity."""


@dataclass(frozen=True)
class Dense(Columns):
    """Columns of a matrix with rows that may not count, each times a factor.

    Attributes:
        whole: shape (M', f).
        kept: rows that count, shape (M',); None for all.
        scale: factors, shape (f,); None for 1.
    """

    whole: FloatArray
    kept: BoolArray | None = None
    scale: FloatArray | None = None

    @property
    def width(self) -> int:  # type: ignore[override]
        return self.whole.shape[1]

    @property
    def finite(self) -> bool:
        """Whether all are."""
        return bool(np.isfinite(self.whole).all())

    def matrix(self) -> FloatArray:
        found = self._rows() if self.kept is None else self._rows()[self.kept]
        return found if self.scale is None else found * self.scale

    def against(self, other: FloatArray, carried: dict[int, FloatArray]) -> FloatArray:
        if self.kept is not None:
            if id(self.kept) not in carried:
                carried[id(self.kept)] = np.zeros((len(self.kept), other.shape[1]))
                carried[id(self.kept)][self.kept] = other
            other = carried[id(self.kept)]
        found = self._onto(other, carried)
        return found if self.scale is None else self.scale[:, None] * found

    def _rows(self) -> FloatArray:
        """Of all rows, without factors."""
        return self.whole

    def _onto(self, other: FloatArray, carried: dict[int, FloatArray]) -> FloatArray:
        """Products with a matrix of all rows, without factors."""
        found: FloatArray = self.whole.T @ other
        return found


@dataclass(frozen=True)
class Along(Dense):
    """Columns that move the readings of a row along one vector, v_ni·f_nj, as whatever changes one actuator's length.

    Attributes:
        whole: features f in every row, shape (N', f).
        vectors: v, shape (N', k) with N'·k = M'; columns at many starts share them.
    """

    vectors: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    def _rows(self) -> FloatArray:
        return (self.vectors[:, :, None] * self.whole[:, None]).reshape(self.vectors.size, -1)

    def _onto(self, other: FloatArray, carried: dict[int, FloatArray]) -> FloatArray:
        if id(self.vectors) not in carried:
            apart = other.reshape(*self.vectors.shape, -1)
            carried[id(self.vectors)] = np.matmul(self.vectors[:, None], apart)[:, 0]
        found: FloatArray = self.whole.T @ carried[id(self.vectors)]
        return found


def along(block: FloatArray, vectors: FloatArray | None = None) -> tuple[Dense, FloatArray]:
    """Columns (N, k, f) as features along vectors where they are that to rounding, and the vectors.

    Args:
        block: the columns.
        vectors: of other columns, shape (N, k); the longest ones of these columns if left out.
    """
    if vectors is None:
        longest = (block**2).sum(axis=1).argmax(axis=1)
        vectors = np.take_along_axis(block, longest[:, None, None], axis=2)[..., 0]
    squares = (vectors**2).sum(axis=1)
    features = np.matmul(vectors[:, None], block)[:, 0] / np.where(squares > 0.0, squares, 1.0)[:, None]
    left = np.abs(block - vectors[:, :, None] * features[:, None]).max(initial=0.0)
    if left <= _ROUNDING * np.abs(block).max(initial=0.0):
        return Along(features, vectors=vectors), vectors
    return Dense(block.reshape(-1, block.shape[2])), vectors


@dataclass(frozen=True)
class Summand:
    """What one channel of a law adds.

    Attributes:
        output: component of u.
        block: of the weights.
        features: in every row, shape (N, r).
        amplitude: factor in every row, shape (N,).
        gain: constant factor.
    """

    output: int
    block: int
    features: FloatArray
    amplitude: FloatArray
    gain: float


@dataclass(frozen=True)
class Mapped(Columns):
    """Features through the map of a port.

    Attributes:
        maps: whitened, of the rows that count, shape (N, k, width of u).
        terms: of all channels; features of the same rank r.
        blocks: of weights.
        scale: factor on everything.
    """

    maps: FloatArray
    terms: Sequence[Summand]
    blocks: int
    scale: float = 1.0

    @property
    def width(self) -> int:  # type: ignore[override]
        return self.blocks * self.terms[0].features.shape[1]

    def matrix(self) -> FloatArray:
        rows, readings, _ = self.maps.shape
        rank = self.terms[0].features.shape[1]
        found = np.zeros((rows, readings, self.width))
        for term in self.terms:
            driven = term.features * (self.scale * term.gain * term.amplitude)[:, None]
            part = slice(term.block * rank, (term.block + 1) * rank)
            found[:, :, part] += self.maps[:, :, term.output, None] * driven[:, None, :]
        return found.reshape(rows * readings, -1)

    def against(self, other: FloatArray, carried: dict[int, FloatArray]) -> FloatArray:
        rows, readings, _ = self.maps.shape
        if id(self.maps) not in carried:
            through = np.matmul(self.maps.swapaxes(1, 2), other.reshape(rows, readings, -1))
            carried[id(self.maps)] = np.ascontiguousarray(through.swapaxes(0, 1))
        through, rank = carried[id(self.maps)], self.terms[0].features.shape[1]
        found = np.zeros((self.width, through.shape[2]))
        for term in self.terms:
            amplitude, features, motion = self.scale * term.gain * term.amplitude, term.features, through[term.output]
            if rank < motion.shape[1]:
                features = features * amplitude[:, None]
            else:
                motion = motion * amplitude[:, None]
            found[term.block * rank : (term.block + 1) * rank] += features.T @ motion
        return found
