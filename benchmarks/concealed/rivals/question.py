"""A case folder as arrays, and the answer file: what every rival needs (docs/benchmark.md)."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import chi2

from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings
from expdesign.chain.row import RowData, row_data
from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import read_robot

Array = NDArray[np.floating[Any]]
ALARM = 0.01
"""p-value of the base model's chi-squared test below which there is a mismatch."""


@dataclass(frozen=True)
class Question:
    """Recordings and points; arrays over both, recordings first, have `all` in their names.

    Attributes:
        recordings: those to be fitted (rows of `split` test are left out).
        points: what is to be predicted.
    """

    robot: Robot
    recordings: Recordings
    points: LoadedPoints
    everything: LoadedPoints
    order: NDArray[np.intp]

    @classmethod
    def read(cls, folder: Path) -> Question:
        """The question of a case folder."""
        robot = read_robot(folder / "robot.yaml")
        seen, points = pd.read_csv(folder / "recordings.csv"), pd.read_csv(folder / "points.csv")
        if "split" in seen:
            seen = seen[seen["split"] != "test"].drop(columns="split")
        seen, points = seen.sort_values("sequence"), points.sort_values("sequence")
        shared = [name for name in points if name in seen]
        together = pd.concat([seen[shared], points[shared]]).sort_values("sequence")
        everything = points_from_table(parse_table(csv_text(together), "all rows"), robot)
        place = {int(number): row for row, number in enumerate(everything.sequence)}
        order = np.array([place[int(number)] for number in (*seen["sequence"], *points["sequence"])])
        return cls(
            robot,
            recordings_from_table(parse_table(csv_text(seen), "recordings"), robot),
            points_from_table(parse_table(csv_text(points), "points"), robot),
            everything,
            order,
        )

    @property
    def fitted(self) -> int:
        """Number of recordings, which come first in arrays over all rows."""
        return len(self.recordings)

    @cached_property
    def std(self) -> Array:
        """Standard deviations of the readings (recordings x components)."""
        assert self.recordings.deviations is not None
        return self.recordings.deviations

    @cached_property
    def std_all(self) -> Array:
        """The same for all rows; points are read by the same instrument."""
        return np.vstack([self.std, np.tile(self.std[0], (len(self.points), 1))])

    @cached_property
    def rows(self) -> RowData:
        """All rows as the chain reads them, in the order of time."""
        return row_data(self.everything, self.robot)

    def maps_all(self) -> tuple[Array, Array, Array]:
        """J-check (rows x n x legs), J (likewise) and leg forces (rows x legs)."""
        jacobians = self.robot.jacobians(self.everything.configurations)
        forces = np.einsum("rij,ri->rj", jacobians.forward, self.everything.wrenches)
        return jacobians.pose[self.order], jacobians.forward[self.order], forces[self.order]

    def base_all(self) -> Array:
        """Readings per relative compliance of each leg by the base model (rows x components x legs)."""
        pose, _, forces = self.maps_all()
        matrices: Array = pose * (forces / self.robot.stiffness)[:, None, :]
        return matrices[:, self.recordings.axes]

    def base_prediction(self) -> Array:
        """Deflections of all rows by the base model fitted to the recordings (rows x components)."""
        matrices, count = self.base_all(), self.fitted
        left = (matrices[:count] / self.std[:, :, None]).reshape(-1, matrices.shape[2])
        right = (self.recordings.deflections / self.std).ravel()
        compliance = np.linalg.lstsq(left, right, rcond=None)[0]
        return np.asarray(matrices @ compliance)

    def whitened_residuals(self) -> Array:
        """What the base model leaves of the readings, in standard deviations (recordings x components)."""
        return (self.recordings.deflections - self.base_prediction()[: self.fitted]) / self.std

    def mismatch(self) -> bool:
        """The chi-squared test of the base model."""
        left = self.whitened_residuals()
        return bool(chi2.sf((left**2).sum(), left.size - len(self.robot.stiffness)) < ALARM)

    def inputs_all(self) -> tuple[Array, NDArray[np.intp]]:
        """Pose, load, and where recorded time in the series, time and warming of every row, and which columns are the
        load. They are scaled to mean 0 and deviation 1 over the recordings; what does not vary is left out.
        """
        each = self.everything
        columns = [each.configurations, each.wrenches]
        first = pd.Series(np.arange(len(each))).groupby(each.series).transform("first").to_numpy()
        if each.time is not None:
            columns += [(each.time - each.time[first])[:, None], each.time[:, None]]
        if each.temperature is not None:
            columns.append((each.temperature - each.temperature[first])[:, None])
        inputs = np.hstack(columns)[self.order]
        mean, spread = inputs[: self.fitted].mean(0), inputs[: self.fitted].std(0)
        varying = spread > 1e-9
        start = each.configurations.shape[1]
        load = np.zeros(len(varying), dtype=bool)
        load[start : start + each.wrenches.shape[1]] = True
        return (inputs[:, varying] - mean[varying]) / spread[varying], np.flatnonzero(load[varying])

    @property
    def groups(self) -> NDArray[np.int_]:
        """Series of the recordings, which cross-validation keeps together."""
        return np.asarray(self.recordings.series)


@dataclass(frozen=True)
class Reply:
    """Predicted deflections of all rows (rows x components), and what is said of the mismatch."""

    predicted_all: Array
    mismatch: bool
    location: Sequence[str] = ()
    physics: Sequence[tuple[str, float]] = ()


def main(solve: Callable[[Question], Reply], about: str | None) -> None:
    """The command line of a rival: a case folder, and the file for its answer."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("case", type=Path)
    parser.add_argument("answer", type=Path)
    chosen = parser.parse_args()
    question = Question.read(chosen.case)
    reply = solve(question)
    names = [question.robot.coordinates.deflection[axis] for axis in question.recordings.axes]
    # Points are answered in the order of their file.
    sequence = pd.read_csv(chosen.case / "points.csv")["sequence"].to_numpy()
    place = np.argsort(np.argsort(sequence))
    predicted = reply.predicted_all[question.fitted :][place]
    answer = {
        "mismatch": reply.mismatch,
        "location": list(reply.location),
        "physics": [{"name": name, "probability": probability} for name, probability in reply.physics],
        "predictions": {name: predicted[:, column].tolist() for column, name in enumerate(names)},
    }
    chosen.answer.write_text(json.dumps(answer), encoding="utf-8")
