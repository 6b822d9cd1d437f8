"""From a robot given by radii and a tracker's list of points to a certificate, by the commands alone."""

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation
from tests.commands.calls import ROOT, call
from tests.docs.test_tutorial import loaded

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
LIMITS = (ROOT / "docs" / "limits.md").read_text(encoding="utf-8")
POINTS = np.array([[0.25, 0.0, 0.02], [-0.15, 0.2, 0.02], [-0.15, -0.2, 0.02], [0.0, 0.0, 0.12]])
POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
NOISE = 3e-6
HOME, ORIGIN = np.array([0.0, 0.0, 0.5]), np.array([2.1, -0.8, 0.4])
TRUTH = np.array([8.7e6, 9.6e6, 11.2e6, 9.1e6, 10.4e6, 7.9e6])

ROBOT = """
name: stage
kind: hexapod
home: [0.0, 0.0, 0.50]
base: {{radius_m: 0.40, half_angle_deg: 10}}
platform: {{radius_m: 0.30, half_angle_deg: 15, height_m: -0.03}}
actuator_stiffness: {stiffness}
limits: {{leg_length: [0.40, 0.60]}}
markers: {markers}
"""

CONFIG = f"""
schema_version: 1
robot: robot.yaml
experiment:
  measurements: 8
  poses:
    bounds: {{x_m: [-0.05, 0.05], y_m: [-0.05, 0.05], z_m: [-0.03, 0.03], rx_rad: [-0.15, 0.15], ry_rad: [-0.15, 0.15]}}
  load:
    kind: payload
    mass_kg: {{choices: [100, 200]}}
    com_x_m: {{choices: [-0.15, 0, 0.15]}}
    com_y_m: {{choices: [-0.15, 0, 0.15]}}
    com_z_m: 0.20
  deflection_noise:
    shared_reference: true
    points: {{positions: {POINTS.tolist()}, std_m: 3 um}}
targets:
  - pose: [0.03, 0, 0, 0, 0, 0]
    payload: {{mass_kg: 150, com_m: [0.05, 0.0, 0.20]}}
    tolerance: {{dx_m: 15 um, dy_m: 15 um, dz_m: 15 um, drx_rad: 60 urad, dry_rad: 60 urad}}
optimiser: {{population: 24, generations: 20, seed: 1}}
"""

TARGETS = """sequence,series,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad,mass_kg,com_x_m,com_y_m,com_z_m
1,1,0.03,0,0,0,0,0,150,0.05,0,0.20
"""


def points_of_the_tracker(steps: pd.DataFrame, bent: pd.DataFrame) -> str:
    """Markers at every step of the sheet, from an instrument that stands somewhere, as SpatialAnalyzer writes them."""
    stands, noise = Rotation.from_euler("xyz", [0.01, -0.02, 0.7]), np.random.default_rng(5)
    deflections = bent.set_index("sequence")[[f"d{name}" for name in POSE]]
    lines = ["// Units: mm"]
    for _, step in steps.iterrows():
        pose = step[list(POSE)].to_numpy(float)
        if step["mass_kg"] > 0.0:
            pose = pose + deflections.loc[step["plan_row"]].to_numpy(float)
        seen = pose[:3] + HOME + Rotation.from_euler("xyz", pose[3:]).apply(POINTS)
        seen = stands.apply(seen) + ORIGIN + noise.normal(0.0, NOISE, POINTS.shape)
        for name, place in enumerate(1e3 * seen, start=1):
            lines.append(f"Stage::row-{step['sequence']}::p{name}  " + " ".join(f"{value:.5f}" for value in place))
    return "\n".join(lines) + "\n"


