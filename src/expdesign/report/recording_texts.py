"""Sentences about tables of recordings: registered, freed of thermal deflection, simulated and predicted."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.models.estimable import OutsideRange
from expdesign.counted import counted
from expdesign.estimation.preparation.registered_deflections import RegisteredDeflection
from expdesign.estimation.preparation.thermal_correction import CorrectedDeflections, Repeatability
from expdesign.io.output import plain
from expdesign.report import words
from expdesign.report.said import REFUTED, Said

MOST_LINES = 20
"""Rows of which `predict` says what is beyond what was calibrated."""


def registered(
    rows: int,
    found: Sequence[RegisteredDeflection],
    covariance: FloatArray,
    estimated: float | None,
    suspicions: Sequence[str],
    unmeasured: Sequence[int],
) -> Said:
    """What `register` says; see `RegistrationResult`."""
    summary = f"{counted(rows, 'row')} registered"
    lines = [summary]
    if estimated is not None:
        size = words.size(estimated, "m")
        lines.append(f"standard deviation of a coordinate, estimated from the residuals: {size}")
    fits = {one.markers for one in found if one.markers is not None}
    if fits:
        rms, worst = np.sqrt(np.mean([fit.rms**2 for fit in fits])), max(fits, key=lambda fit: fit.size)
        lines.append(
            f"points fit the robot's `markers` to {words.size(float(rms), 'm')} (RMS); the worst, {worst.worst}, is "
            f"{words.size(worst.size, 'm')} off"
        )
    notes = [f"warning: {text}" for text in suspicions]
    if unmeasured:
        notes.append(f"no points for row {', '.join(map(str, unmeasured))} of the plan: left out")
    record = {
        "covariance": covariance,
        "estimated_deviation_m": estimated,
        "residual_rms_m": [np.sqrt((one.residuals**2).mean()) for one in found],
        "points": [one.points for one in found],
        "suspicions": suspicions,
    }
    return Said(summary, lines, notes, lambda: plain(record))


def corrected(
    counts: tuple[int, int],
    deflections: CorrectedDeflections,
    repeated: Repeatability | None,
    residuals: tuple[FloatArray, FloatArray] | None,
    axes: Sequence[str],
    unidentified: str = "",
) -> Said:
    """What `correct` says: scatter and residuals before and after, with the noise of each; see `CorrectionResult`.

    Args:
        counts: of recordings, and of poses.
        deflections: corrected.
        repeated: scatter of repeated poses, or None.
        residuals: RMS residual of the identified base model per axis before and after, or None.
        axes: names of the axes.
        unidentified: why there are no residuals.
    """
    noises = [_mean_deviation(noise) for noise in (deflections.noise_before, deflections.covariance)]
    record: dict[str, Any] = {"axes": axes, "deflections": counts[0]}
    units = [f"{name} (µ{name.rsplit('_', 1)[1]})" for name in axes]
    lines = [f"per axis: {', '.join(units)}"]
    if repeated is None:
        lines.append("no pose was measured twice at the same command and load: there is no scatter to compare")
    else:
        scatter = "RMS scatter of repeated poses"
        lines.append(f"{scatter} before {_micro(repeated.before)}, noise alone {_micro(repeated.noise_before)}")
        lines.append(f"{scatter} after  {_micro(repeated.after)}, noise alone {_micro(repeated.noise_after)}")
        record["repeated_poses"] = {
            "groups": repeated.groups, "degrees_of_freedom": repeated.freedom, "rms_before": repeated.before,
            "rms_after": repeated.after, "noise_before": repeated.noise_before, "noise_after": repeated.noise_after,
        }  # fmt: skip
    if counts[0]:
        record["deflection_noise"] = dict(zip(("before", "after"), noises, strict=True))
        record["covariance"] = deflections.covariance
    if residuals is not None:
        for when, values, noise in zip(("before", "after "), residuals, noises, strict=True):
            residual = f"RMS residual of identification {when} {_micro(values)}"
            lines.append(f"{residual}, noise of a deflection {_micro(noise)}")
        record["residuals_of_identification"] = dict(zip(("rms_before", "rms_after"), residuals, strict=True))
    elif unidentified:
        lines.append(f"no residuals of identification: {unidentified}")
    summary = f"{counted(counts[0], 'recording')} of {counted(counts[1], 'pose')}"
    return Said(summary, lines, document=lambda: plain(record))


def simulated(rows: int, seed: int, *, noise: bool) -> Said:
    """What `simulate` says: how many rows there are, and of which seed."""
    summary = f"{counted(rows, 'row')} simulated"
    return Said(summary, [], [f"{summary} (seed {seed}{'' if noise else ', no noise'})"])


def predicted(
    rows: int,
    extrapolated: Mapping[int, tuple[OutsideRange, ...]],
    birge_ratio: float,
    *,
    readings: bool,
    refuted: bool,
) -> Said:
    """What `predict` says: how many points there are, and what their standard deviations contain.

    Args:
        rows: points.
        extrapolated: what is outside of what was calibrated, by the row of the file.
        birge_ratio: by which standard deviations are widened.
        readings: whether they are of readings, else of the model alone.
        refuted: whether the recordings of the model refute it.
    """
    summary = f"{counted(rows, 'point')} predicted"
    summary += f", {len(extrapolated)} of them beyond what was calibrated" if extrapolated else ""
    ratio = "" if birge_ratio == 1.0 else f", multiplied by {birge_ratio:.3g} as its residuals ask for"
    contains = f"standard deviations are of the model{ratio}; argument `readings` adds the noise of a reading"
    if readings:
        contains = f"standard deviations are of readings: those of the model{ratio}, and the noise of a reading"
    beyond = [f"row {line}: {'; '.join(map(str, extrapolated[line]))}" for line in sorted(extrapolated)]
    more = [f"(and {len(beyond) - MOST_LINES} more rows)"] if len(beyond) > MOST_LINES else []
    notes = [f"{summary}; {contains}", *beyond[:MOST_LINES], *more, *([REFUTED] if refuted else [])]
    return Said(summary, [], notes)


def _mean_deviation(covariance: FloatArray | None) -> FloatArray | None:
    if covariance is None or not len(covariance):
        return None
    deviations: FloatArray = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2).mean(axis=0))
    return deviations


def _micro(values: FloatArray | None) -> str:
    return "not stated" if values is None else "[" + ", ".join(f"{1e6 * value:.3g}" for value in values) + "]"
