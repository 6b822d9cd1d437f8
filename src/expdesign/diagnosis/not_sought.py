"""What recordings cannot show of laws at ports, in one sentence each."""

import numpy as np

from expdesign.diagnosis.laws import FEWEST
from expdesign.diagnosis.sample import Sample

_CONSTANT = 1e-9


def not_sought(sample: Sample) -> tuple[str, ...]:
    """Sentences on laws that were not sought in these rows; empty where every kind was."""
    counts, recordings = sample.counts, sample.recordings
    rows = int(counts.sum())
    if rows < FEWEST:
        return (f"No law at a port was sought: {rows} rows may be fitted, and it takes {FEWEST}.",)
    found = []
    if recordings.time is None:
        found.append("No law of time and no creep was sought: the recordings have no column `time_s`.")
    if int(sample.rows.position[counts].max(initial=0)) < 1:
        found.append("Nothing that remembers a load was sought: no series has two rows in a stated order.")
    if _constant(recordings.configurations[counts]):
        found.append("No law of place was sought: all rows are at one pose.")
    if _constant(recordings.wrenches[counts]):
        found.append("No law of force was sought: all rows carry the same load.")
    return tuple(found)


def _constant(values: np.ndarray[tuple[int, ...], np.dtype[np.floating]]) -> bool:
    size = float(np.abs(values).max(initial=0.0))
    return bool(np.ptp(values, axis=0).max(initial=0.0) <= _CONSTANT * size)
