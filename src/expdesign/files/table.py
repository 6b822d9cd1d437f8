"""CSV tables whose errors name file, row and column; a row is the line of the file, the header being line 1."""

import csv
import difflib
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.errors import InputError
from expdesign.files.schema import LARGEST
from expdesign.files.yaml_reader import read_text

_LARGEST_INTEGER = 2.0**53
"""Beyond it a floating-point number no longer tells neighbouring integers apart."""


@dataclass(frozen=True)
class Table:
    """The text of a CSV file by column.

    Attributes:
        source: name of the file, for messages.
        frame: the cells as text, one row per line that is not empty.
        lines: line of the file on which each row stands.
    """

    source: str
    frame: pd.DataFrame
    lines: IntArray

    @property
    def columns(self) -> list[str]:
        """Names of the columns, in the order of the file."""
        return [str(column) for column in self.frame.columns]

    def __len__(self) -> int:
        return len(self.frame)

    def where(self, row: int | None = None, column: str | None = None) -> str:
        """File, row and column, as a person would look them up."""
        parts = [self.source]
        if row is not None:
            parts.append(f"row {self.lines[row]}")
        if column is not None:
            parts.append(f"column {column}")
        return ", ".join(parts)

    def has(self, *columns: str) -> bool:
        """Whether all `columns` are there."""
        return all(column in self.frame.columns for column in columns)

    def require(self, columns: tuple[str, ...]) -> None:
        """Raise an `InputError` for the first of `columns` that is missing."""
        for column in columns:
            if column not in self.frame.columns:
                # Slips of the pen rarely touch the first letter, and `sx_m` is not meant where `x_m` is missing.
                others = [name for name in self.columns if name not in columns and name[:1] == column[:1]]
                near = difflib.get_close_matches(column, others, n=1, cutoff=0.7)
                remedy = f"Is `{near[0]}` meant?" if near else "Add the column."
                raise InputError("the column is missing", where=self.where(column=column), remedy=remedy)

    def numbers(self, columns: tuple[str, ...]) -> FloatArray:
        """The cells of `columns` as numbers, shape (rows, columns).

        Raises:
            InputError: a column is missing, or a cell is empty, not a number, NaN or infinite.
        """
        self.require(columns)
        values = np.empty((len(self), len(columns)))
        for index, column in enumerate(columns):
            cells = self.frame[column]
            values[:, index] = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float)
            wrong = np.flatnonzero(~np.isfinite(values[:, index]))
            if wrong.size:
                text = str(cells.iloc[wrong[0]]).strip()
                what = "the cell is empty" if text == "" else f"`{text[:40]}` is not a finite number"
                remedy = "Fill it in, or remove the row." if text == "" else "Correct it, or remove the row."
                if "," in text:
                    remedy = "Write numbers with a point instead of a comma."
                raise InputError(what, where=self.where(int(wrong[0]), column), remedy=remedy)
            large = np.flatnonzero(np.abs(values[:, index]) > LARGEST)
            if large.size:
                text = str(cells.iloc[large[0]]).strip()
                where = self.where(int(large[0]), column)
                raise InputError(f"{text[:40]} is beyond any quantity in SI units", where=where, remedy="Correct it.")
        return values

    def integers(self, column: str) -> IntArray:
        """The cells of `column` as whole numbers, shape (rows,); an `InputError` where one is not."""
        values = self.numbers((column,))[:, 0]
        wrong = np.flatnonzero((values != np.round(values)) | (np.abs(values) > _LARGEST_INTEGER))
        if wrong.size:
            where = self.where(int(wrong[0]), column)
            raise InputError(f"{values[wrong[0]]:g} is not a whole number", where=where, remedy="Use whole numbers.")
        return values.astype(np.int64)


def read_table(path: Path) -> Table:
    """Read a CSV file with a header row.

    Raises:
        InputError: the file is missing, is not text, has no rows, or its rows have more cells than the header.
    """
    return parse_table(read_text(path), str(path))


def parse_table(text: str, source: str) -> Table:
    """Read a table from the text of a CSV file; see `read_table`."""
    reader = csv.reader(io.StringIO(text, newline=""))
    numbered, line = [], 1
    try:
        for row in reader:
            numbered.append((line, row))
            line = reader.line_num + 1  # a quoted cell may go over several lines
    except csv.Error as error:
        raise InputError(f"not a CSV table: {error}", where=source, remedy="Save it as comma-separated text.") from None
    filled = [(line, row) for line, row in numbered if any(cell.strip() for cell in row)]
    if not filled:
        raise InputError("the file is empty", where=source, remedy="A header row and at least one row are needed.")
    header = [name.strip() for name in filled[0][1]]
    for name in header:
        if header.count(name) > 1:
            what = "the header has a column without a name" if name == "" else f"the column {name} stands there twice"
            raise InputError(what, where=f"{source}, row {filled[0][0]}", remedy="Correct the header.")
    separator = next((mark for mark in (";", "\t") if len(header) == 1 and mark in header[0]), None)
    if separator is not None:
        name = "semicolons" if separator == ";" else "tabulators"
        remedy = "Save it with commas, and with points in the numbers."
        raise InputError(f"the columns are separated by {name}", where=f"{source}, row {filled[0][0]}", remedy=remedy)
    body = filled[1:]
    if not body:
        raise InputError("the file has a header but no rows", where=source, remedy="Add at least one row.")
    for line, row in body:
        if len(row) != len(header):
            what = f"the row has {len(row)} cells and the header has {len(header)}"
            raise InputError(what, where=f"{source}, row {line}", remedy="Correct the row (commas as separators).")
    frame = pd.DataFrame([row for _, row in body], columns=header, dtype=str)
    return Table(source, frame, np.array([line for line, _ in body], dtype=np.int64))
