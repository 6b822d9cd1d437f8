"""Commands that compensate deflections, and what is said of them: for targets one by one, and as a table."""

from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.models.drawn import RESTS_ON_IT
from expdesign.chain.models.estimable import OutsideRange
from expdesign.errors import ArgumentError
from expdesign.estimation.compensation.c_source import c_source
from expdesign.estimation.compensation.compensate import Compensation, Corrections
from expdesign.estimation.compensation.correction_table import CorrectionTable
from expdesign.estimation.compensation.tabulated import Tabulated
from expdesign.mechanics.robots.robot import Robot
from expdesign.report import words
from expdesign.report.blocks import DataTable, table_of
from expdesign.report.result import FolderResult, TableResult
from expdesign.report.said import REFUTED, Said

BASE_AS_DRAWN = (
    "targets are in O. Its rotation about joint 1 is that of the joint's zero as drawn: no reading shows it, and U "
    "does not contain it. If the identified instrument reads the targets, give the frame `instrument`"
)
"""What is said of poses in the base frame where the instrument's frame was identified."""


def tip_as_drawn(deviations: FloatArray) -> str:
    """What is said of standard deviations (N, 6) of the tip's pose that no reading shows."""
    place, turn = 1e3 * float(deviations[:, :3].max()), 1e3 * float(deviations[:, 3:].max())
    return RESTS_ON_IT.format(f"up to {place:.2g} mm and {turn:.2g} mrad")


_MOST_LINES = 20
"""Targets of which a terminal shows a line each; of more, those with the largest corrections."""


@dataclass(frozen=True, repr=False)
class CompensationResult(TableResult):
    """What to command.

    Attributes:
        text: the targets as they stand in a file, with the command in the pose columns.
        compensation: the same as arrays, rows in the order of their sequence, and how the commands were found.
        corrections: how large they are, and how well the attained pose is known, in the same order.
        sequence: numbers of the targets, in the same order.
        robot: that is commanded.
        refuted: whether the recordings of the model refute it.
        scope: which errors of the load were applied at the targets and which not.
    """

    compensation: Compensation
    corrections: Corrections
    sequence: list[int]
    robot: Robot
    refuted: bool = False
    scope: list[str] = field(default_factory=list)

    @property
    def said(self) -> Said:
        translations = self.robot.coordinates.translations
        size, known = _sizes(self.corrections, translations, list(range(len(self.sequence))))
        summary = f"largest correction {', '.join(size)}; expected U {', '.join(known)}"
        if outside := sum(bool(row) for row in self.corrections.beyond):
            summary += f"; {outside} of {len(self.sequence)} targets beyond what was calibrated"
        more = len(self.sequence) - _MOST_LINES
        lines = [*([f"({more} smaller corrections are in the file)"] if more > 0 else []), summary, *self.scope]
        tables = [_table(self.corrections, self.sequence, translations)]
        return Said(summary, lines, [REFUTED] if self.refuted else [], tables=tables)


ROUNDED = 1e-9
"""Parts of a step beyond the range that are the rounding of a number, as in the file of C."""


