"""Remarks of identification and diagnosis in sentences: a table by the kind of remark."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from expdesign.chain.readings.position import HeldMarker
from expdesign.chain.recordings.recordings import Remark
from expdesign.diagnosis.remarks import (
    AliasedParameters,
    Averaged,
    ConfoundedTime,
    Extrapolation,
    NotSought,
    SerialCorrelation,
    Sought,
    TooFewForLaws,
    WithoutMoment,
    WrittenOtherwise,
)
from expdesign.estimation.remarks import (
    AliasedGeometry,
    BeyondManufacture,
    BlindPoses,
    GenerousNoise,
    IdleActuators,
    Implausible,
    LargeGeometricErrors,
    NegativeCompliance,
    NoiseBeyondStated,
)
from expdesign.report import words
from expdesign.report.physics_words import effect_words

_NAMES = 6
"""Names that a sentence lists."""

_NOT_SOUGHT = {
    Sought.TIME: "Laws of time and creep were not considered: the recordings have no column `time_s`.",
    Sought.MEMORY: "Effects that remember a load were not considered: no series has two rows in a stated order.",
    Sought.PLACE: "Laws of the pose were not considered: all rows have one pose.",
    Sought.FORCE: "Laws of force were not considered: all rows have the same load.",
}


def sentences(remarks: Iterable[Remark]) -> list[str]:
    """A sentence for each."""
    return [sentence(remark) for remark in remarks]


def sentence(remark: Remark) -> str:
    """A remark as a user reads it."""
    return TEXTS[type(remark)](remark)


def _first(names: Sequence[str]) -> str:
    return ", ".join(names[:_NAMES]) + (" and others" if len(names) > _NAMES else "")


def _vector(components: Sequence[float]) -> str:
    return f"({', '.join(words.fixed(float(x), 4) for x in components)})"


def _implausible(one: Implausible) -> str:
    return f"{words.sentence(f'{one.where}: {one.what}' if one.where else one.what)}. {one.likely}"


def _negative(one: NegativeCompliance) -> str:
    certain = ": a deflection has the wrong sign, a load or joint is wrong, or physics is missing."
    perhaps = ", but its uncertainty includes positive values: the actuator carries hardly any load."
    return f"The identified compliance of {one.actuator} is negative{certain if one.certain else perhaps}"


def _held_marker(one: HeldMarker) -> str:
    along = "" if len(one.axes) == 3 else f" along {' and '.join(one.axes)} of the tip"
    return (
        f"The fitted rows of marker `{one.marker}` have one orientation of the tip: its place{along} is confounded "
        "with that of the instrument, and is held at the tip's origin. Rows with other orientations cannot be "
        "predicted and are not judged. Give the marker's place in the robot file, or record more orientations."
    )


def _beyond(one: BeyondManufacture) -> str:
    units = ["rad" if angle else "m" for angle in one.angles]
    listed = [
        f"{name} {words.size(value, unit)} (machines are made to {words.size(size, unit)})"
        for name, value, size, unit in zip(one.names, one.values, one.sizes, units, strict=True)
    ]
    more = len(listed) - _NAMES
    return (
        f"Corrections beyond manufacture: {'; '.join(listed[:_NAMES])}{f' and {more} more' if more > 0 else ''}. "
        "The robot file is of another robot, the instrument or a marker was moved (columns `station`, `session`), the "
        "poses do not show them, or offsets cancel along parallel axes. They are not written into `robot.urdf` unless "
        "they are accepted (argument `accept`)."
    )


def _size(value: float, name: str) -> str:
    """A length or an angle, by whether translations or rotations are meant."""
    return words.size(value, "m" if name == "translations" else "rad")


def _confounded_time(one: ConfoundedTime) -> str:
    text = (
        f"Time is confounded with {one.name}, which explains {100.0 * one.share:.0f} % of its variance (variance "
        f"inflation factor {1.0 / max(1.0 - one.share, 1e-9):.3g}). "
    )
    if not one.imitations:
        return text + f"The named drift also shows among rows with the same {one.name}."
    listed = words.listed([f"`{key}`" for key in one.imitations])
    return text + (
        f"{listed} would describe all rows, but not those with the same {one.name}, and is not named. Record rows in "
        f"random order of {one.name}, or a second visit, to show a drift."
    )


def _averaged(one: Averaged) -> str:
    named, more = (
        "; ".join(effect_words(effect) for effect in one.effects[:_NAMES]),
        len(one.effects) - _NAMES,
    )
    return (
        f"{one.rows} rows are too few to rule out small effects. Predictions are the average over what may be there, "
        f"weighted by evidence: {named}{f' and {more} others' if more > 0 else ''}. Record more poses to decide."
    )


TEXTS: Mapping[type[Remark], Callable[[Any], str]] = {
    Implausible: _implausible,
    NegativeCompliance: _negative,
    IdleActuators: lambda one: (
        f"No fitted row shows how {words.listed(one.actuators)} yields: weights do not load a joint about the "
        "vertical, and a tip on the joint's axis does not move. "
        f"{'Its stiffness stays' if len(one.actuators) == 1 else 'Their stiffnesses stay'} that of the robot file, "
        f"with a standard deviation of {100.0 * one.deviation:.0f} %. Other loads or measured axes would determine it."
    ),
    LargeGeometricErrors: lambda one: (
        f"The identified joints and lengths are {1e3 * one.size:.3g} mm (RMS) off. Are the measured poses in another "
        "frame than the commands? `expdesign identify --frames unknown` identifies the frames too."
    ),
    AliasedGeometry: lambda one: (
        f"The recordings determine only combinations of {one.count} of {one.total} geometric parameters. Intervals of "
        "these parameters are those of the prior; predicted poses are more accurate."
    ),
    BeyondManufacture: _beyond,
    HeldMarker: _held_marker,
    BlindPoses: lambda one: (
        f"The fitted poses do not show {words.listed(one.names[:_NAMES])}"
        f"{' and others' if len(one.names) > _NAMES else ''}, which stay as drawn. Poses in which all joints move "
        "would determine them."
    ),
    NoiseBeyondStated: lambda one: (
        f"Residuals of the {one.name} are {one.needed / one.stated:.3g} times the stated standard deviation of "
        f"{_size(one.stated, one.name)}: {_size(one.needed, one.name)} would agree with them. All intervals include "
        f"a second component of {_size(one.extra, one.name)} (repeatability, or missing physics)."
    ),
    GenerousNoise: lambda one: (
        f"The stated standard deviation of the {one.name}, {_size(one.stated, one.name)}, is far too large: "
        f"{_size(one.needed, one.name)} from the residuals replaces it."
    ),
    AliasedParameters: lambda one: (
        f"{len(one.names)} parameters are confounded with others and keep their assumed values and tolerances: "
        f"{_first(one.names)}. Only their combination is determined, single values are not."
    ),
    WithoutMoment: lambda one: (
        f"No load has a moment about {' and '.join(map(_vector, one.directions))}: moments of a weight have none along "
        "gravity. Elements of a compliance that only such a moment distinguishes are not determined, however small the "
        "noise."
    ),
    Extrapolation: lambda one: (
        "Held-out rows depend on parameters that the fitted rows do not determine: their error is "
        f"{one.held_out:.3g} standard deviations, that of fitted rows {one.fitted:.3g}."
    ),
    SerialCorrelation: lambda one: (
        f"Residuals of consecutive rows are correlated ({one.correlation:.2f}): {one.rows} rows are worth about "
        f"{one.effective_rows:.0f} independent ones. All intervals allow for this."
    ),
    ConfoundedTime: _confounded_time,
    TooFewForLaws: lambda one: (
        f"Laws at ports were not considered: they need {one.needed} fitted rows, and there are {one.rows}."
    ),
    NotSought: lambda one: _NOT_SOUGHT[one.law],
    Averaged: _averaged,
    WrittenOtherwise: lambda one: (
        f"The model file predicts the fitted rows {one.difference:.2g} standard deviations of a reading away from what "
        "is said here of the model. Predict with the model of `expdesign identify`."
        if math.isfinite(one.difference)
        else "The model file holds values that no machine has, and is refused. Predict with the model of `identify`."
    ),
}
"""What is said of each."""
