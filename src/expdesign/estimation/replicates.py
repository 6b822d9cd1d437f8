"""Replicates: rows with the same command under the same load (of the same marker), which differ by noise alone.

Their scatter about their own mean (pure error) measures the noise without any model of the robot.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.recordings.references import groups, sharing_rows


@dataclass(frozen=True)
class PureError:
    """Scatter of replicates about their means.

    Attributes:
        squares: sum of squares of every measured component, in units of the deviations it was taken in, shape (k,).
        dof: degrees of freedom of each component: rows that have a replicate minus groups of replicates.
    """

    squares: FloatArray
    dof: int


def replicate_groups(recordings: Recordings) -> IntArray:
    """Number of the group of replicates of every row, shape (N,).

    Rows that share an unloaded reading are replicates of each other alone, and so are rows that share none.
    """
    wrenches = recordings.wrenches
    size = np.abs(wrenches).max(axis=0, initial=0.0)
    parts = [np.round(recordings.configurations, 9), np.round(wrenches / np.where(size > 0.0, size, 1.0), 9)]
    # Two markers on one link are apart by their places, not by noise.
    parts.append(recordings.marker_indicators)
    if recordings.references is not None:
        several = sharing_rows(recordings)
        parts.append(np.where(several, 1.0 + groups(recordings.references), 0.0)[:, None])
    # Adding zero makes -0.0 and 0.0 one value.
    frame = pd.DataFrame(np.concatenate(parts, axis=1) + 0.0)
    return frame.groupby(list(frame.columns), sort=False).ngroup().to_numpy().astype(np.int64)


def pure_error(recordings: Recordings, deviations: FloatArray, alike: IntArray) -> PureError:
    """Pure error of the deflections in units of `deviations` (N, k), of the groups of replicates `alike` (N,).

    Within a group that shares its reference only the loaded half of the variance scatters, so that the squares count
    twice.
    """
    weights = 1.0 / deviations**2
    count = int(alike.max()) + 1
    sums, totals = np.empty((2, count, deviations.shape[1]))
    for axis in range(deviations.shape[1]):
        sums[:, axis] = np.bincount(alike, weights[:, axis] * recordings.deflections[:, axis], count)
        totals[:, axis] = np.bincount(alike, weights[:, axis], count)
    scatter = (recordings.deflections - (sums / totals)[alike]) / deviations
    factor = np.where(sharing_rows(recordings), 2.0, 1.0)[:, None]
    return PureError((factor * scatter**2).sum(axis=0), len(alike) - len(sums))
