"""Accuracy before and after a calibration: errors of positions (m) and orientations (rad), as people read them.

Absolute accuracy of a pose is the distance between where it was measured and where the model has it (ISO 9283:1998,
section 7, states it for one command; here every row counts as one).
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.estimation.arm_problem import ArmProblem
from expdesign.estimation.groups import Priors, with_groups

_MILLI = 1e-3
_SEED = 0


@dataclass(frozen=True)
class Errors:
    """Lengths of the errors of some rows.

    Attributes:
        rows: how many.
        mean, rms, most, percentile: mean, root mean square, maximum and 95 % quantile (m or rad).
    """

    rows: int
    mean: float
    rms: float
    most: float
    percentile: float


@dataclass(frozen=True)
class Compared:
    """Errors of the same rows before and after: of the robot file's robot, and of the calibrated one."""

    before: Errors
    after: Errors


Accuracies = dict[tuple[str, str], Compared]
"""By kind of row (`fitted`, `held out`, `left-out folds`) and of reading (`position`, `orientation`, `distance`,
`gauge`).
"""


def accuracies(
    before: FloatArray,
    after: FloatArray,
    fitted: BoolArray,
    test: BoolArray,
    left_out: FloatArray | None,
    axes: IntArray,
) -> Accuracies:
    """From errors (N, k) of all rows; NaN where nothing was read. `left_out` (n, k) are those of fitted rows.

    `axes` (k,) are components of readings: 0 to 2 of positions, 3 to 5 of orientations, 6 a distance, 7 a gauge.
    """
    entries: Accuracies = {}
    sets = [("fitted", before[fitted], after[fitted])]
    if test.any():
        sets.append(("held out", before[test], after[test]))
    if left_out is not None:
        sets.append(("left-out folds", before[fitted], left_out))
    kinds = {"position": axes < 3, "orientation": (axes >= 3) & (axes < 6), "distance": axes == 6, "gauge": axes > 6}
    for rows, first, second in sets:
        for kind, columns in kinds.items():
            one, other = _errors(first[:, columns]), _errors(second[:, columns])
            if one is not None and other is not None:
                entries[rows, kind] = Compared(one, other)
    return entries


def _errors(errors: FloatArray) -> Errors | None:
    seen = np.isfinite(errors).any(axis=1) if errors.size else np.zeros(len(errors), dtype=bool)
    if not seen.any():
        return None
    sizes = np.sqrt(np.nansum(errors[seen] ** 2, axis=1))
    rms = float(np.sqrt((sizes**2).mean()))
    return Errors(len(sizes), float(sizes.mean()), rms, float(sizes.max()), float(np.quantile(sizes, 0.95)))


def nominal_readings(chain: Chain, recordings: Recordings) -> FloatArray:
    """Readings (N, k) of the robot as its file has it, to which instrument and markers are fitted."""
    plain = Chain(chain.robot, (), reading=chain.reading)
    start = nominal_start(chain, recordings)
    predicted: FloatArray = plain.predict(row_data(recordings, chain.robot), start)[:, recordings.axes]
    return predicted


def nominal_start(chain: Chain, recordings: Recordings) -> FloatArray:
    """Compliances of the robot file, and instrument, markers and fixed points as they fit the nominal robot."""
    plain = Chain(chain.robot, (), reading=chain.reading)
    own = np.arange(plain.compliances, plain.base)
    start = plain.start()
    if not np.isfinite(chain.robot.stiffness).all():
        start[: plain.compliances] = 0.0
    train = recordings.rows(~recordings.test)
    problem, deviations = (
        ArmProblem(plain, train, row_data(train, chain.robot), own),
        np.full(train.deflections.shape, _MILLI),
    )
    if len(own):
        spreads = np.array([plain.parameters[index].spread for index in own])
        free = np.full(len(own), -1, dtype=np.int64)
        low, high = plain.bounds()
        wide = Priors(np.zeros(len(own)), np.minimum(spreads, 1e3), free, low[own], high[own])
        start[own] = with_groups(lambda at: problem.linearised(at, deviations, start), wide, start[own]).values
    return start


def pose_folds(recordings: Recordings, count: int) -> IntArray:
    """Fold of every row: rows at one command are in one fold, commands are dealt out at random (seeded)."""
    _, pose = np.unique(np.round(recordings.configurations, 9), axis=0, return_inverse=True)
    number = int(pose.max()) + 1
    dealt = np.random.default_rng(_SEED).permutation(np.arange(number) % max(min(count, number), 1))
    folds: IntArray = dealt[pose.ravel()]
    return folds
