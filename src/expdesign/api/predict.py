"""`predict`: deflections of an identified robot, with their standard deviations."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from expdesign.api.inputs import ModelInput, PathLike, TableInput, numeric, table_of, truth_of
from expdesign.api.outputs import save_table
from expdesign.compensation.prediction import Prediction, in_file_order, require_history, require_regular_points
from expdesign.compensation.prediction import predict as predict_points
from expdesign.recordings.reader import points_from_table


@dataclass(frozen=True)
class Predicted:
    """Points with their deflections.

    Attributes:
        text: the points as they stand in a file, with `dx_m …` (`measured_x_m …` of measured poses) and `sx_m …` filled
            in.
        prediction: the same as arrays, rows in the order of their sequence.
    """

    text: pd.DataFrame
    prediction: Prediction

    @property
    def frame(self) -> pd.DataFrame:
        """The points with numbers as numbers."""
        return numeric(self.text)

    def save(self, file: PathLike, units: str | None = None) -> Path:
        """Write the points into a file, CSV or .xlsx, in SI or in units such as `mm,mrad`."""
        return save_table(file, self.text, units)


def predict(model: ModelInput, points: TableInput, *, platform: bool = False) -> Predicted:
    """Predict deflections at points in recordings form.

    Args:
        model: identified robot, or a robot file whose stiffness is then taken as exact.
        points: commands and loads.
        platform: the motion of the platform instead of the instrument's reading.

    Raises:
        InputError: a file is missing or wrong, or lacks the history on which the model depends.
        SingularConfigurationError: the robot is singular at a point.
    """
    identified = truth_of(model)
    robot = identified.chain.robot
    table = table_of(points, "points")
    require_history(identified, table)
    loaded = points_from_table(table, robot)
    require_regular_points(robot, loaded)
    prediction = predict_points(identified, loaded, platform=platform)
    deflections, deviations = in_file_order(loaded, prediction.deflections, prediction.deviations)
    frame = table.frame.copy()
    for axis, name in enumerate(prediction.measurand.columns(robot.coordinates)):
        frame[name] = deflections[:, axis]
    for axis, name in enumerate(prediction.measurand.deviation_columns(robot.coordinates)):
        frame[name] = deviations[:, axis]
    return Predicted(frame, prediction)
