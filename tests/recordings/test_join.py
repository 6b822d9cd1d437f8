"""Several files are read as one."""

import numpy as np
import pytest

from expdesign.chain.recordings.reader import recordings_from_tables
from expdesign.errors import InputError
from tests.cases import robot
from tests.identification.experiments import experiment, read, table_of

AXES = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")


def test_a_file_split_in_two_reads_as_the_whole() -> None:
    made = experiment("H1", 9)
    frame = made.frame(made.exact).assign(time_s=np.arange(9.0))
    whole = read(frame, robot("H1"))
    tables = [table_of(frame.iloc[1::2], "odd.csv"), table_of(frame.iloc[::2], "even.csv")]
    together = recordings_from_tables(tables, robot("H1"))
    for name in ("sequence", "series", "time", "configurations", "wrenches", "deflections", "deviations", "test"):
        np.testing.assert_array_equal(getattr(together, name), getattr(whole, name))
    assert together.where(1) == "odd.csv, row 2"
    assert together.where(2, "dx_m") == "even.csv, row 3, column dx_m"


def test_sessions_with_the_same_numbers_are_counted_on() -> None:
    made = experiment("H1", 4)
    frame = made.frame(made.exact).assign(time_s=[0.0, 1.0, 2.0, 3.0])
    tables = [table_of(frame, "monday.csv"), table_of(frame, "tuesday.csv")]
    together = recordings_from_tables(tables, robot("H1"))
    np.testing.assert_array_equal(together.sequence, np.arange(1, 9))
    np.testing.assert_array_equal(together.series, [1, 1, 2, 2, 3, 3, 4, 4])
    assert together.time is not None
    assert np.all(np.diff(together.time) >= 0.0)
    assert together.where(5) == "tuesday.csv, row 3"


def test_files_need_the_same_columns() -> None:
    made = experiment("H1", 4)
    whole, unstated = table_of(made.frame(made.exact), "a.csv"), made.frame(made.exact, stated=False)
    with pytest.raises(InputError, match=r"s\w+ is in only one of a.csv and b.csv"):
        recordings_from_tables([whole, table_of(unstated, "b.csv")], robot("H1"))
    with pytest.raises(InputError, match=r"dx_m is in only one of a.csv and c.csv") as caught:
        recordings_from_tables([whole, table_of(made.frame(made.exact).drop(columns=["dx_m"]), "c.csv")], robot("H1"))
    assert caught.value.where == "c.csv"


def test_markers_are_numbered_over_all_files() -> None:
    made = experiment("H1", 3)
    frame = made.frame(made.exact).drop(columns=[f"{kind}{name}" for kind in "ds" for name in AXES])
    frame = frame.assign(px_m=[0.0, 1.0, 2.0], py_m=0.0, pz_m=0.0)
    first, second = frame.assign(marker=["left", "right", "left"]), frame.assign(marker=["top", "right", "right"])
    together = recordings_from_tables([table_of(first, "a.csv"), table_of(second, "b.csv")], robot("H1"))
    assert together.markers == ("left", "right", "top")
    assert together.marker is not None
    assert [together.markers[index] for index in together.marker] == ["left", "right", "left", "top", "right", "right"]
