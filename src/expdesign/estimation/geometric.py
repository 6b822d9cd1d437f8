"""Geometric calibration: what is identified from absolute readings, and whether they determine it.

The geometry (`chain/effects/legs/geometry.py`) and, where the frames are unknown, their displacements have wide normal
priors, or the one of the robot file. The priors fix the gauge freedoms of unknown frames; what the readings determine,
every pose that can be measured among it, does not depend on them (theory.md 9.I).
"""

from dataclasses import replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.chain.chain import Chain
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.chain.effects.legs.geometry import LegGeometry
from expdesign.chain.recordings.recordings import DEFLECTIONS, Recordings, Remark
from expdesign.chain.row import row_data
from expdesign.errors import ArgumentError, InputError, NotIdentifiableError
from expdesign.estimation.fit import Data, Fit
from expdesign.estimation.remarks import AliasedGeometry, LargeGeometricErrors
from expdesign.mechanics.elastostatics.calibration import CALIBRATIONS, Calibration
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot import Robot

LARGE_ERROR = 2e-3
"""m; RMS of the identified errors of joints and lengths above which frames or units are suspected."""
_RANK_TOLERANCE = 1e-8
_MANY = 120
"""Rows from which every kind of row tells all that it can."""
_REACH = 0.1
_TURN = 0.15
"""How far commands are spread to see what more of them would tell: part of the joints' spread, and rad."""
_UNDETERMINED = 0.1
"""Part of its prior standard deviation that a parameter keeps at least where the readings do not determine it."""


def calibration_of(robot: Robot, recordings: Recordings, asked: Calibration | None) -> Calibration:
    """What is identified: what is asked for, or what the columns say.

    Positions and poses of an arm show its geometry and, as its links weigh, its stiffness. Measured poses of a platform
    show the geometry, and with loads the stiffness as well; deflections and positions of markers on a loaded platform
    are taken for the stiffness alone.

    Raises:
        InputError: the robot or the recordings do not go with what is asked for.
    """
    loaded = bool(np.any(recordings.wrenches))
    yields = bool(np.isfinite(robot.stiffness).all())
    arm = robot.jointed and recordings.measurand.absolute
    if asked is None:
        if arm:
            return "both" if yields else "geometric"
        if recordings.poses:
            return "both" if loaded else "geometric"
        on_legs = robot.on_legs and recordings.measurand is not DEFLECTIONS
        return "geometric" if on_legs and not loaded else "elastostatic"
    if asked not in CALIBRATIONS:
        remedy = f"Choose {', '.join(CALIBRATIONS)}."
        raise ArgumentError(f"`{asked}` is no calibration", argument="calibration", remedy=remedy)
    if asked != "geometric" and not yields:
        what = f"`{robot.name}` has no `actuator_stiffness`, about which stiffness could be identified"
        raise ArgumentError(what, argument="calibration", remedy="Add its order of magnitude, or use `geometric`.")
    if asked == "elastostatic":
        return asked
    if not robot.on_legs and not robot.jointed:
        what = f"{asked} calibration needs a robot with legs or joints, and `{robot.name}` is a {robot.kind}"
        raise ArgumentError(what, argument="calibration", remedy="Leave the option out.")
    if not recordings.measurand.absolute:
        what = "deflections are differences, in which the geometry cancels"
        remedy = "Give measured poses (measured_x_m ...) or positions of markers, or use `elastostatic`."
        raise InputError(what, where=recordings.source, remedy=remedy)
    if asked == "both" and not loaded and not arm:
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
        remedy = (
            "Use argument `calibration=both` where all rows are loaded, or mark rows `train` in the column `split`."
        )
        raise InputError(what, where=recordings.source, remedy=remedy)
    return usable


