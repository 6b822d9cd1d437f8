"""What limits the statements of a diagnosis, and what recordings cannot show of laws at ports."""

import numpy as np

from expdesign.chain.recordings.recordings import Remark
from expdesign.diagnosis.base_models import base_model
from expdesign.diagnosis.dispersion import Dispersion
from expdesign.diagnosis.held_out import HeldOut
from expdesign.diagnosis.names import NamedModel
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.remarks import (
    AliasedParameters,
    Extrapolation,
    NotSought,
    SerialCorrelation,
    Sought,
    TooFewForLaws,
    WithoutMoment,
)
from expdesign.estimation.fit import Data

_NO_MOMENT = 1e-6
"""Share of the largest moments below which those about a direction are the rounding of a file."""
_CONSTANT = 1e-9
"""Spread of a quantity, in parts of its size, below which it was not varied."""


def caveats(sample: Data, model: NamedModel, spread: Dispersion, errors: HeldOut) -> tuple[Remark, ...]:
    """Remarks, most limiting first."""
    found: list[Remark] = []
    found += sample.reading.degeneracies
    aliased = base_model(model.fit.chain.robot, sample.reading).undetermined(model.fit)
    if aliased:
        found.append(AliasedParameters(tuple(aliased)))
    found += _without_moment(sample, model)
    if errors.test_after**2 > OPTIONS.most_inflated * max(errors.train_after, 1.0) ** 2:
        found.append(Extrapolation(errors.test_after, errors.train_after))
    if spread.correlation > OPTIONS.correlated:
        found.append(SerialCorrelation(spread.correlation, spread.rows, spread.effective_rows))
    return tuple(found)


def _without_moment(sample: Data, model: NamedModel) -> list[WithoutMoment]:
    """Directions about which no load of a body had a moment, where that leaves parameters undetermined.

    The moment of a weight is r × (m g), which has no part along g: with M·g = 0 in all rows C and C + λ·g·gᵀ turn
    alike, and where g is not an axis of O that concerns all elements of C.
    """
    if not model.fit.chain.robot.on_support or model.fit.determined.all():
        return []
    moments = sample.recordings.wrenches[sample.counts, 3:]
    if not np.any(moments):
        return []
    _, sizes, directions = np.linalg.svd(np.linalg.qr(moments, mode="r"))
    sizes = np.concatenate([sizes, np.zeros(3 - len(sizes))])
    free = directions[sizes < _NO_MOMENT * sizes[0]]
    upright = [tuple((direction * np.sign(direction[np.abs(direction).argmax()])).tolist()) for direction in free]
    return [WithoutMoment(tuple(upright))] if upright else []


def not_sought(sample: Data) -> tuple[Remark, ...]:
    """Kinds of laws that were not sought in these rows; empty where every kind was."""
    counts, recordings = sample.counts, sample.recordings
    rows = int(counts.sum())
    if rows < OPTIONS.fewest_rows:
        return (TooFewForLaws(rows, OPTIONS.fewest_rows),)
    missing = {
        Sought.TIME: recordings.time is None,
        Sought.MEMORY: int(sample.rows.position[counts].max(initial=0)) < 1,
        Sought.PLACE: _constant(recordings.configurations[counts]),
        Sought.FORCE: _constant(recordings.wrenches[counts]),
    }
    return tuple(NotSought(law) for law, is_missing in missing.items() if is_missing)


def _constant(values: np.ndarray[tuple[int, ...], np.dtype[np.floating]]) -> bool:
    size = float(np.abs(values).max(initial=0.0))
    return bool(np.ptp(values, axis=0).max(initial=0.0) <= _CONSTANT * size)
