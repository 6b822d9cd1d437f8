"""What the functions of the package return: objects that say themselves in a line, and can be saved, opened and copied.

A result is a `FolderResult` (files and a page in a folder), a `TableResult` (rows in one file) or neither. What its
command prints stands in it as well (`lines`, `notes`), so that a notebook can say the same.
"""

import html
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.models.model_file import Model, model_text
from expdesign.copying import Copied
from expdesign.io.excel import is_excel_name, workbook
from expdesign.io.output import csv_text, json_text, output_file, output_folder, write_file
from expdesign.io.tables_in_units import in_units
from expdesign.io.written import Purpose
from expdesign.mechanics.robots.robot_file import RobotFile
from expdesign.report.said import Said

if TYPE_CHECKING:  # most results have no targets, and no page is drawn unless it is saved
    from expdesign.assurance.acceptance.decision import Decision
    from expdesign.report.at_targets import AtTargets
    from expdesign.report.page import Page

PathLike = str | Path
PAGE: Mapping[str, str] = {"report.html": "page"}
"""The report, the last of the files of a result."""


@dataclass(frozen=True, repr=False)
class Result(Copied):
    """A result.

    Attributes:
        purpose: the command and the main inputs; `save` replaces what was written for the same.
    """

    purpose: Purpose = field(default=Purpose(""), kw_only=True, compare=False)

    @property
    def said(self) -> Said:
        """What the result says; made in `report`."""
        return Said(self.purpose.command)

    @property
    def summary(self) -> str:
        """The result in one line."""
        return self.said.summary

    @property
    def lines(self) -> list[str]:
        """What the command prints."""
        return self.said.lines

    @property
    def notes(self) -> list[str]:
        """What the command says beside its results, on standard error."""
        return list(self.said.notes)

    @property
    def record(self) -> dict[str, Any]:
        """What the command writes as JSON (file-formats.md); empty where it writes none."""
        return dict(self.said.document())

    @property
    def refused(self) -> bool:
        """Whether the work is done and the answer is no: the command then says and keeps all, and exits with status 3.

        A class whose results can fail overrides it, as `verify`'s does (a verdict `fail`).
        """
        return False

    def __str__(self) -> str:
        return "\n".join([*self.lines, *self.notes])

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.summary.splitlines()[0]}>"

    def _repr_html_(self) -> str:
        """For notebooks: the summary, one line below the other."""
        lines = "<br>".join(html.escape(line) for line in self.summary.splitlines())
        return f"<div><b>{type(self).__name__}</b><br>{lines}</div>"

    def as_table(self) -> pd.DataFrame | None:
        """The rows that a function reads where it is given this result in the place of a table."""
        return None

    def as_model(self) -> Model | None:
        """The model that a function uses where it is given this result in the place of a model file."""
        return None


@dataclass(frozen=True, repr=False)
class FolderResult(Result):
    """A result that is kept as files of a folder.

    Attributes:
        FILES: of the class: the files that `save` writes into a folder, and what of the result is in each: a frame, a
            record, a text or a model; nothing is written of None. A name with `*` for any characters stands for
            several, which are a mapping of names.
        FIRST: of the class: name of the file whose path `save` returns.
    """

    FILES: ClassVar[Mapping[str, str]] = {}
    FIRST: ClassVar[str] = "report.html"

    def files(self, folder: Path = Path()) -> dict[str, Any]:
        """Names and contents of the files without the report, as they will lie in `folder`."""
        found: dict[str, Any] = {}
        for name, part in self.FILES.items():
            if name not in PAGE:
                content = getattr(self, part)
                found |= content if "*" in name else {name: content}
        return {name: _written(content, folder) for name, content in found.items() if content is not None}

    def page(self) -> "Page | None":
        """The report."""
        return None

    def save(self, folder: PathLike, *, force: bool = False) -> Path:
        """Write the result and return the path of its report, or of its first file.

        Args:
            folder: folder for the results.
            force: replace files that are there for another purpose.

        Raises:
            InputError: the folder cannot be written, or holds files that must not be replaced.
        """
        return self._write(Path(folder), self.files(Path(folder)), force=force)

    def _write(self, folder: Path, contents: Mapping[str, str | bytes], *, force: bool) -> Path:
        page = self.page()
        with output_folder(folder, self.purpose, force=force) as scratch:
            for name, content in contents.items():
                write_file(scratch / name, content)
            if page is not None:
                from expdesign.report.page import render  # noqa: PLC0415 (slow to import)

                write_file(scratch / "report.html", render(page, folder))
        return folder / self.FIRST


