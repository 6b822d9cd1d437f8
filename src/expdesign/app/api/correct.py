"""`correct`: recordings from absolute measured poses, freed of thermal deflection by reference poses."""

from __future__ import annotations

import numpy as np
import pandas as pd

from expdesign.app.api.arguments import named_arguments
from expdesign.app.api.inputs import RobotInput, TableInput, load_robot, purpose_of, table_of
from expdesign.app.api.points_said import say_unknown_columns
from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.commanded import commanded_findings
from expdesign.chain.recordings.columns import REFERENCE
from expdesign.chain.recordings.points import require_load
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import in_order
from expdesign.chain.recordings.references import reference_names
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.estimation.identify import identify
from expdesign.estimation.preparation.thermal_correction import (
    CorrectedDeflections,
    correct_poses,
    deflections,
    measured_poses,
    repeatability,
)
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.robots.robot import Robot
from expdesign.report.recording_texts import CorrectionResult
from expdesign.report.result import filled


@named_arguments
def correct(robot: RobotInput, poses: TableInput, *, interpolate: bool = False) -> CorrectionResult:
    """Remove thermal drift from measured poses, using the reference pose measured before each.

    Args:
        robot: robot (YAML), one on legs.
        poses: measured poses (CSV) with a column `kind`: reference or pose (docs/reference-poses.md).
        interpolate: interpolate between the references before and after each pose.

    Raises:
        InputError: a file is missing or wrong, or the robot has no legs.

    Command:
        expdesign correct configs/robots/hexapod-h1.yaml poses.csv --out recordings.csv
    """
    given = load_robot(robot).robot
    if not given.on_legs:
        what = f"`{given.name}` is a {given.kind}; the correction needs the lengths of legs"
        raise InputError(what, remedy="Use a robot on legs.")
    here, table = given.inverse_kinematics, table_of(poses, "poses")
    measured = measured_poses(table, here)
    names = here.coordinates.pose
    columns = [f"measured_{name}" for name in names]
    points = measured.points
    for mistaken in commanded_findings(points.configurations, measured.poses, columns, points.lines):
        raise InputError(mistaken.what, where=f"{table.source}, {mistaken.where}", remedy=mistaken.likely)
    say_unknown_columns(points)
    corrected = correct_poses(here, measured, interpolate=interpolate)
    found = deflections(measured, corrected)
    if len(found.index):
        require_load(table, here.coordinates)
    kept = in_order(table).rows(corrected.rows).frame
    kept = filled(kept, (f"corrected_{name}" for name in names), corrected.after)
    dropped = [*columns, *(f"corrected_{name}" for name in names), "kind"]
    text = kept.iloc[found.index].reset_index(drop=True).drop(columns=dropped)
    # Deflections of a series are counted from its one unloaded pose.
    shared = reference_names(text["series"].to_numpy(dtype=np.int64))
    residuals, unidentified = _residuals(text, here, found)
    return CorrectionResult(
        _recordings(text, here, found.after, found.covariance).assign(**{REFERENCE: shared}),
        kept,
        found,
        repeatability(measured, corrected),
        residuals,
        here.coordinates.deflection,
        unidentified,
        purpose=purpose_of("correct", robot, poses),
    )


def _recordings(text: pd.DataFrame, robot: Robot, values: FloatArray, covariance: FloatArray | None) -> pd.DataFrame:
    frame = text.drop(columns=[*robot.coordinates.deviation], errors="ignore")
    frame = filled(frame, robot.coordinates.deflection, values)
    if covariance is None:
        return frame
    return filled(frame, robot.coordinates.deviation, np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)))


def _residuals(
    text: pd.DataFrame, robot: Robot, found: CorrectedDeflections
) -> tuple[tuple[FloatArray, FloatArray] | None, str]:
    """RMS residuals of identification before and after, or None with the reason, which is empty without deflections."""
    if len(text) * robot.coordinates.n <= len(robot.stiffness):
        return None, "there are too few loaded rows" if len(text) else ""
    rms = []
    for values, covariance in ((found.before, found.noise_before), (found.after, found.covariance)):
        frame = _recordings(text, robot, values, covariance)
        recordings = recordings_from_table(table_of(frame, "poses"), robot)
        try:
            compliance = identify(robot, recordings).compliance.estimate
        except (InputError, NotIdentifiableError) as error:  # drift may exceed the deflections, or a leg have no load
            return None, error.message
        observation = observation_matrix(robot.jacobians(recordings.configurations), recordings.wrenches)
        rms.append(np.sqrt(((recordings.deflections - observation @ compliance) ** 2).mean(axis=0)))
    return (rms[0], rms[1]), ""
