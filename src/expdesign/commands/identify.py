"""`expdesign identify`: stiffness with confidence intervals, from recordings."""

from pathlib import Path
from typing import Annotated, cast

import numpy as np
import typer

import expdesign as xd
from expdesign.acceptance.decision import sentences
from expdesign.api.identify import Frames, recordings_of, require_prior
from expdesign.api.inputs import robot_of
from expdesign.commands.console import counted, note, note_unknown_columns
from expdesign.files.output import require_writable
from expdesign.identification.geometric import Calibration
from expdesign.identification.goodness import REFUTED
from expdesign.identification.identify import Identification
from expdesign.report.identification_record import rms, stiffness_unit
from expdesign.report.remark_texts import sentence


def command(
    robot: Annotated[Path, typer.Argument(help="Robot (YAML).")],
    recordings: Annotated[list[Path], typer.Argument(help="Recordings (CSV), in one or more files.")],
    out: Annotated[Path, typer.Option(help="Folder for the results.")],
    shared_reference: Annotated[
        bool,
        typer.Option("--shared-reference", help="Half of each row's variance is common to its series."),
    ] = False,
    prior: Annotated[
        float | None, typer.Option(help="Prior relative standard deviation of `actuator_stiffness`, in percent.")
    ] = None,
    targets: Annotated[
        Path | None, typer.Option(help="Run configuration (YAML) at whose targets the robot is accepted or not.")
    ] = None,
    calibration: Annotated[
        str | None,
        typer.Option(help="elastostatic, geometric or both. Default: what the columns of the recordings say."),
    ] = None,
    frames: Annotated[
        str, typer.Option(help="known, or unknown: frames of measured poses are identified as well.")
    ] = "known",
) -> None:
    """Identify the stiffness of every actuator, the geometry of a robot on legs, or both from recordings.

    Example: expdesign identify configs/robots/hexapod-h1.yaml recordings.csv --out results/mine
    """
    require_prior(prior)
    require_writable(out)
    machine = robot_of(robot)
    measured = recordings_of(recordings, machine)
    note_unknown_columns(measured)
    chosen = cast("Calibration | None", calibration)
    identified = xd.identify(
        machine,
        measured,
        shared_reference=shared_reference,
        prior=prior,
        targets=targets,
        calibration=chosen,
        frames=cast("Frames", frames),
    )
    page = identified.save(out)
    _summarise(identified.result)
    for text in sentences(identified.acceptance) if identified.acceptance is not None else []:
        note(text)
    if identified.accuracy is not None:
        note(identified.accuracy.sentence)
    print(page)


def _summarise(result: Identification) -> None:
    unit = stiffness_unit(result)
    if result.geometry is not None:
        deviation = (result.geometry.high - result.geometry.low) / 4.0
        size = float(np.sqrt((result.geometry.estimate**2).mean()))
        known = f"known to {1e3 * float(np.median(deviation)):.3g} mm (median)"
        note(f"{len(deviation)} errors of joints and lengths: {1e3 * size:.3g} mm RMS, {known}")
    for index, name in enumerate(() if result.calibration == "geometric" else result.robot.actuators):
        interval = result.stiffness
        note(f"{name}: {interval.estimate[index]:.4g} {unit} ({_interval(interval.low[index], interval.high[index])})")
    if not result.robot.actuators:
        note(f"a {result.robot.kind} has no actuators whose stiffness could be identified: does it deflect at all?")
    goodness = result.goodness
    if goodness.p_value is not None:
        verdict = (
            "" if goodness.p_value >= REFUTED else "; the base model does not explain them, see `expdesign diagnose`"
        )
        dof = f"{goodness.dof} degrees of freedom"
        note(f"chi2 {result.fit.chi2:.6g} for {dof}, p = {goodness.p_value:.3g}{verdict}")
        if goodness.birge_ratio > 1.0:
            note(f"intervals and predicted deviations are widened by the Birge ratio {goodness.birge_ratio:.3g}")
    else:
        for group in result.noise.groups:
            note(f"noise of the {group.name}, estimated from {result.noise.origin}: {group.deviation:.3g}")
    if goodness.lack_of_fit is not None:
        note(f"lack of fit against replicates: p = {goodness.lack_of_fit.p_value:.3g}")
    outliers = int(result.influence.outlier.sum())
    if outliers:
        note(f"{counted(outliers, 'row')} that may be outliers; see the report")
    held_out = rms(result.test_residuals)
    if held_out is not None:
        note(f"RMS of the test rows: {held_out:.3g} standard deviations")
    for remark in result.suspicions:
        note(f"suspicion: {sentence(remark)}")


def _interval(low: float, high: float) -> str:
    if np.isfinite(low) and np.isfinite(high):
        return f"95 %: {low:.4g} to {high:.4g}"
    if np.isfinite(low):
        return f"95 %: at least {low:.4g}"
    return "without an interval: its compliance may be 0, or is negative"
