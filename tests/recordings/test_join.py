"""Several files are read as one."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.chain.recordings.reader import join
from expdesign.errors import InputError
from tests.cases import robot
from tests.identification.experiments import experiment, read


def test_a_file_split_in_two_reads_as_the_whole() -> None:
    made = experiment("H1", 9)
    frame = made.frame(made.exact).assign(time_s=np.arange(9.0))
    whole = read(frame, robot("H1"))
    odd, even = read(frame.iloc[1::2], robot("H1"), "odd.csv"), read(frame.iloc[::2], robot("H1"), "even.csv")
    together = join([odd, even])
    for name in ("sequence", "series", "time", "configurations", "wrenches", "deflections", "deviations", "test"):
        np.testing.assert_array_equal(getattr(together, name), getattr(whole, name))
    assert together.where(1) == "odd.csv, row 2"
    assert together.where(2, "dx_m") == "even.csv, row 3, column dx_m"


def test_sessions_with_the_same_numbers_are_counted_on() -> None:
    made = experiment("H1", 4)
    frame = made.frame(made.exact).assign(time_s=[0.0, 1.0, 2.0, 3.0])
    first, second = read(frame, robot("H1"), "monday.csv"), read(frame, robot("H1"), "tuesday.csv")
    together = join([first, second])
    np.testing.assert_array_equal(together.sequence, np.arange(1, 9))
    np.testing.assert_array_equal(together.series, [1, 1, 2, 2, 3, 3, 4, 4])
    assert together.time is not None
    assert np.all(np.diff(together.time) >= 0.0)
    assert together.where(5) == "tuesday.csv, row 3"


def test_files_need_the_same_columns() -> None:
    made = experiment("H1", 4)
    whole = read(made.frame(made.exact), robot("H1"), "a.csv")
    with pytest.raises(InputError, match="deviations is known in only one"):
        join([whole, read(made.frame(made.exact, stated=False), robot("H1"), "b.csv")])
    with pytest.raises(InputError, match="measured columns are not those") as caught:
        join([whole, read(made.frame(made.exact).drop(columns=["dx_m"]), robot("H1"), "c.csv")])
    assert caught.value.where == "c.csv"


def test_markers_are_numbered_over_all_files() -> None:
    made = experiment("H1", 3)
    plain = read(made.frame(made.exact), robot("H1"), "a.csv")
    first = replace(plain, marker=np.array([0, 1, 0]), markers=("left", "right"))
    second = replace(
        read(made.frame(made.exact), robot("H1"), "b.csv"), marker=np.array([1, 0, 0]), markers=("right", "top")
    )
    together = join([first, second])
    assert together.markers == ("left", "right", "top")
    assert together.marker is not None
    assert [together.markers[index] for index in together.marker] == ["left", "right", "left", "top", "right", "right"]
