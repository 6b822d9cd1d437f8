"""Another robot as the truth, and the version."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import expdesign as xd
from expdesign.errors import InputError
from tests.commands.calls import CONFIG, ROBOT, Printed, call, plan_file, yaml_file


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
