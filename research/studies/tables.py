"""Rows and cells that several studies have in common."""

from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import norm

from expdesign.arrays import FloatArray

BINS = 48


def rows_of(frame: pd.DataFrame) -> list[Any]:
    """The rows as tuples whose attributes are the columns."""
    return list(frame.itertuples(index=False))


def column(frame: pd.DataFrame, name: str) -> FloatArray:
    """A column of numbers (rows,)."""
    return frame[name].to_numpy(dtype=float)


def density_rows(
    name: str, samples: FloatArray, high: float, predicted: float | None = None, low: float | None = None
) -> pd.DataFrame:
    """Density of samples from `low` (−high) to `high`, with standard errors; `normal` is that of deviation `predicted`.

    The standard error is that of a count of Poisson (with one more, so that an empty bin has one as well).
    """
    edges = np.linspace(-high if low is None else low, high, BINS + 1)
    per_count = 1.0 / (len(samples) * np.diff(edges))
    counts = np.histogram(samples, edges)[0]
    frame = pd.DataFrame({"series": name, "centre": (edges[1:] + edges[:-1]) / 2.0, "density": counts * per_count})
    frame["density_se"] = np.sqrt(counts + 1.0) * per_count
    if predicted is not None:
        frame["normal"] = np.diff(norm.cdf(edges / predicted)) / np.diff(edges)
    return frame


def number(value: float, digits: int = 4) -> str:
    """A number for a page, – where there is none."""
    return "–" if np.isnan(value) else f"{value:.{digits}g}"