def require_determined(chain: Chain, data: Data) -> None:
    """Raise where the fitted rows determine less than more rows of their kind would, and no prior is stated.

    Gauge freedoms, which no rows of this kind determine, are no reason to refuse: the frames where they are unknown,
    turns about the only marker, turns of the platform where its position alone is measured.

    Raises:
        NotIdentifiableError: with how many combinations are determined, and how many there are.
    """
    if chain.robot.geometry_std is not None:
        return
    recordings = data.recordings
    most = _rank(chain, _more_rows(recordings, chain.robot), data.idle)
    readings = recordings.deflections.size
    remedy = (
        "Measure more poses that differ more (all six coordinates), or more axes, or give `geometry_std_m` in the "
        "robot file for what is known from drawings."
    )
    if readings < most:
        what = f"{readings} readings of {len(recordings)} poses cannot determine {most} parameters"
        raise NotIdentifiableError(what, where=recordings.source, remedy=remedy)
    rank = _rank(chain, recordings, data.idle)
    if rank < most:
        what = f"the poses determine {rank} of {most} combinations of geometry and stiffness"
        raise NotIdentifiableError(what, where=recordings.source, remedy=remedy)


def _rank(chain: Chain, recordings: Recordings, idle: BoolArray | None) -> int:
    """How many combinations of the parameters the measured axes of these rows show."""
    rows = row_data(recordings, chain.robot)
    sensitivities = chain.predict_with_sensitivities(rows, chain.start())[1][:, recordings.axes]
    matrix = as_matrix(sensitivities) * chain.scales()
    if idle is not None:
        matrix[:, np.flatnonzero(idle)] = 0.0
    columns = np.linalg.norm(matrix, axis=0)
    singular = np.linalg.svd(matrix / np.where(columns > 0.0, columns, 1.0), compute_uv=False)
    return int((singular > _RANK_TOLERANCE * singular[0]).sum())


def _more_rows(recordings: Recordings, robot: Robot) -> Recordings:
    """As many rows of the same kind, at commands and loads spread about those of the recordings, as tell all."""
    random = np.random.default_rng(1)
    more = recordings.rows(np.resize(np.arange(len(recordings)), max(_MANY, len(recordings))))
    sizes = np.full(robot.coordinates.n, _TURN)
    sizes[: robot.coordinates.translations] = _REACH * _size(robot.inverse_kinematics)
    configurations = more.configurations + sizes * random.uniform(-1.0, 1.0, more.configurations.shape)
    wrenches = more.wrenches * (1.0 + random.standard_normal(more.wrenches.shape))
    spread = np.abs(more.wrenches).max() * random.standard_normal(more.wrenches.shape)
    loaded = np.any(more.wrenches != 0.0, axis=1)
    wrenches[loaded] += 0.1 * spread[loaded]
    return replace(more, configurations=configurations, wrenches=wrenches)


def _size(closed_form: ParallelRobot) -> float:
    """Spread of the joints (m)."""
    return float(np.ptp(closed_form.geometry)) / 2.0


def geometry_slice(chain: Chain) -> slice | None:
    """Where the geometry lies among the parameters of a chain, None where it is not one of them."""
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        if isinstance(effect, LegGeometry | CalibratedGeometryError):
            return part
    return None


def geometry_remarks(fit: Fit) -> list[Remark]:
    """On an identified geometry that looks like a mistake, and on what the readings leave undetermined."""
    part = geometry_slice(fit.chain)
    if part is None:
        return []
    parameters = fit.chain.parameters[part]
    remarks: list[Remark] = []
    spreads: FloatArray = np.array([parameter.spread for parameter in parameters])
    loose = np.sqrt(np.diag(fit.covariance)[part]) > _UNDETERMINED * spreads
    size = float(np.sqrt((fit.values[part][~loose] ** 2).mean())) if not loose.all() else 0.0
    if size > LARGE_ERROR and fit.chain.reading.record.get("frames") == "known":
        remarks.append(LargeGeometricErrors(size))
    if loose.any():
        remarks.append(AliasedGeometry(int(loose.sum()), len(parameters)))
    return remarks
