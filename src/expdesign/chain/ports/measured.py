"""What laws are sought in: the rows of recordings, whitened, and how they belong together."""

from collections.abc import Callable
from dataclasses import dataclass

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.readings.reading import Reading
from expdesign.chain.row import RowData


@dataclass(frozen=True)
class Measured:
    """Rows that laws are sought in.

    Attributes:
        rows: numbers of the chain.
        axes: measured components.
        counts: rows that may be fitted, shape (N,); all others have zero residuals and directions.
        whiten: readings (N, k, ...) in standard deviations of the noise, zero for rows that do not count.
        blocks: of rows that are left out together, shape (N,).
        timed: whether times are stated.
        reading: what the instrument reads.
    """

    rows: RowData
    axes: tuple[int, ...]
    counts: BoolArray
    whiten: Callable[[FloatArray], FloatArray]
    blocks: IntArray
    timed: bool
    reading: Reading
