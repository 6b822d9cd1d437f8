"""`expdesign montecarlo` as it is called, another robot as the truth, and the version."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.errors import InputError
from tests.commands.calls import CONFIG, ROBOT, ROOT, Printed, call, plan_file, yaml_file

BIPOD = ROOT / "configs" / "bipod.yaml"


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


def test_without_load_errors_there_is_no_feir(tmp_path: Path) -> None:
    content = dict(xd.load(BIPOD).config)
    content["experiment"] = content["experiment"] | {"load_error": []}
    done = xd.montecarlo(content, pd.DataFrame([{"x_m": -0.2, "y_m": -0.1, "fx_N": 0, "fy_N": -1000}]), samples=1000)
    assert done.record["criteria"]["feir"] is None
    assert done.record["criteria"]["total"] == done.record["criteria"]["duir"]
    done.save(tmp_path / "out")


def softer(folder: Path, factor: float = 2.0) -> Path:
    content = yaml.safe_load(ROBOT.read_text())
    content["actuator_stiffness"] = [5.24e6 / factor] * 6
    return yaml_file(folder / "softer.yaml", content)


def test_another_robot_deflects_as_its_file_says(tmp_path: Path) -> None:
    exact: dict[str, Any] = {"noise": False, "load_errors": False}
    plan, soft = plan_file(tmp_path), softer(tmp_path)
    own, simulated = (xd.simulate(CONFIG, plan, **exact, model=model).frame for model in (None, soft))
    predicted = xd.predict(soft, plan).frame
    for found in (simulated, predicted):
        np.testing.assert_allclose(found["dz_m"], 2.0 * own["dz_m"], rtol=1e-9)
    assert (predicted["sx_m"] == 0.0).all()


def test_montecarlo_with_another_stiffness_attains_the_same(tmp_path: Path) -> None:
    """The estimator is linear: with the geometry of the file, the errors do not depend on the true stiffness (but to
    second order in the deflection)."""
    done = [xd.montecarlo(CONFIG, plan_file(tmp_path), samples=400, seed=3, truth=truth)
            for truth in (None, softer(tmp_path, 1.2))]  # fmt: skip
    for result, said in zip(done, ("that of the configuration", "softer.yaml")):
        result.save(tmp_path / "out", force=True)
        assert said in (tmp_path / "out" / "report.html").read_text()
    assert done[0].criteria["rms"]["duir"] == pytest.approx(done[1].criteria["rms"]["duir"], rel=1e-2)


def test_the_cause_of_another_feir_is_the_stiffness(tmp_path: Path) -> None:
    said = xd.montecarlo(CONFIG, plan_file(tmp_path), samples=4000, seed=3, truth=softer(tmp_path, 2.0)).summary
    assert "predict with the stiffness and the geometry of the configuration, and the true robot" in said
    assert "change of geometry under load" not in said


def test_montecarlo_with_another_geometry_is_worse(tmp_path: Path) -> None:
    content = yaml.safe_load(ROBOT.read_text())
    content["base_joints"][0][0] += 0.02
    (tmp_path / "other.yaml").write_text(yaml.safe_dump(content))
    plan, other = plan_file(tmp_path), tmp_path / "other.yaml"
    with pytest.raises(InputError, match="another geometry"):
        xd.montecarlo(CONFIG, plan, samples=400, truth=other)
    done = [xd.montecarlo(CONFIG, plan, samples=400, seed=3, truth=truth, other_robot=True) for truth in (None, other)]
    assert done[1].criteria["rms"]["total"] > 1.05 * done[0].criteria["rms"]["total"]


def test_the_version(capsys: Printed) -> None:
    assert call("--version") == 0
    assert capsys.readouterr().out == f"expdesign {xd.__version__}\n"
