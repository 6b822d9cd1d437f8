"""The text of a table as programs save it: encodings, separators and decimal marks, found out and reported."""

import csv
import io
import re

from expdesign.errors import InputError
from expdesign.io.units import NUMBER

_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
_STATED = re.compile(r"\s*(?P<line>\"?sep=(?P<mark>[,;\t])\"?)[;,\t ]*(?=\r?\n|\r)", re.IGNORECASE)
"""The line with which Excel is told the separator."""
_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabulators"}

Rows = list[tuple[int, list[str]]]
"""Cells with the line of the file on which each row stands."""


def decoded(data: bytes, source: str) -> tuple[str, list[str]]:
    """The text of bytes in UTF-8 (with or without a byte-order mark), UTF-16 or CP1252, and notes on what was found.

    Raises:
        InputError: they are no text.
    """
    try:
        if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
            return data.decode("utf-16"), ["read as UTF-16"]
        text, notes = data.decode("utf-8-sig"), []
    except UnicodeDecodeError as error:
        if error.encoding.startswith("utf-16"):
            remedy = "Is the file cut off? Save it again, as UTF-8 text."
            raise InputError("not whole UTF-16 text", where=source, remedy=remedy) from None
        try:
            text, notes = data.decode("cp1252"), ["read as CP1252 (Windows), as it is not UTF-8"]
        except UnicodeDecodeError:
            what = f"neither UTF-8 nor CP1252 text (byte {error.start})"
            raise InputError(what, where=source, remedy="Save the file as UTF-8 text.") from None
    if "\0" in text:
        what = f"not UTF-8 text (byte {text.index(chr(0))} is zero)"
        raise InputError(what, where=source, remedy="Save the file as UTF-8 text.")
    return text, notes


def separated(text: str, source: str) -> tuple[Rows, list[str]]:
    """The cells of a table separated by commas, semicolons or tabulators, and notes on what was found.

    A first line such as `sep=;` states the separator. Else names of columns have no such mark in them, so that the
    one that the header has most of is the separator. Where it is not the comma, numbers may be written with a decimal
    comma.

    Raises:
        InputError: the text is no table, or numbers are written in two ways.
    """
    stated = _STATED.match(text)
    if stated is not None:
        text = text[stated.end() :]  # its line end stays, so that lines keep their numbers
    header = next((line for line in text.splitlines() if line.strip(' \t,;"')), "")
    separator = max(_SEPARATORS, key=header.count) if any(map(header.count, _SEPARATORS)) else ","
    separator = separator if stated is None else stated.group("mark")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    rows, line = [], 1
    try:
        for row in reader:
            rows.append((line, row))
            line = reader.line_num + 1  # a quoted cell may go over several lines
    except csv.Error as error:
        what = f"not a CSV table: {error}"
        if "unexpected end" in str(error):
            what = f"the table ends within a quoted cell that begins in row {line}"
        remedy = "Is the file cut off? Save it as comma-separated text."
        raise InputError(what, where=source, remedy=remedy) from None
    if separator == ",":
        return rows, []
    notes = [f"columns separated by {_SEPARATORS[separator]}"]
    if _with_decimal_points(rows, source):
        notes.append("decimal commas")
    return rows, notes


def _with_decimal_points(rows: Rows, source: str) -> bool:
    """Write decimal commas of columns of numbers as points; whether there were some."""
    commas: str = ""
    points: str = ""
    body = [row for _, row in rows if any(cell.strip() for cell in row)][1:]
    lines = [line for line, row in rows if any(cell.strip() for cell in row)][1:]
    for column in range(max(map(len, body), default=0)):
        cells = [row[column].strip() if column < len(row) else "" for row in body]
        if not all(cell == "" or NUMBER.fullmatch(cell) or _DECIMAL_COMMA.fullmatch(cell) for cell in cells):
            continue
        for line, row, cell in zip(lines, body, cells, strict=True):
            if _DECIMAL_COMMA.fullmatch(cell):
                commas = commas or f"{cell} in row {line}"
                row[column] = cell.replace(",", ".")
            elif "." in cell:
                points = points or f"{cell} in row {line}"
    if commas and points:
        what = f"numbers are written with a comma ({commas}) and with a point ({points})"
        raise InputError(what, where=source, remedy="Write all of them in one way.")
    return bool(commas)
