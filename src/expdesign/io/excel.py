"""Sheets of Excel workbooks (.xlsx), read as tables and written from them."""

import datetime
import io
import warnings
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from expdesign.errors import InputError
from expdesign.io.table_text import Rows
from expdesign.io.units import measured_column

if TYPE_CHECKING:
    from openpyxl.worksheet.worksheet import Worksheet

ZIPPED = b"PK\x03\x04"
"""How every workbook begins."""
MOST_CELLS = 10_000_000
"""Of a table, rows times columns; a stray cell far from the table counts with all between."""
_UNPACKED = 20_000_000
"""Bytes to which a workbook may always unpack: half a million cells."""
_PACKED = 25
"""Times its size to which a larger one may: tables are packed to a tenth, texts that are made to fill a memory to a
thousandth."""
_FORMULA = ("=", "+", "-", "@")
"""How texts begin that a spreadsheet may take for a formula."""
OLD_WORKBOOK = b"\xd0\xcf\x11\xe0"
"""How workbooks of Excel up to 2003 (.xls) begin."""


def is_workbook(data: bytes) -> bool:
    """Whether the content of a file is a workbook, whatever its name."""
    return data[:4] == ZIPPED


def sheet_rows(data: bytes, source: str) -> tuple[Rows, str, list[str]]:
    """The cells of the sheet that holds the table, its name, and notes on what was found.

    It is the sheet whose first row that is not empty has a column that has a meaning here, or the first that is not
    empty. Formulas count with the values that the workbook holds, hidden rows as the others.

    Raises:
        InputError: the workbook cannot be opened (half written), is empty, or holds two tables or merged cells.
    """
    from openpyxl import load_workbook  # noqa: PLC0415 (slow to import)

    try:
        _require_unpackable(data, source)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what a workbook holds besides cells
            book = load_workbook(io.BytesIO(data), data_only=True)
    except (zipfile.BadZipFile, KeyError, ValueError, OSError, EOFError, SyntaxError) as error:
        what = f"cannot be opened as an Excel workbook ({' '.join(str(error).split())})"
        raise InputError(what, where=source, remedy="Is it cut off? Save it again as .xlsx, or as CSV.") from None
    sheets = [(sheet.title, _rows(sheet, source)) for sheet in book.worksheets]
    filled = [(title, rows) for title, rows in sheets if rows]
    if not filled:
        remedy = "A header row and at least one row are needed."
        raise InputError("the workbook is empty", where=source, remedy=remedy)
    tables = [(title, rows) for title, rows in filled if _is_table(rows)]
    if len(tables) > 1:
        what = f"the sheets {' and '.join(f'`{name}`' for name, _ in tables)} both hold a table"
        remedy = "Leave one in the workbook, or save each as a file; recordings may stand in several files."
        raise InputError(what, where=source, remedy=remedy)
    title, rows = (tables or filled)[0]
    notes = [] if len(filled) == 1 else [f"read sheet `{title}`"]
    return rows, title, [*notes, *_hidden_rows(book[title], rows, f"{source}, sheet `{title}`")]


def _hidden_rows(sheet: Any, rows: Rows, where: str) -> list[str]:
    """A note on rows that are hidden but read.

    Raises:
        InputError: cells of the table are merged, so that all but one of them are empty.
    """
    numbers = {number for number, _ in rows}
    for merged in sheet.merged_cells.ranges:
        if numbers & set(range(merged.min_row, merged.max_row + 1)) and rows[0][0] <= merged.min_row:
            remedy = "Unmerge them, and write a name or a value into every cell."
            raise InputError("cells of the table are merged", where=f"{where}, {merged.coord}", remedy=remedy)
    hidden = [number for number in sorted(numbers) if sheet.row_dimensions[number].hidden]
    listed = ", ".join(map(str, hidden[:8])) + (" ..." if len(hidden) > 8 else "")
    return [f"{len(hidden)} hidden rows are read as the others (row {listed})"] if hidden else []


def _is_table(rows: Rows) -> bool:
    names = rows[0][1]
    return len(rows) > 1 and any(name.strip().lower() == "sequence" or _has_meaning(name) for name in names)


def _has_meaning(name: str) -> bool:
    try:
        return measured_column(name) is not None
    except InputError:
        return True


