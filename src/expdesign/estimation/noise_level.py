"""The standard deviations of the readings: as the recordings state them, or estimated from the recordings themselves.

Where they are estimated, translations and rotations have one level each. It comes from replicates where there are
enough of them, and otherwise from the residuals of the base model, by iterating σ_g² = RSS_g / (n_g − tr H_g) with the
weights that follow from it, H_g being the group's part of the hat matrix (the simplified Helmert estimator of variance
components, which converges to the restricted maximum likelihood estimate).

Replicates are rows with the same command under the same load (of the same marker), which differ by noise alone. Their
scatter about their own mean (pure error) measures the noise without any model of the robot.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.recordings.references import groups, sharing_rows
from expdesign.errors import NotIdentifiableError
from expdesign.estimation.fit import Fit


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


FEWEST_REPLICATES = 5
"""Degrees of freedom below which the scatter of replicates says too little, and the residuals are used."""
SMALLEST_LEVEL = 1e-9
"""Noise below this fraction of the readings is rounding."""
_ITERATIONS = 200

Origin = Literal["recordings", "replicates", "residuals"]


@dataclass(frozen=True)
class NoiseGroup:
    """Readings of one kind, whose noise level was estimated.

    Attributes:
        name: `translations` or `rotations`.
        columns: indices into the measured components.
        deviation: estimated standard deviation, m or rad.
        dof: degrees of freedom of the estimate.
    """

    name: str
    columns: IntArray
    deviation: float
    dof: float


@dataclass(frozen=True)
class NoiseLevel:
    """Standard deviations of the readings and where they come from.

    Attributes:
        deviations: shape (N, k), m or rad.
        origin: `recordings` where they are known.
        groups: the estimated levels; empty where they are known.
    """

    deviations: FloatArray
    origin: Origin
    groups: tuple[NoiseGroup, ...] = ()

    @property
    def known(self) -> bool:
        """Whether the recordings state the standard deviations."""
        return self.origin == "recordings"

    @property
    def degrees(self) -> float:
        """Degrees of freedom of the least known level, infinite where none was estimated."""
        return min((group.dof for group in self.groups), default=float("inf"))

    def of_rows(self, count: int) -> "NoiseLevel":
        """An estimated level for any number of rows."""
        return replace(self, deviations=np.tile(self.deviations[:1], (count, 1)))


def axis_groups(recordings: Recordings, translations: int) -> list[tuple[str, IntArray]]:
    """The measured components by kind: names and indices into the measured components."""
    spans = 6 if recordings.point is not None else np.inf
    groups = [
        ("translations", np.flatnonzero(recordings.axes < translations)),
        ("rotations", np.flatnonzero((recordings.axes >= translations) & (recordings.axes < spans))),
        ("distances", np.flatnonzero(recordings.axes == spans)),
        ("gauges", np.flatnonzero(recordings.axes > spans)),
    ]
    return [(name, columns) for name, columns in groups if columns.size]


def noise_from_replicates(recordings: Recordings, translations: int) -> NoiseLevel | None:
    """The noise level that replicates show, or None where there are too few of them."""
    groups = replicate_groups(recordings)
    ones = np.ones_like(recordings.deflections)
    error = pure_error(recordings, ones, groups)
    if error.dof < FEWEST_REPLICATES:
        return None
    levels = []
    for name, columns in axis_groups(recordings, translations):
        dof = error.dof * columns.size
        deviation = float(np.sqrt(error.squares[columns].sum() / dof))
        levels.append(NoiseGroup(name, columns, max(deviation, _floor(recordings, columns)), float(dof)))
    return _level(recordings, levels, "replicates")


def noise_from_residuals(recordings: Recordings, translations: int, fit: Callable[[FloatArray], Fit]) -> NoiseLevel:
    """The noise level that the residuals of the base model show.

    Args:
        recordings: what is fitted.
        translations: number of leading axes that are translations.
        fit: the fit with given standard deviations (N, k).

    Raises:
        NotIdentifiableError: there are not more readings of a kind than the parameters use up.
    """
    kinds = axis_groups(recordings, translations)
    levels = [
        NoiseGroup(name, columns, max(_size(recordings, columns), 1e-30), float("inf")) for name, columns in kinds
    ]
    for _ in range(_ITERATIONS):
        current = fit(_level(recordings, levels, "residuals").deviations)
        updated = [_update(recordings, level, current) for level in levels]
        change = max(abs(new.deviation / old.deviation - 1.0) for new, old in zip(updated, levels, strict=True))
        levels = updated
        if change < 1e-9:
            break
    return _level(recordings, levels, "residuals")


def _update(recordings: Recordings, level: NoiseGroup, current: Fit) -> NoiseGroup:
    """One step of the iteration for one kind of readings."""
    chosen = current.sensitivities[:, level.columns]
    used = float(np.einsum("nkp,pq,nkq->", chosen, current.estimable.generalised, chosen))
    dof = chosen.shape[0] * chosen.shape[1] - used
    if dof < 0.5:
        what = f"the {level.name} leave no reading over from which their noise could be estimated"
        remedy = "State standard deviations (sx_m ...), or measure more."
        raise NotIdentifiableError(what, where=recordings.source, remedy=remedy)
    squares = float((current.residuals[:, level.columns] ** 2).sum())
    deviation = max(level.deviation * float(np.sqrt(squares / dof)), _floor(recordings, level.columns))
    return NoiseGroup(level.name, level.columns, deviation, dof)


def _size(recordings: Recordings, columns: IntArray) -> float:
    return float(np.sqrt((recordings.deflections[:, columns] ** 2).mean()))


def _floor(recordings: Recordings, columns: IntArray) -> float:
    return max(SMALLEST_LEVEL * _size(recordings, columns), 1e-30)


def _level(recordings: Recordings, groups: list[NoiseGroup], origin: Origin) -> NoiseLevel:
    deviations = np.empty_like(recordings.deflections)
    for group in groups:
        deviations[:, group.columns] = group.deviation
    return NoiseLevel(deviations, origin, tuple(groups))
