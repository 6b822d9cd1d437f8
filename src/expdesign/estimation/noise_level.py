"""The standard deviations of the readings: as the recordings state them, or estimated from the recordings themselves.

Where they are estimated, translations and rotations have one level each. It comes from replicates where there are
enough of them, and otherwise from the residuals of the base model, by iterating σ_g² = RSS_g / (n_g − tr H_g) with the
weights that follow from it, H_g being the group's part of the hat matrix (the simplified Helmert estimator of variance
components, which converges to the restricted maximum likelihood estimate).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import NotIdentifiableError
from expdesign.estimation.fit import Fit
from expdesign.estimation.replicates import pure_error, replicate_groups

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
