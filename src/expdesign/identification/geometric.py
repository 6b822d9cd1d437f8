"""Geometric calibration of robots on legs: what is identified from absolute readings, and whether they determine it.

The geometry (`chain/effects/legs/geometry.py`) and, where the frames are unknown, their displacements have wide normal
priors, or the one of the robot file. The priors fix the gauge freedoms of unknown frames; what the readings determine,
every pose that can be measured among it, does not depend on them (theory.md 9.I).
"""

from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.chain.chain import Chain
from expdesign.chain.effects.legs.geometry import LegGeometry
from expdesign.chain.readings.pose import MeasuredPose
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.identification.fit import RANK_TOLERANCE, Data, Fit
from expdesign.recordings.measurand import DEFLECTIONS
from expdesign.recordings.recordings import Recordings
from expdesign.robots.robot import Robot

Calibration = Literal["elastostatic", "geometric", "both"]
CALIBRATIONS: tuple[Calibration, ...] = get_args(Calibration)
LARGE_ERROR = 2e-3
"""m; RMS of the identified errors of joints and lengths above which frames or units are suspected."""
_UNDETERMINED = 0.1
"""Part of its prior standard deviation that a parameter keeps at least where the readings do not determine it."""


def calibration_of(robot: Robot, recordings: Recordings, asked: Calibration | None) -> Calibration:
    """What is identified: what is asked for, or what the columns say.

    Measured poses show the geometry, and with loads the stiffness as well; deflections and, of a loaded robot,
    positions of markers are taken for the stiffness alone.

    Raises:
        InputError: the robot or the recordings do not go with what is asked for.
    """
    loaded = bool(np.any(recordings.wrenches))
    if asked is None:
        if recordings.poses:
            return "both" if loaded else "geometric"
        on_legs = robot.inverse_kinematics is not None and recordings.measurand is not DEFLECTIONS
        return "geometric" if on_legs and not loaded else "elastostatic"
    if asked not in CALIBRATIONS:
        remedy = f"Choose {', '.join(CALIBRATIONS)}."
        raise InputError(f"`{asked}` is no calibration", where="--calibration", remedy=remedy)
    if asked == "elastostatic":
        return asked
    if robot.inverse_kinematics is None:
        what = f"{asked} calibration needs a robot on legs, and `{robot.name}` is a {robot.kind}"
        raise InputError(what, where="--calibration", remedy="`expdesign diagnose` finds the geometry of arms.")
    if not recordings.measurand.absolute:
        what = "deflections are differences, in which the geometry cancels"
        remedy = "Give measured poses (measured_x_m ...) or positions of markers, or use `elastostatic`."
        raise InputError(what, where=recordings.source, remedy=remedy)
    if asked == "both" and not loaded:
        what = "no row has a load, so that nothing shows the stiffness"
        raise InputError(what, where=recordings.source, remedy="Record loaded poses, or use `geometric`.")
    return asked


def usable_rows(recordings: Recordings, calibration: Calibration) -> BoolArray:
    """Rows that go with a calibration, shape (N,): the geometry alone is read off poses without load.

    Raises:
        InputError: there is none that may be fitted.
    """
    usable = np.ones(len(recordings), dtype=bool)
    if calibration == "geometric":
        usable = (recordings.wrenches == 0.0).all(axis=1)
    if not (usable & ~recordings.test).any():
        what = "no row without load is left to fit" if not usable.any() else "no row is left to fit"
        remedy = "Use `--calibration both` where all rows are loaded, or mark some rows `train` in the column `split`."
        raise InputError(what, where=recordings.source, remedy=remedy)
    return usable


def require_determined(chain: Chain, data: Data) -> None:
    """Raise where the fitted rows do not determine everything but the gauge freedoms, and no prior is stated.

    Raises:
        NotIdentifiableError: with how many combinations are determined, and how many there are.
    """
    if chain.robot.geometry_std is not None:
        return
    _, sensitivities = data.residuals_with_sensitivities(chain, chain.start())
    matrix = as_matrix(sensitivities) * chain.scales()
    wanted = int(np.any(matrix != 0.0, axis=0).sum()) - gauge_freedoms(chain)
    where = data.recordings.source
    remedy = (
        "Measure more poses that differ more (all six coordinates), or more axes, or give `geometry_std_m` in the "
        "robot file for what is known from drawings."
    )
    readings = len(matrix)
    if readings < wanted:
        what = f"{readings} readings of {len(data.recordings)} poses cannot determine {wanted} parameters"
        raise NotIdentifiableError(what, where=where, remedy=remedy)
    columns = np.linalg.norm(matrix, axis=0)
    singular = np.linalg.svd(matrix / np.where(columns > 0.0, columns, 1.0), compute_uv=False)
    rank = int((singular > RANK_TOLERANCE * singular[0]).sum())
    if rank < wanted:
        what = f"the poses determine {rank} of {wanted} combinations of geometry and stiffness"
        raise NotIdentifiableError(what, where=where, remedy=remedy)


def judged_by_readings(fit: Fit) -> Fit:
    """The fit with χ² and degrees of freedom of the readings alone.

    Wide priors count as readings that always agree. The sum of squared residuals has the expectation N − tr(H) with
    the hat matrix H, whether the parameters are spread as their priors say or the priors are so wide that they tell
    nothing.
    """
    hat = float(np.einsum("nkp,pq,nkq->", fit.sensitivities, fit.covariance, fit.sensitivities))
    return replace(fit, chi2=float((fit.residuals**2).sum()), dof=round(fit.residuals.size - hat))


def gauge_freedoms(chain: Chain) -> int:
    """Combinations of the parameters that no reading of this kind shows: displacements of frames, and turns about the
    only marker or the line of two.
    """
    if not any(isinstance(effect, LegGeometry) for effect in chain.effects):
        return 0
    reading = chain.reading
    if isinstance(reading, MeasuredPose):
        return reading.redundant
    known = len(reading.names) - sum(p.name.startswith("marker ") for p in reading.parameters) // 3
    instrument = 6 if any(p.name.startswith("instrument ") for p in reading.parameters) else 0
    return instrument + {0: 6, 1: 3, 2: 1}.get(known, 0)


def geometry_slice(chain: Chain) -> slice | None:
    """Where the geometry lies among the parameters of a chain, None where it is not one of them."""
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        if isinstance(effect, LegGeometry):
            return part
    return None


def geometry_remarks(fit: Fit) -> list[str]:
    """Sentences on an identified geometry that looks like a mistake, and on what the readings leave undetermined."""
    part = geometry_slice(fit.chain)
    if part is None:
        return []
    parameters = fit.chain.parameters[part]
    remarks = []
    size = float(np.sqrt((fit.values[part] ** 2).mean()))
    if size > LARGE_ERROR and fit.chain.reading.record.get("frames") != "unknown":
        remarks.append(
            f"Joints and lengths come out {1e3 * size:.3g} mm (RMS) off: are the measured poses in another frame than "
            "the commands? (`--frames unknown` identifies the frames as well.)"
        )
    spreads: FloatArray = np.array([parameter.spread for parameter in parameters])
    loose = np.sqrt(np.diag(fit.covariance)[part]) > _UNDETERMINED * spreads
    if loose.any():
        remarks.append(
            f"{int(loose.sum())} of {len(parameters)} geometric parameters are not determined one by one, only "
            "combinations of them are: their intervals are those of the prior, those of predicted poses are not."
        )
    return remarks
