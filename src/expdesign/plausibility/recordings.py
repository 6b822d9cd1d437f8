"""Recordings: would another unit, sign or order of the columns make them fit?

The base model is fitted to the recordings as they are, and as they would be under each hypothesis. The misfit of a fit
is the share of the readings that it leaves over, translations and rotations apart, each in parts of their own size, so
that it depends neither on units nor on the noise. A hypothesis is suspected where it reduces the misfit tenfold and all
compliances come out positive; sound recordings, whose misfit is their noise, are not improved by any.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.elastostatics.maps import observation_matrix
from expdesign.elastostatics.measurements import LoadedRobot
from expdesign.loads.payload import Payload
from expdesign.plausibility.finding import Finding
from expdesign.plausibility.positions import positions_findings
from expdesign.recordings.measurand import POSITIONS
from expdesign.recordings.recordings import Recordings
from expdesign.robots.robot import Robot

GAIN = 10.0
"""Factor by which a hypothesis must reduce the misfit."""
POOR = 1e-3
"""Misfit below which nothing needs an explanation by a mistake."""
RATIO = 30.0
"""Factor between identified and stated stiffness beyond which a unit is suspected."""
_SPARE = 4
"""Readings beyond the compliances that a judgement takes at least."""


@dataclass(frozen=True)
class _Data:
    """Recordings under a hypothesis: configurations (N, n_q), wrenches (N, n), readings (N, k) of `axes`."""

    configurations: FloatArray
    wrenches: FloatArray
    readings: FloatArray


@dataclass(frozen=True)
class _Fitted:
    misfit: float
    positive: bool
    ratio: float


def recordings_findings(recordings: Recordings, robot: Robot) -> list[Finding]:
    """What speaks against the units and signs of recordings of deflections or positions."""
    if recordings.measurand is POSITIONS:
        return positions_findings(recordings, robot)
    if recordings.measurand.absolute or not len(robot.stiffness) or not _judgeable(recordings, robot):
        return []
    train = recordings.rows(~recordings.test)
    data = _Data(train.configurations, train.wrenches, train.deflections)
    stated = _fit(data, robot, recordings)
    if stated is None:
        return []
    needed = stated.misfit > POOR or not stated.positive
    suspects: list[tuple[_Fitted, str]] = []
    for text, other in _hypotheses(data, train, robot) if needed else ():
        found = _fit(other, robot, recordings)
        if found is None or not found.positive:
            continue
        better = found.misfit * GAIN < stated.misfit
        upright = not stated.positive and found.misfit <= 1.05 * stated.misfit and stated.misfit < 0.5
        if better or upright:
            suspects.append((found, text))
    if suspects:
        least = min(found.misfit for found, _ in suspects)
        equal = [(found, text) for found, text in suspects if found.misfit <= 2.0 * least]
        # Translations in mm and rotations in thousands of rad fit alike: what keeps the stiffness is likelier.
        text = min(equal, key=lambda one: round(abs(np.log10(one[0].ratio))))[1]
        return [Finding("the recordings do not fit the robot as they are, and would fit otherwise", text)]
    return _scale(stated) if stated.misfit < 0.5 else []


def _judgeable(recordings: Recordings, robot: Robot) -> bool:
    enough = (~recordings.test).sum() * len(recordings.axes) >= len(robot.stiffness) + _SPARE
    return bool(enough and (~recordings.test).sum() >= 2 and np.any(recordings.wrenches))


def _scale(stated: _Fitted) -> list[Finding]:
    """Everything fits, but with another stiffness than the file states."""
    if 1.0 / RATIO < stated.ratio < RATIO:
        return []
    softer = "softer" if stated.ratio > 1.0 else "stiffer"
    factor = max(stated.ratio, 1.0 / stated.ratio)
    what = f"the robot comes out {factor:.3g} times {softer} than its file says"
    likely = (
        "Are deflections in mm (and mrad), a mass in tonnes, a force in kN, or `actuator_stiffness` in another unit?"
        if stated.ratio > 1.0
        else "Is a mass in grams or a force in mN, are deflections in km, or is `actuator_stiffness` in N/µm or N/mm?"
    )
    return [Finding(what, likely)]


def _fit(data: _Data, robot: Robot, recordings: Recordings) -> _Fitted | None:
    """Least squares with translations and rotations in parts of their own size; None where nothing can be fitted."""
    jacobians = robot.jacobians(data.configurations)
    observation = observation_matrix(jacobians, data.wrenches)[:, recordings.axes] * robot.compliance
    if not np.isfinite(observation).all():
        return None
    weights = np.ones(len(recordings.axes))
    for kind in _kinds(recordings, robot):
        size = np.sqrt((data.readings[:, kind] ** 2).mean())
        weights[kind] = 1.0 / size if size > 0.0 else 0.0
    rows = (observation * weights[:, None]).reshape(-1, observation.shape[-1])
    right = (data.readings * weights).ravel()
    scale = np.linalg.norm(rows, axis=0)
    kept = scale > 1e-6 * scale.max(initial=0.0)
    if not kept.any():
        return None
    values, _, _, _ = np.linalg.lstsq(rows[:, kept] / scale[kept], right, rcond=1e-8)
    left = right - rows[:, kept] / scale[kept] @ values
    compliances = values / scale[kept]
    spread = np.sqrt((left**2).mean()) / scale[kept]
    positive = bool((compliances > -3.0 * spread * np.sqrt(len(compliances))).all() and compliances.sum() > 0.0)
    total = float((right**2).sum())
    ratio = float(np.median(compliances[compliances > 0.0])) if (compliances > 0.0).any() else float("nan")
    return _Fitted(float((left**2).sum()) / total if total else 0.0, positive, ratio)


def _kinds(recordings: Recordings, robot: Robot) -> list[BoolArray]:
    linear = recordings.axes < robot.coordinates.translations
    return [kind for kind in (linear, ~linear) if kind.any()]


def _hypotheses(data: _Data, recordings: Recordings, robot: Robot) -> Iterator[tuple[str, _Data]]:
    names = robot.coordinates.deflection
    linear = recordings.axes < robot.coordinates.translations

    def readings(factors: FloatArray) -> _Data:
        return _Data(data.configurations, data.wrenches, data.readings * factors)

    yield (
        "Have all deflections, or all loads, the wrong sign? A deflection is the loaded minus the unloaded pose, and a "
        "load what the environment applies to the platform.",
        readings(np.full(len(linear), -1.0)),
    )
    for column, axis in enumerate(recordings.axes):
        turned = np.ones(len(linear))
        turned[column] = -1.0
        yield f"Has {names[axis]} the wrong sign?", readings(turned)
    for kind, noun in ((linear, "translations"), (~linear, "rotations")):
        if 0 < kind.sum() < len(linear) or (kind.sum() == len(linear) and len(linear) > 1):
            yield f"Have the {noun} the wrong sign?", readings(np.where(kind, -1.0, 1.0))
    if linear.any() and (~linear).any():
        for factor, unit in ((1e-3, "mm"), (1e-6, "µm"), (1e3, "km")):
            yield f"Are the translations in {unit}? They have to be in m.", readings(np.where(linear, factor, 1.0))
        for factor, unit in (
            (np.pi / 180.0, "degrees"),
            (1e-3, "mrad"),
            (1e-6, "µrad"),
            (180.0 / np.pi, "turned twice"),
        ):
            yield f"Are the rotations in {unit}? They have to be in rad.", readings(np.where(linear, 1.0, factor))
    for column, axis in enumerate(recordings.axes):
        for factor, unit in ((1e-3, "mm or mrad"), (np.pi / 180.0, "degrees")):
            single = np.ones(len(linear))
            single[column] = factor
            yield f"Is {names[axis]} in {unit}?", readings(single)
    for first in range(len(linear)):
        for second in range(first + 1, len(linear)):
            if linear[first] == linear[second]:
                order = np.arange(len(linear))
                order[[first, second]] = second, first
                pair = f"{names[recordings.axes[first]]} and {names[recordings.axes[second]]}"
                yield (
                    f"Are the columns {pair} swapped?",
                    _Data(data.configurations, data.wrenches, data.readings[:, order]),
                )
    yield from _loads(data, recordings, robot)


def _loads(data: _Data, recordings: Recordings, robot: Robot) -> Iterator[tuple[str, _Data]]:
    split = robot.coordinates.translations
    if robot.coordinates.n > split:
        for factor, text in (
            (1e-3, "Are moments in N·mm, or centres of mass in millimetres?"),
            (1e3, "Are moments in kN·m?"),
        ):
            wrenches = data.wrenches.copy()
            wrenches[:, split:] *= factor
            yield text, _Data(data.configurations, wrenches, data.readings)
        wrenches = data.wrenches.copy()
        wrenches[:, split:] *= -1.0
        yield "Have the moments the wrong sign?", _Data(data.configurations, wrenches, data.readings)
        turned = data.configurations.copy()
        if robot.configuration == robot.coordinates.pose:
            turned[:, split:] *= np.pi / 180.0
            yield "Are the commanded angles in degrees?", _Data(turned, data.wrenches, data.readings)
    if recordings.payload is None or recordings.payload.shape[1] < 4:
        return
    loaded, rotation = LoadedRobot(robot, Payload(robot.coordinates)), robot.jacobians(data.configurations).rotation

    def payload(centres: FloatArray) -> _Data:
        parameters = np.concatenate([recordings.payload[:, :1], centres, recordings.gravity], axis=1)  # type: ignore[index]
        return _Data(data.configurations, loaded.wrenches(rotation, parameters)[0], data.readings)

    centres = recordings.payload[:, 1:4]
    for first, second, pair in (
        (0, 1, "com_x_m and com_y_m"),
        (0, 2, "com_x_m and com_z_m"),
        (1, 2, "com_y_m and com_z_m"),
    ):
        order = np.arange(3)
        order[[first, second]] = second, first
        yield f"Are the columns {pair} swapped?", payload(centres[:, order])
    for axis, name in enumerate(robot.coordinates.centre_of_mass):
        flipped = centres.copy()
        flipped[:, axis] *= -1.0
        yield f"Has {name} the wrong sign?", payload(flipped)
