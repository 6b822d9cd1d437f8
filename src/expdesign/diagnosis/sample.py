"""Recordings of which some rows do not count: held-out rows, and rows that are set aside as outliers.

All rows stay in the chain, because effects with memory need the whole history of a series; a row that does not count
has its residual and its sensitivities multiplied by zero.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.chain import Chain
from expdesign.estimation.fit import Data


@dataclass(frozen=True)
class Sample(Data):
    """Data with a mark for every row that counts.

    Attributes:
        counts: shape (N,).
    """

    counts: BoolArray

    @classmethod
    def of(cls, data: Data, counts: BoolArray) -> Self:
        """The sample of some rows of data."""
        return cls(
            data.recordings, data.rows, data.whitening, counts, idle=data.idle, reading=data.reading,
            identified=data.identified,
        )  # fmt: skip

    def restricted(self, counts: BoolArray) -> Self:
        """The rows of this sample that also count in `counts`."""
        return replace(self, counts=self.counts & counts)

    @property
    def readings(self) -> int:
        """Number of readings that count."""
        return int(self.counts.sum()) * len(self.recordings.axes)

    @property
    def kept(self) -> BoolArray:
        """Which of all readings count, row after row, shape (N·k,)."""
        return np.repeat(self.counts, len(self.recordings.axes))

    def whiten(self, values: FloatArray) -> FloatArray:
        """Whitened values (N, k, ...), zero for rows that do not count."""
        extra = (1,) * (values.ndim - 1)
        return self.whitening.apply(values) * self.counts.reshape(-1, *extra)

    def residuals(self, chain: Chain, values: FloatArray) -> FloatArray:
        return super().residuals(chain, values) * self.counts[:, None]

    def residuals_with_sensitivities(self, chain: Chain, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        residuals, sensitivities = super().residuals_with_sensitivities(chain, values)
        return residuals * self.counts[:, None], sensitivities * self.counts[:, None, None]


def rms(residuals: FloatArray, counts: BoolArray | None = None) -> float:
    """Root mean square of whitened residuals, over the rows that count (N,) or all; 1 is the noise floor."""
    chosen = residuals if counts is None else residuals[counts]
    return float(np.sqrt((chosen**2).mean())) if chosen.size else float("nan")
