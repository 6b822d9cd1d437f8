"""Tables as other programs save them: encodings, separators, decimal marks, workbooks, files cut off."""

import io
import logging
import time
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from openpyxl import Workbook, load_workbook

from expdesign.errors import InputError
from expdesign.io.excel import workbook
from expdesign.io.table import parse_table, read_table
from expdesign.io.written import Purpose
from expdesign.report.result import TableResult

PLAIN = "sequence,dx_m,note\n1,0.5,Müller\n2,-1.25e-6,µ\n"
SEMICOLONS = PLAIN.replace(",", ";")
GERMAN = SEMICOLONS.replace(".", ",")


@pytest.mark.parametrize(
    ("data", "note"),
    [
        (PLAIN.encode(), ""),
        (b"\xef\xbb\xbf" + PLAIN.encode(), ""),
        (PLAIN.replace("\n", "\r\n").encode(), ""),
        (PLAIN.replace("\n", "\r").encode(), ""),
        (PLAIN.encode("utf-16"), "read as UTF-16"),
        (b"\xfe\xff" + PLAIN.encode("utf-16-be"), "read as UTF-16"),
        (PLAIN.encode("cp1252"), "read as CP1252"),
        (SEMICOLONS.encode(), "columns separated by semicolons"),
        (PLAIN.replace(",", "\t").encode(), "columns separated by tabulators"),
        (GERMAN.encode(), "columns separated by semicolons; decimal commas"),
        (GERMAN.replace("\n", "\r\n").encode("cp1252"), "CP1252 (Windows), as it is not UTF-8; columns separated"),
        (GERMAN.replace(";", "\t").encode("utf-16"), "read as UTF-16; columns separated by tabulators; decimal commas"),
    ],
)
def test_one_table_in_many_forms(data: bytes, note: str, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "t.csv").write_bytes(data)
    with caplog.at_level(logging.INFO, "expdesign"):
        table = read_table(tmp_path / "t.csv")
    np.testing.assert_array_equal(table.numbers(("sequence", "dx_m")), [[1, 0.5], [2, -1.25e-6]])
    assert table.frame["note"].tolist() == ["Müller", "µ"]
    assert note in caplog.text
    assert bool(caplog.text) == bool(note)


def test_a_file_cut_off_is_refused_unless_only_its_last_cell_is_concerned() -> None:
    text = 'sequence,series,dx_m,sx_m\n1,1,1.5e-6,"1e-7"\n2,1,2.5e-6,1e-7\n'
    whole = parse_table(text, "t.csv").frame
    refused = 0
    for length in range(len(text) - 2):
        try:
            frame = parse_table(text[:length], "t.csv").frame
        except InputError:
            refused += 1
            continue
        assert frame.iloc[:, :-1].equals(whole.iloc[: len(frame), :-1]), text[:length]
        assert frame.iloc[:-1].equals(whole.iloc[: len(frame) - 1]), text[:length]
    assert refused > 45


@pytest.mark.parametrize(
    ("text", "what", "remedy"),
    [
        ("a_x;dx_m\n1,5;2\n1.5;3\n", "with a comma .1,5 in row 2. and with a point .1.5 in row 3.", "in one way"),
        ('dx_m,note\n1,"abc\n2,3\n', "ends within a quoted cell that begins in row 2", "Is the file cut off?"),
        ("dx_m,note\n1,a\n2", "1 cells and the header has 2", "Is the file cut off?"),
    ],
)
def test_what_is_refused(text: str, what: str, remedy: str) -> None:
    with pytest.raises(InputError, match=what) as error:
        parse_table(text, "t.csv")
    assert remedy in error.value.remedy


