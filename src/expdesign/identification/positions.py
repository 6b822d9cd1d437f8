"""Identification from positions of markers: compliances together with the instrument's pose and the markers' places.

Own weight loads the joints, so that positions show compliances without a payload. What the fitted rows do not determine
stays what the robot file says, within a wide tolerance (`chain.knowledge`), and its interval says so.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.row import row_data
from expdesign.identification.fit import Data, Fit, fit
from expdesign.identification.noise_level import NoiseLevel, noise_from_residuals
from expdesign.identification.whitening import Whitening
from expdesign.recordings.recordings import Recordings
from expdesign.robots.robot import Robot


@dataclass(frozen=True)
class PositionFit:
    """A fit of positions.

    Attributes:
        fit: of the fitted rows.
        noise: standard deviations of the fitted rows.
        test_residuals: of the held-out rows that can be predicted, in standard deviations, shape (n, 3).
        remarks: what cannot be told apart, in sentences.
    """

    fit: Fit
    noise: NoiseLevel
    test_residuals: FloatArray
    remarks: list[str]


def fit_positions(robot: Robot, recordings: Recordings, *, shared_reference: bool) -> PositionFit:
    """Fit the base model to the rows that are not marked `test`.

    Raises:
        InputError: the robot is of a kind that has no markers.
        NotIdentifiableError: the noise is not stated and cannot be estimated.
    """
    reading = reading_of(robot, recordings)
    train = recordings.rows(~recordings.test)
    chain, rows = Chain(robot, reading=reading), row_data(train, robot)

    def solve(deviations: FloatArray) -> Fit:
        return fit(chain, Data(train, rows, Whitening(deviations, train.series, shared_reference=shared_reference)))

    if train.deviations is not None:
        noise = NoiseLevel(train.deviations, "recordings")
    else:
        noise = noise_from_residuals(train, robot.coordinates.translations, solve)
    result = solve(noise.deviations)
    judged = recordings.test & reading.predictable(robot, recordings)
    test = recordings.rows(judged)
    residuals = np.zeros((0, 3))
    if len(test):
        deviations = test.deviations if test.deviations is not None else noise.deviations[:1]
        residuals = (test.deflections - chain.predict(row_data(test, robot), result.values)) / deviations
    return PositionFit(result, noise, residuals, reading.degeneracies)
