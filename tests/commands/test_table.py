"""`expdesign table`: a correction in C that agrees with `compensate` within what it states."""

import ctypes
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.arrays import FloatArray
from expdesign.errors import ArgumentError
from tests.commands.calls import Printed, call, model_file, refusal

OVER = {"x_mm": (-20, 20), "y_mm": (-20, 20), "rx_mrad": (-80, 80), "mass_kg": (0, 30), "com_x_m": (-0.1, 0.1)}
SI = ("x_m", "y_m", "rx_rad", "mass_kg", "com_x_m")
POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
WARNINGS = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wmissing-prototypes", "-Werror")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("table")
    options = [text for name, (low, high) in OVER.items() for text in ("--over", f"{name}={low}:{high}")]
    model = model_file(folder)
    held = ("--at", "com_z_m=0.12", "--at", "z_mm=5")
    assert call("table", model, *options, *held, "--out", folder / "table", "--error", "0.02 um, 0.2 urad") == 0
    return folder


def compiled(folder: Path) -> ctypes.CDLL:
    compiler = next((path for name in ("cc", "gcc", "clang") if (path := shutil.which(name))), None)
    if compiler is None:
        pytest.skip("there is no C compiler on this machine")
    library = folder / "correction.so"
    source = folder / "table" / "correction.c"
    subprocess.run([compiler, *WARNINGS, "-O1", "-shared", "-fPIC", str(source), "-o", str(library)], check=True)
    return ctypes.CDLL(str(library))


def corrections(library: ctypes.CDLL, points: FloatArray) -> tuple[FloatArray, list[int]]:
    pointer = ctypes.POINTER(ctypes.c_double)
    found, states = np.empty((len(points), 6)), []
    for point, row in zip(np.ascontiguousarray(points), found, strict=True):
        states.append(library.expdesign_correction(point.ctypes.data_as(pointer), row.ctypes.data_as(pointer)))
    return found, states


def test_c_agrees_with_compensate_at_2000_random_points(folder: Path) -> None:
    record = json.loads((folder / "table" / "table.json").read_text(encoding="utf-8"))
    low, high = np.array([[axis["low"], axis["high"]] for axis in record["axes"].values()]).T
    assert tuple(record["axes"]) == SI
    points = low + (high - low) * np.random.default_rng(11).random((2000, len(SI)))
    found, states = corrections(compiled(folder), points)
    assert set(states) == {0}
    targets = pd.DataFrame(dict(zip(SI, points.T, strict=True)))
    targets = targets.assign(z_m=0.005, ry_rad=0.0, rz_rad=0.0, com_y_m=0.0, com_z_m=0.12)
    commands = xd.compensate(folder / "identified" / "model.yaml", targets).compensation.commands
    errors = np.abs(found - (commands - targets[list(POSE)].to_numpy())).max(axis=0)
    stated = [record["interpolation_error"][name]["stated"] for name in POSE]
    assert np.all(errors <= stated)
    assert np.all(stated <= [2e-8] * 3 + [2e-7] * 3)
    assert np.all(errors > 0.0)
    assert np.abs(found).max() > 100 * max(stated[:3])  # the corrections themselves are micrometres


def test_c_and_csv_are_the_same_table(folder: Path) -> None:
    table = xd.load(folder / "table" / "table.csv")
    nodes = table[list(SI)].to_numpy()
    found, states = corrections(compiled(folder), nodes)
    assert set(states) == {0}
    expected = table[[f"correction_{name}" for name in POSE]].to_numpy()
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-18)


def test_outside_the_range_the_edge_holds_and_is_reported(folder: Path) -> None:
    library = compiled(folder)
    edge = np.array([[0.02, 0.0, 0.0, 10.0, 0.0]])
    beyond, nan, infinite = edge.copy(), edge.copy(), edge.copy()
    beyond[0, 0], nan[0, 3], infinite[0, 0] = 0.03, np.nan, np.inf
    at_edge, state = corrections(library, edge)
    assert state == [0]
    outside, states = corrections(library, np.concatenate([beyond, infinite]))
    assert states == [1, 1]
    np.testing.assert_array_equal(outside, np.repeat(at_edge, 2, axis=0))
    assert corrections(library, nan)[1] == [1]


