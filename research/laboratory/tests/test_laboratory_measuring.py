"""Noise, reproducibility, files and errors; and that the laboratory knows nothing of what it tests."""

from __future__ import annotations

import ast
import dataclasses
import textwrap
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from tests.cases import content_of, robot

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
import research.laboratory as virtual_laboratory
from research.laboratory import Laboratory, LaboratoryError, Robot
from research.laboratory import elements as el
from research.laboratory.__main__ import main
from research.laboratory.truth import element_from, laboratory_from

STD = np.array([5e-7, 5e-7, 5e-7, 2e-6, 2e-6, 2e-6])
WRENCH = [20.0, -30, -300, 10, 5, -2]
HOME = [0.0] * 6
COLUMNS = ["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]

EVERYTHING = [
    {"physics": "payload_com_offset", "com_dx_m": 0.002},
    {"physics": "payload_mass_error", "relative_mass_error": 0.02},
    {"physics": "load_direction_tilt", "tilt_x_rad": "1e-3"},
    {"physics": "platform_compliance", "stiffness": ["2e8", "2e8", "2e8", "5e6", "5e6", "5e6"], "at_m": [0, 0, 0.02]},
    {"physics": "base_compliance", "stiffness": [3e8, 3e8, 3e8, 1e7, 1e7, 1e7]},
    {"physics": "passive_joint_compliance", "component": "leg 3", "stiffness_N_per_m": [5e7, 2e8, 2e8]},
    {"physics": "passive_joint_stiffness", "joint_Nm_per_rad": 50},
    {"physics": "leg_nonlinear_stiffness", "component": "leg 1", "law": "hertz", "contact_m_per_N23": 2e-8},
    {"physics": "leg_backlash", "component": "leg 5", "gap_m": 1e-6, "rest": "long"},
    {"physics": "friction_hysteresis", "component": "leg 4", "friction_N": 3, "contact_N_per_m": 5e7, "sliders": 4},
    {"physics": "creep", "component": "all legs", "creep_ratio": 0.03, "tau_s": 100},
    {"physics": "thermal_drift", "alpha_per_K": 1.2e-5},
    {"physics": "leg_coupling", "legs": [1, 2], "stiffness": [3e8, 3e8, 3e8, 1e7, 1e7, 1e7]},
    {"physics": "geometric_stiffness"},
    {"physics": "joint_position_error", "component": "leg 2", "end": "platform", "dx_m": 1e-4},
    {"physics": "instrument_misalignment", "rot_z_rad": 0.01},
    {"physics": "instrument_scale", "scale_z": 0.01},
    {"physics": "encoder_periodic_error", "component": "leg 6", "amplitude_m": 1e-6, "pitch_m": 2e-3},
    {"physics": "outlier", "rows": [1]},
    {"physics": "loose_mount", "holding_N": 20, "slip_m": 1e-6},
    {"physics": "cable", "base_m": [0.3, 0, 0], "platform_m": [0, 0, 0.1], "slack_m": 0.4, "stiffness_N_per_m": 1e4},
    {"physics": "attraction", "magnet_m": [0.5, 0, 0.3], "force_N": 5, "distance_m": 0.3},
    {"physics": "unilateral_stop", "platform_m": [0.1, 0, 0], "clearance_m": 5e-6, "stiffness_N_per_m": 1e7},
    {"physics": "instrument_distortion", "instrument_m": [-1, 0, 0], "quadratic_per_m": [0.01, 0, 0]},
]


def plan(bench, rows=12):
    rng = np.random.default_rng(5)
    poses = np.repeat(rng.uniform(-1, 1, (rows // 4, 6)) * [0.02, 0.02, 0.02, 0.1, 0.1, 0.1], 4, axis=0)
    loads = rng.uniform(-1, 1, (rows, 6)) * [30, 30, 300, 10, 10, 10]
    loads[::4] = 0
    return bench.frame(
        poses,
        **bench.wrenches(loads),
        series=np.repeat(range(rows // 4), 4),
        sequence=range(rows),
        time_s=60.0 * np.arange(rows),
        temperature_degC=20 + 0.01 * np.arange(rows),
    )


LABORATORY = Path(virtual_laboratory.__file__).parent


def test_laboratory_imports_nothing_of_the_package_under_test():
    allowed = {"argparse", "numpy", "pandas", "yaml", "exudyn", "research"}
    for path in set(LABORATORY.rglob("*.py")) - set((LABORATORY / "tests").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module or ""]
            for name in names:
                assert name.split(".")[0] != "expdesign", path
                assert name.split(".")[0] in allowed | STANDARD, f"{path}: {name}"
        assert 'import_module("expdesign' not in path.read_text(encoding="utf-8")


STANDARD = {
    "__future__",
    "abc",
    "ast",
    "collections",
    "dataclasses",
    "enum",
    "importlib",
    "math",
    "pathlib",
    "sys",
    "typing",
}


def test_all_elements_work_together(bench):
    truth = {"elements": EVERYTHING, "noise": {"std": dict(zip(COLUMNS, STD.tolist(), strict=True))}}
    assert {entry["physics"] for entry in EVERYTHING} == set(el.LIBRARY) | set(el.OUTSIDE)
    measured = laboratory_from(bench.robot("H1"), truth, seed=3).measure(plan(bench))
    assert np.all(np.isfinite(measured[COLUMNS].to_numpy()))
    assert np.abs(measured[COLUMNS].to_numpy()).max() < 1e-3


@pytest.mark.parametrize("entry", EVERYTHING, ids=lambda entry: entry["physics"])
def test_every_element_is_reproducible_and_does_something(bench, entry):
    robot, rows = bench.robot("H1"), plan(bench, 8)
    plain = Laboratory(robot).measure(rows)[COLUMNS].to_numpy()
    laboratory = laboratory_from(robot, {"elements": [entry]})
    first, again = laboratory.measure(rows), laboratory.measure(rows)
    pd.testing.assert_frame_equal(first, again, check_exact=True)
    if entry["physics"] != "geometric_stiffness":
        assert np.abs(first[COLUMNS].to_numpy() - plain).max() > 1e-9


def test_same_seed_same_bytes(bench):
    rows = plan(bench)
    texts = [Laboratory(bench.robot("H1"), noise_std=STD, seed=s).measure(rows).to_csv() for s in (1, 1, 2)]
    assert texts[0] == texts[1] != texts[2]


def test_noise_has_its_standard_deviation(bench):
    rows = bench.frame([HOME] * 4000, **bench.wrenches([0] * 6), series=np.repeat(range(1000), 4))
    measured = Laboratory(bench.robot("H1"), noise_std=STD, seed=1).measure(rows)
    assert measured[COLUMNS].std().to_numpy() == pytest.approx(STD, rel=0.05)
    assert measured[["sx_m", "srz_rad"]].to_numpy()[7] == pytest.approx(STD[[0, 5]])


def test_shared_reference_correlates_the_rows_of_a_series(bench):
    rows = bench.frame([HOME] * 4000, **bench.wrenches([0] * 6), series=np.repeat(range(2000), 2))
    values = bench.measure(bench.robot("H1"), rows, noise_std=STD, shared_reference=True, seed=1)
    assert values.std(axis=0) == pytest.approx(STD, rel=0.06)
    for component in range(6):
        assert np.corrcoef(values[::2, component], values[1::2, component])[0, 1] == pytest.approx(0.5, abs=0.08)


def test_correlated_noise(bench):
    root = np.diag(STD) @ (np.eye(6) + 0.5 * np.eye(6, k=1))
    covariance = root @ root.T
    rows = bench.frame([HOME] * 4000, **bench.wrenches([0] * 6))
    values = bench.measure(bench.robot("H1"), rows, covariance=covariance, seed=1)
    scale = np.sqrt(np.diag(covariance))
    assert np.cov(values.T) / np.outer(scale, scale) == pytest.approx(covariance / np.outer(scale, scale), abs=0.08)


def test_true_stiffness_is_the_laboratory_s(bench):
    rows = bench.frame(HOME, **bench.wrenches([0, 0, -300, 0, 0, 0]))
    robot = bench.robot("H1")
    soft = bench.measure(robot, rows, true_stiffness=robot.actuator_stiffness / 2)
    assert soft == pytest.approx(2 * bench.measure(robot, rows), rel=1e-3, abs=1e-9)


def test_order_of_rows_in_the_file_does_not_matter(bench):
    rows = plan(bench)
    laboratory = laboratory_from(bench.robot("H1"), {"elements": EVERYTHING[8:12]})
    shuffled = rows.sample(frac=1, random_state=1)
    expected = laboratory.measure(rows)[COLUMNS]
    found = laboratory.measure(shuffled.reset_index(drop=True))[COLUMNS].set_axis(shuffled.index).sort_index()
    pd.testing.assert_frame_equal(found, expected, rtol=0, atol=1e-13)


def write_files(tmp_path, bench):
    content = content_of(robot("H1")) | {"actuator_stiffness": ["5e6"] * 6}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(content))
    truth = """
        true_stiffness: [5.1e6, 5.2e6, 5.3e6, 5.4e6, 5.5e6, 5.6e6]
        noise: {std: {dx_m: 5e-7, dz_m: 5e-7}}
        elements:
        - {physics: leg_backlash, component: leg 3, gap_m: 1e-6}
    """
    (tmp_path / "truth.yaml").write_text(textwrap.dedent(truth))
    plan(bench).to_csv(tmp_path / "plan.csv", index=False)
    return [str(tmp_path / "robot.yaml"), str(tmp_path / "plan.csv"), "--truth", str(tmp_path / "truth.yaml")]


def test_command_line(bench, tmp_path):
    files = write_files(tmp_path, bench)
    out = tmp_path / "recordings.csv"
    assert main([*files, "--out", str(out), "--seed", "4"]) == 0
    first = out.read_bytes()
    assert main([*files, "--out", str(out), "--seed", "4"]) == 0
    assert out.read_bytes() == first
    recordings = pd.read_csv(out)
    assert recordings[COLUMNS].notna().to_numpy().all()
    assert main([*files, "--out", str(out), "--attained"]) == 0
    assert list(pd.read_csv(out)) == ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]


@pytest.mark.parametrize(
    ("truth", "message"),
    [
        ("elements: [{physics: leg_backlsh}]", "unknown physics 'leg_backlsh'"),
        ("elements: [{physics: leg_backlash, component: leg 3, gap: 1}]", "leg_backlash: unknown key 'gap'"),
        ("elements: [{physics: leg_backlash, component: leg 3}]", "gap_m"),
        ("elements: [{physics: leg_backlash, component: leg 9, gap_m: 1e-6}]", "'leg 9'"),
        ("stiffness: 1", "truth: unknown key 'stiffness'"),
        ("noise: {std: {dw_m: 1}}", "unknown component dw_m"),
        ("true_stiffness: [1e6]", "true_stiffness"),
    ],
)
def test_bad_truth_is_one_message(bench, tmp_path, capsys, truth, message):
    files = write_files(tmp_path, bench)
    (tmp_path / "truth.yaml").write_text(truth)
    assert main([*files, "--out", str(tmp_path / "out.csv")]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x_m": np.nan}, "row 2, column x_m"),
        ({"fx_N": "many"}, "column fx_N"),
        ({"fz_N": np.nan}, "row 2: the load"),
        ({"rx_rad": np.arange(12) / 100}, "different poses"),
    ],
)
def test_bad_rows_are_named(bench, change, message):
    with pytest.raises(LaboratoryError, match=message):
        Laboratory(bench.robot("H1")).measure(plan(bench).assign(**change))


def test_creep_without_time_is_refused(bench):
    with pytest.raises(LaboratoryError, match="time_s"):
        bench.measure(bench.robot("H1"), plan(bench).drop(columns="time_s"), el.Creep("leg 1", 0.1, 10.0))


def test_robot_kinds_and_shapes(bench):
    with pytest.raises(LaboratoryError, match="bipods and hexapods"):
        Robot.from_mapping({"kind": "serial"})
    with pytest.raises(LaboratoryError, match="base_joints: expected shape"):
        bench.robot("H1", base_joints=[[0, 0, 0]])
    with pytest.raises(LaboratoryError, match="home: missing"):
        bench.robot("H1", home=None)


def test_parameters_of_elements_are_read_with_their_units():
    for entry in EVERYTHING:
        element = element_from(entry)  # type: ignore[arg-type]
        assert element.identifier == entry["physics"]
        assert dataclasses.is_dataclass(element)