@dataclass(frozen=True, repr=False)
class RecordedResult(FolderResult):
    """What recordings of a robot say.

    Attributes:
        robot: with its file.
        model: what prediction and compensation need.
        at_targets: what it says at the targets of a configuration; None where none was given.
    """

    robot: RobotFile
    model: Model
    at_targets: "AtTargets | None" = field(default=None, kw_only=True)

    def as_model(self) -> Model:
        """The model that was found."""
        return self.model

    @property
    def acceptance(self) -> "Decision | None":
        """Whether the robot is accepted at the targets; None where none were named."""
        return None if self.at_targets is None else self.at_targets.acceptance


@dataclass(frozen=True, repr=False)
class RowsResult(Result):
    """A result that other functions read as a table.

    Attributes:
        text: the rows as they stand in a file.
    """

    text: pd.DataFrame

    def as_table(self) -> pd.DataFrame:
        """The rows as they stand in a file."""
        return self.text

    @property
    def frame(self) -> pd.DataFrame:
        """The rows with numbers as numbers."""
        return numeric(self.text)


@dataclass(frozen=True, repr=False)
class TableResult(RowsResult):
    """A result that is kept as one table."""

    def save(self, file: PathLike, units: str | None = None, *, force: bool = False) -> Path:
        """Write the rows and return the path of the file.

        Args:
            file: file for the rows: a workbook if it ends in `.xlsx`, else CSV.
            units: units to write, by what they measure, e.g. `mm,mrad`; SI if left out.
            force: replace a file that is there for another purpose.

        Raises:
            InputError: a unit is unknown, or the file cannot be written or must not be replaced.
        """
        frame, path = in_units(self.as_table(), units), Path(file)
        output_file(path, workbook(frame) if is_excel_name(path) else csv_text(frame), self.purpose, force=force)
        return path


@dataclass(frozen=True, repr=False)
class RecordedTable(TableResult):
    """A table with a record of how its rows came about."""

    def save_record(self, file: PathLike, *, force: bool = False) -> Path:
        """Write `record`.

        Args:
            file: JSON file for what does not fit into rows, such as the covariance of each.
            force: replace a file that is there for another purpose.
        """
        output_file(Path(file), json_text(self.record), self.purpose, force=force)
        return Path(file)


def _written(content: Any, folder: Path) -> str | bytes:
    """A part of a result as it stands in a file of `folder`."""
    if isinstance(content, pd.DataFrame):
        return csv_text(content)
    if isinstance(content, Model):
        return model_text(content, folder)
    return content if isinstance(content, str | bytes) else json_text(content)


def filled(frame: pd.DataFrame, names: Iterable[str], values: FloatArray) -> pd.DataFrame:
    """A frame with columns of values (N, k) at its end, also where it had some of these names before."""
    columns = dict(zip(names, values.T, strict=True))
    return frame.drop(columns=list(columns), errors="ignore").assign(**columns)


def numeric(text: pd.DataFrame) -> pd.DataFrame:
    """A frame whose cells are as in a CSV file, with the columns that hold numbers only as numbers, exactly as read."""
    return pd.DataFrame({name: _numbers(text[name].tolist()) for name in text.columns})


def _numbers(cells: list[Any]) -> list[Any]:
    texts = [repr(float(cell)) if isinstance(cell, float) else str(cell) for cell in cells]
    for kind in (int, float):
        try:
            return [float("nan") if kind is float and text == "" else kind(text) for text in texts]
        except ValueError:
            continue
    return cells
