"""Recordings: would another unit, sign, order or frame make them fit, or do the numbers give a mistake away?

The base model is fitted to the recordings as they are and as they would be read under every alternative that a kind of
mistake proposes (`mistakes`). With n readings more than compliances, the noise unknown, the logarithm of the ratio of
likelihoods of two readings is n/2·ln(misfit/misfit'). An alternative is named where that exceeds the logarithm of the
number of alternatives times the odds against a mistake, its misfit is a tenth, and no compliance comes out negative; or
where noise is stated, the recordings as they are are refuted and the alternative's are not; or where nearly all
compliances come out negative, and positive under it. Physics that the base model lacks is reduced by none so far.
"""

from typing import NamedTuple

import numpy as np

from expdesign.assurance.plausibility.commanded import commanded_findings
from expdesign.assurance.plausibility.evidence import (
    CONSISTENT,
    FAIR,
    GAIN,
    MOST,
    ODDS,
    REFUTED,
    Alternative,
    Evidence,
    Fitted,
    evidence_of,
)
from expdesign.assurance.plausibility.finding import Implausibility, extent, say
from expdesign.assurance.plausibility.instrument import instrument_findings
from expdesign.assurance.plausibility.interpretations import unexplained
from expdesign.assurance.plausibility.mistakes import ALTERNATIVES, FINDINGS
from expdesign.assurance.plausibility.positions import positions_findings
from expdesign.chain.recordings.recordings import POSES, POSITIONS, Recordings
from expdesign.estimation.arm import ArmCalibration
from expdesign.estimation.left_over import LeftOver
from expdesign.estimation.remarks import Implausible
from expdesign.mechanics.robots.robot import Robot

_POOR = 1e-3
"""Misfit below which nothing needs an explanation by a mistake where noise is not stated."""
_SPARE = 4
"""Readings beyond the compliances that a judgement takes at least."""


def recordings_findings(recordings: Recordings, robot: Robot, gain: float = GAIN) -> list[Implausibility]:
    """What speaks against units, signs, frames and single numbers of recordings.

    Args:
        recordings: that were read.
        robot: of which they are.
        gain: factor by which an alternative must reduce the misfit.
    """
    if recordings.measurand is POSITIONS:
        return positions_findings(recordings, robot)
    if recordings.measurand is POSES:
        names = recordings.components(robot.coordinates)
        commands = recordings.configurations[:, recordings.axes]
        measured = [names[axis] for axis in recordings.axes]
        return commanded_findings(commands, recordings.deflections, measured, recordings.lines)
    if not robot.actuated:
        return []
    evidence = evidence_of(recordings, robot)
    rows = evidence.recordings
    enough = rows.deflections.size >= len(robot.stiffness) + _SPARE and len(rows) >= 2
    if not enough or not np.any(rows.wrenches) or evidence.fits[-1] is None:
        return []
    named = _out_of_reach(evidence, gain) or _named(evidence, gain)
    own = (finding for findings in FINDINGS for finding in findings(evidence))
    return [*named, *(finding for finding in own if not named or finding.where)]


def doubts(
    recordings: Recordings, robot: Robot, left: LeftOver | None, arm: ArmCalibration | None
) -> tuple[Implausible, ...]:
    """What physics holds against recordings, and against what a fit leaves of them, as remarks.

    What the recordings show by themselves has been said where they were read; what the fit shows is logged here. A fit
    that leaves what no model of the right machine leaves is named with the interpretations that were tried.

    Args:
        recordings: that were fitted.
        robot: of which they are.
        left: what the fit leaves of the readings, where that is known.
        arm: the calibration of an arm's geometry, where there is one.
    """
    found, more = recordings_findings(recordings, robot), list[Implausibility]()
    if not any(finding.otherwise for finding in found):
        if left is not None and left.beyond:
            more = [unexplained(left.sentence, robot)]
        elif arm is not None:
            more = instrument_findings(arm, recordings)
    say(more, recordings.source)
    return tuple(Implausible(one.what, one.likely, one.where, one.otherwise) for one in (*found, *more))


BEYOND, FAR = 0.002, 0.02
"""Parts of a robot's size by which a recorded pose is beyond its limits, and by which it cannot have been there."""


