"""Tables of pose errors along named axes, sampled and predicted, and plans written out in a configuration."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.repeated import standard_deviation
from expdesign.errors import InputError
from expdesign.planning.deflection_noise import series_by_pose
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.report.words import with_error
from research.studies.study import Shown
from research.studies.tables import rows_of

MICRO = 1e6
"""µm in a metre, µrad in a radian."""
AXES = ("x (µm)", "y (µm)", "z (µm)", "rx (µrad)", "ry (µrad)", "rz (µrad)")


def deviation_frame(labels: Mapping[str, object], samples: FloatArray, covariance: FloatArray) -> pd.DataFrame:
    """Standard deviation of every axis (µm, µrad) of samples (s, 6), and what a covariance (6, 6) predicts."""
    found = standard_deviation(MICRO * samples)
    return pd.DataFrame(
        {
            **{name: [value] * len(AXES) for name, value in labels.items()},
            "axis": AXES,
            "std": found.value,
            "std_se": found.standard_error,
            "std_predicted": MICRO * np.sqrt(np.diag(covariance)),
        }
    )


def deviation_table(frame: pd.DataFrame, headings: Mapping[str, str], name: str = "std") -> Shown:
    """The same as a page shows it: label columns by their headings, value ± standard error, prediction and z."""
    rows = []
    for row in rows_of(frame):
        value, error, predicted = (getattr(row, f"{name}{suffix}") for suffix in ("", "_se", "_predicted"))
        score = "–" if not error > 0.0 else f"{(value - predicted) / error:+.2f}"
        cells = [str(getattr(row, column)) for column in headings]
        rows.append([*cells, with_error(value, error), f"{predicted:.4g}", score])
    return Shown([*headings.values(), "Monte-Carlo", "predicted", "z"], rows)


def plan_of(problem: DesignProblem, rows: Sequence[Sequence[float]]) -> Plan:
    """A plan from rows of a configuration: the pose, then the load (mass and centre of mass, or the wrench).

    Raises:
        InputError: a row has not as many numbers as pose and load have.
    """
    load, robot = problem.loaded.load, problem.loaded.robot
    gravity = robot.gravity if load.kind == "payload" else np.zeros(0)
    width = len(robot.configuration) + len(load.columns) - len(gravity)
    for index, row in enumerate(rows):
        if len(row) != width:
            what = f"row {index + 1} of `plan` has {len(row)} numbers, not {width}"
            raise InputError(what, where=problem.source, remedy="Write the pose and then the load.")
    table = np.array(rows, dtype=float)
    configurations = table[:, : len(robot.configuration)]
    given = table[:, len(robot.configuration) :]
    loads = np.concatenate([given, np.broadcast_to(gravity, (len(table), len(gravity)))], axis=1)
    return Plan(configurations, loads, series_by_pose(configurations))
