"""Pages name the files that they are about, show all criteria of a design, and residuals over what varied."""

import html
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

import expdesign as xd
from expdesign.app.api.load import load
from expdesign.planning.problem import DesignProblem
from expdesign.report.blocks import NextSteps
from expdesign.report.identification_tables import varied
from expdesign.report.page import Page
from tests.commands.calls import Printed, call

CONFIG, ROBOT = Path("configs/bipod.yaml"), Path("configs/robots/bipod.yaml")


def commands(page: Page) -> list[str]:
    (section,) = (one for one in page.sections if one.id == "next")
    return [command for block in section.blocks if isinstance(block, NextSteps) for _, command in block.items]


def test_commands_name_robot_and_configuration(tmp_path: Path) -> None:
    problem = load(CONFIG)
    assert isinstance(problem, DesignProblem)
    assert Path(problem.robot_file).resolve() == ROBOT.resolve()
    config = {**problem.config, "optimiser": {"population": 8, "generations": 2, "polish": False}}
    run = xd.run(config)
    run.plan.to_csv(tmp_path / "plan.csv", index=False)
    assert call("simulate", CONFIG, tmp_path / "plan.csv", "--out", tmp_path / "r.csv") == 0
    found = commands(xd.identify(ROBOT, tmp_path / "r.csv", targets=CONFIG).page())
    assert f"expdesign diagnose {ROBOT} {tmp_path / 'r.csv'} --targets {CONFIG} --out diagnosed" in found
    assert f"expdesign next {CONFIG} {tmp_path / 'r.csv'} --out plan-next.csv" in found
    assert not any("ROBOT.yaml" in command or "CONFIG.yaml" in command for command in found)
    # A configuration given as a mapping has no robot file, and the page says what to put there.
    run.save(tmp_path / "run")
    written = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert f"simulate configuration {tmp_path / 'run' / 'plan.csv'} --out rehearsal.csv" in written
    content = run.page()
    assert any("ROBOT.yaml" in command for command in commands(content))
    rows = {row[0]: row for row in content.data["designs"][0]["criteria"]}
    assert {f"O{number}" for number in range(1, 6)} <= {title[:2] for title in rows}
    assert float(rows["O2 (inverse condition)"][4]) >= float(rows["O2 (inverse condition)"][3])


def test_commands_can_be_copied_as_they_stand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Printed) -> None:
    """Files beside the page are named as they are seen from the folder in which the command was given."""
    shutil.copytree(CONFIG.parent / "robots", tmp_path / "robots")
    short = yaml.safe_load(CONFIG.read_text(encoding="utf-8"))
    short["optimiser"] = {"population": 8, "generations": 1, "polish": False}
    (tmp_path / "my config.yaml").write_text(yaml.safe_dump(short), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert call("run", "my config.yaml", "--out", "my results") == 0
    assert call("simulate", "my config.yaml", "my results/plan.csv", "--out", "recordings.csv") == 0
    text = html.unescape(Path("my results/report.html").read_text(encoding="utf-8"))
    steps = re.findall(r"expdesign [a-z]+ '?my config.yaml'? [^<]*", text)
    assert any("'my results'/plan.csv" in step for step in steps)
    for step in steps:
        capsys.readouterr()
        assert call(*shlex.split(step)[1:]) == 0, (step, capsys.readouterr().err)
    assert call("identify", "robots/bipod.yaml", "recordings.csv", "--out", "identified") == 0
    page = html.unescape(Path("identified/report.html").read_text(encoding="utf-8"))
    steps = re.findall(r"expdesign (?:predict|diagnose) [^<]*", page)
    assert steps[0].startswith("expdesign predict identified/model.yaml recordings.csv")
    for step in steps:
        assert call(*shlex.split(step)[1:]) == 0, step


def test_residuals_are_drawn_over_what_varies_most(tmp_path: Path) -> None:
    """Of five rows at two poses with five forces, the force has the most levels; what is constant is not offered."""
    rows = [f"{k},{1 + k % 2},{0.1 * (k % 2)},0.6,0,{-200.0 * k}" for k in range(1, 6)]
    (tmp_path / "p.csv").write_text("\n".join(["sequence,series,x_m,y_m,fx_N,fy_N", *rows]) + "\n", encoding="utf-8")
    assert call("simulate", CONFIG, tmp_path / "p.csv", "--out", tmp_path / "r.csv") == 0
    result = xd.identify(ROBOT, tmp_path / "r.csv").result
    found = varied(result, result.recordings.rows(result.fitted))
    assert list(found) == ["fy_N", "x_m"]
    content = xd.identify(ROBOT, tmp_path / "r.csv").page()
    assert [one["title"] for one in content.data["residuals"]] == ["fy (N)", "x (mm)", "order of recording (sequence)"]
    assert np.ptp(content.data["residuals"][1]["values"]) == 100.0


def report(folder: Path, robot: Path, recordings: str) -> str:
    (folder / "r.csv").write_text(recordings, encoding="utf-8")
    return repr(xd.diagnose(robot, folder / "r.csv").page())


def test_moments_on_a_body_that_stays_where_it_is(tmp_path: Path) -> None:
    robot = tmp_path / "body.yaml"
    robot.write_text("name: b\nkind: body\n", encoding="utf-8")
    head = "sequence,series,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad,fx_N,fy_N,fz_N,mx_Nm,my_Nm,mz_Nm"
    head += ",drx_rad,dry_rad,srx_rad,sry_rad"
    generator = np.random.default_rng(1)
    rows = []
    for k in range(1, 13):
        mx, my = 100.0 * generator.normal(size=2)
        rx, ry = np.array([mx * 1e-6, my * 2e-6]) + 2e-6 * generator.normal(size=2)
        rows.append(f"{k},1,0,0,2,0,0,0,0,0,0,{mx},{my},0,{rx},{ry},2e-6,2e-6")
    text = report(tmp_path, robot, "\n".join([head, *rows]) + "\n")
    assert "size of the load, N·m" in text
    assert "Residuals by pose" not in text  # the body never moved


def test_an_arm_has_joints_instead_of_legs(tmp_path: Path) -> None:
    assert call("new", "serial", "--out", tmp_path) == 0
    joints = ["0.5,-1.2,1.3,-1.1,-1.5,0.2", "-0.5,-0.8,0.9,-1.6,-1.2,0.9", "0.2,-1.7,1.8,-0.6,-1.9,-0.9"]
    joints += ["0.9,-1.0,0.6,-2.1,-1.1,0.4", "-0.9,-1.9,2.0,-0.3,-2.0,-0.4", "0.1,-0.6,1.5,-2.4,-1.4,1.2"]
    head = "sequence,series,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,q6_rad,mass_kg,com_x_m,com_y_m,com_z_m"
    plan = tmp_path / "plan.csv"
    plan.write_text("\n".join([head, *(f"{k},{k},{q},5,0.1,0,0.1" for k, q in enumerate(joints, 1))]) + "\n")
    assert call("simulate", tmp_path / "config.yaml", plan, "--out", tmp_path / "s.csv") == 0
    text = report(tmp_path, tmp_path / "robot.yaml", (tmp_path / "s.csv").read_text(encoding="utf-8"))
    assert "Residuals as motions of the joints" in text
    assert "each leg" not in text
