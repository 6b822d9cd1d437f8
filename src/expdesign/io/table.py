"""Tables whose errors name file, row and column; a row is the line of the file, the header being line 1."""

import difflib
import logging
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.arrays import BoolArray, FloatArray, IntArray, TextArray
from expdesign.errors import InputError
from expdesign.io.excel import OLD_WORKBOOK, is_excel_name, is_workbook, sheet_rows
from expdesign.io.known_columns import NONE_KNOWN, KnownColumns
from expdesign.io.schema import LARGEST
from expdesign.io.table_text import Rows, decoded, separated
from expdesign.io.tables_in_units import in_si
from expdesign.io.units import NUMBER, known_units, quantities, unit_of
from expdesign.io.yaml_reader import read_bytes

_LOG = logging.getLogger(__name__)

_MOST_COLUMNS = 10_000
"""A tree of a hundred joints has fewer than a thousand."""
_LARGEST_INTEGER = 2.0**53
"""Beyond it a floating-point number no longer tells neighbouring integers apart."""


@dataclass(frozen=True)
class Table:
    """The text of a table by column.

    Attributes:
        source: name of the file, for messages.
        frame: the cells as text, one row per line that is not empty.
        lines: line of the file on which each row stands.
        written: name in the file of the columns that were converted to SI, by their SI names.
        known: the columns that are known, for messages.
        files: name of the file of each row, where they come from several; else None.
    """

    source: str
    frame: pd.DataFrame
    lines: IntArray
    written: dict[str, str] = field(default_factory=dict)
    known: KnownColumns = NONE_KNOWN
    files: TextArray | None = None

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
            file = self.source if self.files is None else str(self.files[row])
            parts = [file, f"row {self.lines[row]}"]
        if column is not None:
            in_file = self.written.get(column)
            parts.append(f"column {column}" if in_file is None else f"column {in_file} (as {column})")
        return ", ".join(parts)

    def fault(self, what: str, row: int | None = None, column: str | None = None, *, remedy: str = "") -> InputError:
        """The error to raise where a row, a column or a cell cannot be meant."""
        return InputError(what, where=self.where(row, column), remedy=remedy)

    def has(self, *columns: str) -> bool:
        """Whether all `columns` are there."""
        return all(column in self.frame.columns for column in columns)

    def text(self, column: str) -> np.ndarray:
        """The cells of `column` without blanks around them, shape (rows,); empty where there is no such column."""
        if not self.has(column):
            return np.full(len(self), "", dtype=object)
        return self.frame[column].astype(str).str.strip().to_numpy(dtype=object)

    def require_known_units(self, columns: Sequence[str]) -> None:
        """Raise an `InputError` where one of `columns` is there in a unit that is not known (`mass_lb`)."""
        bases = {name.rpartition("_")[0] for name in columns}
        for name in self.columns:
            base, _, unit = name.rpartition("_")
            dimensions = quantities(base) if base in bases else ()
            if dimensions and unit_of(unit) is None:
                remedy = f"Known: {', '.join(one for each in dimensions for one in known_units(each))}."
                raise self.fault(f"the unit `{unit}` is not known", column=name, remedy=remedy)

    def require(self, columns: tuple[str, ...]) -> None:
        """Raise an `InputError` for the first of `columns` that is missing."""
        for column in columns:
            if column not in self.frame.columns:
                # Slips of the pen rarely touch the first letter, and `sx_m` is not meant where `x_m` is missing.
                others = [name for name in self.columns if name not in columns]
                alike = [name for name in others if name[:1] == column[:1]]
                near = difflib.get_close_matches(column, alike, n=1, cutoff=0.7)
                near = near or [name for name in others if self.known.hint(name) == column]
                if not near:
                    self.require_known_units([column])
                asked = f": {self.known.asked[column]}" if column in self.known.asked else ""
                remedy = f"Is `{near[0]}` meant?" if near else f"Add the column{asked}."
                raise self.fault("the column is missing", column=column, remedy=remedy)

    def numbers(self, columns: tuple[str, ...]) -> FloatArray:
        """The cells of `columns` as numbers, shape (rows, columns).

        Raises:
            InputError: a column is missing, or a cell is empty, not a number, NaN or infinite.
        """
        self.require(columns)
        values = np.empty((len(self), len(columns)))
        for index, column in enumerate(columns):
            values[:, index] = pd.to_numeric(self.frame[column], errors="coerce").to_numpy(dtype=float)
            wrong = np.flatnonzero(~(np.abs(values[:, index]) <= LARGEST))
            if wrong.size:
                raise self._no_number(int(wrong[0]), column)
        return values

    def _no_number(self, row: int, column: str) -> InputError:
        text = str(self.frame[column].iloc[row]).strip()
        if text == "":
            return self.fault("the cell is empty", row, column, remedy="Fill it in, or remove the row.")
        if NUMBER.fullmatch(text):
            return self.fault(f"{text[:40]} is beyond any quantity in SI units", row, column, remedy="Correct it.")
        remedy = "Write numbers with a point instead of a comma." if "," in text else "Correct it, or remove the row."
        return self.fault(f"`{text[:40]}` is not a finite number", row, column, remedy=remedy)

    def rows(self, chosen: BoolArray | IntArray) -> "Table":
        """The table of some of its rows, or of all in another order."""
        place = np.arange(len(self))[chosen]
        files = None if self.files is None else self.files[place]
        frame = self.frame.iloc[place].reset_index(drop=True)
        return replace(self, frame=frame, lines=self.lines[place], files=files)

    def numbers_where_filled(self, columns: tuple[str, ...]) -> FloatArray:
        """`numbers` with NaN in empty cells and for columns that are missing."""
        values = np.full((len(self), len(columns)), np.nan)
        for index, column in enumerate(columns):
            if self.has(column):
                filled = np.flatnonzero(self.text(column) != "")
                values[filled, index] = self.rows(filled).numbers((column,))[:, 0]
        return values

    def refuse(
        self,
        wrong: BoolArray,
        columns: Sequence[str],
        what: str,
        remedy: str,
        values: FloatArray | IntArray | TextArray | None = None,
    ) -> None:
        """Raise an `InputError` at the first cell that is wrong.

        Args:
            wrong: shape (rows,) or (rows, columns).
            columns: names of its columns.
            what: what is wrong with the cell; `{}` stands for its value.
            remedy: what to do.
            values: of the cells, in the shape of `wrong`.
        """
        if not wrong.any():
            return
        place = np.argwhere(wrong)[0]
        row, column = int(place[0]), int(place[1]) if wrong.ndim > 1 else 0
        said = what if values is None else what.format(values[tuple(place)])
        raise self.fault(said, row, columns[column], remedy=remedy)

    def words(self, column: str, allowed: Sequence[str], what: str) -> TextArray:
        """The cells of `column` without blanks around them, shape (rows,).

        Raises:
            InputError: one of them is not `allowed`; `what` says so of it, e.g. "`{}` is neither `a` nor `b`".
        """
        cells: TextArray = self.text(column).astype(str)
        self.refuse(~np.isin(cells, list(allowed)), (column,), what, "Correct it.", cells)
        return cells

    def integers(self, column: str) -> IntArray:
        """The cells of `column` as whole numbers, shape (rows,); an `InputError` where one is not."""
        values = self.numbers((column,))[:, 0]
        wrong = (values != np.round(values)) | (np.abs(values) > _LARGEST_INTEGER)
        self.refuse(wrong, (column,), "{:g} is not a whole number", "Use whole numbers.", values=values)
        return values.astype(np.int64)


