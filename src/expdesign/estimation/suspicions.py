"""Compliances that come out negative, as no robot's are."""

import numpy as np
from scipy.special import ndtri

from expdesign.chain.recordings.recordings import Recordings, Remark
from expdesign.errors import InputError
from expdesign.estimation.fit import Fit
from expdesign.estimation.remarks import NegativeCompliance
from expdesign.mechanics.robots.robot import Robot

CERTAINTY = float(ndtri(0.9999))
"""Standard deviations below zero at which a compliance is certainly negative."""


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


def negative_compliances(fit: Fit, robot: Robot) -> list[Remark]:
    """Actuators whose compliance comes out negative."""
    deviation = np.sqrt(np.diag(fit.covariance))
    return [
        NegativeCompliance(robot.actuators[index], bool(fit.values[index] + CERTAINTY * deviation[index] < 0.0))
        for index in np.flatnonzero(fit.values <= 0.0)
    ]
