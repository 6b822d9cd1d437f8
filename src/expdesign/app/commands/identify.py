"""`expdesign identify`: stiffness with confidence intervals, from recordings."""

from pathlib import Path
from typing import Annotated, cast

import numpy as np
import typer

import expdesign as xd
from expdesign.app.api.identify import Frames, recordings_of, require_prior
from expdesign.app.api.inputs import purpose_of, robot_of
from expdesign.app.commands.console import note, note_unknown_columns
from expdesign.app.commands.writing import Folder, Force, OtherRobot, RobotPath, SharedReference, require_folder
from expdesign.assurance.acceptance.decision import sentences
from expdesign.estimation.arm_options import Further, Loss
from expdesign.estimation.identify import Identification
from expdesign.estimation.remarks import Implausible
from expdesign.mechanics.elastostatics.calibration import Calibration
from expdesign.report.arm_section import accuracy_lines, further_lines, geometry_line
from expdesign.report.check_texts import coverage_sentence, fit_sentences
from expdesign.report.identification_record import rms, stiffness_unit
from expdesign.report.remark_texts import sentence

GROUP = ("way", 5)
"""Where it stands in the list of commands."""


def command(
    robot: RobotPath,
    recordings: Annotated[list[Path], typer.Argument(help="Recordings (CSV), in one or more files.")],
    out: Folder,
    shared_reference: SharedReference = None,
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
    other_robot: OtherRobot = False,
    force: Force = False,
    loss: Annotated[
        str, typer.Option(help="Of large residuals of an arm's positions: squares, huber or student.")
    ] = "squares",
    further: Annotated[
        list[str] | None,
        typer.Option(help="Also identified of an arm from positions: masses, tool, harmonics or drift; repeatable."),
    ] = None,
) -> None:
    """Identify the stiffness of every actuator, the geometry, or both from recordings.

    Example: expdesign identify configs/robots/hexapod-h1.yaml recordings.csv --out results/mine
    """
    require_prior(prior)
    require_folder(out, xd.IdentificationResult, purpose_of("identify", robot, recordings), force=force)
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
        other_robot=other_robot,
        loss=cast("Loss", loss),
        further=cast("list[Further]", further or []),
    )
    page = identified.save(out, force=force)
    _summarise(identified.result)
    for text in sentences(identified.acceptance) if identified.acceptance is not None else []:
        print(text)
    if identified.accuracy is not None:
        print(identified.accuracy.sentence)
    print(page)


def _summarise(result: Identification) -> None:
    unit = stiffness_unit(result)
    _geometry(result)
    for index, name in enumerate(() if result.calibration == "geometric" else result.robot.actuators):
        interval = result.stiffness
        print(f"{name}: {interval.estimate[index]:.4g} {unit} ({_interval(interval.low[index], interval.high[index])})")
    if not result.robot.actuators:
        print(f"a {result.robot.kind} has no actuators whose stiffness could be identified: does it deflect at all?")
    for text in fit_sentences(result):
        print(text)
    for group in result.noise.groups:
        print(f"noise of the {group.name}, estimated from {result.noise.origin}: {group.deviation:.3g}")
    held_out = rms(result.test_residuals)
    if held_out is not None:
        print(f"RMS of the test rows: {held_out:.3g} standard deviations")
        print(coverage_sentence(result.coverage))
    for remark in result.suspicions:
        if not isinstance(remark, Implausible):  # which is said where the recordings are read
            note(f"warning: {sentence(remark)}")


def _geometry(result: Identification) -> None:
    if result.arm is not None:
        for text in [*filter(None, [geometry_line(result)]), *further_lines(result.arm), *accuracy_lines(result.arm)]:
            print(text)
    elif result.geometry is not None:
        deviation = (result.geometry.high - result.geometry.low) / 4.0
        size = float(np.sqrt((result.geometry.estimate**2).mean()))
        known = f"known to {1e3 * float(np.median(deviation)):.3g} mm (median)"
        print(f"{len(deviation)} errors of joints and lengths: {1e3 * size:.3g} mm RMS, {known}")


def _interval(low: float, high: float) -> str:
    if np.isfinite(low) and np.isfinite(high):
        return f"95 %: {low:.4g} to {high:.4g}"
    if np.isfinite(low):
        return f"95 %: at least {low:.4g}"
    return "without an interval: its compliance may be 0, or is negative"
