"""Tables of recordings, and what is said of them: registered, freed of thermal deflection, simulated, predicted."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.models.estimable import OutsideRange
from expdesign.counted import counted
from expdesign.estimation.compensation.prediction import Prediction
from expdesign.estimation.preparation.registered_deflections import RegisteredDeflection
from expdesign.estimation.preparation.thermal_correction import CorrectedDeflections, Repeatability
from expdesign.io.output import plain
from expdesign.report import words
from expdesign.report.result import RecordedTable, TableResult
from expdesign.report.said import REFUTED, Said

_MOST_LINES = 20
"""Rows of which `predict` says what is beyond what was calibrated."""


@dataclass(frozen=True, repr=False)
class RegistrationResult(RecordedTable):
    """Recordings from points.

    Attributes:
        text: recordings (file-formats.md, Recordings), as they stand in a file: deflections, with the unloaded set of
            each row as its `reference`, or positions of markers.
        found: what registration found for every deflection, in the order of the rows; empty for positions.
        covariance: of the deflections (m², m·rad, rad²), shape (N, 6, 6); N = 0 for positions.
        estimated: standard deviation of one coordinate of a point (m), estimated from the residuals, or None where the
            lists or the caller state it.
        suspicions: points that moved differently from the others, in words.
        unmeasured: sequence numbers of loaded rows for which there are no points.
    """

    found: tuple[RegisteredDeflection, ...]
    covariance: FloatArray
    estimated: float | None
    suspicions: tuple[str, ...]
    unmeasured: tuple[int, ...] = ()

    @property
    def said(self) -> Said:
        summary = f"{counted(len(self.text), 'row')} registered"
        lines = [summary]
        if self.estimated is not None:
            size = words.size(self.estimated, "m")
            lines.append(f"standard deviation of a coordinate, estimated from the residuals: {size}")
        fits = {one.markers for one in self.found if one.markers is not None}
        if fits:
            rms, worst = np.sqrt(np.mean([fit.rms**2 for fit in fits])), max(fits, key=lambda fit: fit.size)
            lines.append(
                f"points fit the robot's `markers` to {words.size(float(rms), 'm')} (RMS); the worst, {worst.worst}, "
                f"is {words.size(worst.size, 'm')} off"
            )
        notes = [f"warning: {text}" for text in self.suspicions]
        if self.unmeasured:
            notes.append(f"no points for row {', '.join(map(str, self.unmeasured))} of the plan: left out")
        record = {
            "covariance": self.covariance,
            "estimated_deviation_m": self.estimated,
            "residual_rms_m": [np.sqrt((one.residuals**2).mean()) for one in self.found],
            "points": [one.points for one in self.found],
            "suspicions": self.suspicions,
        }
        return Said(summary, lines, notes, lambda: plain(record))


@dataclass(frozen=True, repr=False)
class CorrectionResult(RecordedTable):
    """What the correction made.

    Attributes:
        text: recordings (file-formats.md, Recordings), as they stand in a file; empty where no row has a load.
        poses: every measured pose with its corrected one in `corrected_x_m …`, as it stands in a file.
        deflections: the same as arrays.
        repeatability: scatter of repeated poses, or None.
        residuals: RMS residual of the identified base model per axis (m, rad) before and after, or None.
        axes: names of the axes.
        unidentified: why there are no `residuals`, where deflections are.
    """

    poses: pd.DataFrame
    deflections: CorrectedDeflections
    repeatability: Repeatability | None
    residuals: tuple[FloatArray, FloatArray] | None
    axes: tuple[str, ...]
    unidentified: str = ""

    def as_table(self) -> pd.DataFrame:
        """The recordings, or the corrected poses where nothing has a load."""
        return self.text if len(self.text) else self.poses

    @property
    def said(self) -> Said:
        found, repeated, count = self.deflections, self.repeatability, len(self.text)
        noises = [_mean_deviation(noise) for noise in (found.noise_before, found.covariance)]
        record: dict[str, Any] = {"axes": self.axes, "deflections": count}
        units = [f"{name} (µ{name.rsplit('_', 1)[1]})" for name in self.axes]
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
        if count:
            record["deflection_noise"] = dict(zip(("before", "after"), noises, strict=True))
            record["covariance"] = found.covariance
        if self.residuals is not None:
            for when, values, noise in zip(("before", "after "), self.residuals, noises, strict=True):
                residual = f"RMS residual of identification {when} {_micro(values)}"
                lines.append(f"{residual}, noise of a deflection {_micro(noise)}")
            rms = zip(("rms_before", "rms_after"), self.residuals, strict=True)
            record["residuals_of_identification"] = dict(rms)
        elif self.unidentified:
            lines.append(f"no residuals of identification: {self.unidentified}")
        summary = f"{counted(count, 'recording')} of {counted(len(self.poses), 'pose')}"
        return Said(summary, lines, document=lambda: plain(record))


@dataclass(frozen=True, repr=False)
class SimulationResult(TableResult):
    """Recordings that were not measured.

    Attributes:
        text: the rows as they stand in a file.
        seed: seed of the noise and the load errors.
        noise: whether there is noise.
    """

    seed: int
    noise: bool

    @property
    def said(self) -> Said:
        summary = f"{counted(len(self.text), 'row')} simulated"
        return Said(summary, [], [f"{summary} (seed {self.seed}{'' if self.noise else ', no noise'})"])


@dataclass(frozen=True, repr=False)
class PredictionResult(TableResult):
    """Points with their deflections.

    Attributes:
        text: the points as they stand in a file, with `dx_m …` (`measured_x_m …` of measured poses) and `sx_m …` filled
            in.
        prediction: the same as arrays, rows in the order of their sequence.
        birge_ratio: by which the standard deviations are widened, because the recordings of the model ask for it.
        readings: whether they are of readings (else of the model alone).
        extrapolated: commands and loads outside of those of the model's recordings, by the row of the file.
        refuted: whether the recordings of the model refute it.
    """

    prediction: Prediction
    birge_ratio: float = 1.0
    readings: bool = False
    extrapolated: Mapping[int, tuple[OutsideRange, ...]] = field(default_factory=dict)
    refuted: bool = False

    @property
    def beyond(self) -> int:
        """Rows at which the model extrapolates."""
        return len(self.extrapolated)

    @property
    def said(self) -> Said:
        summary = f"{counted(len(self.text), 'point')} predicted"
        summary += f", {self.beyond} of them beyond what was calibrated" if self.extrapolated else ""
        ratio = "" if self.birge_ratio == 1.0 else f", multiplied by {self.birge_ratio:.3g} as its residuals ask for"
        contains = f"standard deviations are of the model{ratio}; argument `readings` adds the noise of a reading"
        if self.readings:
            contains = f"standard deviations are of readings: those of the model{ratio}, and the noise of a reading"
        beyond = [f"row {line}: {'; '.join(map(str, row))}" for line, row in sorted(self.extrapolated.items())]
        more = [f"(and {len(beyond) - _MOST_LINES} more rows)"] if len(beyond) > _MOST_LINES else []
        refuted = [REFUTED] if self.refuted else []
        return Said(summary, [], [f"{summary}; {contains}", *beyond[:_MOST_LINES], *more, *refuted])


def _mean_deviation(covariance: FloatArray | None) -> FloatArray | None:
    if covariance is None or not len(covariance):
        return None
    deviations: FloatArray = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2).mean(axis=0))
    return deviations


def _micro(values: FloatArray | None) -> str:
    return "not stated" if values is None else "[" + ", ".join(f"{1e6 * value:.3g}" for value in values) + "]"