def is_table_name(path: Path) -> bool:
    """Whether a file's name is that of a table."""
    return path.suffix.lower() in {".csv", ".txt", ".tsv", ".xls", ".ods"} or is_excel_name(path)


_OTHERS = {
    ".yaml": "a YAML file (a robot, a configuration or a model)",
    ".yml": "a YAML file (a robot, a configuration or a model)",
    ".urdf": "a robot's URDF file",
    ".html": "a page",
    ".json": "a record of results",
}
"""What files are that are plainly no tables, by the ends of their names."""


def _require_table(path: Path, data: bytes) -> None:
    """Raise an `InputError` where a file is plainly no table, or a workbook in a form that is not read."""
    suffix = path.suffix.lower()
    if data.startswith(OLD_WORKBOOK) or suffix == ".ods":
        what = "this is a workbook in another form than .xlsx"
        raise InputError(what, where=str(path), remedy="Save it as .xlsx, or as CSV.")
    if suffix in _OTHERS:
        remedy = "Check the order of the files."
        raise InputError(f"this is {_OTHERS[suffix]}, not a table", where=str(path), remedy=remedy)


def read_table(path: Path, known: KnownColumns = NONE_KNOWN) -> Table:
    """Read a table with a header row from CSV (any usual separator and encoding) or a sheet of a workbook (.xlsx).

    Columns in other units become SI columns, and those that are `known` may be written in other letters. What was found
    out about the file is logged.

    Raises:
        InputError: the file is missing, is not text, has no rows, or its rows have more cells than the header.
    """
    data = read_bytes(path)
    source = str(path)
    _require_table(path, data)
    if is_workbook(data) or is_excel_name(path):
        rows, sheet, notes = sheet_rows(data, source)
        return _table(rows, f"{source}, sheet `{sheet}`", notes, known, file=source)
    text, notes = decoded(data, source)
    return parse_table(text, source, known, notes)