@dataclass(frozen=True, repr=False)
class CorrectionTableResult(FolderResult):
    """A table of corrections: command = target + correction.

    Attributes:
        tabulated: the model, the coordinates that vary, and those with one value in the whole table.
        table: nodes, values and the error of interpolation.
        extrapolated: commands and loads at the corners of the table that are outside of those of the model's
            recordings, the farthest of each kind.
    """

    FILES: ClassVar = {"table.csv": "frame", "correction.c": "c_source", "table.json": "record"}
    FIRST: ClassVar = "correction.c"
    tabulated: Tabulated
    table: CorrectionTable
    extrapolated: tuple[OutsideRange, ...] = ()

    @property
    def axes(self) -> tuple[str, ...]:
        """The coordinates that vary, with their SI units."""
        return self.tabulated.axes

    @property
    def outputs(self) -> tuple[str, ...]:
        """The corrected coordinates, with their SI units."""
        return self.tabulated.model.chain.robot.configuration

    @property
    def said(self) -> Said:
        table, grid = self.table, self.table.grid
        lines = [f"{len(table.values)} nodes ({' x '.join(map(str, grid.counts))}) over {', '.join(self.axes)}"]
        errors = list(zip(self.outputs, table.stated, table.bound, table.found, strict=True))
        lines += [
            f"{name}: interpolation within {stated:.2g} (found {found:.2g} at {table.checks} points)"
            for name, stated, _, found in errors
        ]
        rows = zip(self.axes, grid.low, grid.high, grid.counts, strict=True)
        record = {
            "model": self.tabulated.model.source,
            "version": version("expdesign"),
            "axes": {name: {"low": float(a), "high": float(b), "nodes": int(n)} for name, a, b, n in rows},
            "held": self.tabulated.held,
            "nodes": len(table.values),
            "interpolation_error": {
                name: {"stated": float(stated), "bound": float(bound), "found": float(found)}
                for name, stated, bound, found in errors
            },
            "checked_at": table.checks,
        }
        if self.extrapolated:
            lines.append(self._beyond)
            record["beyond_calibration"] = [str(each) for each in self.extrapolated]
        return Said("\n".join(lines), document=lambda: record)

    @property
    def _beyond(self) -> str:
        return f"The table reaches beyond what was calibrated: {'; '.join(map(str, self.extrapolated))}"

    @property
    def frame(self) -> pd.DataFrame:
        """One row per node: the axes and the corrections in SI units."""
        names = [*self.axes, *(f"correction_{name}" for name in self.outputs)]
        return pd.DataFrame(np.concatenate([self.table.grid.nodes, self.table.values], axis=1), columns=names)

    def exact(self, points: FloatArray) -> FloatArray:
        """What the table interpolates: command − target of `compensate` (N, o) at points (N, d)."""
        return self.tabulated.corrections(points)

    def interpolated(self, points: FloatArray) -> FloatArray:
        """What the table says at points (N, d) within its range, shape (N, o), as the file of C does.

        Raises:
            ArgumentError: a point is outside of the range or not a number, for which the C function returns 1 with the
                correction at the edge.
        """
        grid = self.table.grid
        places = (points - grid.low) / (grid.high - grid.low) * (grid.counts - 1)
        outside = ~((places >= -ROUNDED) & (places <= grid.counts - 1 + ROUNDED))
        if outside.any():
            row, axis = (int(index) for index in np.argwhere(outside)[0])
            what = f"{self.axes[axis]} = {points[row, axis]:g} in row {row} is outside of the table"
            remedy = f"It has {grid.low[axis]:g} to {grid.high[axis]:g}; make a larger one, or ask `exact`."
            raise ArgumentError(what, argument="points", remedy=remedy)
        return grid.interpolate(self.table.values, np.clip(points, grid.low, grid.high))

    @property
    def c_source(self) -> str:
        """The table as one file of C99."""
        model = self.tabulated.model
        about = f"Robot {model.robot.get('name', '')}, model {Path(model.source).name}; "
        about += f"made by expdesign {version('expdesign')}. SI units."
        about += f" {self._beyond}." if self.extrapolated else ""
        return c_source(self.table, self.axes, self.outputs, list(self.tabulated.held.items()), about)


def _table(corrections: Corrections, sequence: list[int], translations: int) -> DataTable:
    """The corrections in the order of the targets; of many targets the largest."""
    largest = np.argsort(-corrections.translation, kind="stable")[:_MOST_LINES]
    rows = []
    for row in np.sort(largest):
        size, known = _sizes(corrections, translations, [int(row)])
        beyond = "; ".join(map(str, corrections.beyond[row])) or "-"
        rows.append([str(sequence[row]), ", ".join(size), ", ".join(known), beyond])
    return table_of("corrections", "", ["Target", "Correction", "U (k = 2)", "Beyond what was calibrated"], rows)


def _sizes(corrections: Corrections, translations: int, rows: list[int]) -> tuple[list[str], list[str]]:
    """The largest corrections and U of some rows: of lengths, and of angles where there are some."""
    expanded = corrections.expanded[rows]
    pairs = [(corrections.translation[rows], expanded[:, :translations], "m")]
    if expanded.shape[1] > translations:
        pairs.append((corrections.rotation[rows], expanded[:, translations:], "rad"))
    size, known = zip(*((words.size(a.max(), unit), words.size(b.max(), unit)) for a, b, unit in pairs), strict=True)
    return list(size), list(known)
