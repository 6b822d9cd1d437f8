"""`predict`: deflections of an identified robot, with their standard deviations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from expdesign.app.api.arguments import named_arguments
from expdesign.app.api.inputs import TableInput, TruthInput, purpose_of, table_of, truth_of
from expdesign.app.api.points_said import say_limits, say_unknown_columns
from expdesign.arrays import BoolArray, FloatArray
from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.targets import target_findings
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.measured import TARGET
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import (
    POSITION,
    POSITION_DEVIATION,
    SPAN_DEVIATIONS,
    SPANS,
    LoadedPoints,
    measured_names,
)
from expdesign.estimation.compensation.prediction import (
    Prediction,
    in_file_order,
    require_history,
    require_regular_points,
)
from expdesign.estimation.compensation.prediction import predict as predict_points
from expdesign.estimation.compensation.target_loads import loads_of_targets
from expdesign.io.table import Table
from expdesign.mechanics.robots.robot import Robot
from expdesign.report.recording_texts import PredictionResult


@named_arguments
def predict(
    model: TruthInput, points: TableInput, *, platform: bool = False, readings: bool = False
) -> PredictionResult:
    """Predict deflections at points in recordings form.

    At targets and commands (columns `target_x_m` or `same_as`) errors of the load act as for `compensate`.

    Args:
        model: identified model, or a robot file (YAML) whose stiffness is then taken as exact.
        points: points (CSV) in recordings form without the measured columns.
        platform: predict the motion of the platform, not what the instrument reads.
        readings: add the noise of a reading to the standard deviations, as in the model's recordings (or, if the model
            does not state it, as in the points). Axes that were not measured get none.

    Raises:
        InputError: a file is missing or wrong, or lacks the history on which the model depends, or the noise of a
            reading is not known, or a point cannot be meant.
        SingularConfigurationError: the robot is singular at a point.

    Example:
        >>> predicted = xd.predict("identified/model.yaml", "plan.csv").frame
        >>> (1e6 * predicted["dy_m"]).round(1).tolist()  # µm
        [-132.6, -73.6, -66.2, -133.8]

    Command:
        expdesign predict results/mine/model.yaml points.csv --out predicted.csv
    """
    identified = truth_of(model)
    robot = identified.chain.robot
    table = table_of(points, "points")
    require_history(identified, table)
    table = _with_target(table, identified)
    loaded = points_from_table(table, robot)
    say_unknown_columns(loaded)
    say(target_findings(loaded, robot, identified.calibrated), loaded.source)
    say_limits(loaded, robot)
    require_regular_points(robot, loaded)
    prediction = predict_points(identified, loaded, platform=platform, loads=loads_of_targets(table, robot))
    names = prediction.measurand.deviation_columns(robot.coordinates)
    spans = loaded.point is not None and bool(identified.chain.reading.fixed) and not platform
    if prediction.orientations is not None or spans:
        names = (*names, *robot.coordinates.deviation[robot.coordinates.translations :])
    if spans:
        names = (*names, *SPAN_DEVIATIONS)
    if readings:
        prediction = replace(prediction, deviations=_of_readings(identified, table, loaded, prediction, names))
    deflections, deviations = in_file_order(loaded, prediction.deflections, prediction.deviations)
    frame = table.frame.copy()
    for axis, name in enumerate(prediction.measurand.columns(robot.coordinates)):
        frame[name] = deflections[:, axis]
    for axis, name in enumerate(names):
        if readings and np.isnan(deviations[:, axis]).all():
            frame = frame.drop(columns=name, errors="ignore")
        else:
            frame[name] = deviations[:, axis]
    if spans:
        frame = _with_spans(frame, loaded, deflections, deviations)
    if prediction.orientations is not None:
        frame = _with_poses(frame, loaded, prediction, deviations, robot)
    outside = [] if identified.calibrated is None else identified.calibrated.beyond(loaded, robot)
    extrapolated = {int(line): row for line, row in zip(loaded.lines, outside, strict=True) if row} if outside else {}
    purpose = purpose_of("predict", model, points)
    return PredictionResult(
        frame,
        prediction,
        identified.birge_ratio,
        readings,
        extrapolated,
        identified.fit == "refuted",
        purpose=purpose,
    )


def _of_readings(
    model: Model, table: Table, points: LoadedPoints, prediction: Prediction, names: tuple[str, ...]
) -> FloatArray:
    """Standard deviations of readings (N, n): of the model and of the noise together; NaN where that is not known."""
    noise = np.full(prediction.deviations.shape, np.nan)
    order = np.searchsorted(table.lines, points.lines)
    for axis, name in enumerate(names):
        if name in model.reading_std:
            noise[:, axis] = model.reading_std[name]
        elif not model.reading_std and table.has(name):
            noise[:, axis] = table.numbers_where_filled((name,))[order, 0]
    if np.isnan(noise).all():
        what = f"neither the points nor the model say how large the noise of a reading is ({', '.join(names)})"
        raise table.fault(what, remedy="Add these columns to the points, or identify the recordings again.")
    found: FloatArray = np.hypot(prediction.deviations, noise)
    return found


def _with_spans(
    frame: pd.DataFrame, points: LoadedPoints, predicted: FloatArray, deviations: FloatArray
) -> pd.DataFrame:
    """Distances and gauges in place of positions, in the rows that name a point."""
    assert points.along is not None
    (along,) = in_file_order(points, points.along)
    gauged = np.any(along, axis=1)
    for axis, (name, deviation) in enumerate(zip(SPANS, SPAN_DEVIATIONS, strict=True)):
        mine = gauged == bool(axis)
        frame[name] = np.where(mine, predicted[:, 6 + axis], np.nan)
        frame[deviation] = np.where(mine, deviations[:, 6 + axis], np.nan)
    return frame.drop(columns=[*POSITION, *POSITION_DEVIATION], errors="ignore").dropna(axis="columns", how="all")


def _poses(frame: pd.DataFrame) -> BoolArray:
    """Rows of the kind `pose`."""
    if "kind" not in frame:
        return np.zeros(len(frame), dtype=bool)
    return frame["kind"].astype(str).str.strip().isin(("pose", "reference")).to_numpy()


def _with_target(table: Table, model: Model) -> Table:
    """The table with the name of the target in rows of the kind `pose` that name none."""
    rows = _poses(table.frame)
    if not model.chain.robot.jointed or not rows.any() or TARGET not in model.chain.reading.names:
        return table
    names = table.text("marker")
    marker = np.where(rows & (names == ""), TARGET, names)
    return replace(table, frame=table.frame.assign(marker=marker))


def _with_poses(
    frame: pd.DataFrame, points: LoadedPoints, prediction: Prediction, deviations: FloatArray, robot: Robot
) -> pd.DataFrame:
    """Rows of poses as `measured_x_m` ... with `sx_m` ..., the others as positions of their markers."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 (slow to import, and few need it)

    assert prediction.orientations is not None
    angles = Rotation.from_matrix(prediction.orientations).as_euler("xyz")
    values = np.hstack([prediction.deflections[:, :3], angles])
    (values,) = in_file_order(points, values)
    rows = _poses(frame)
    for axis, name in enumerate(measured_names(robot.coordinates)):
        frame[name] = np.where(rows, values[:, axis], np.nan)
    for axis, name in enumerate(robot.coordinates.deviation):
        frame[name] = np.where(rows, deviations[:, axis], np.nan)
    for name in (*POSITION, *POSITION_DEVIATION):
        frame[name] = np.where(rows, np.nan, frame[name])
    return frame.dropna(axis="columns", how="all")
