"""Replicates: rows with the same command under the same load (of the same marker), which differ by noise alone.

Their scatter about their own mean (pure error) measures the noise without any model of the robot.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.recordings.recordings import Recordings


@dataclass(frozen=True)
class PureError:
    """Scatter of replicates about their means.

    Attributes:
        squares: sum of squares of every measured component, in units of the deviations it was taken in, shape (k,).
        dof: degrees of freedom of each component: rows that have a replicate minus groups of replicates.
    """

    squares: FloatArray
    dof: int


def replicate_groups(recordings: Recordings, *, shared_reference: bool) -> IntArray:
    """Number of the group of replicates of every row, shape (N,).

    With a shared reference only rows of one series count as replicates of each other: those of different series do not
    have their unloaded measurement in common.
    """
    wrenches = recordings.wrenches
    size = np.abs(wrenches).max(axis=0, initial=0.0)
    parts = [np.round(recordings.configurations, 9), np.round(wrenches / np.where(size > 0.0, size, 1.0), 9)]
    # Two markers on one link are apart by their places, not by noise.
    parts.append(recordings.marker_indicators)
    if shared_reference:
        parts.append(recordings.series[:, None].astype(float))
    # Adding zero makes -0.0 and 0.0 one value.
    frame = pd.DataFrame(np.concatenate(parts, axis=1) + 0.0)
    groups = frame.groupby(list(frame.columns), sort=False).ngroup().to_numpy()
    return groups.astype(np.int64)


def pure_error(
    recordings: Recordings, deviations: FloatArray, groups: IntArray, *, shared_reference: bool
) -> PureError:
    """Pure error of the deflections in units of `deviations` (N, k).

    Within a group that shares its reference only the loaded half of the variance scatters, so that the squares count
    twice.
    """
    weights = 1.0 / deviations**2
    count = int(groups.max()) + 1
    sums, totals = np.empty((2, count, deviations.shape[1]))
    for axis in range(deviations.shape[1]):
        sums[:, axis] = np.bincount(groups, weights[:, axis] * recordings.deflections[:, axis], count)
        totals[:, axis] = np.bincount(groups, weights[:, axis], count)
    scatter = (recordings.deflections - (sums / totals)[groups]) / deviations
    factor = 2.0 if shared_reference else 1.0
    return PureError(factor * (scatter**2).sum(axis=0), len(groups) - len(sums))
