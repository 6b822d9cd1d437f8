"""What a section of a report page is made of.

Each block is plain data; `blocks.html` has one macro for each kind, and escapes every text. A block that
a page's script fills in again (when another design is chosen, say) is found by its `id`.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd
from markupsafe import Markup

from expdesign.io.output import csv_text
from expdesign.report.words import UNDETERMINED, in_ascii_powers, number

_UNBROKEN = 30
"""Characters of a cell that stay in one line."""

_BOUND = re.compile(r"(below|above) \d")
"""How a cell begins that is a number."""


@dataclass(frozen=True)
class Block:
    """One piece of a section; `blocks.html` draws it by the name of its class."""

    @property
    def kind(self) -> str:
        """Name of its class."""
        return type(self).__name__


@dataclass(frozen=True)
class Paragraph(Block):
    """Text. With `live`, a screen reader announces it whenever a script changes it."""

    text: str
    id: str = ""
    live: bool = False


@dataclass(frozen=True)
class Subheading(Block):
    """A heading inside a section."""

    text: str
    id: str = ""


@dataclass(frozen=True)
class Sentences(Block):
    """A list of sentences."""

    items: Sequence[str]
    id: str = ""


@dataclass(frozen=True)
class KeyFigure:
    """One number worth reading first; its tone is `good` or `bad` where it decides something."""

    label: str
    value: str
    unit: str = ""
    note: str = ""
    tone: str = ""


@dataclass(frozen=True)
class KeyFigures(Block):
    """A row of numbers worth reading first."""

    items: Sequence[KeyFigure]


@dataclass(frozen=True)
class Definitions(Block):
    """Terms with what they mean or their values, in pairs."""

    items: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class NextSteps(Block):
    """What to do, in order: each a sentence and the command for it (or an empty text)."""

    items: Sequence[tuple[str, str]]


HERE = "@here@/"
"""In a command: the folder of the page, as seen from the current folder, filled in when the page is written."""


@dataclass(frozen=True)
class Download:
    """A file that the page offers: its name and its text."""

    filename: str
    text: str


@dataclass(frozen=True)
class DataTable(Block):
    """A table with a caption and its data as CSV.

    Attributes:
        columns: headings, with units.
        rows: cells as they are shown.
        csv: the same data unrounded, or None where a script supplies it.
        choice: name of the group of radio buttons that the rows are given, to choose one row; empty for none.
        chosen: index of the row that is chosen at first.
        tall: whether the table scrolls inside a box instead of taking its full height.
    """

    id: str
    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    csv: Download | None = None
    choice: str = ""
    chosen: int = 0
    tall: bool = False

    def look(self, column: int) -> Markup:
        """Class of a column's cells: words are set flush left rather than as numbers, and sentences are broken."""
        cells = [row[column] for row in self.rows if row[column]]
        words = sum(cell[:1].isalpha() and cell != UNDETERMINED and not _BOUND.match(cell) for cell in cells)
        if 2 * words <= len(cells):  # a number now and then is only said to be none
            return Markup()
        return Markup(' class="text long"' if max(map(len, cells)) > _UNBROKEN else ' class="text"')

    @property
    def lines(self) -> list[str]:
        """The table as a terminal prints it: headings and rows, columns as wide as their cells."""
        columns = [[in_ascii_powers(cell) for cell in cells] for cells in zip(self.columns, *self.rows, strict=True)]
        aligned = [
            [cell.ljust(width) if self.look(number) else cell.rjust(width) for cell in cells]
            for number, cells in enumerate(columns)
            for width in [max(map(len, cells))]
        ]
        return ["  ".join(cells).rstrip() for cells in zip(*aligned, strict=True)]


def table_of(
    id: str,
    caption: str,
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    frame: pd.DataFrame | None = None,
    *,
    tall: bool = False,
) -> DataTable:
    """A table whose CSV, named like the table, is a frame in SI units, or what is shown where there is none."""
    data = pd.DataFrame(list(rows), columns=list(columns)) if frame is None else frame
    filename = f"{id.removesuffix('-table')}.csv"
    return DataTable(id, caption, columns, rows, Download(filename, csv_text(data)), tall=tall)


Shown = Mapping[str, str | Callable[[Any], str]]
"""By the heading of each column of a table, the column of a frame, or the cell of a row (of `itertuples`)."""


def number_of(column: str, factor: float = 1.0, digits: int = 3) -> Callable[[Any], str]:
    """The cell of a row with the number of a column of its frame, in another unit."""
    return lambda row: number(factor * getattr(row, column), digits)


def corrections_of(heading: str, column: str) -> Shown:
    """Cells of a correction (mm, mrad) and of the ends `low` and `high` of its interval; dashes where there is none."""

    def cell(name: str) -> Callable[[Any], str]:
        return lambda row: "–" if row.low == row.high else number(1e3 * getattr(row, name), 4)

    return {heading: cell(column), "Low": cell("low"), "High": cell("high")}


def framed(
    id: str,
    caption: str,
    frame: pd.DataFrame,
    shown: Shown,
    *,
    rows: Sequence[int] | None = None,
    tall: bool = False,
) -> DataTable:
    """A table that shows a frame, whose CSV is the frame.

    Args:
        id: of the table; its CSV is named like it.
        caption: of the table.
        frame: in SI units.
        shown: what its columns show.
        rows: that are shown; all if left out.
        tall: whether the table scrolls inside a box.
    """
    listed = frame if rows is None else frame.iloc[list(rows)]
    cells = [
        [str(getattr(row, cell)) if isinstance(cell, str) else cell(row) for cell in shown.values()]
        for row in listed.itertuples()
    ]
    return table_of(id, caption, list(shown), cells, frame, tall=tall)


@dataclass(frozen=True)
class Figure(Block):
    """A plotly figure.

    Attributes:
        plot: `{"data": [...], "layout": {...}}`, arrays allowed. Colours are written as `var(--noise)` with the names
            of page.css, so that they follow the light and the dark look. Texts in it that come from a user go
            through `page.plot_text`.
        caption: what is to be seen, for a technician.
        description: the same for a person who cannot see it.
        csv: its data, or None where a script supplies it.
        height: in pixels on a wide screen.
        filename: of the picture, without extension.
    """

    id: str
    title: str
    plot: Mapping[str, Any]
    caption: str
    description: str
    csv: Download | None = None
    height: int = 420
    filename: str = "figure"


@dataclass(frozen=True)
class Option:
    """One entry of a selector."""

    value: str
    text: str
    chosen: bool = False


def choices(texts: Iterable[str]) -> list[Option]:
    """Entries that are numbered from 0, of which the first is chosen."""
    return [Option(str(number), text, number == 0) for number, text in enumerate(texts)]


@dataclass(frozen=True)
class Selector(Block):
    """A labelled choice; with `step`, buttons to the previous and next entry stand beside it."""

    id: str
    label: str
    options: Sequence[Option]
    step: bool = False


@dataclass(frozen=True)
class Buttons(Block):
    """Buttons that a page's script acts on: pairs of id and text."""

    items: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class SideBySide(Block):
    """Two columns on a wide screen, one below the other on a narrow one."""

    left: Sequence[Block]
    right: Sequence[Block]


@dataclass(frozen=True)
class PageSection:
    """A heading and what stands below it."""

    id: str
    title: str
    blocks: Sequence[Block] = field(default_factory=tuple)