def _require_unpackable(data: bytes, source: str) -> None:
    """Raise an `InputError` where a workbook would unpack to far more than its cells can be worth."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        size = sum(part.file_size for part in archive.infolist())
    if size > max(_UNPACKED, _PACKED * len(data)):
        what = f"unpacks to {size / 1e6:.0f} MB, {size / len(data):.0f} times its size, which no table does"
        raise InputError(what, where=source, remedy="Save the table as CSV.")


def _rows(sheet: Any, source: str) -> Rows:
    """Rows that have a text, as wide as the widest; cells between that do not exist are empty."""
    rows: dict[int, dict[int, str]] = {}
    for (number, column), cell in sheet._cells.items():  # its public iterators make every cell up to the farthest
        text = _text(cell.value)
        if text.strip():
            rows.setdefault(number, {})[column] = text
    width = max((max(cells) for cells in rows.values()), default=0)
    if len(rows) * width > MOST_CELLS:
        what = f"a table of {len(rows)} rows and {width} columns is too large"
        remedy = "Is there a stray cell far to the right? Remove it, or save the table as CSV."
        raise InputError(what, where=f"{source}, sheet `{sheet.title}`", remedy=remedy)
    return [(number, [rows[number].get(column, "") for column in range(1, width + 1)]) for number in sorted(rows)]


def _text(cell: Any) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "true" if cell else "false"
    if isinstance(cell, float):
        return str(int(cell)) if cell.is_integer() and abs(cell) < 1e15 else repr(cell)
    if isinstance(cell, datetime.datetime | datetime.date | datetime.time):
        return cell.isoformat()
    return str(cell)


def workbook(frame: pd.DataFrame, notes: Sequence[str] = (), blank: str = "") -> bytes:
    """A workbook whose first sheet is a frame, and whose second, `notes`, has lines of text.

    Args:
        frame: cells; texts that are numbers are written as numbers, to 16 digits.
        notes: lines of the second sheet; without them there is one sheet.
        blank: colour of the empty cells, as `RRGGBB`, where they are to be filled in.
    """
    from openpyxl import Workbook  # noqa: PLC0415 (slow to import)
    from openpyxl.styles import Font, PatternFill  # noqa: PLC0415
    from openpyxl.utils import get_column_letter  # noqa: PLC0415

    book = Workbook()
    sheet: Worksheet = book.worksheets[0]
    sheet.title = "recordings"
    _append(sheet, [str(name) for name in frame.columns])
    for row in frame.itertuples(index=False):
        _append(sheet, [_value(cell) for cell in row])
    for cell in sheet[1]:
        cell.font = Font(bold=True)
    sheet.freeze_panes = "A2"
    for number, cells in enumerate(sheet.iter_cols(), 1):
        longest = max(len(str(cell.value)) for cell in cells if cell.value is not None)
        sheet.column_dimensions[get_column_letter(number)].width = min(max(longest + 2, 8), 40)
        for cell in cells if blank else ():
            if cell.value is None:
                cell.fill = PatternFill("solid", fgColor=blank)
    if notes:
        other = book.create_sheet("notes")
        for line in notes:
            _append(other, [line])
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def _append(sheet: Any, values: Sequence[object]) -> None:
    """A row below the others, in which a text stays a text: `=HYPERLINK(...)` would be a formula otherwise."""
    from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE  # noqa: PLC0415 (slow to import)

    sheet.append([ILLEGAL_CHARACTERS_RE.sub("", one) if isinstance(one, str) else one for one in values])
    for column, value in enumerate(values, 1):
        if isinstance(value, str) and value.startswith(_FORMULA):
            cell = sheet.cell(sheet.max_row, column)
            cell.data_type, cell.quotePrefix = "s", True


def _value(cell: object) -> object:
    if cell is None or (isinstance(cell, str) and cell.strip() == ""):
        return None
    if isinstance(cell, str):
        for kind in (int, float):
            try:
                value = kind(cell)
            except ValueError:
                continue
            return value if abs(value) < float("inf") else cell
        return cell
    if isinstance(cell, bool | int | float):
        return cell
    return cell.item() if hasattr(cell, "item") else str(cell)


def is_excel_name(path: Path) -> bool:
    """Whether a file's name asks for a workbook."""
    return path.suffix.lower() in {".xlsx", ".xlsm"}
