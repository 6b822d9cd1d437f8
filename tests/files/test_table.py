"""Tables whose errors say on which line and in which column."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from expdesign.chain.recordings.columns import COLUMNS
from expdesign.errors import InputError
from expdesign.io.table import parse_table, read_table
from expdesign.io.tables_in_units import in_si


def test_numbers_integers_and_text() -> None:
    table = parse_table('sequence, x_m ,note\n1, 1e-3,a\n2,-.5,"b, c"\n', "t.csv")
    assert table.columns == ["sequence", "x_m", "note"]
    assert len(table) == 2
    np.testing.assert_array_equal(table.numbers(("x_m", "sequence")), [[1e-3, 1.0], [-0.5, 2.0]])
    np.testing.assert_array_equal(table.integers("sequence"), [1, 2])
    assert list(table.frame["note"]) == ["a", "b, c"]
    assert table.has("x_m", "note")
    assert not table.has("x_m", "y_m")


def test_windows_line_ends_and_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(b"\xef\xbb\xbfx_m,y_m\r\n1,2\r\n")
    np.testing.assert_array_equal(read_table(path).numbers(("x_m", "y_m")), [[1.0, 2.0]])


@pytest.mark.parametrize(
    "cell", ["", "  ", "nan", "inf", "-Infinity", "1,5", "abc", "1e", "--", "1e400", "None", "true"]
)
def test_cells_that_are_not_numbers(cell: str) -> None:
    quoted = f'"{cell}"'
    table = parse_table(f"x_m,y_m\n1,2\n\n3,{quoted}\n", "t.csv")
    with pytest.raises(InputError) as error:
        table.numbers(("x_m", "y_m"))
    assert error.value.where == "t.csv, row 4, column y_m"
    assert error.value.remedy
    assert ("a point instead of a comma" in error.value.remedy) == ("," in cell)


@pytest.mark.parametrize("cell", ["1.5", "1e20", "-1e18"])
def test_cells_that_are_not_whole_numbers(cell: str) -> None:
    table = parse_table(f"series\n1\n{cell}\n", "t.csv")
    with pytest.raises(InputError, match="whole number") as error:
        table.integers("series")
    assert error.value.where == "t.csv, row 3, column series"


def test_a_row_is_a_line_of_the_file_even_after_cells_of_several_lines() -> None:
    table = parse_table('x_m,note\n1,"two\nlines"\n\nabc,last\n', "t.csv")
    with pytest.raises(InputError) as error:
        table.numbers(("x_m",))
    assert error.value.where == "t.csv, row 5, column x_m"


@pytest.mark.parametrize(
    ("text", "what", "where"),
    [
        ("", "empty", "t.csv"),
        ("\n\n", "empty", "t.csv"),
        ("x_m,y_m\n", "no rows", "t.csv"),
        ("x_m,x_m\n1,2\n", "twice", "t.csv, row 1"),
        ("x_m,,\n1,2,3\n", "without a name", "t.csv, row 1"),
        ("x_m,y_m\n1,2\n1,2,3\n", "3 cells", "t.csv, row 3"),
        ("x_m,y_m\n1\n", "1 cells", "t.csv, row 2"),
    ],
)
def test_broken_tables(text: str, what: str, where: str) -> None:
    with pytest.raises(InputError, match=what) as error:
        parse_table(text, "t.csv")
    assert error.value.where == where
    assert error.value.remedy


def test_missing_columns_suggest_the_nearest() -> None:
    table = parse_table("x_m,yy_m\n1,2\n", "t.csv")
    with pytest.raises(InputError, match="missing") as error:
        table.numbers(("x_m", "y_m"))
    assert error.value.where == "t.csv, column y_m"
    assert "`yy_m`" in error.value.remedy


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file") as error:
        read_table(tmp_path / "none.csv")
    assert str(tmp_path / "none.csv") in error.value.where


@pytest.mark.parametrize(
    ("written", "known"), [("J1", "q1_rad"), ("Joint 3", "q3_rad"), ("Achse 6", "q6_rad"), ("q0", None)]
)
def test_joints_as_controllers_call_them_are_recognised(written: str, known: str | None) -> None:
    """Controllers count joints from 1; q0 is part of a quaternion."""
    assert COLUMNS.meant(written) == known


def test_a_joint_of_a_urdf_keeps_its_name_whatever_that_is() -> None:
    """Joints of many URDFs are called j1 to j6; where `q1_rad` is missing, its place may be taken by `j1_rad`."""
    rows = pd.DataFrame({"j1_rad": ["0.1"], "motor3_rad": ["0.2"]})
    assert in_si(rows, "t.csv", COLUMNS)[0].columns.tolist() == ["j1_rad", "motor3_rad"]
    assert COLUMNS.hint("j1_rad") == "q1_rad"
    with pytest.raises(InputError, match="`J1` is not known"):
        in_si(rows.rename(columns={"j1_rad": "J1"}), "t.csv", COLUMNS)
