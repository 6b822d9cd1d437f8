"""Every fault of recordings is answered with file, row and column; what is right is read, in one file or several."""

import logging
from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from expdesign.app.api.points_said import say_unknown_columns
from expdesign.chain.recordings.filled_in import check_structure
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.reader import recordings_from_tables
from expdesign.errors import InputError
from tests import oracle
from tests.cases import robot
from tests.identification.experiments import experiment, read, table_of

Fault = Callable[[pd.DataFrame], pd.DataFrame]


def valid() -> pd.DataFrame:
    made = experiment("H1", 6)
    return made.frame(made.noisy(np.random.default_rng(1)))


def put(column: str, row: int, value: object) -> Fault:
    """The file with one cell changed; `row` counts data rows from 0."""

    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame = frame.astype(object)
        frame.loc[row, column] = value
        return frame

    return change


def without(*columns: str) -> Fault:
    return lambda frame: frame.drop(columns=list(columns))


def with_column(name: str, values: object) -> Fault:
    return lambda frame: frame.assign(**{name: values})  # type: ignore[arg-type]


WRENCH = ("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")


DEFLECTION = ("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad")


#: name: (fault, what the message says, place).
FAULTS: dict[str, tuple[Fault, str, str]] = {
    "no sequence": (without("sequence"), "missing", "column sequence"),
    "no series": (without("series"), "missing", "column series"),
    "no pose": (without("rz_rad"), "missing", "column rz_rad"),
    "misspelt": (lambda f: f.rename(columns={"series": "serie"}), "Is `serie` meant", "column series"),
    "a force is missing": (without("fz_N"), "missing", "column fz_N"),
    "no load": (without(*WRENCH), "no load", "recordings.csv"),
    "nothing measured": (without(*DEFLECTION), "no measured column", "recordings.csv"),
    "NaN": (put("dz_m", 3, "NaN"), "not a finite number", "row 5, column dz_m"),
    "infinite": (put("fx_N", 0, "inf"), "not a finite number", "row 2, column fx_N"),
    "empty cell": (put("my_Nm", 2, ""), "empty", "row 4, column my_Nm"),
    "text": (put("x_m", 1, "1 mm"), "`1 mm` is not", "row 3, column x_m"),
    "fraction": (put("series", 1, 1.5), "not a whole number", "row 3, column series"),
    "repeated sequence": (put("sequence", 4, 2), "appears twice", "row 6, column sequence"),
    "s zero": (put("sy_m", 2, 0.0), "must be positive", "row 4, column sy_m"),
    "s negative": (put("srx_rad", 5, -1e-6), "must be positive", "row 7, column srx_rad"),
    "s in micrometres": (put("sx_m", 0, 0.5), "cannot be the standard deviation", "row 2, column sx_m"),
    "one s is missing": (without("sz_m"), "missing", "column sz_m"),
    "3 m deflection": (put("dx_m", 1, 3.0), "cannot be a deflection", "row 3, column dx_m"),
    "rotation in degrees": (put("drz_rad", 1, -0.5), "cannot be a deflection", "row 3, column drz_rad"),
    "pose in mm": (put("z_m", 0, 12.0), "times as long", "row 2, column z_m"),
    "pose in degrees": (put("ry_rad", 5, 8.0), "cannot be an angle", "row 7, column ry_rad"),
    "two commands": (put("y_m", 3, 0.0), "differs from that of the first row of series 2", "row 5, column y_m"),
    "time runs back": (with_column("time_s", [0.0, 1.0, 2.0, 1.5, 4.0, 5.0]), "backwards", "row 5, column time_s"),
    "split": (with_column("split", ["train"] * 5 + ["tset"]), "neither", "row 7, column split"),
    "a leg's temperature is missing": (with_column("leg1_degC", 20.0), "missing", "column leg2_degC"),
    "temperature": (with_column("temperature_degC", ["20"] * 5 + ["warm"]), "`warm`", "row 7, column temperature_degC"),
    "negative mass": (
        lambda f: f.drop(columns=list(WRENCH)).assign(
            mass_kg=[1, 2, 3, -4, 5, 6], com_x_m=0.0, com_y_m=0.0, com_z_m=0.0
        ),
        "cannot be negative",
        "row 5, column mass_kg",
    ),
    "no centre of mass": (lambda f: f.drop(columns=list(WRENCH)).assign(mass_kg=1.0), "missing", "column com_x_m"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_with_its_place(fault: str) -> None:
    change, says, place = FAULTS[fault]
    with pytest.raises(InputError) as caught:
        read(change(valid()), robot("H1"))
    assert says in caught.value.message
    assert caught.value.where.endswith(place)
    assert caught.value.where.startswith("recordings.csv")


#: Faults that can only be seen with the robot.
NEED_ROBOT = {"pose in mm", "pose in degrees", "a leg's temperature is missing"}


@pytest.mark.parametrize("fault", sorted(set(FAULTS) - NEED_ROBOT))
def test_the_structural_check_finds_the_same_faults_without_a_robot(fault: str) -> None:
    change, says, place = FAULTS[fault]
    with pytest.raises(InputError) as caught:
        check_structure(table_of(change(valid())))
    assert says in caught.value.message
    assert caught.value.where.endswith(place)


def test_the_structural_check_describes_what_is_there() -> None:
    text = check_structure(table_of(valid().assign(split=["train"] * 4 + ["test"] * 2)))
    assert "6 rows in 3 series, 2 of them for testing" in text
    assert "dz_m" in text


def test_rows_are_read_in_the_order_of_their_sequence() -> None:
    frame = valid()
    shuffled = frame.sample(frac=1.0, random_state=3)
    expected, found = read(frame, robot("H1")), read(shuffled, robot("H1"))
    for name in ("sequence", "series", "configurations", "wrenches", "deflections", "deviations"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    np.testing.assert_array_equal(found.lines, 2 + np.argsort(shuffled["sequence"].to_numpy()))


def test_no_load_needs_no_centre_of_mass() -> None:
    """An empty cell is 0 where nothing is carried, and named where something is."""
    frame = valid().drop(columns=list(WRENCH)).assign(com_x_m=0.05, com_y_m=-0.02, com_z_m=0.1)
    frame["mass_kg"] = [0.0, *[10.0] * (len(frame) - 1)]
    empty = frame.astype({"com_x_m": object})
    empty.loc[0, "com_x_m"] = ""
    np.testing.assert_array_equal(read(empty, robot("H1")).wrenches, read(frame, robot("H1")).wrenches)
    empty.loc[2, "com_x_m"] = ""
    with pytest.raises(InputError, match="the cell is empty") as raised:
        read(empty, robot("H1"))
    assert "row 4, column com_x_m" in raised.value.where


@pytest.mark.parametrize(
    ("added", "what", "column"),
    [
        ({"mass_lb": 5.0}, "the unit `lb` is not known", "mass_lb"),
        ({"fz_lbf": 5.0}, "the unit `lbf` is not known", "fz_lbf"),
        ({"fx_N": 1.0, "fz_lbf": 5.0}, "the unit `lbf` is not known", "fz_lbf"),
        ({"mass_kg": 10.0, "fz_N": -98.0}, "`mass_kg` and `fz_N` state two loads", "fz_N"),
    ],
)
def test_a_load_in_an_unknown_unit_or_stated_twice_is_named(added: dict[str, float], what: str, column: str) -> None:
    centre = {"com_x_m": 0.05, "com_y_m": -0.02, "com_z_m": 0.1}
    frame = valid().drop(columns=list(WRENCH)).assign(**centre, **dict.fromkeys(WRENCH[1:2], 0.0)).assign(**added)
    frame = frame.drop(columns=WRENCH[1] if len(added) == 1 or "mass_kg" in added else [])
    with pytest.raises(InputError, match=what) as raised:
        read(frame, robot("H1"))
    assert raised.value.where.endswith(f"column {column}")
    assert raised.value.remedy


def test_a_payload_makes_the_wrench_of_the_conventions() -> None:
    frame = valid().drop(columns=list(WRENCH)).assign(mass_kg=10.0, com_x_m=0.05, com_y_m=-0.02, com_z_m=0.1)
    found = read(frame, robot("H1"))
    turned = oracle.rotation(found.configurations[:, 3:], "fixed-xyz")
    parameters = np.tile([10.0, 0.05, -0.02, 0.1, 0.0, 0.0, -9.80665], (len(turned), 1))
    np.testing.assert_allclose(found.wrenches, oracle.payload_wrench(parameters, turned), atol=1e-12)


@pytest.mark.parametrize(("factor", "contradicts"), [(1.005, False), (1.02, True), (-1.0, True)])
def test_a_wrench_may_not_contradict_the_payload(factor: float, contradicts: bool) -> None:
    frame = valid().drop(columns=list(WRENCH)).assign(mass_kg=10.0, com_x_m=0.05, com_y_m=-0.02, com_z_m=0.1)
    wrenches = read(frame, robot("H1")).wrenches.copy()
    wrenches[4] *= factor
    both = frame.assign(**{name: wrenches[:, i] for i, name in enumerate(WRENCH)})
    if not contradicts:
        np.testing.assert_array_equal(read(both, robot("H1")).wrenches[0], wrenches[0])
        return
    with pytest.raises(InputError, match="contradicts the payload") as caught:
        read(both, robot("H1"))
    assert "row 6, column f" in caught.value.where


def test_what_is_said_of_columns_without_a_meaning(caplog: pytest.LogCaptureFixture) -> None:
    """Numbers in every row that vary are what a diagnosis compares residuals with; nothing else is used."""
    made = valid()
    numbers = np.arange(len(made), dtype=float)
    gaps = np.where(numbers == 2.0, np.nan, numbers)
    found = read(made.assign(operator="Ada", humidity=numbers, gaps=gaps, room=21.0), robot("H1"))
    assert list(found.further) == ["humidity"]
    with caplog.at_level(logging.INFO, "expdesign"):
        say_unknown_columns(found)
    kept, used = caplog.messages
    assert kept.endswith("kept but not used: operator, gaps, room")
    assert "`diagnose` alone uses" in used
    assert used.endswith(": humidity")


def test_points_need_neither_sequence_nor_measured_columns() -> None:
    frame = valid().drop(columns=["sequence", "series", *DEFLECTION])
    points = points_from_table(table_of(frame), robot("H1"))
    np.testing.assert_array_equal(points.series, points.sequence)
    np.testing.assert_array_equal(points.lines, np.arange(2, 8))


def test_some_components_may_not_be_measured() -> None:
    found = read(
        valid()[["sequence", "series", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad", *WRENCH, "dz_m"]], robot("H1")
    )
    np.testing.assert_array_equal(found.axes, [2])
    assert found.deviations is None


def test_gravity_of_a_row_loads_its_payload() -> None:
    frame = valid().drop(columns=list(WRENCH)).assign(mass_kg=2.0, com_x_m=0.0, com_y_m=0.0, com_z_m=0.0, gx_m_s2=3.0)
    found = read(frame, robot("H1"))
    np.testing.assert_allclose(found.wrenches[:, :3], np.tile([6.0, 0.0, -19.6133], (6, 1)))


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
