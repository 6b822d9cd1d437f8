"""Which rows are left out together."""

import numpy as np
import pandas as pd

from expdesign.arrays import IntArray
from expdesign.diagnosis.held_out import folds_of
from expdesign.diagnosis.sample import Sample

STATION = "station"
"""Column of recordings that numbers groups of rows which were measured together (file-formats.md, Recordings)."""
SEVERAL = 5
"""Groups from which they are left out as wholes."""


def blocks_of(sample: Sample) -> IntArray:
    """Block of every row: stations where the recordings state them, else series, else consecutive rows, shape (N,).

    Rows of one station are alike, so that a law which only describes the rows it has seen shows in another station.
    """
    extra = sample.recordings.extra
    if STATION in extra.columns:
        numbers = pd.to_numeric(extra[STATION], errors="coerce").to_numpy()
        if np.isfinite(numbers).all():
            stations = np.unique(numbers, return_inverse=True)[1]
            if len(np.unique(stations[sample.counts])) >= SEVERAL:
                return stations.astype(np.int64)
    series = sample.rows.series
    return series if len(np.unique(series[sample.counts])) >= SEVERAL else folds_of(sample)
