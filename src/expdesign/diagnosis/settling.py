"""The motion of the whole machine against the instrument from one series to the next, as noise that they share.

It predicts nothing, but without it whatever moves whole series would be laid to effects that happen to differ between
them. With J_k the derivatives of the readings of series k by the pose of the instrument, its motions are random with
the deviations D, and are noise of the covariance I + φ·J_k·D²·J_kᵀ (`shared_noise`), so that many series cost no more
than one. Evidence sets φ. A series at one pose says nothing of it: its motion is not told from an error of the machine
at that pose.
"""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, rms
from expdesign.chain.chain import Chain
from expdesign.diagnosis.cross_validation import readings_of
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data
from expdesign.estimation.shared_noise import SharedNoise

_RATIOS = tuple(float(ratio) for ratio in np.geomspace(1e-4, 10.0, 11))
"""φ that are compared, deviations being such that each motion alone would show as much as the base model misses."""
_SINGULAR = 1e-9
"""Directions of a series' motion that move its readings by a smaller share than the largest are none."""


@dataclass(frozen=True)
class Settling(SharedNoise):
    """Noise that the readings of a series share, whose ratio evidence sets."""

    def of_state(self, state: Present) -> Present:
        """The base model and laws with this noise in their whitening."""
        laws = tuple(self.whitened(law) for law in state.laws)
        base, readings = self.whitened(state.base), self.whitened(state.readings)
        return replace(state, base=base, readings=readings, laws=laws)

    def most_evident(self, state: Present) -> "Settling":
        """The same with the φ of largest evidence beside some laws; none moved where that is not worth its prior."""
        best = (-np.inf, replace(self, ratio=0.0))
        for ratio in (0.0, *_RATIOS) if self.groups else ():
            one = replace(self, ratio=ratio)
            volume = sum(float(np.log1p(ratio * squares).sum()) for squares in self.squares)
            evidence = one.of_state(state).log_evidence - 0.5 * volume
            best = max(best, (evidence, one), key=lambda item: item[0])
        return best[1]


def settling(chain: Chain, sample: Data, present: Present) -> Settling:
    """What may have moved, for `ratio` to be set.

    Args:
        chain: with the pose of the instrument among the parameters of its reading.
        sample: rows that count.
        present: the base model, to first order.
    """
    names = [parameter.name for parameter in chain.parameters[: chain.base]]
    pose = [i for i, name in enumerate(names) if name.startswith("instrument ")]
    moving = [np.flatnonzero(readings_of(rows, sample)) for rows in _moving(sample)]
    if len(moving) < OPTIONS.groups or not pose:
        return Settling()
    directions = present.base[:, pose]
    shows = np.sqrt((directions**2).mean(axis=0))
    directions = directions * (rms(present.readings) / np.maximum(shows, 1e-9 * max(float(shows.max()), 1e-300)))
    turned, squares = [], []
    for rows in moving:
        left, singular, _ = np.linalg.svd(directions[rows], full_matrices=False)
        there = singular > _SINGULAR * singular.max(initial=1e-300)
        turned.append(left[:, there])
        squares.append(singular[there] ** 2)
    return Settling(tuple(moving), tuple(turned), tuple(squares))


def _moving(sample: Data) -> list[BoolArray]:
    """Rows of every series that was read at several poses, shape (N,) each."""
    poses = sample.recordings.configurations
    ranges = OPTIONS.slight * np.ptp(poses[sample.counts], axis=0)
    found = []
    for number in np.unique(sample.rows.series[sample.counts]):
        rows: BoolArray = (sample.rows.series == number) & sample.counts
        if (np.ptp(poses[rows], axis=0) > ranges).any():
            found.append(rows)
    return found
