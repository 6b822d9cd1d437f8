"""What a person filled in: empty rows and columns are left out, readings become deflections from their references."""

import logging
import re

import numpy as np
import pytest

from expdesign.chain.recordings.filled_in import check_structure
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.recordings.references import groups
from expdesign.errors import InputError
from expdesign.io.table import parse_table
from tests.cases import symmetric_hexapod

ROBOT = symmetric_hexapod(0.24, 0.17, 0.30, 0.03, 5.24e6)
HEAD = "sequence,series,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad,mass_kg,com_x_m,com_y_m,com_z_m,"
POSE = ",0,0,0,0,0,0,"


def row(sequence: int, series: int, mass: float, cells: str) -> str:
    return f"{sequence},{series}{POSE}{mass},0.1,0,0.12,{cells}\n"


def read(text: str) -> Recordings:
    table = parse_table(text, "t.csv")
    check_structure(table)
    return recordings_from_table(table, ROBOT)


def test_rows_and_columns_that_are_empty_are_left_out(caplog: pytest.LogCaptureFixture) -> None:
    text = HEAD + "dz_m,drx_rad,sz_m,time_min,temperature_degC\n"
    text += row(1, 1, 5, "-1e-6,,1e-7,,") + row(2, 1, 5, ",,1e-7,,") + row(3, 1, 5, "-2e-6,,1e-7,,")
    with caplog.at_level(logging.INFO, "expdesign"):
        found = read(text)
    assert found.lines.tolist() == [2, 4]
    assert found.axes.tolist() == [2]
    assert found.time is None
    assert found.temperature is None
    assert "1 row left out: no measured value (row 3)" in caplog.text
    assert "drx_rad, time_s, temperature_degC" in caplog.text


@pytest.mark.parametrize(
    ("cells", "what"),
    [((",,", ",,"), "nothing is filled in under dz_m, drx_rad"), (("1e-6,,", "1e-6,1e-6,"), "the cell is empty")],
)
def test_nothing_and_half_of_it_is_refused(cells: tuple[str, ...], what: str) -> None:
    with pytest.raises(InputError, match=re.escape(what)):
        read(HEAD + "dz_m,drx_rad,sz_m\n" + "".join(row(i + 1, 1, 5, cell) for i, cell in enumerate(cells)))


def test_readings_are_counted_from_the_reference_before(caplog: pytest.LogCaptureFixture) -> None:
    """Own references (R L R L), a shared one (R L L), and a row without load at the end, which is a measurement."""
    text = HEAD + "reading_z_um,sz_m\n"
    text += row(1, 1, 0, "100,1e-7") + row(2, 1, 5, "97,1e-7") + row(3, 1, 0, "101,1e-7") + row(4, 1, 5, "99,1e-7")
    text += row(5, 2, 0, "-50,1e-7") + row(6, 2, 5, "-52,1e-7") + row(7, 2, 26, "-60,1e-7") + row(8, 2, 0, "-49,1e-7")
    with caplog.at_level(logging.INFO, "expdesign"):
        found = read(text)
    assert found.sequence.tolist() == [2, 4, 6, 7, 8]
    np.testing.assert_allclose(found.deflections[:, 0], [-3e-6, -2e-6, -2e-6, -10e-6, 1e-6], rtol=1e-9)
    assert "readings of 5 rows counted from 3 reference rows" in caplog.text
    assert found.references is not None
    assert groups(found.references).tolist() == [0, 1, 2, 2, 2]
    assert "share its noise" in caplog.text


def test_the_reference_stays_where_time_or_temperature_are_counted_from_it() -> None:
    text = HEAD + "reading_z_um,time_min\n" + row(1, 1, 0, "100,0") + row(2, 1, 5, "97,2")
    found = read(text)
    assert found.sequence.tolist() == [1, 2]
    assert found.time.tolist() == [0.0, 120.0]
    np.testing.assert_allclose(found.deflections[:, 0], [0.0, -3e-6], rtol=1e-9)


@pytest.mark.parametrize(
    ("text", "what", "where"),
    [
        (row(1, 7, 5, "97,"), "series 7 does not begin with a row without load", "t.csv, row 2, column series"),
        (
            row(1, 1, 0, "100,1e-6") + row(2, 1, 5, "9,1e-6"),
            "there are readings together with the deflections",
            "t.csv",
        ),
    ],
)
def test_readings_that_cannot_be_used(text: str, what: str, where: str) -> None:
    with pytest.raises(InputError, match=what) as error:
        read(HEAD + "reading_z_um,dz_m\n" + text)
    assert error.value.where.startswith(where)
    assert error.value.remedy
