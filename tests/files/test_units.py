"""Units of choice: columns and keys become SI, to the last digit, and contradictions are refused."""

import math
from pathlib import Path

import numpy as np
import pytest

from expdesign.coordinates import PLANAR, SPATIAL
from expdesign.errors import InputError
from expdesign.io.table import parse_table
from expdesign.io.tables_in_units import in_units
from expdesign.io.units import SI, UNITS, measured_column, unit_of
from expdesign.io.yaml_reader import parse_yaml


@pytest.mark.parametrize(
    ("column", "cell", "si", "value"),
    [
        ("dx_mm", "0.0123", "dx_m", 1.23e-5),
        ("dx_um", "12.3", "dx_m", 1.23e-5),
        ("dx_µm", "12.3", "dx_m", 1.23e-5),
        ("dx [mm]", "0.0123", "dx_m", 1.23e-5),
        ("dx_nm", "-12300", "dx_m", -1.23e-5),
        ("rx_mrad", "1.5", "rx_rad", 1.5e-3),
        ("rz_deg", "180", "rz_rad", math.pi),
        ("rz (°)", "-90", "rz_rad", -math.pi / 2),
        ("drx_arcsec", "3600", "drx_rad", math.pi / 180),
        ("fx_kN", "1.2", "fx_N", 1200.0),
        ("abs_fx_kN", "1.2", "abs_fx_N", 1200.0),
        ("mx_Nmm", "250", "mx_Nm", 0.25),
        ("mz [N m]", "2", "mz_Nm", 2.0),
        ("mass_g", "500", "mass_kg", 0.5),
        ("com_x_mm", "120", "com_x_m", 0.12),
        ("time_min", "1.5", "time_s", 90.0),
        ("px_mm", "1", "px_m", 1e-3),
        ("spx_um", "15", "spx_m", 1.5e-5),
        ("sx_um", "0.5", "sx_m", 5e-7),
        ("q1_deg", "90", "q1_rad", math.pi / 2),
        ("q2_mm", "90", "q2_m", 0.09),
        ("measured_x_mm", "7", "measured_x_m", 7e-3),
        ("temperature_K", "293.15", "temperature_degC", 20.0),
        ("leg1_degF", "212", "leg1_degC", 100.0),
        ("gz_mm_s2", "-9806.65", "gz_m_s2", -9.80665),
    ],
)
def test_columns_become_si_columns(column: str, cell: str, si: str, value: float) -> None:
    table = parse_table(f"sequence,{column}\n1,{cell}\n", "t.csv")
    assert table.columns == ["sequence", si]
    assert table.numbers((si,))[0, 0] == pytest.approx(value, rel=1e-15)


def test_powers_of_ten_are_exact_and_the_way_back_too() -> None:
    generator = np.random.default_rng(3)
    for number in generator.normal(size=300):
        text = f"{number:.9g}"
        si = parse_table(f"x_um\n{text}\n", "t.csv").numbers(("x_m",))[0, 0]
        assert si == float(f"{text}e-6" if "e" not in text else repr(float(text) * 1e-6))
        assert UNITS["um"].from_si(si) == float(text)


def test_every_si_column_of_the_project_is_left_as_it_is() -> None:
    for coordinates in (SPATIAL, PLANAR):
        for names in vars(coordinates).values():
            for name in names if isinstance(names, tuple) else ():
                found = measured_column(name)
                assert found is not None, name
                assert found.is_si
                assert found.si_name == name


@pytest.mark.parametrize("name", ["note", "sequence", "series", "split", "marker", "dx_mmm", "x", "dxm", "my_thing"])
def test_other_columns_are_left_alone(name: str) -> None:
    assert measured_column(name) is None


@pytest.mark.parametrize(
    ("header", "what", "column"),
    [
        ("dx_m,dx_mm", "give the same quantity", "dx_mm"),
        ("dx_um,dx_mm", "give the same quantity", "dx_mm"),
        ("dx_m,dy_mrad", "`dy` is a length, and mrad is a unit of angle", "dy_mrad"),
        ("dx_m,rx_mm", "`rx` is an angle, and mm is a unit of length", "rx_mm"),
        ("dx_m,fx_kg", "`fx` is a force, and kg is a unit of mass", "fx_kg"),
        ("dx_m,q1_kg", "`q1` is an angle or length, and kg", "q1_kg"),
    ],
)
def test_contradictions_are_refused(header: str, what: str, column: str) -> None:
    with pytest.raises(InputError, match=what) as error:
        parse_table(f"{header}\n1,2\n", "t.csv")
    assert error.value.where == f"t.csv, column {column}"
    assert error.value.remedy


def test_faults_are_named_by_the_column_of_the_file() -> None:
    table = parse_table("dx_mm\n1\nabc\n", "t.csv")
    with pytest.raises(InputError, match="`abc` is not a finite number") as error:
        table.numbers(("dx_m",))
    assert error.value.where == "t.csv, row 3, column dx_mm (as dx_m)"


