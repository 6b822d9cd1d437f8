"""Lists of points in the forms that trackers' software writes."""

from pathlib import Path

import numpy as np
import pytest

from expdesign.errors import InputError
from expdesign.estimation.preparation.point_lists import read_point_sets
from expdesign.io.units import UNITS

XYZ = [[0.1, -0.2, 0.3], [1e-3, 2.0, 0.0]]

SPATIAL_ANALYZER = """// SpatialAnalyzer
// Working frame: A::WORLD
// Units: Millimeters
Job 7::loaded-1::p1 100.0 -200.0 300.0
Job 7::loaded-1::p2 1.0 2000.0 0.0
"""
FORMS = {
    "double colons": SPATIAL_ANALYZER.replace("Job 7", "Job7"),
    "a name with a blank": SPATIAL_ANALYZER,
    "three names": "// units mm\nJob7 loaded-1 p1 100 -200 300\nJob7 loaded-1 p2 1 2000 0\n",
    "commas": "// Units: mm\nJob7,loaded-1,p1,100,-200,300\nJob7,loaded-1,p2,1,2000,0\n",
    "header with units": "Group,Name,X [mm],Y [mm],Z [mm]\nloaded-1,p1,100,-200,300\nloaded-1,p2,1,2000,0\n",
    "decimal commas": "Group;Name;X_mm;Y_mm;Z_mm\nloaded-1;p1;100,0;-200,0;300,0\nloaded-1;p2;1,0;2000,0;0,0\n",
    "tabulators": "# units = mm\nloaded-1\tp1\t100\t-200\t300\nloaded-1\tp2\t1\t2000\t0\n",
    "metres": "! Units: m\nloaded-1 p1 0.1 -0.2 0.3\nloaded-1 p2 1e-3 2 0\n",
}


@pytest.mark.parametrize("text", FORMS.values(), ids=FORMS.keys())
def test_one_list_in_many_forms(text: str, tmp_path: Path) -> None:
    path = tmp_path / "points.txt"
    for data in (text.encode(), text.replace("\n", "\r\n").encode("utf-16")):
        path.write_bytes(data)
        (found,) = read_point_sets(path)
        assert found.name == "loaded-1"
        assert list(found.points) == ["p1", "p2"]
        np.testing.assert_allclose([point.position for point in found.points.values()], XYZ, rtol=1e-15)


def test_names_that_are_numbers_uncertainties_and_files_without_groups(tmp_path: Path) -> None:
    path = tmp_path / "loaded-4.txt"
    path.write_text("X Y Z Ux Uy Uz\n1 100 -200 300 0.01 0.02 0.03\n2 1 2000 0 0.01 0.02 0.03\n", encoding="utf-8")
    (found,) = read_point_sets(path, UNITS["mm"])
    assert found.name == "loaded-4"
    assert list(found.points) == ["1", "2"]
    deviation = found.points["2"].deviation
    assert deviation is not None
    np.testing.assert_allclose(deviation, [1e-5, 2e-5, 3e-5], rtol=1e-12)
    path.write_text("100 -200 300\n1 2000 0\n", encoding="utf-8")
    (found,) = read_point_sets(path, UNITS["mm"])
    assert list(found.points) == ["1", "2"]


@pytest.mark.parametrize(
    ("text", "sets"),
    [
        ("A::u::p1 1 2 3\nA::l::p1 1 2 4\nA::u::p2 5 6 7\n", [("u", ["p1", "p2"]), ("l", ["p1"])]),
        ("Job 1::zero of 1::p 1 1 2 3\nJob 1::state 1::p 1 1 2 4\n", [("zero of 1", ["p 1"]), ("state 1", ["p 1"])]),
    ],
)
def test_groups_are_kept_apart_also_with_blanks_in_their_names(text: str, sets: object, tmp_path: Path) -> None:
    path = tmp_path / "all.txt"
    path.write_text(f"// units: mm\n{text}", encoding="utf-8")
    assert [(one.name, list(one.points)) for one in read_point_sets(path)] == sets


@pytest.mark.parametrize(
    ("text", "unit", "what", "row"),
    [
        ("p1 1 2 3\n", None, "does not state the unit", ""),
        ("// Units: mm\np1 1 2 3\n", "m", "is in mm by its header, and m was given", ""),
        ("// Units: mm\nName X[m] Y[m] Z[m]\np1 1 2 3\n", None, "states two units, mm and m", "row 2"),
        ("// Units: cubits\np1 1 2 3\n", None, "`cubits` is not a unit of length", "row 1"),
        ("// Units: mm\np1 1 2 3\np1 1 2 4\n", None, "the point p1 appears twice", "row 3"),
        ("// Units: mm\np1 1 2 3\np2 1 2\n", None, "`p2 1 2` is no point", "row 3"),
        ("// Units: mm\np1 1 2 3 0 1 1\n", None, "a standard deviation must be positive", "row 2"),
        ("// Units: mm\n\n", None, "there are no points", ""),
        ("// Units: mm\np1 1x 2 3\np2 1 2 3\n", None, "`p1 1x 2 3` is no point", "row 2"),
        ("// Units: mm\nJ::u::p1 1x 2x 3\nJ::u::p2 1 2 3\n", None, "`J::u::p1 1x 2x 3` is no point", "row 2"),
        ("// Units: mm\np1 1 2\np2 1 2 3\n", None, "`p1 1 2` is no point", "row 2"),
        ("P;X [mm];Y [mm];Z [mm]\nA;1,0x;2,0x;3,0\nB;1,0;2,0;3,0\n", None, "`A;1,0x;2,0x;3,0` is no point", "row 2"),
        (
            "// Units: mm\np1 1 2 3x 1 1 1\np2 1 2 3 1 1 1\n",
            None,
            "ends with 6 numbers, and the first point with 3",
            "row 3",
        ),
    ],
)
def test_what_is_refused(text: str, unit: str | None, what: str, row: str, tmp_path: Path) -> None:
    path = tmp_path / "points.txt"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=what.replace("(", ".").replace("`", ".")) as error:
        read_point_sets(path, None if unit is None else UNITS[unit])
    assert error.value.where == f"{path}{f', {row}' if row else ''}"
    assert error.value.remedy


def test_titles_and_rows_of_units_are_no_points(tmp_path: Path) -> None:
    path = tmp_path / "points.txt"
    path.write_text("Export 2026-05-12 10:30:00\nHall 4, 21.5 C\nP;X;Y;Z\n-;mm;mm;mm\nA;1;2;3\n", encoding="utf-8")
    (found,) = read_point_sets(path, UNITS["mm"])
    assert list(found.points) == ["A"]
