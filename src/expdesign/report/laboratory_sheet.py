"""The laboratory sheet as a page for printing: what is set, what is done, and room for what is read."""

import math
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd
from jinja2 import Environment, FileSystemLoader

from expdesign.io.excel import workbook
from expdesign.io.output import csv_text
from expdesign.io.tables_in_units import in_units
from expdesign.io.units import measured_column
from expdesign.planning.laboratory_sheet import Steps
from expdesign.report.result import FolderResult, PathLike, RowsResult
from expdesign.report.said import Said

DECIMALS = {"length": 6, "angle": 6, "mass": 6, "force": 6, "moment": 6}
"""Digits that are shown, after the point in SI units; in other units as many as it takes for the same step."""
_HIDDEN = ("plan_row", "kind", "remarks")
_DEVIATION = re.compile("s[xyz]|sr[xyz]")
_LOAD = re.compile("mass|com|[fm][xyz]")
_BLANKS = ("Date", "Operator", "Instrument", "Temperature")


_INSTRUCTIONS = (
    "Readings: what the instrument shows, from any zero that stays the same within a series; a loaded row is "
    "counted from the unloaded row before it in its series. Rows left empty are ignored.",
    "Columns s...: standard deviation of a deflection, as planned; correct them where the instrument says "
    "otherwise. Columns time and temperature may stay empty.",
)
_FILL = "FFF8DC"


@dataclass(frozen=True, repr=False)
class SheetResult(RowsResult, FolderResult):
    """What is done in the laboratory, with room for what is read.

    Attributes:
        text: one row per step, in order: set-points, load, what to do, and empty cells to be filled in.
        steps: the order and what it takes.
        minutes: time of the steps, or None where the configuration states no costs.
        minutes_in_plan_order: the same for the plan row by row.
        title: of the page.
        robot_file: path of the robot's file, for the command that follows; empty where it is not known.
    """

    FILES: ClassVar = dict.fromkeys(("sheet.html", "sheet.csv", "sheet.xlsx"), "files")
    FIRST: ClassVar = "sheet.html"
    steps: Steps
    minutes: float | None
    minutes_in_plan_order: float | None
    title: str
    robot_file: str = ""

    @property
    def said(self) -> Said:
        steps = self.steps
        readings, references = len(steps.rows), int(steps.reference.sum())
        text = f"{readings} readings, {references} of them without load; {steps.pose_changes} poses to set, "
        text += f"{steps.load_changes} changes of the load{' (no order needs less)' if steps.exact else ''}."
        if self.minutes is not None:
            text += f" Time: {self.minutes:.4g} min; row by row as planned {self.minutes_in_plan_order:.4g} min."
        return Said(text)

    def files(self, folder: Path = Path(), units: str | None = None) -> dict[str, Any]:
        """The sheet as a table, as a workbook and as a page for printing."""
        frame = _rounded(in_units(self.text, units))
        robot, filled_in = (shlex.quote(str(path)) for path in (self.robot_file or "ROBOT.yaml", folder / "sheet.xlsx"))
        lines = [*_INSTRUCTIONS, f"Afterwards: expdesign identify {robot} {filled_in} --out results"]
        notes = [self.title, self.summary, *lines]
        return {
            "sheet.csv": csv_text(frame),
            "sheet.xlsx": workbook(frame, notes=notes, blank=_FILL),
            "sheet.html": self._page(frame, lines),
        }

    def _page(self, frame: pd.DataFrame, notes: Sequence[str]) -> str:
        """The page of a frame in the units that were asked for, with notes below the table."""
        environment = Environment(loader=FileSystemLoader(Path(__file__).parent), autoescape=True)
        columns = [str(name) for name in frame.columns]
        shown = [name for name in columns if name not in _HIDDEN and not _DEVIATION.fullmatch(name.split("_")[0])]
        texts = {name: [_text(name, cell) for cell in frame[name]] for name in shown}
        set_points = columns[columns.index("series") + 1 : columns.index("do")]  # tilts of the base among them
        loads = [name for name in set_points if _LOAD.fullmatch(name.split("_")[0])]
        poses = [name for name in set_points if name not in loads]
        same = [name for name in (*poses, *loads) if len(set(texts[name])) == 1 and len(frame) > 1]
        names = [name for name in shown if name not in same]
        constant = ", ".join(f"{_headed(name)} {texts[name][0]}" for name in same)
        rows = []
        for index in range(len(frame)):
            reference = "reference" in texts["do"][index]
            cells = [_cell(texts[name], index, blank=reference and name in loads, key=name) for name in names]
            stop = index == 0 or any(texts[name][index] != texts[name][index - 1] for name in poses)
            rows.append({"cells": cells, "kind": " ".join(["reference"] * reference + ["stop"] * stop)})
        page = environment.get_template("sheet.html")
        lines = [*([f"The same throughout: {constant}."] if constant else []), *notes]
        header = [_headed(name) for name in names]
        return page.render(
            title=self.title, summary=self.summary, blanks=_BLANKS, header=header, rows=rows, notes=lines
        )

    def save(self, folder: PathLike, units: str | None = None, *, force: bool = False) -> Path:
        """Write the sheet and return the path of its page.

        Args:
            folder: folder for the results.
            units: units to write, by what they measure, e.g. `mm,mrad`; SI if left out.
            force: replace files that are there for another purpose. A sheet with readings never is.

        Raises:
            InputError: a unit is unknown, or the folder cannot be written.
        """
        return self._write(Path(folder), self.files(Path(folder), units), force=force)


def _cell(texts: list[str], index: int, *, blank: bool, key: str) -> dict[str, str]:
    if blank:
        return {"text": "–", "kind": "same"}
    if texts[index] == "":
        return {"text": "", "kind": "blank"}
    repeated = index > 0 and texts[index] == texts[index - 1] and key != "sequence"
    return {"text": texts[index], "kind": "text" if key == "do" else ("same" if repeated else "")}


def _headed(name: str) -> str:
    measured = measured_column(name)
    if measured is None:
        return {"sequence": "no.", "do": "to do"}.get(name, name.replace("_", " "))
    unit = measured.unit.name.replace("um", "µm").replace("urad", "µrad").replace("deg", "°").replace("_s2", "/s²")
    called = re.sub("^com_", "centre of mass ", measured.base.replace("temperature", "temp."))
    return f"{called.replace('_', ' ')} ({unit})"


def _rounded(frame: pd.DataFrame) -> pd.DataFrame:
    """A sheet with set-points and loads rounded to what the page shows, so that what is set is what the file says."""
    columns = {str(name): frame[name] for name in frame.columns}
    for name, cells in columns.items():
        if not _DEVIATION.fullmatch(name.split("_")[0]):
            columns[name] = cells.map(lambda cell, name=name: _round(name, cell))
    return pd.DataFrame(columns)


def _round(name: str, cell: object) -> object:
    """A number with the digits that are shown; anything else as it is."""
    measured = measured_column(name)
    if not isinstance(cell, float) or measured is None or measured.unit.dimension not in DECIMALS:
        return cell
    step = measured.unit.from_si(10.0 ** -DECIMALS[measured.unit.dimension])
    return round(cell, max(0, math.ceil(-math.log10(step) - 1e-9))) + 0.0


def _text(name: str, cell: object) -> str:
    shown = _round(name, cell)
    return f"{shown:.9g}" if isinstance(shown, float) else str(shown)
