"""What looks like a mistake in the recordings although every cell is readable: signs and units."""

import numpy as np
from scipy.stats import norm

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.identification.fit import Fit, linear_fit
from expdesign.identification.remarks import NegativeCompliance, TurnedSign, UnlikelyCompliance
from expdesign.recordings.recordings import Recordings
from expdesign.recordings.remark import Remark
from expdesign.robots.robot import Robot

CERTAINTY = float(norm.ppf(0.9999))
"""Standard deviations below zero at which a compliance is certainly negative."""
GAIN = 10.0
"""Factor by which turning the sign of a column must reduce χ² to be suspected."""
LIKELY_RATIO = 30.0
"""Factor between identified and approximate stiffness above which a unit is suspected."""


def require_positive(fit: Fit, recordings: Recordings, robot: Robot) -> None:
    """Raise where most compliances are certainly negative, which no robot's are.

    Raises:
        InputError: with the sign that is probably wrong.
    """
    deviation = np.sqrt(np.diag(fit.covariance))
    negative = fit.values + CERTAINTY * deviation < 0.0
    if 2 * negative.sum() > len(negative):
        what = f"{int(negative.sum())} of {len(negative)} identified stiffnesses are negative: wrong sign?"
        columns = ", ".join(robot.coordinates.deflection[i] for i in recordings.axes)
        remedy = (
            "Deflections are pose under load minus pose without load, and loads are what the environment applies to "
            "the platform; check the sign of both."
        )
        raise InputError(what, where=f"{recordings.where(0)}, columns {columns}", remedy=remedy)


def suspicions(fit: Fit, recordings: Recordings, robot: Robot, *, noise_known: bool) -> list[Remark]:
    """Signs and units that look wrong, most telling first."""
    found: list[Remark] = []
    found += _turned_columns(fit, recordings, robot, noise_known=noise_known)
    deviation = np.sqrt(np.diag(fit.covariance))
    for index in np.flatnonzero(fit.values <= 0.0):
        sure = fit.values[index] + CERTAINTY * deviation[index] < 0.0
        found.append(NegativeCompliance(robot.actuators[index], bool(sure)))
    positive = fit.values[fit.values > 0.0]
    if positive.size:
        ratio = float(np.median(positive))
        if not 1.0 / LIKELY_RATIO < ratio < LIKELY_RATIO:
            found.append(UnlikelyCompliance(ratio))
    return found


def _turned_columns(fit: Fit, recordings: Recordings, robot: Robot, *, noise_known: bool) -> list[TurnedSign]:
    """Measured components whose sign, turned, would make the readings of their kind fit much better.

    Translations and rotations are judged apart: where the noise is estimated, a wrong sign inflates that of its kind.
    """
    found: list[TurnedSign] = []
    if fit.dof <= 0 or len(recordings.axes) < 2 or len(robot.stiffness) == 0:
        return found
    rotation = recordings.axes >= robot.coordinates.translations
    readings = fit.residuals + fit.sensitivities @ fit.values
    for column, axis in enumerate(recordings.axes):
        kind = rotation == rotation[column]
        before = float((fit.residuals[:, kind] ** 2).sum())
        floor = float(len(readings) * kind.sum()) if noise_known else 0.0
        if before <= GAIN * floor:
            continue
        turned: FloatArray = readings.copy()
        turned[:, column] *= -1.0
        other = linear_fit(fit.chain, np.zeros_like(fit.values), turned, fit.sensitivities)
        after = float((other.residuals[:, kind] ** 2).sum())
        if GAIN * max(after, floor) < before and other.chi2 < fit.chi2 and (other.values > 0.0).all():
            found.append(TurnedSign(robot.coordinates.deflection[axis]))
    return found
