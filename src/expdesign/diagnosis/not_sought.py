"""What recordings cannot show of laws at ports."""

import numpy as np

from expdesign.chain.recordings.recordings import Remark
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.remarks import NotSought, Sought, TooFewForLaws
from expdesign.diagnosis.sample import Sample

_CONSTANT = 1e-9


def not_sought(sample: Sample) -> tuple[Remark, ...]:
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
