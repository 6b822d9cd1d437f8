"""Where a table of corrections has its values: coordinates of target and load that vary, beside those that do not."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.errors import ConvergenceError, InfeasibleError, InputError, SingularConfigurationError
from expdesign.estimation.compensation.compensate import Compensation, compensate
from expdesign.estimation.compensation.prediction import require_history
from expdesign.io.table import Table


@dataclass(frozen=True)
class Tabulated:
    """The places of a table of corrections.

    Attributes:
        model: of the robot.
        axes: the d coordinates that vary, with their SI units.
        held: coordinates with one value in the whole table.
    """

    model: Model
    axes: tuple[str, ...]
    held: Mapping[str, float]

    def table(self, places: FloatArray) -> Table:
        """Places (N, d) as a table of points."""
        robot = self.model.chain.robot
        columns: dict[str, Any] = dict(zip(robot.configuration, robot.reference_configuration().tolist(), strict=True))
        given = {*self.axes, *self.held}
        if "mass_kg" in given:
            columns |= dict.fromkeys(robot.coordinates.centre_of_mass, 0.0)
        if given & set(robot.coordinates.wrench):
            columns |= dict.fromkeys(robot.coordinates.wrench, 0.0)
        columns |= dict(self.held) | {name: places[:, index] for index, name in enumerate(self.axes)}
        frame = pd.DataFrame({name: np.broadcast_to(value, len(places)) for name, value in columns.items()})
        return Table("table", frame, np.arange(len(places)))

    def points(self, places: FloatArray) -> LoadedPoints:
        """Places (N, d) as points."""
        return points_from_table(self.table(places), self.model.chain.robot)

    def commands(self, places: FloatArray, points: LoadedPoints) -> Compensation:
        """The commands at places (N, d), which are these points; what is wrong is said with the values there."""
        try:
            return compensate(self.model, points)
        except (InfeasibleError, SingularConfigurationError, ConvergenceError) as error:
            remedy = "Take smaller ranges, in which every target can be reached."
            where = f"table {self.named(places, error.where)}"
            raise type(error)(error.what, where=where, remedy=remedy) from None

    def corrections(self, places: FloatArray) -> FloatArray:
        """Command − target of `compensate` (N, n_q) at places (N, d)."""
        points = self.points(places)
        found: FloatArray = self.commands(places, points).commands - points.configurations
        return found

    def named(self, places: FloatArray, where: str) -> str:
        """The place that `row N` names, by its values."""
        row = int(where.rpartition("row ")[2]) if "row " in where else 0
        return "at " + ", ".join(f"{name} {value:.4g}" for name, value in zip(self.axes, places[row], strict=True))

    def require_no_history(self) -> None:
        """Raise an `InputError` where the model depends on more than pose and load."""
        try:
            require_history(self.model, self.table(np.zeros((1, len(self.axes)))))
        except InputError as error:
            name = error.where.split()[-1]
            what = f"the model depends on more than pose and load, which a table cannot tell ({name})"
            remedy = "Use `expdesign compensate` with the history, or a model without these effects."
            raise InputError(what, where=self.model.source, remedy=remedy) from None
