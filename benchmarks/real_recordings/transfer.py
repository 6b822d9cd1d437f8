"""What a model that was found under one condition says of recordings under another, as it is."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from expdesign.chain.chain import Chain
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.readings.reading import Reading
from expdesign.chain.recordings.reader import read_recordings
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.result import Diagnosis
from expdesign.diagnosis.sample import Sample, rms
from expdesign.estimation.fit import Data, Fit, fit
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.robot import Robot

_FIXED = 1e-6
"""Standard deviation, in typical sizes, of what is carried over from one condition to another."""


@dataclass(frozen=True)
class Transfer:
    """RMS of the residuals of another file, in standard deviations, of the base model and of the model carried over."""

    file: str
    before: float
    after: float


def transfer(result: Diagnosis, file: Path) -> Transfer:
    """Deflections are predicted as they are. An instrument that was set up anew (positions) is placed with the other
    file's training rows, nothing else is fitted, and the other rows are predicted.
    """
    robot = result.robot
    recordings = read_recordings(file, robot)
    reading = reading_of(robot, recordings)
    judged = np.ones(len(recordings), dtype=bool) if reading.linear else recordings.test
    every = everything(robot, recordings, reading)
    errors = []
    for found in (result.base, result.model.fit):
        chain = Chain(robot, found.chain.effects, reading=reading)
        values = found.values
        if not reading.linear:
            values = _placed(chain, found, every.restricted(~recordings.test)).values
        errors.append(rms(every.residuals(chain, values), judged))
    return Transfer(file.stem, *errors)


def everything(robot: Robot, recordings: Recordings, reading: Reading) -> Sample:
    """All rows of recordings, those marked `test` as well, with the deviations that they state."""
    assert recordings.deviations is not None
    whitening = Whitening(recordings.deviations)
    data = Data(recordings, row_data(recordings, robot), whitening, reading=reading)
    return Sample.of(data, np.ones(len(recordings), dtype=bool))


def _placed(chain: Chain, found: Fit, sample: Sample) -> Fit:
    """The chain with only its instrument fitted."""
    start, spread = chain.start(), chain.scales() * _FIXED
    start[: chain.compliances] = found.values[: chain.compliances]
    start[chain.base :] = found.values[found.chain.base :]
    start[chain.base - 3 : chain.base] = found.values[found.chain.base - 3 : found.chain.base]
    frame = slice(chain.compliances, chain.compliances + (6 if chain.robot.instrument is None else 0))
    spread[frame] = np.inf
    return fit(chain, sample, start, (start, spread))
