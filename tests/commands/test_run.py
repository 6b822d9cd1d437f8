"""`run`: its files (file-formats.md, Commands), the same bytes from one seed, reference poses, and early ends."""

import json
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

import expdesign as xd
from expdesign.planning.optimality.certificate import LowerBound
from tests.commands.calls import Printed, call, config_file
from tests.design.problems import BIPOD, problem, searched


def test_run_writes_what_the_interfaces_say(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without `--out` beside what is there already: the shipped bipod with a small search."""
    config = config_file(tmp_path, {"optimiser": {"population": 12, "generations": 4, "seed": 3}}, "bipod")
    (tmp_path / "results" / "config-run-1").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    assert call("run", config) == 0
    out = tmp_path / "results" / "config-run-2"
    names = [".expdesign.json", "pareto.csv", "plan-checked.csv", "plan.csv", "plans.csv", "report.html", "run.json"]
    assert sorted(p.name for p in out.iterdir()) == names
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


def test_unknown_frames_have_no_lower_bound_and_say_so(tmp_path: Path, capsys: Printed) -> None:
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


def test_a_reference_pose_makes_a_protocol(tmp_path: Path) -> None:
    search = {"population": 6, "generations": 2, "seed": 3, "polish": False}
    changes = {"experiment.reference_pose": {"pose": [0.0] * 6}, "experiment.measurements": 2, "optimiser": search}
    out = tmp_path / "out"
    searched(config_file(tmp_path, changes)).save(out)
    poses = pd.read_csv(out / "poses.csv")
    assert list(poses["kind"]) == ["reference", "pose"] * 4
    assert (poses.loc[poses["kind"] == "reference", "mass_kg"] == 0.0).all()
    assert list(poses["mass_kg"].iloc[[3, 7]]) == list(pd.read_csv(out / "plan.csv")["mass_kg"])


def test_no_bound_of_the_total_is_below_that_of_its_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """The relaxation of DUIR may be the closer one, and DUIR is a part of every plan's total."""
    bounds = {0.0: LowerBound(1e-3, "of DUIR"), 1.0: LowerBound(5e-4, "of total")}
    found = {errors: SimpleNamespace(bound=lambda *rest, errors=errors: bounds[errors]) for errors in bounds}
    monkeypatch.setattr("expdesign.app.api.run.Certificate", lambda problem, errors: found[errors])
    record = xd.run(problem(BIPOD)).record
    assert record["total_lower_bound"] == record["duir_lower_bound"] == 1e-3


SHORT = {"population": 16, "generations": 6, "seed": 1, "polish": True}


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bipod with three measurements, so that there is a front."""
    changes = {"optimiser": SHORT, "experiment.measurements": 3}
    return config_file(tmp_path_factory.mktemp("run"), changes, "bipod")


@pytest.fixture(scope="module")
def states(config: Path) -> list[str]:
    """Every state that the search of a whole run reports."""
    seen: list[str] = []
    xd.run(config, callback=lambda stage, done, total, note: seen.append(note) if stage == "searching" else None)
    return seen


@pytest.mark.parametrize("part", [0.0, 0.5, 1.0])
def test_a_run_that_is_ended_has_its_usual_results(
    config: Path, states: list[str], part: float, tmp_path: Path
) -> None:
    """Whichever state somebody ends at: the first generation, a later one, the last."""
    last = round(part * (len(states) - 1))
    seen: list[str] = []

    def callback(stage: str, done: int, total: int, note: str) -> None:
        if stage == "searching":
            seen.append(note)

    found = xd.run(config, callback=callback, ended=lambda: len(seen) > last)
    assert seen == states[: last + 1]
    assert found.record["ended_by_hand"].endswith(states[last].partition(": ")[0])
    found.save(tmp_path / "out")
    names = {".expdesign.json", "pareto.csv", "plan.csv", "plans.csv", "report.html", "run.json"}
    assert {file.name for file in (tmp_path / "out").iterdir()} == names
    assert "Ended by hand" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    pareto = pd.read_csv(tmp_path / "out" / "pareto.csv")
    judged = xd.evaluate(config, tmp_path / "out" / "plan.csv").record
    assert judged["total"] == pytest.approx(pareto["total"].min(), rel=1e-9)


def test_a_run_says_itself_before_its_bounds_are_known() -> None:
    known: list[xd.RunResult] = []
    xd.run("configs/bipod.yaml", searched=known.append, ended=lambda: bool(known))
    assert known[0].record["duir_lower_bound"] is None
    assert "recommended design" in known[0].summary