def test_what_is_typed_into_a_controller_is_written_in_the_units_asked_for() -> None:
    table = parse_table("x_m,rx_rad,controller_x_m,controller_rx_rad,U_x_m,drx_rad\n1,1,1,1,1,1\n", "t.csv")
    alike = ["x_mm", "rx_deg", "controller_x_mm", "controller_rx_deg", "U_x_mm", "drx_deg"]
    assert list(in_units(table.frame, "mm,deg").columns) == alike
    apart = [*alike[:4], "U_x_um", "drx_urad"]
    assert list(in_units(table.frame, "mm,deg,um,urad").columns) == apart


def test_output_in_units_of_choice_reads_back() -> None:
    table = parse_table("x_m,rz_rad,fx_N,note\n0.0012,0.5,3,a\n-7e-9,-0.25,,b\n", "t.csv")
    written = in_units(table.frame, "µm,deg")
    assert list(written.columns) == ["x_um", "rz_deg", "fx_N", "note"]
    assert written["x_um"].tolist() == [1200.0, -0.007]
    back = parse_table(written.to_csv(index=False), "t.csv")
    np.testing.assert_allclose(back.numbers(("x_m", "rz_rad")), table.numbers(("x_m", "rz_rad")), rtol=1e-15)
    with pytest.raises(InputError, match="both measure a length"):
        in_units(table.frame, "mm,um,nm")
    with pytest.raises(InputError, match="both measure a length"):
        in_units(table.frame, "mm,mm")
    with pytest.raises(InputError, match="unknown unit `mmm`") as error:
        in_units(table.frame, "mmm")
    assert "`mm`" in error.value.remedy


def test_every_quantity_has_an_si_unit_of_factor_one() -> None:
    for dimension, name in SI.items():
        assert UNITS[name].dimension == dimension
        assert UNITS[name].to_si("2.5") == 2.5
    assert unit_of("N/µm") is UNITS["N_um"]
    assert unit_of("N·m/rad") is UNITS["Nm_rad"]


def yaml(text: str) -> object:
    return parse_yaml(text, "x.yaml", Path()).content


@pytest.mark.parametrize(
    ("text", "content"),
    [
        ("mass_kg: 500 g", {"mass_kg": 0.5}),
        ('x_m: ["-30 mm", "3 cm"]', {"x_m": [-0.03, 0.03]}),
        ('grid: {rz_rad: ["-180 deg", 0, 3]}', {"grid": {"rz_rad": [-math.pi, 0, 3]}}),
        ('mass_kg: {choices: ["500 g", 5]}', {"mass_kg": {"choices": [0.5, 5]}}),
        ("std: {dx_m: 0.5 µm, drx_rad: 2 urad}", {"std": {"dx_m": 5e-7, "drx_rad": 2e-6}}),
        ('home: [0, 0, "250 mm"]', {"home": [0, 0, 0.25]}),
        ('base_joints: [["10 cm", 0, 0]]', {"base_joints": [[0.1, 0, 0]]}),
        ('markers: {A1: ["10 cm", 0, 0]}', {"markers": {"A1": [0.1, 0, 0]}}),
        ("actuator_stiffness: [25 N/um, 25 kN/mm]", {"actuator_stiffness": [25e6, 25e6]}),
        ("actuator_stiffness: [10 kNm/rad]", {"actuator_stiffness": [1e4]}),
        ("pose: [1 mm, 0, 0, 0, 0, 1 mrad]", {"pose": [1e-3, 0, 0, 0, 0, 1e-3]}),
        ("wrench: [0, 0, -1 kN, 1 Nmm, 0, 0]", {"wrench": [0, 0, -1000.0, 1e-3, 0, 0]}),
        ("load_error: [{source: com, std: [1 mm, 0, 0]}]", {"load_error": [{"source": "com", "std": [1e-3, 0, 0]}]}),
        ("load_error: [{source: mass, std: 10 g}]", {"load_error": [{"source": "mass", "std": 0.01}]}),
        ("vary: {experiment.load.mass_kg: [500 g]}", {"vary": {"experiment.load.mass_kg": [0.5]}}),
        ("costs: {pose_change: 30 s}", {"costs": {"pose_change": 0.5}}),
        ("name: 5 mm", {"name": "5 mm"}),
    ],
)
def test_texts_with_units_in_yaml(text: str, content: object) -> None:
    assert yaml(text) == content


@pytest.mark.parametrize(
    ("text", "what", "where"),
    [
        ("a: 1\nmass_kg: 5 mm", "`mass_kg` is a mass, and mm is a unit of length", "x.yaml, line 2, mass_kg"),
        ("x_m: [1 mm, 2 mrad]", "mrad is a unit of angle", "x.yaml, line 1, x_m[1]"),
        ("pose: [1 mm, 0, 0, 5 mm, 0, 0]", "`pose` is an angle", "x.yaml, line 1, pose[3]"),
        ("mass_kg: 5 stone", "unknown unit `stone`", "x.yaml, line 1, mass_kg"),
        ("load_error: [{source: mass, std: 1 mm}]", "is a mass", "x.yaml, line 1, load_error[0].std"),
    ],
)
def test_contradictions_in_yaml(text: str, what: str, where: str) -> None:
    with pytest.raises(InputError, match=what) as error:
        yaml(text)
    assert error.value.where == where
    assert error.value.remedy