def test_python_says_what_c_says_within_the_range_and_refuses_what_is_outside(folder: Path) -> None:
    table = xd.table(folder / "identified" / "model.yaml", {"x_mm": (-20, 20)}, {"mass_kg": 5.0, "com_z_m": 0.12})
    edge = table.interpolated(np.array([[0.02]]))
    np.testing.assert_array_equal(table.interpolated(np.array([[0.02 * (1.0 + 1e-13)]])), edge)
    for outside in (0.0201, np.nan, np.inf):
        with pytest.raises(ArgumentError, match="in row 1 is outside of the table") as error:
            table.interpolated(np.array([[0.0], [outside]]))
        assert "-0.02 to 0.02" in error.value.remedy


@pytest.mark.parametrize(
    ("over", "at", "what"),
    [
        ({"x_mm": "-20:20"}, {"mass_kg": 5.0}, "'-20:20' is no range"),
        ({"x_m": "ab"}, {"mass_kg": 5.0}, "'ab' is no range"),
        ({"x_mm": (-20, 0, 20)}, {"mass_kg": 5.0}, "is no range"),
        ({"x_mm": 20}, {"mass_kg": 5.0}, "20 is no range"),
        ({"x_mm": (-20, 20)}, {"mass_kg": "5 kg"}, "'5 kg' is no value"),
    ],
)
def test_ranges_and_values_are_numbers(over: Any, at: Any, what: str, folder: Path) -> None:
    with pytest.raises(ArgumentError, match=what) as error:
        xd.table(folder / "identified" / "model.yaml", over, at)
    assert error.value.remedy


def test_the_header_says_ranges_units_and_errors(folder: Path) -> None:
    text = (folder / "table" / "correction.c").read_text(encoding="utf-8")
    head = text.split("*/")[0]
    for word in (*SI, *POSE, "-0.02 to 0.02", "z_m = 0.005", "com_z_m = 0.12", "SI units"):
        assert word in head
    assert "#include" not in text
    assert "malloc" not in text


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("--over", "x_mm=20:-20", "--at", "mass_kg=5"), "the range of x_m from 0.02 to -0.02 is empty"),
        (("--over", "x_mm=-2", "--at", "mass_kg=5"), "`x_mm=-2` is not a range"),
        (("--over", "x_mm=a:2", "--at", "mass_kg=5"), "`x_mm=a:2` is not a range"),
        (("--over", "w_mm=1:2", "--at", "mass_kg=5"), "unknown coordinate `w_mm`"),
        (("--over", "x_mrad=1:2", "--at", "mass_kg=5"), "`x` is a length"),
        (("--over", "x_mm=1:2", "--at", "x_m=5"), "x_m is both varied and held"),
        (("--over", "x_mm=1:2"), "no load is named"),
        (("--over", "z_mm=-90:90", "--at", "mass_kg=5"), "beyond the robot's limits"),
        (("--over", "x_mm=-20:20", "--at", "mass_kg=5", "--error", "1 kg"), "is no length or angle"),
        (("--over", "rx_mrad=-99:99", "--at", "mass_kg=25", "--error", "1 pm"), "unknown unit `pm`"),
        (("--over", "rx_mrad=-99:99", "--at", "mass_kg=25", "--nodes", "3"), "more than 3 nodes"),
    ],
)
def test_what_cannot_be_tabulated(arguments: tuple[str, ...], what: str, folder: Path, capsys: Printed) -> None:
    message = refusal(capsys, "table", folder / "identified" / "model.yaml", *arguments, "--out", folder / "none")
    assert what in message
    assert not (folder / "none").exists()


def test_the_corners_of_a_table_are_judged_as_targets_are(folder: Path, capsys: Printed) -> None:
    model, over = folder / "identified" / "model.yaml", ("--over", "x_mm=-5:5")
    message = refusal(capsys, "table", model, *over, "--over", "mass_kg=0:26500", "--out", folder / "none")
    assert "at x_m -0.005, mass_kg 2.65e+04: the mass is 26500 kg, 1000 times the largest" in message
    message = refusal(
        capsys, "table", model, *over, "--at", "mass_kg=20", "--at", "com_x_m=100", "--out", folder / "no"
    )
    assert "a centre of mass would be 100 m away" in message
    heavy = folder / "heavy"
    assert call("table", model, *over, "--at", "mass_kg=106", "--out", heavy) == 0
    printed, beyond = capsys.readouterr(), "mass_kg 106 (recorded up to 26.5)"
    assert "at x_m -0.005: the mass is 106 kg, 4 times the largest that was calibrated" in printed.err
    assert f"The table reaches beyond what was calibrated: {beyond}" in printed.out
    assert beyond in (heavy / "correction.c").read_text(encoding="utf-8").split("*/")[0]
    assert json.loads((heavy / "table.json").read_text(encoding="utf-8"))["beyond_calibration"] == [beyond]