@pytest.mark.slow
def test_from_radii_and_a_list_of_points_to_a_certificate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    markers = json.dumps({f"p{i}": place for i, place in enumerate(POINTS.tolist(), start=1)})
    for file, stiffness in (("robot", np.full(6, 1e7)), ("truth", TRUTH), ("weak", TRUTH / 3.0)):
        text = ROBOT.format(stiffness=stiffness.tolist(), markers=markers)
        Path(f"{file}.yaml").write_text(text, encoding="utf-8")
    Path("config.yaml").write_text(CONFIG, encoding="utf-8")
    Path("targets.csv").write_text(TARGETS, encoding="utf-8")
    assert call("check", "config.yaml") == 0
    assert call("run", "config.yaml", "--out", "planned") == 0
    assert call("sheet", "config.yaml", "planned/plan.csv", "--out", "sheet") == 0
    truth = ("--truth", "truth.yaml")
    assert call("simulate", "config.yaml", "planned/plan.csv", *truth, "--no-noise", "--out", "bent.csv") == 0
    listed = points_of_the_tracker(pd.read_csv("sheet/sheet.csv"), pd.read_csv("bent.csv"))
    Path("points.txt").write_text(listed, encoding="utf-8")
    given = ("sheet/sheet.csv", "points.txt", "--std", "3 um", "--out", "recordings.csv")
    assert call("register", "robot.yaml", *given) == 0

    capsys.readouterr()
    assert call("identify", "robot.yaml", "recordings.csv", "--targets", "config.yaml", "--out", "identified") == 0
    assert "without a meaning" not in capsys.readouterr().err  # the sheet's own columns are no surprise
    result = json.loads(Path("identified/identification.json").read_text(encoding="utf-8"))
    estimate, low, high = np.array(list(result["stiffness"].values())).T
    assert np.all(np.abs(estimate - TRUTH) < 2.0 * (high - low))  # 8 standard deviations: never by chance
    assert np.all(high - low < 0.15 * TRUTH)

    assert call("compensate", "identified/model.yaml", "targets.csv", "--out", "commands.csv") == 0
    for file, verdict, consistent in (("truth.yaml", "pass", True), ("weak.yaml", "fail", False)):
        assert call("simulate", "config.yaml", "commands.csv", "--truth", file, "--out", "check.csv") == 0
        checked = ("identified/model.yaml", "check.csv", "--config", "config.yaml", "--out", "verified")
        assert call("verify", *checked) == 0  # a certificate that says fail was made without an error
        found = json.loads(Path("verified/verification.json").read_text(encoding="utf-8"))
        assert (found["verdict"], found["model_test"]["consistent"]) == (verdict, consistent)
        assert "Certificate of verification" in Path("verified/report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_page_shows_what_its_commands_print(tmp_path: Path) -> None:
    """To the word, and its figures to a twentieth: another linear algebra leads to another optimum."""
    tutorial = loaded("tutorial")
    page = tutorial.PAGE.with_stem("walk").read_text(encoding="utf-8")
    steps = list(tutorial.follow(page, tmp_path))
    assert len(steps) == 12
    for step in steps:
        assert NUMBER.sub("#", step.printed) == NUMBER.sub("#", step.shown), step.command
        printed, shown = (np.array(NUMBER.findall(text), dtype=float) for text in (step.printed, step.shown))
        np.testing.assert_allclose(printed, shown, rtol=0.05, err_msg=step.command)
    low, high = (1e6 * float(text) for text in re.findall(r"pages of ([\d.]+) to ([\d.]+) MB", LIMITS)[0])
    sizes = [(tmp_path / name / "report.html").stat().st_size for name in ("planned", "identified", "diagnosed")]
    assert low <= min(sizes)
    assert max(sizes) <= high


@pytest.mark.slow
def test_the_page_of_an_arm_shows_what_its_commands_print(tmp_path: Path) -> None:
    tutorial = loaded("tutorial")
    steps = list(tutorial.follow(tutorial.PAGE.with_stem("arms-walk").read_text(encoding="utf-8"), tmp_path))
    assert len(steps) == 9
    for step in steps:
        assert NUMBER.sub("#", step.printed) == NUMBER.sub("#", step.shown), step.command
    assert "verdict: pass" in steps[-1].printed
