"""`expdesign montecarlo` as it is called."""

import json
from pathlib import Path

import numpy as np
import pytest

import expdesign as xd
from tests.commands.calls import CONFIG, ROOT, Printed, call, plan_file

BIPOD = ROOT / "configs" / "bipod.yaml"


def bipod_plan(folder: Path) -> Path:
    path = folder / "plan.csv"
    path.write_text("x_m,y_m,fx_N,fy_N\n-0.2,-0.1,0,-1000\n", encoding="utf-8")
    return path


def test_prediction_and_simulation_stand_beside_each_other(tmp_path: Path, capsys: Printed) -> None:
    plan = plan_file(tmp_path)
    assert call("montecarlo", CONFIG, plan, "--out", tmp_path / "out", "--samples", 20_000) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(tmp_path / "out" / "report.html")
    record = json.loads((tmp_path / "out" / "montecarlo.json").read_text(encoding="utf-8"))
    expected = xd.evaluate(CONFIG, plan).record
    for name in ("duir", "feir", "total"):
        entry = record["criteria"][name]
        assert entry["predicted"] == pytest.approx(expected[name], rel=1e-12)
        assert entry["z"] == pytest.approx((entry["rms"] - entry["predicted"]) / entry["standard_error"], rel=1e-9)
    assert record["comparisons"] == 33  # three causes on two targets with five axes each, and three criteria
    assert record["beyond_three"] == 0
    covariance = np.array(expected["targets"][1]["U"])
    axis = record["targets"][1]["axes"][2]
    assert axis["axis"] == "dz_m"
    assert axis["duir"]["predicted"] == pytest.approx(np.sqrt(covariance[2, 2]), rel=1e-9)
    assert record["largest_residual"] < 2e-13


def test_same_seed_same_result(tmp_path: Path) -> None:
    plan = bipod_plan(tmp_path)
    for name in ("a", "b"):
        assert call("montecarlo", BIPOD, plan, "--out", tmp_path / name, "--samples", 2000) == 0
    texts = [(tmp_path / name / "montecarlo.json").read_text(encoding="utf-8") for name in ("a", "b")]
    assert texts[0] == texts[1]


def test_without_load_errors_there_is_no_feir(tmp_path: Path) -> None:
    content = dict(xd.load(BIPOD).config)
    content["experiment"] = content["experiment"] | {"load_error": []}
    done = xd.montecarlo(content, bipod_plan(tmp_path), samples=1000)
    assert done.record["criteria"]["feir"] is None
    assert done.record["criteria"]["total"] == done.record["criteria"]["duir"]
    done.save(tmp_path / "out")
