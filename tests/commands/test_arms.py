"""Every command on an arm of seven axes, as a user calls them; docs/arms-walk.md has one of six."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from expdesign.report.page import content_of
from tests.commands.calls import call, yaml_file
from tests.robots.arms import ARMS

SEARCH = {"population": 12, "generations": 4, "seed": 3}


def seven_axis(folder: Path) -> tuple[Path, Path]:
    """A redundant arm whose URDF comes from the package index, on a base that is tilted by 30°."""
    arm = ARMS["panda"]
    described = {
        "name": "seven axes",
        "kind": "serial",
        "urdf": str(arm.path),
        "base_link": arm.base,
        "tip_link": arm.tip,
        "actuator_stiffness": [2e4, 2e4, 2e4, 2e4, 5e3, 5e3, 5e3],
        "gravity_m_s2": [4.9, 0.0, -8.5],
    }
    bounds = {f"q{k}_rad": [-1.0, 1.0] for k in (1, 2, 3, 5, 7)} | {"q4_rad": [-2.2, -0.8], "q6_rad": [0.8, 2.5]}
    content = {
        "schema_version": 1,
        "robot": "robot.yaml",
        "experiment": {
            "measurements": 8,
            "poses": {"bounds": bounds},
            "load": {"kind": "payload", "mass_kg": {"choices": [1, 2, 3]}, "com_x_m": [-0.1, 0.1], "com_z_m": 0.1},
            "deflection_noise": {"std": {"dx_m": 2e-5, "dy_m": 2e-5, "dz_m": 2e-5}},
            "load_error": [{"source": "mass", "std": 0.01}],
        },
        "targets": [
            {
                "pose": [0.2, 0.3, -0.2, -1.5, 0.1, 1.8, 0.4],
                "payload": {"mass_kg": 2.0, "com_m": [0.03, 0.0, 0.1]},
                "tolerance": {"dx_m": 1e-4, "dz_m": 1e-4},
            }
        ],
        "optimiser": SEARCH,
    }
    return yaml_file(folder / "robot.yaml", described), yaml_file(folder / "config.yaml", content)


def test_from_the_configuration_to_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot, config = seven_axis(tmp_path)
    joints = len(yaml.safe_load(robot.read_text())["actuator_stiffness"])
    names = [f"q{k + 1}_rad" for k in range(joints)]
    plan, recordings, out = tmp_path / "run/plan.csv", tmp_path / "recordings.csv", tmp_path / "identified"
    for path in (robot, config):
        assert call("check", path) == 0
    assert call("run", config, "--out", tmp_path / "run") == 0
    assert '"name": "links"' in json.dumps(content_of((tmp_path / "run/report.html").read_text()))
    assert set(names) <= set(pd.read_csv(plan).columns)
    capsys.readouterr()
    assert call("evaluate", config, plan, "--json") == 0
    criteria = json.loads(capsys.readouterr().out)
    # Weights do not load joint 1 of an upright arm; joint 7 turns its tip on the spot, and turns are not measured.
    assert criteria["rank"] == joints - 1
    assert 0.0 < criteria["duir"] < 1.0
    assert call("simulate", config, plan, "--out", recordings, "--seed", 2) == 0
    assert call("check", recordings, "--robot", robot) == 0
    assert call("identify", robot, recordings, "--out", out) == 0
    found = json.loads((out / "identification.json").read_text())
    assert list(found["stiffness"]) == [f"joint {k + 1}" for k in range(joints)]
    assert found["unit"] == "N·m/rad"
    assert call("diagnose", robot, recordings, "--out", tmp_path / "diagnosed") == 0
    assert call("predict", out / "model.yaml", plan, "--out", tmp_path / "predicted.csv") == 0
    assert np.isfinite(pd.read_csv(tmp_path / "predicted.csv")[["dx_m", "sz_m"]].to_numpy()).all()
    assert call("compensate", out / "model.yaml", plan, "--out", tmp_path / "commands.csv") == 0
    commands = pd.read_csv(tmp_path / "commands.csv")
    np.testing.assert_allclose(commands[[f"target_{name}" for name in names]], pd.read_csv(plan)[names], rtol=1e-15)
    moved = np.abs(commands[names].to_numpy() - pd.read_csv(plan)[names].to_numpy()).max()
    assert 1e-5 < moved < 0.05
    assert call("next", config, recordings, "--out", tmp_path / "next.csv") == 0
    assert "not determined" not in capsys.readouterr().out
