"""Residuals against what the recordings vary, and in the words of the robot's kind."""

from pathlib import Path

import numpy as np

import expdesign as xd
from tests.commands.calls import call


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
