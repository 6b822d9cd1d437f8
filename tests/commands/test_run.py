"""`run`: its files (file-formats.md, Commands), the same bytes from one seed, and nothing from a wrong input."""

import json
from pathlib import Path

import pandas as pd
import pytest
import yaml

from tests.commands.calls import call, config_file, refusal, yaml_file
from tests.design.problems import changed

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """The shipped bipod configuration, with a small search."""
    content = yaml.safe_load((CONFIGS / "bipod.yaml").read_text())
    content["robot"] = yaml.safe_load((CONFIGS / "robots/bipod.yaml").read_text())
    content["optimiser"] = {"population": 12, "generations": 4, "seed": 3}
    return yaml_file(tmp_path / "config.yaml", content)


def test_run_writes_what_the_interfaces_say(config: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert call("run", config, "--out", out) == 0
    assert sorted(p.name for p in out.iterdir()) == [
        ".expdesign.json",
        "pareto.csv",
        "plan.csv",
        "plans.csv",
        "report.html",
        "run.json",
    ]
    pareto = pd.read_csv(out / "pareto.csv")
    expected = {"design", "duir", "feir", "total", "o1", "o2", "o3", "o4", "o5", "o_tp", "o_mv", "kktpm", "recommended"}
    assert expected <= set(pareto.columns)
    assert pareto["recommended"].sum() == 1
    assert pareto.loc[pareto["recommended"], "total"].item() == pareto["total"].min()
    run = json.loads((out / "run.json").read_text())
    keys = "config seed versions wall_s evaluations duir_lower_bound duir_lower_bound_certified_on hypervolume"
    assert {*keys.split(), "reference_point"} <= set(run)
    assert run["seed"] == 3
    assert run["duir_lower_bound"] <= pareto["duir"].min() * (1.0 + 1e-9)
    assert run["total_lower_bound"] <= pareto["total"].min() * (1.0 + 1e-9)
    plans, plan = pd.read_csv(out / "plans.csv"), pd.read_csv(out / "plan.csv")
    best = int(pareto.loc[pareto["recommended"], "design"].item())
    chosen = plans[plans["design"] == best].drop(columns="design").reset_index(drop=True)
    pd.testing.assert_frame_equal(chosen, plan)
    assert list(plan.columns) == ["sequence", "series", "x_m", "y_m", "fx_N", "fy_N"]


def test_the_same_seed_gives_the_same_bytes(config: Path, tmp_path: Path) -> None:
    for name in ("one", "two"):
        assert call("run", config, "--out", tmp_path / name) == 0
    for name in ("pareto.csv", "plans.csv", "plan.csv"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_a_new_folder_under_results_without_out(config: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for number in (1, 2):
        assert call("run", config) == 0
        assert (tmp_path / "results" / f"config-run-{number}" / "plan.csv").exists()


WRONG = {
    "unknown key": ("experiment.measurments", 2, "measurements"),
    "bounds the wrong way round": ("experiment.poses.bounds.x_m", [0.3, -0.3], "wrong way round"),
    "negative deviation": ("experiment.deflection_noise.std.dx_m", -1e-6, "dx_m"),
    "not a number": ("experiment.deflection_noise.std.dx_m", float("nan"), "dx_m"),
    "wrong unit": ("targets.0.tolerance.dx_m", "1 kg", "dx_m"),
    "wrong type": ("targets.0.tolerance.dx_m", "one", "dx_m"),
    "too few points": ("robot.base_joints", [[0.0, 0.0]], "base_joints"),
    "limits no pose can meet": ("robot.limits", {"leg_length": [5.0, 6.0]}, "limits"),
    "no objective": ("objectives", [], "at least one"),
    "unknown criterion": ("objectives", ["duir", "o9"], "o9"),
    "singular target": ("targets.0.pose", [0.0, -0.65], "singular"),
    "target nobody can serve": ("experiment.load.fy_N", 0, "targets"),
    "missing robot": ("robot", "nowhere.yaml", "nowhere.yaml"),
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("command", ["run", "check"])
def test_a_wrong_configuration_ends_in_one_message(
    command: str, name: str, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    key, value, word = WRONG[name]
    yaml_file(config, changed(yaml.safe_load(config.read_text()), {key: value}))
    out = tmp_path / "out"
    error = refusal(capsys, command, config, *(["--out", out] if command == "run" else []))
    message = error.strip().splitlines()[-1]
    assert message.startswith("expdesign: ")
    assert "config.yaml" in message
    assert word in message
    assert "Traceback" not in error
    assert not out.exists()
    assert list(tmp_path.glob(".out*")) == []


def test_unknown_frames_have_no_lower_bound_and_say_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    search = {"population": 6, "generations": 2, "seed": 3, "polish": False}
    changes = {"experiment.frames": "unknown", "experiment.measurements": 8, "optimiser": search}
    out = tmp_path / "out"
    assert call("run", config_file(tmp_path, changes, "hexapod-geometric"), "--out", out) == 0
    assert json.loads((out / "run.json").read_text())["duir_lower_bound"] is None
    assert "unknown frames make parameters redundant" in capsys.readouterr().out
    assert call("evaluate", tmp_path / "config.yaml", out / "plan.csv", "--json") == 0
    record = json.loads(capsys.readouterr().out.split("report.html")[-1])
    assert record["rank"] == 42
    assert record["identifies_targets"]
    assert "Take `frames: unknown` out" in refusal(
        capsys, "montecarlo", tmp_path / "config.yaml", out / "plan.csv", "--out", tmp_path / "repeated"
    )


def test_a_reference_pose_makes_a_protocol(tmp_path: Path) -> None:
    search = {"population": 6, "generations": 2, "seed": 3, "polish": False}
    changes = {"experiment.reference_pose": {"pose": [0.0] * 6}, "experiment.measurements": 2, "optimiser": search}
    out = tmp_path / "out"
    assert call("run", config_file(tmp_path, changes), "--out", out) == 0
    poses = pd.read_csv(out / "poses.csv")
    assert list(poses["kind"]) == ["reference", "pose"] * 4
    assert (poses.loc[poses["kind"] == "reference", "mass_kg"] == 0.0).all()
    assert list(poses["mass_kg"].iloc[[3, 7]]) == list(pd.read_csv(out / "plan.csv")["mass_kg"])
