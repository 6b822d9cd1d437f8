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
    Sought.TIME: "No law of time and no creep was sought: the recordings have no column `time_s`.",
    Sought.MEMORY: "Nothing that remembers a load was sought: no series has two rows in a stated order.",
    Sought.PLACE: "No law of place was sought: all rows are at one pose.",
    Sought.FORCE: "No law of force was sought: all rows carry the same load.",
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
    text = f"The compliance of {remark.actuator} comes out negative"
    if remark.certain:
        return text + ": a deflection of the wrong sign, a wrong load or joint, or physics that the model leaves out?"
    return text + " but may be positive within its uncertainty: the actuator is hardly loaded."


@sentence.register
def _idle(remark: IdleActuators) -> str:
    whose = "its stiffness stays" if len(remark.actuators) == 1 else "their stiffnesses stay"
    return (
        f"No fitted row shows how {words.listed(remark.actuators)} yields, as weights do not for a joint about the "
        f"vertical, nor positions of a tip on the joint's axis: {whose} what the robot file says, taken as known to "
        f"{remark.deviation:.0%} (other loads or axes would tell)."
    )


@sentence.register
def _large_geometry(remark: LargeGeometricErrors) -> str:
    return (
        f"Joints and lengths come out {1e3 * remark.size:.3g} mm (RMS) off: are the measured poses in another frame "
        "than the commands? (`--frames unknown` identifies the frames as well.)"
    )


@sentence.register
def _aliased_geometry(remark: AliasedGeometry) -> str:
    return (
        f"{remark.count} of {remark.total} geometric parameters are not determined one by one, only combinations of "
        "them are: their intervals are those of the prior, those of predicted poses are not."
    )


@sentence.register
def _held_marker(remark: HeldMarker) -> str:
    along = f" along {' and '.join(remark.axes)} of the tip"
    place = f"its place{'' if len(remark.axes) == 3 else along}"
    return (
        f"In the fitted rows the tip keeps one orientation, as far as marker `{remark.marker}` is concerned: {place} "
        "is confounded with that of the instrument, and is taken to be the tip's origin. Rows in which the tip is "
        "turned otherwise cannot be predicted, and are not judged; give the marker's place in the robot file, or "
        "record more orientations."
    )


@sentence.register
def _blind(remark: BlindPoses) -> str:
    listed = words.listed(remark.names[:_MOST_NAMES]) + (" and others" if len(remark.names) > _MOST_NAMES else "")
    return (
        f"The fitted poses do not show {listed}, which poses with all joints moving would: what they leave blind stays "
        "as drawn."
    )


@sentence.register
def _beyond(remark: NoiseBeyondStated) -> str:
    unit, factor = ("mm", 1e3) if remark.name == "translations" else ("mrad", 1e3)
    return (
        f"Residuals of the {remark.name} are {remark.needed / remark.stated:.3g} times the stated standard deviation "
        f"of {factor * remark.stated:.3g} {unit}: it would have to be {factor * remark.needed:.3g} {unit}. A second "
        f"component of {factor * remark.extra:.3g} {unit} (repeatability, or physics left out) is in all intervals."
    )


@sentence.register
def _generous(remark: GenerousNoise) -> str:
    unit, factor = ("mm", 1e3) if remark.name == "translations" else ("mrad", 1e3)
    return (
        f"The stated standard deviation of the {remark.name}, {factor * remark.stated:.3g} {unit}, is far too large: "
        f"the residuals show {factor * remark.needed:.3g} {unit}, which was used."
    )


@sentence.register
def _aliased(remark: AliasedParameters) -> str:
    listed = ", ".join(remark.names[:_MOST_NAMES]) + (" and others" if len(remark.names) > _MOST_NAMES else "")
    return (
        f"{len(remark.names)} parameters are aliased with combinations of others and stay what was assumed, within "
        f"the tolerance assumed for them: {listed}. Single values among them mean nothing; their sum does."
    )


@sentence.register
def _without_moment(remark: WithoutMoment) -> str:
    listed = ["(" + ", ".join(f"{x:.4f}" for x in direction) + ")" for direction in remark.directions]
    return (
        f"No load has a moment about {' and '.join(listed)}, as moments of a weight have none along gravity: elements "
        "of a compliance that only such a moment distinguishes are not determined, however small the noise."
    )


@sentence.register
def _extrapolation(remark: Extrapolation) -> str:
    return (
        f"The fitted rows do not determine what the held-out rows depend on: {remark.held_out:.3g} standard "
        f"deviations there against {remark.fitted:.3g}."
    )


@sentence.register
def _correlation(remark: SerialCorrelation) -> str:
    return (
        f"Residuals of consecutive rows are alike (correlation {remark.correlation:.2f}): {remark.rows} rows say as "
        f"much as about {remark.effective_rows:.0f} independent ones; intervals allow for it."
    )


@sentence.register
def _confounded_time(remark: ConfoundedTime) -> str:
    text = (
        f"Time is confounded with {remark.name}: {remark.share:.0%} of its variance follows from it (variance "
        f"inflation factor {1.0 / max(1.0 - remark.share, 1e-9):.3g}). "
    )
    if not remark.imitations:
        return text + f"The drift that is named shows among rows that are alike in {remark.name} as well."
    listed = words.listed(tuple(f"`{key}`" for key in remark.imitations))
    return text + (
        f"{listed} would describe the rows, but not those that are alike in {remark.name}, and is not named; rows in "
        f"random order of {remark.name}, or a second visit, would show a drift."
    )


@sentence.register
def _too_few(remark: TooFewForLaws) -> str:
    return f"No law at a port was sought: {remark.rows} rows may be fitted, and it takes {remark.needed}."


@sentence.register
def _not_sought(remark: NotSought) -> str:
    return _NOT_SOUGHT[remark.law]


@sentence.register
def _averaged(remark: Averaged) -> str:
    named = ", ".join(f"`{effect}`" for effect in remark.effects[:_MOST_NAMES])
    more = len(remark.effects) - _MOST_NAMES
    return (
        f"{remark.rows} rows cannot tell what else may be there: the model predicts the average over it by its "
        f"evidence, with {named}{f' and {more} others' if more > 0 else ''} at a share of their size. Record more "
        "poses to decide."
    )