def test_binary_files_and_half_an_utf16_file(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(b"dx_m\n\x00\x01\x02\n")
    with pytest.raises(InputError, match="not UTF-8 text"):
        read_table(path)
    path.write_bytes("dx_m\n1\n".encode("utf-16")[:-1])
    with pytest.raises(InputError, match="not whole UTF-16") as error:
        read_table(path)
    assert "cut off" in error.value.remedy


def book(sheets: dict[str, list[list[object]]]) -> bytes:
    made = Workbook()
    made.remove(made.worksheets[0])
    for title, rows in sheets.items():
        sheet = made.create_sheet(title)
        for row in rows:
            sheet.append(row)
    stream = io.BytesIO()
    made.save(stream)
    return stream.getvalue()


def test_a_sheet_of_a_workbook(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    rows: list[list[object]] = [["sequence", "dx_mm", "note", None], [1, 0.5, "a"], [None], [2, -1.25e-3, None]]
    data = book({"Cover": [["Report of"], ["me"]], "Tabelle1": rows})
    for name in ("t.xlsx", "named.csv"):
        (tmp_path / name).write_bytes(data)
        with caplog.at_level(logging.INFO, "expdesign"):
            table = read_table(tmp_path / name)
        np.testing.assert_array_equal(table.numbers(("sequence", "dx_m")), [[1, 0.5e-3], [2, -1.25e-6]])
        assert table.lines.tolist() == [2, 4]
    assert "t.xlsx: read sheet `Tabelle1`; converted: dx_mm to dx_m" in caplog.text
    with pytest.raises(InputError, match="the column is missing") as error:
        table.require(("series",))
    assert "sheet `Tabelle1`, column series" in error.value.where


def test_workbooks_that_cannot_be_read(tmp_path: Path) -> None:
    path = tmp_path / "t.xlsx"
    data = book({"a": [["sequence"], [1]]})
    for cut in (data[: len(data) // 2], data[:200], b"no workbook at all", b""):
        path.write_bytes(cut)
        with pytest.raises(InputError, match="cannot be opened as an Excel workbook") as error:
            read_table(path)
        assert error.value.where == str(path)
        assert "cut off" in error.value.remedy
    path.write_bytes(book({"a": [], "b": []}))
    with pytest.raises(InputError, match="the workbook is empty"):
        read_table(path)
    path.write_bytes(book({"a": [["Dear Sir"], ["yours"]]}))
    with pytest.raises(InputError, match="the column is missing"):
        read_table(path).require(("sequence", "series"))


def test_what_is_written_reads_back(tmp_path: Path) -> None:
    generator = np.random.default_rng(1)
    frame = pd.DataFrame({"sequence": np.arange(1, 101), "x_m": generator.normal(size=100), "note": ["ä"] * 100})
    TableResult(frame, purpose=Purpose("test")).save(tmp_path / "t.xlsx")
    table = read_table(tmp_path / "t.xlsx")
    np.testing.assert_allclose(table.numbers(("x_m",))[:, 0], frame["x_m"], rtol=5e-16)  # 16 digits
    assert table.frame["note"].tolist() == ["ä"] * 100
    sheets = load_workbook(io.BytesIO(workbook(frame, notes=["one", "two"], blank="FFFFCC"))).sheetnames
    assert sheets == ["recordings", "notes"]


def test_a_stray_cell_far_from_the_table(tmp_path: Path) -> None:
    book = Workbook()
    sheet = book.worksheets[0]
    sheet.append(["sequence", "dz_m"])
    sheet.append([1, 0.5])
    sheet["A1048576"] = "end"
    book.save(tmp_path / "rows.xlsx")
    started = time.perf_counter()
    table = read_table(tmp_path / "rows.xlsx")
    assert time.perf_counter() - started < 5.0  # all cells between were made before: more than a minute
    assert table.lines.tolist() == [2, 1048576]


def test_a_workbook_that_unpacks_to_more_than_a_table(tmp_path: Path) -> None:
    path = tmp_path / "rows.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/worksheets/sheet1.xml", b" " * 50_000_000)
    with pytest.raises(InputError, match="which no table does"):
        read_table(path)


def test_a_text_is_no_formula() -> None:
    frame = pd.DataFrame({"note": ['=HYPERLINK("x")', "+1a", "bell \a"]})
    sheet = load_workbook(io.BytesIO(workbook(frame))).worksheets[0]
    assert [cell.data_type for cell in sheet["A"]] == ["s"] * 4
    assert sheet["A2"].value == '=HYPERLINK("x")'
