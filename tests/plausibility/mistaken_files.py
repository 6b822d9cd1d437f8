"""Mistakes in how a table, a configuration or a list of points is written, each with what has to be said of it."""

import io
import re
from collections.abc import Callable

import pandas as pd
from openpyxl import Workbook

Text = Callable[[str], str]
"""What becomes of the text of a sound file."""


def renamed(old: str, new: str) -> Text:
    """A column's name in another form."""
    return lambda text: re.sub(rf"(?<=[,\n])(?<![^,\n]){re.escape(old)}(?=[,\n])", new, "\n" + text, count=1)[1:]


def in_mm(new: str) -> Text:
    """`dx_m` in mm, under a name."""

    def change(text: str) -> str:
        frame = pd.read_csv(io.StringIO(text))
        frame["dx_m"] *= 1e3
        return frame.rename(columns={"dx_m": new}).to_csv(index=False)

    return change


def capitals(text: str) -> str:
    header, rest = text.split("\n", 1)
    return f"{header.upper()}\n{rest}"


def german(text: str) -> str:
    return text.replace(",", ";").replace(".", ",")


READ_AS: dict[str, tuple[Text, str]] = {
    "DX (mm)": (in_mm("DX (mm)"), "DX (mm) read as dx_m"),
    "dX [mm]": (in_mm("dX [mm]"), "dX [mm] read as dx_m"),
    "dx mm": (in_mm("dx mm"), "dx mm read as dx_m"),
    "Dx_MM": (in_mm("Dx_MM"), "Dx_MM read as dx_m"),
    "all in capitals": (capitals, "DX_M read as dx_m"),
    "Sequence": (renamed("sequence", "Sequence"), "Sequence read as sequence"),
    "Excel's own first line": (lambda text: "sep=;\n" + text.replace(",", ";"), "separated by semicolons"),
    "the same with decimal commas": (lambda text: '"sep=;"\n' + german(text), "decimal commas"),
}
"""Names that can mean one thing only: they are read so, and it is said."""

REFUSED: dict[str, tuple[Text, str]] = {
    "dxm": (renamed("dx_m", "dxm"), "column dxm: the column `dxm` is not known. Did you mean `dx_m`?"),
    "x without a unit": (renamed("x_m", "x"), "Did you mean `x_m`?"),
    "mass without a unit": (renamed("mass_kg", "Mass"), "Did you mean `mass_kg`?"),
    "rx without a unit": (renamed("rx_rad", "RX"), "Did you mean `rx_rad`?"),
    "Seq": (renamed("sequence", "Seq"), "column sequence: the column is missing. Is `Seq` meant?"),
    "Reihenfolge": (renamed("sequence", "Reihenfolge"), "Is `Reihenfolge` meant?"),
    "Serie": (renamed("series", "Serie"), "Is `Serie` meant?"),
    "FX_MN in capitals": (renamed("mass_kg", "FX_MN"), "the unit MN may be mN or MN"),
    "decimal commas between commas": (lambda text: text.replace(".", ","), "decimal commas between the commas?"),
    "two decimal marks": (lambda text: german(text).replace(",", ".", 1), "with a comma"),
}
"""Names and marks that cannot be read with certainty."""


def _book(change: Callable[[Workbook], None]) -> Callable[[str], bytes]:
    def made(text: str) -> bytes:
        book = Workbook()
        sheet = book.worksheets[0]
        sheet.title = "Monday"
        frame = pd.read_csv(io.StringIO(text))
        sheet.append(list(frame.columns))
        for row in frame.itertuples(index=False):
            sheet.append(list(row))
        change(book)
        stream = io.BytesIO()
        book.save(stream)
        return stream.getvalue()

    return made


def _second_sheet(book: Workbook) -> None:
    book.copy_worksheet(book.worksheets[0]).title = "Tuesday"


def _merged_header(book: Workbook) -> None:
    book.worksheets[0].merge_cells("C1:D1")


def _merged_cells(book: Workbook) -> None:
    book.worksheets[0].merge_cells("B2:B4")


def _hidden(book: Workbook) -> None:
    for row in (3, 5):
        book.worksheets[0].row_dimensions[row].hidden = True


WORKBOOKS: dict[str, tuple[Callable[[str], bytes], str]] = {
    "two sheets with data": (_book(_second_sheet), "the sheets `Monday` and `Tuesday` both hold a table"),
    "a merged header": (_book(_merged_header), "sheet `Monday`, C1:D1: cells of the table are merged"),
    "merged cells": (_book(_merged_cells), "sheet `Monday`, B2:B4: cells of the table are merged"),
    "hidden rows": (_book(_hidden), "2 hidden rows are read as the others (row 3, 5)"),
}

YAML: dict[str, tuple[str, str, str]] = {
    "decimal commas in a list": (
        "actuator_stiffness: [5.24e6, 5.24e6, 5.24e6, 5.24e6, 5.24e6, 5.24e6]",
        "actuator_stiffness: [5,24e6, 5,24e6, 5,24e6, 5,24e6, 5,24e6, 5,24e6]",
        "Are these decimal commas? Write points",
    ),
    "a decimal comma in one entry of a list": ("home: [0.0, 0.0, 0.3]", "home: [0, 0, 0,3]", "Write a point: `0.3`."),
    "an entry too many": ("home: [0.0, 0.0, 0.3]", "home: [0.0, 0.0, 0.3, 0.2]", "Correct the list."),
    "a decimal comma in a number": ("std: 0.01", "std: 0,01", "Is there a decimal comma before it? Write a point."),
    "decimal commas in a range": ("com_x_m: [-0.1, 0.1]", "com_x_m: [-0,1, 0,1]", "decimal commas?"),
    "a number in quotes": ("com_z_m: 0.12", 'com_z_m: "1.2e-1"', "a number is needed here"),
}
"""In the text of hexapod-h1.yaml with its robot: what stands there, what is written instead, and what is said."""

POINTS: dict[str, tuple[str, Text, str]] = {
    "two reflectors swapped": (
        "loaded.txt",
        lambda text: _swap(text, "loaded-2::a ", "loaded-2::c "),
        "loaded-2: the points a and c are swapped",
    ),
    "two reflectors swapped throughout": (
        "both",
        lambda text: _swap(text, "::a ", "::b "),
        "the points a and b are swapped: exchanged, all lie as the robot's `markers` say",
    ),
    "names in capitals": ("both", lambda text: text.replace("::a ", "::A ").replace("::b ", "::B "), "did you mean"),
    "names in capitals in one list": (
        "loaded.txt",
        lambda text: text.replace("::a ", "::A ").replace("::b ", "::B "),
        "differ in capitals: did you mean",
    ),
    "no points of an unloaded state": (
        "unloaded.txt",
        lambda text: "".join(line for line in text.splitlines(True) if "unloaded-2" not in line),
        "Name a set `unloaded-2`",
    ),
    "no points of a loaded row": (
        "loaded.txt",
        lambda text: "".join(line for line in text.splitlines(True) if "::loaded-2" not in line),
        "no points for row 2 of the plan",
    ),
    "decimal commas between commas": (
        "loaded.txt",
        lambda text: re.sub(r"(\d)\.(\d)", r"\1,\2", text.replace(" ", ",").replace("//,Units:,mm", "// Units: mm")),
        "whole numbers: are they three coordinates with decimal commas?",
    ),
}
"""In lists of points: which file, what becomes of it, and what `register` says."""


def _swap(text: str, first: str, second: str) -> str:
    return text.replace(first, "\0").replace(second, first).replace("\0", second)
