"""Remarks of identification and diagnosis in sentences."""

from collections.abc import Iterable
from functools import singledispatch

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
)
from expdesign.estimation.noise_remarks import GenerousNoise, NoiseBeyondStated
from expdesign.estimation.redundancy import BlindPoses
from expdesign.estimation.remarks import (
    AliasedGeometry,
    IdleActuators,
    Implausible,
    LargeGeometricErrors,
    NegativeCompliance,
)
from expdesign.report import words

_MOST_NAMES = 6
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


@singledispatch
def sentence(remark: Remark) -> str:
    """A remark as a user reads it; every type has its own."""
    raise NotImplementedError(f"no sentence says {type(remark).__name__}")


@sentence.register
def _implausible(remark: Implausible) -> str:
    what = remark.what if not remark.where else f"{remark.where}: {remark.what}"
    return f"{what[:1].upper()}{what[1:]}. {remark.likely}"


@sentence.register
def _negative(remark: NegativeCompliance) -> str:
    text = f"The identified compliance of {remark.actuator} is negative"
    if remark.certain:
        return text + ": a deflection has the wrong sign, a load or joint is wrong, or physics is missing."
    return text + ", but its uncertainty includes positive values: the actuator carries hardly any load."


@sentence.register
def _idle(remark: IdleActuators) -> str:
    whose = "its stiffness stays" if len(remark.actuators) == 1 else "their stiffnesses stay"
    return (
        f"No fitted row shows how {words.listed(remark.actuators)} yields: weights do not load a joint about the "
        f"vertical, and a tip on the joint's axis does not move. {whose[:1].upper()}{whose[1:]} that of the robot "
        f"file, with a standard deviation of {remark.deviation:.0%}. Other loads or measured axes would determine it."
    )


@sentence.register
def _large_geometry(remark: LargeGeometricErrors) -> str:
    return (
        f"The identified joints and lengths are {1e3 * remark.size:.3g} mm (RMS) off. Are the measured poses in "
        "another frame than the commands? `expdesign identify --frames unknown` identifies the frames too."
    )


@sentence.register
def _aliased_geometry(remark: AliasedGeometry) -> str:
    return (
        f"The recordings determine only combinations of {remark.count} of {remark.total} geometric parameters. "
        "Intervals of these parameters are those of the prior; predicted poses are more accurate."
    )


@sentence.register
def _held_marker(remark: HeldMarker) -> str:
    along = f" along {' and '.join(remark.axes)} of the tip"
    place = f"its place{'' if len(remark.axes) == 3 else along}"
    return (
        f"The fitted rows of marker `{remark.marker}` have one orientation of the tip: {place} is confounded with that "
        "of the instrument, and is held at the tip's origin. Rows with other orientations cannot be predicted and are "
        "not judged. Give the marker's place in the robot file, or record more orientations."
    )


@sentence.register
def _blind(remark: BlindPoses) -> str:
    listed = words.listed(remark.names[:_MOST_NAMES]) + (" and others" if len(remark.names) > _MOST_NAMES else "")
    return (
        f"The fitted poses do not show {listed}, which stay as drawn. Poses in which all joints move would determine "
        "them."
    )


@sentence.register
def _beyond(remark: NoiseBeyondStated) -> str:
    unit, factor = ("mm", 1e3) if remark.name == "translations" else ("mrad", 1e3)
    return (
        f"Residuals of the {remark.name} are {remark.needed / remark.stated:.3g} times the stated standard deviation "
        f"of {factor * remark.stated:.3g} {unit}: {factor * remark.needed:.3g} {unit} would agree with them. All "
        f"intervals include a second component of {factor * remark.extra:.3g} {unit} (repeatability, or missing "
        "physics)."
    )


@sentence.register
def _generous(remark: GenerousNoise) -> str:
    unit, factor = ("mm", 1e3) if remark.name == "translations" else ("mrad", 1e3)
    return (
        f"The stated standard deviation of the {remark.name}, {factor * remark.stated:.3g} {unit}, is far too large: "
        f"{factor * remark.needed:.3g} {unit} from the residuals replaces it."
    )


@sentence.register
def _aliased(remark: AliasedParameters) -> str:
    listed = ", ".join(remark.names[:_MOST_NAMES]) + (" and others" if len(remark.names) > _MOST_NAMES else "")
    return (
        f"{len(remark.names)} parameters are confounded with others and keep their assumed values and tolerances: "
        f"{listed}. Only their combination is determined, single values are not."
    )


@sentence.register
def _without_moment(remark: WithoutMoment) -> str:
    listed = ["(" + ", ".join(f"{x:.4f}" for x in direction) + ")" for direction in remark.directions]
    return (
        f"No load has a moment about {' and '.join(listed)}: moments of a weight have none along gravity. Elements of "
        "a compliance that only such a moment distinguishes are not determined, however small the noise."
    )


@sentence.register
def _extrapolation(remark: Extrapolation) -> str:
    return (
        f"Held-out rows depend on parameters that the fitted rows do not determine: their error is "
        f"{remark.held_out:.3g} standard deviations, that of fitted rows {remark.fitted:.3g}."
    )


@sentence.register
def _correlation(remark: SerialCorrelation) -> str:
    return (
        f"Residuals of consecutive rows are correlated ({remark.correlation:.2f}): {remark.rows} rows are worth about "
        f"{remark.effective_rows:.0f} independent ones. All intervals allow for this."
    )


@sentence.register
def _confounded_time(remark: ConfoundedTime) -> str:
    text = (
        f"Time is confounded with {remark.name}, which explains {remark.share:.0%} of its variance (variance "
        f"inflation factor {1.0 / max(1.0 - remark.share, 1e-9):.3g}). "
    )
    if not remark.imitations:
        return text + f"The named drift also shows among rows with the same {remark.name}."
    listed = words.listed(tuple(f"`{key}`" for key in remark.imitations))
    return text + (
        f"{listed} would describe all rows, but not those with the same {remark.name}, and is not named. Record rows "
        f"in random order of {remark.name}, or a second visit, to show a drift."
    )


@sentence.register
def _too_few(remark: TooFewForLaws) -> str:
    return f"Laws at ports were not considered: they need {remark.needed} fitted rows, and there are {remark.rows}."


@sentence.register
def _not_sought(remark: NotSought) -> str:
    return _NOT_SOUGHT[remark.law]


@sentence.register
def _averaged(remark: Averaged) -> str:
    named = ", ".join(f"`{effect}`" for effect in remark.effects[:_MOST_NAMES])
    more = len(remark.effects) - _MOST_NAMES
    return (
        f"{remark.rows} rows are too few to rule out small effects. Predictions are the average over what may be "
        f"there, weighted by evidence: {named}{f' and {more} others' if more > 0 else ''}. Record more poses to decide."
    )
