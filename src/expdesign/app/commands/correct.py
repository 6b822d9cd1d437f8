"""`expdesign correct`: recordings from measured poses, freed of thermal deflection by reference poses."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.writing import Force, RobotPath, require_file
from expdesign.arrays import FloatArray

GROUP = ("data", 2)
"""Where it stands in the list of commands."""


def command(
    robot: RobotPath,
    poses: Annotated[Path, typer.Argument(help="Measured poses (CSV) with a column `kind`: reference or pose.")],
    out: Annotated[Path, typer.Option(help="File for the recordings, or for the poses where none has a load.")],
    interpolate: Annotated[
        bool, typer.Option("--interpolate", help="Between the references before and after each pose.")
    ] = False,
    record: Annotated[
        Path | None, typer.Option(help="JSON file for RMS, expected noise and the covariance of every row.")
    ] = None,
    force: Force = False,
) -> None:
    """Free measured poses of thermal deflection by the reference pose that was measured before each of them.

    Example: expdesign correct configs/robots/hexapod-h1.yaml poses.csv --out recordings.csv
    """
    purpose = purpose_of("correct", robot, poses)
    require_file(out, purpose, force=force)
    require_file(record, purpose, force=force)
    result = xd.correct(robot, poses, interpolate=interpolate)
    result.save(out, force=force)
    if record is not None:
        result.save_record(record, force=force)
    units = [f"{name} (µ{name.rsplit('_', 1)[1]})" for name in result.axes]
    print(f"per axis: {', '.join(units)}")
    here = result.repeatability
    if here is None:
        print("no pose was measured twice at the same command and load: there is no scatter to compare")
    else:
        print(f"RMS scatter of repeated poses before {_micro(here.before)}, noise alone {_micro(here.noise_before)}")
        print(f"RMS scatter of repeated poses after  {_micro(here.after)}, noise alone {_micro(here.noise_after)}")
    if result.residuals is not None:
        before, after = result.residuals
        noise = (_mean(result.deflections.noise_before), _mean(result.deflections.covariance))
        print(f"RMS residual of identification before {_micro(before)}, noise of a deflection {_micro(noise[0])}")
        print(f"RMS residual of identification after  {_micro(after)}, noise of a deflection {_micro(noise[1])}")
    print(out)


def _mean(covariance: FloatArray | None) -> FloatArray | None:
    if covariance is None:
        return None
    deviations: FloatArray = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2).mean(axis=0))
    return deviations


def _micro(values: FloatArray | None) -> str:
    return "not stated" if values is None else "[" + ", ".join(f"{1e6 * value:.3g}" for value in values) + "]"
