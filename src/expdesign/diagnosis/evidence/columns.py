"""Directions of readings with respect to the weights of a law, kept as the factors that they are products of.

What a weight does in a row is its feature there, times the port's map. Thousands of laws share few maps and features,
so that products with all of them are taken through the maps, and a matrix is made only of laws that are chosen.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray


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

    def matrix(self) -> FloatArray:
        found = self.whole if self.kept is None else self.whole[self.kept]
        return found if self.scale is None else found * self.scale

    def against(self, other: FloatArray, carried: dict[int, FloatArray]) -> FloatArray:
        if self.kept is not None:
            if id(self.kept) not in carried:
                carried[id(self.kept)] = np.zeros((len(self.kept), other.shape[1]))
                carried[id(self.kept)][self.kept] = other
            other = carried[id(self.kept)]
        found: FloatArray = self.whole.T @ other
        return found if self.scale is None else self.scale[:, None] * found


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
