"""Which rows are left out together, whatever is judged by rows that were not fitted."""

import numpy as np
import pandas as pd

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.sample import Sample

STATION = "station"
"""Column of recordings that numbers groups of rows which were measured together (file-formats.md, Recordings)."""


def blocks_of(sample: Sample, most: int | None = None) -> IntArray:
    """Block of every row: stations where the recordings state them, else series, else consecutive rows, shape (N,).

    Rows of one station are alike, so that a law which only describes the rows it has seen shows in another station.

    Args:
        sample: the rows that count; the others belong to some block as well.
        most: how many blocks there are, each of several groups; one for every group if left out.
    """
    fewest = OPTIONS.groups if most is None else most
    for groups in (_stations(sample), sample.rows.series):
        if groups is not None and len(np.unique(groups[sample.counts])) >= fewest:
            ranks = np.unique(groups, return_inverse=True)[1].astype(np.int64)
            return ranks if most is None else ranks % most
    before = np.maximum(np.cumsum(sample.counts) - 1, 0)
    return np.asarray(before * fewest // max(int(sample.counts.sum()), 1), dtype=np.int64)


def last_part(sample: Sample, parts: int) -> tuple[BoolArray, BoolArray]:
    """The last of so many parts of the rows that count, whole series where there are several, and those before it.

    What depends on time or history is judged by what came later: between rows that it has seen, anything smooth
    predicts.
    """
    rows, series = np.flatnonzero(sample.counts), sample.rows.series
    last: BoolArray = np.zeros(len(series), dtype=bool)
    last[rows[-(len(rows) // parts) :] if len(rows) >= parts else []] = True
    whole: BoolArray = sample.counts & np.isin(series, np.unique(series[last]))
    before: BoolArray = sample.counts & ~whole
    if before.sum() < (1.0 - 2.0 / parts) * len(rows):
        whole, before = last, sample.counts & ~last
    return whole, before


def readings_of(values: IntArray, sample: Sample) -> IntArray:
    """Values of rows (N,) for every reading that counts, shape (M,)."""
    found: IntArray = np.repeat(values[sample.counts], len(sample.recordings.axes))
    return found


def _stations(sample: Sample) -> FloatArray | None:
    extra = sample.recordings.extra
    if STATION not in extra.columns:
        return None
    numbers = pd.to_numeric(extra[STATION], errors="coerce").to_numpy(dtype=float)
    return numbers if np.isfinite(numbers).all() else None
