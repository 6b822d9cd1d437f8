"""Whether the recordings determine every compliance, and if not, whose; and compliances that come out negative."""

import numpy as np
from scipy.special import ndtri

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.recordings import Recordings, Remark
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.estimation.fit import IDLE_DEVIATION, RANK_TOLERANCE, Fit
from expdesign.estimation.remarks import IdleActuators, NegativeCompliance
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.robots.robot import Jacobians, Robot

_REMEDY = "Add measurements in which every actuator carries load, or give a prior (argument `prior`, in percent)."

CORRECT_ROW = "Remove the row, or correct it."
"""What to do about a row that cannot be."""

CERTAINTY = float(ndtri(0.9999))
"""Standard deviations below zero at which a compliance is certainly negative."""


def idle_actuators(robot: Robot, jacobians: Jacobians, wrenches: FloatArray, axes: IntArray) -> BoolArray | None:
    """Actuators that move the measured axes by nothing but rounding in all rows, shape (n_p,).

    None for robots whose actuators must all be loaded, and where no actuator shows.
    """
    if not robot.may_idle:
        return None
    # A force and a moment are compared through what they do at the tip: J̌·diag(c)·τ per row.
    shown = observation_matrix(jacobians, wrenches)[:, axes] * robot.compliance
    moved = np.linalg.norm(shown, axis=-2).max(axis=0)
    idle: BoolArray = moved <= RANK_TOLERANCE * moved.max(initial=0.0)
    return None if idle.all() else idle


def require_estimable(
    actuators: list[str], recordings: Recordings, forces: FloatArray, sensitivities: FloatArray
) -> None:
    """Raise where the readings do not determine all compliances.

    Args:
        actuators: their names, n_p of them.
        recordings: what is fitted.
        forces: τ of the actuators in every row, shape (N, n_p).
        sensitivities: whitened derivatives of the readings with respect to the compliances, shape (N, k, n_p).

    Raises:
        NotIdentifiableError: names the actuators without load, those that cannot be told apart, or says that there are
            fewer readings than compliances.
    """
    matrix = sensitivities.reshape(-1, sensitivities.shape[-1])
    columns = np.linalg.norm(matrix, axis=0)
    where = recordings.source
    largest = float(columns.max(initial=0.0))
    if largest == 0.0 and np.any(forces):
        remedy = "Record other axes, or other poses."
        raise NotIdentifiableError("no actuator moves any of the measured axes", where=where, remedy=remedy)
    if largest == 0.0:
        raise NotIdentifiableError("no row has a load", where=where, remedy="Record loaded states.")
    idle = np.flatnonzero(columns <= RANK_TOLERANCE * largest)
    if idle.size:
        named = _listed([actuators[i] for i in idle])
        unloaded = np.abs(forces[:, idle]).max() <= RANK_TOLERANCE * np.abs(forces).max()
        verb = ("carry" if idle.size > 1 else "carries") if unloaded else ("move" if idle.size > 1 else "moves")
        what = f"{named} {verb} {'no load' if unloaded else 'none of the measured axes'} in any of the fitted rows"
        raise NotIdentifiableError(what, where=where, remedy=_REMEDY)
    if len(matrix) < len(columns):
        what = f"{len(matrix)} readings cannot determine {len(columns)} compliances"
        raise NotIdentifiableError(what, where=where, remedy=_REMEDY)
    _, singular, right = np.linalg.svd(np.asarray(np.linalg.qr(matrix / columns, mode="r")))
    lost = right[singular <= RANK_TOLERANCE * singular[0]]
    if len(lost):
        involved = np.flatnonzero(np.abs(lost).max(axis=0) > 1e-6)
        named = _listed([actuators[i] for i in involved])
        what = f"the fitted rows do not tell {named} apart (rank {len(columns) - len(lost)} of {len(columns)})"
        raise NotIdentifiableError(what, where=where, remedy=_REMEDY)


def idle_remarks(robot: Robot, idle: BoolArray) -> list[Remark]:
    """That the stiffness of idle actuators stays what the robot file says."""
    named = tuple(robot.actuators[i] for i in np.flatnonzero(idle))
    return [IdleActuators(named, IDLE_DEVIATION)] if named else []


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


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + f" and {names[-1]}"