def parse_table(text: str, source: str, known: KnownColumns = NONE_KNOWN, notes: Sequence[str] = ()) -> Table:
    """Read a table from the text of a CSV file; see `read_table`."""
    rows, found = separated(text, source)
    return _table(rows, source, [*notes, *found], known)


def _table(rows: Rows, source: str, notes: list[str], known: KnownColumns, file: str = "") -> Table:
    filled = [(line, row) for line, row in rows if any(cell.strip() for cell in row)]
    if not filled:
        raise InputError("the file is empty", where=source, remedy="A header row and at least one row are needed.")
    header = [name.strip() for name in filled[0][1]]
    if len(header) > _MOST_COLUMNS:
        what = f"the header has {len(header)} columns"
        raise InputError(
            what, where=source, remedy=f"Is there a stray cell far to the right? At most {_MOST_COLUMNS} are read."
        )
    for name, count in Counter(header).items():
        if count > 1:
            what = "the header has a column without a name" if name == "" else f"the column {name} appears twice"
            raise InputError(what, where=f"{source}, row {filled[0][0]}", remedy="Correct the header.")
    body = filled[1:]
    if not body:
        raise InputError("the file has a header but no rows", where=source, remedy="Add at least one row.")
    for line, row in body:
        if len(row) != len(header):
            what = f"the row has {len(row)} cells and the header has {len(header)}"
            remedy = "Correct the row (commas as separators)."
            if len(row) > len(header) and any(_decimal_pairs(cells) for _, cells in body):
                what += ": are there numbers with decimal commas between the commas?"
                remedy = "Write decimal points, or save the table with semicolons between its columns."
            if line == body[-1][0] and len(row) < len(header):
                remedy = "Is the file cut off? Save it again, or complete the row."
            raise InputError(what, where=f"{source}, row {line}", remedy=remedy)
    frame = pd.DataFrame([row for _, row in body], columns=header, dtype=str)
    frame, written, units = in_si(frame, source, known)
    if written:
        notes = [*notes, *_conversions(written, units)]
    if notes:
        _LOG.info("%s: %s", file or source, "; ".join(notes))
    return Table(source, frame, np.array([line for line, _ in body], dtype=np.int64), written, known)


def _conversions(written: dict[str, str], units: Sequence[str]) -> list[str]:
    """What became of columns, in a few words: units that were converted, and names that were read otherwise."""
    respelt = {si: old for si, old in written.items() if re.fullmatch(r"[a-z][\w/]*", old) is None}
    converted = len(written) - len(respelt)
    notes = [f"{old} read as {si}" for si, old in respelt.items()]
    if len(written) == 1 and not respelt:
        ((si, old),) = written.items()
        return [f"converted: {old} to {si}"]
    return [*notes, *([f"{converted} columns converted from {', '.join(units)}"] if converted else [])]


def _decimal_pairs(cells: list[str]) -> bool:
    """Whether cells may be the halves of numbers that were written with decimal commas: whole numbers side by side."""
    whole = [re.fullmatch(r"\s*[-+]?\d+\s*", first) is not None for first in cells]
    halves = [re.fullmatch(r"\d+(?:[eE][-+]?\d+)?\s*", second) is not None for second in cells]
    return sum(first and second for first, second in zip(whole, halves[1:], strict=False)) >= 2