def _out_of_reach(evidence: Evidence, gain: float) -> list[Implausibility]:
    """Recorded poses at which the limits of the robot do not let it be, where most rows are within them.

    Where most are beyond them as well, the file is another robot's, or its columns mean something else: other readings
    of these come first.
    """
    robot, poses = evidence.robot, evidence.recordings.configurations
    size = extent(robot)
    if size is None or robot.jointed:
        return []
    excess = np.asarray(robot.limit_excess(poses), dtype=float).reshape(-1)
    beyond = np.flatnonzero(excess > BEYOND * size)
    if not len(beyond):
        return []
    worst = int(np.argmax(excess))
    lines = ", ".join(str(line) for line in evidence.recordings.lines[beyond][:6]) + (", …" if len(beyond) > 6 else "")
    what = f"the robot cannot have been where row{'s' * (len(beyond) > 1)} {lines} have it: " + (
        robot.limit_message(poses[worst]).rstrip(".")
    )
    far = bool(excess[worst] > FAR * size)
    if len(beyond) <= len(poses) // 2:
        likely = "Correct the pose (has a decimal point slipped, or a sign?), or the limits in the robot file."
        return [Implausibility(what, likely, otherwise=far)]
    named = _named(evidence, gain)
    likely = (
        "Is this the file of another robot? Compare the robot file, or its limits, with the robot that was measured."
    )
    return named or [Implausibility(what, likely, otherwise=far)]


class _Suspect(NamedTuple):
    alternative: Alternative
    fitted: Fitted


def _named(evidence: Evidence, gain: float) -> list[Implausibility]:
    """The alternative that explains the recordings, where they do not fit as they are."""
    alternatives: list[Alternative] | None = None
    for place, (weighting, stated) in enumerate(zip(evidence.weightings, evidence.fits, strict=True)):
        chi_square = evidence.noise_stated and place == 0
        refuted = chi_square and stated is not None and stated.p_value < REFUTED
        if stated is None or not (stated.misfit > _POOR or not stated.positive or refuted):
            continue
        if alternatives is None:
            alternatives = [each for mistake in ALTERNATIVES for each in mistake(evidence)]
        fitted = ((each, evidence.fit(each.sample, weighting)) for each in alternatives)
        suspects = [_Suspect(each, fit) for each, fit in fitted if fit is not None and fit.positive]
        suspects = [one for one in suspects if _explains(one, stated, len(alternatives), gain, refuted=refuted)]
        if suspects:
            best, *others = _likeliest(suspects)
            what = "the recordings do not fit the robot as they are, and would fit otherwise"
            before, after = (f"{100 * each.misfit:.2g} %" for each in (stated, best.fitted))
            if chi_square:
                before, after = (f"{each.chi2:.4g}" for each in (stated, best.fitted))
                what += f" (chi2 {before} for {stated.dof} degrees of freedom, and {after} for {best.fitted.dof})"
            else:
                what += f" ({before} of the readings is left over, and {after})"
            or_else = f" Or: {others[0].alternative.sentence}" if others else ""
            return [Implausibility(what, best.alternative.sentence + or_else, best.alternative.where, otherwise=True)]
    return []


def _explains(one: _Suspect, stated: Fitted, count: int, gain: float, *, refuted: bool) -> bool:
    """Whether an alternative, of so many, explains recordings that as they are have the fit `stated`."""
    fitted, hurdle = one.fitted, np.log(ODDS * (count + one.alternative.tried))
    ratio = stated.misfit / max(fitted.misfit, 1e-300)
    likelier = 0.5 * fitted.dof * np.log(ratio) > hurdle
    better = likelier and ratio > gain and stated.misfit > _POOR
    upside_down = 1.0 - stated.share_positive >= MOST and stated.misfit < FAIR
    upright = upside_down and fitted.share_positive >= MOST and fitted.misfit <= 1.05 * stated.misfit
    return bool(better or upright or (refuted and likelier and fitted.p_value > CONSISTENT))


def _likeliest(suspects: list[_Suspect]) -> list[_Suspect]:
    """The best and those as good: of those that keep the stiffness as well, in the order of the mistakes.

    Translations in mm, in µm and rotations in thousands of rad fit alike: what keeps the stiffness is likelier.
    """
    least = min(suspects, key=lambda one: one.fitted.misfit).fitted
    slack = float(np.exp(6.0 / max(least.dof, 1)))
    equal = [one for one in suspects if one.fitted.misfit <= slack * least.misfit + 1e-20]
    changes = [round(abs(np.log10(one.fitted.ratio))) for one in equal]
    return [one for one, change in zip(equal, changes, strict=True) if change == min(changes)]
