"""Identification from absolute readings, positions of markers or poses: compliances and geometry, together with the
frames of the instrument and the markers' places.

Own weight loads the joints, so that positions show compliances without a payload. What the fitted rows do not determine
stays what the robot file says, within a wide tolerance (`chain.knowledge`), and its interval says so.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.effects.legs.geometry import leg_geometry
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.recordings import Recordings, Remark
from expdesign.chain.row import row_data
from expdesign.estimation.coverage import NONE_HELD_OUT, HeldOutRows
from expdesign.estimation.fit import Data, Fit, fit
from expdesign.estimation.geometric import (
    geometry_remarks,
    require_determined,
    usable_rows,
)
from expdesign.estimation.noise_level import NoiseLevel, noise_from_residuals
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.elastostatics.calibration import Calibration
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class PositionFit:
    """A fit of absolute readings.

    Attributes:
        fitted: the rows that were fitted, shape (N,).
        fit: of the fitted rows.
        noise: standard deviations of the fitted rows.
        held_out: the rows marked `test` that can be predicted.
        remarks: what is confounded or looks like a mistake.
    """

    fitted: BoolArray
    fit: Fit
    noise: NoiseLevel
    held_out: HeldOutRows
    remarks: list[Remark]


def fit_positions(
    robot: Robot,
    recordings: Recordings,
    *,
    calibration: Calibration = "elastostatic",
    frames_known: bool = True,
) -> PositionFit:
    """Fit the base model to the rows that are not marked `test`.

    Args:
        robot: the robot.
        recordings: positions of markers, or measured poses.
        calibration: what is identified; the geometry alone from rows without load.
        frames_known: whether measured poses are in the very frames of the commands.

    Raises:
        InputError: the robot is of a kind that has no markers.
        NotIdentifiableError: the rows do not determine the geometry, or the noise is not stated and cannot be
            estimated.
    """
    usable = usable_rows(recordings, calibration)
    fitted = usable & ~recordings.test
    reading = reading_of(robot, recordings, frames_known=frames_known)
    train = recordings.rows(fitted)
    effects = () if calibration == "elastostatic" else (leg_geometry(robot),)
    chain, rows = Chain(robot, effects, reading=reading), row_data(train, robot)
    idle = np.ones(len(robot.stiffness), dtype=bool) if calibration == "geometric" else None

    def data(deviations: FloatArray) -> Data:
        whitening = Whitening(deviations, references=train.references)
        return Data(train, rows, whitening, idle=idle, reading=reading)

    def solve(deviations: FloatArray) -> Fit:
        return fit(chain, data(deviations))

    if effects:
        require_determined(chain, data(np.ones_like(train.deflections)))

    if train.deviations is not None:
        noise = NoiseLevel(train.deviations, "recordings")
    else:
        noise = noise_from_residuals(train, robot.coordinates.translations, solve)
    result = solve(noise.deviations)
    judged = recordings.test & usable & reading.predictable(robot, recordings)
    test = recordings.rows(judged)
    remarks = reading.degeneracies + geometry_remarks(result)
    if not len(test):
        return PositionFit(fitted, result, noise, NONE_HELD_OUT, remarks)
    predicted, sensitivities = chain.predict_with_sensitivities(row_data(test, robot), result.values)
    stated = test.deviations if test.deviations is not None else noise.deviations[:1]
    axes = recordings.axes
    held_out = HeldOutRows((test.deflections - predicted[:, axes]) / stated, sensitivities[:, axes] / stated[..., None])
    return PositionFit(fitted, result, noise, held_out, remarks)
