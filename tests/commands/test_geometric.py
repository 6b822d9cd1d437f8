"""A geometric calibration from the plan to the prediction, by the commands and by the API."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.errors import InputError
from tests.commands.calls import ROBOT, call

CONFIG = Path(__file__).parents[2] / "configs" / "hexapod-geometric.yaml"
POSE = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]


@pytest.fixture
def plan() -> pd.DataFrame:
    """Forty poses."""
    reach = np.array([0.02, 0.02, 0.01, 0.1, 0.1, 0.1])
    return pd.DataFrame(np.random.default_rng(1).uniform(-reach, reach, (40, 6)), columns=POSE)


def test_the_commands_go_from_plan_to_model(plan: pd.DataFrame, tmp_path: Path) -> None:
    plan.to_csv(tmp_path / "plan.csv", index=False)
    call("simulate", CONFIG, tmp_path / "plan.csv", "--out", tmp_path / "poses.csv")
    call("identify", ROBOT, tmp_path / "poses.csv", "--calibration", "geometric", "--out", tmp_path / "found")
    record = json.loads((tmp_path / "found/identification.json").read_text())
    assert record["calibration"] == "geometric"
    assert record["stiffness"] == {}
    assert record["rank"] == 42 + 6  # the stiffness is held by what the file says
    assert len(record["geometry"]) == 42
    assert "Geometry of" in (tmp_path / "found/report.html").read_text()
    call("predict", tmp_path / "found/model.yaml", tmp_path / "poses.csv", "--out", tmp_path / "predicted.csv")
    measured, predicted = pd.read_csv(tmp_path / "poses.csv"), pd.read_csv(tmp_path / "predicted.csv")
    columns = [f"measured_{name}" for name in POSE]
    deviation = measured[[f"s{name}" for name in POSE]].to_numpy()
    off = (measured[columns] - predicted[columns]).to_numpy() / deviation
    assert 0.6 < np.sqrt((off**2).mean()) < 1.0


def test_identified_deviations_are_what_the_criteria_foresee(plan: pd.DataFrame) -> None:
    """U of a plan at a target is the covariance of the pose that the identified model predicts there."""
    targets = xd.evaluate(CONFIG, plan).record["targets"]
    simulated = xd.simulate(CONFIG, plan, seed=2)
    model = xd.identify(ROBOT, simulated.text).model
    poses = [target["pose"] for target in yaml.safe_load(CONFIG.read_text())["targets"]]
    points = pd.DataFrame(poses, columns=POSE).assign(kind="pose")
    deviations = xd.predict(model, points).prediction.deviations
    foreseen = np.sqrt([np.diag(target["U"]) for target in targets])
    np.testing.assert_allclose(deviations, foreseen, rtol=0.01)


def test_simulated_poses_of_a_found_robot_have_its_geometry(plan: pd.DataFrame) -> None:
    model = xd.identify(ROBOT, xd.simulate(CONFIG, plan, seed=2).text).model
    exact = xd.simulate(CONFIG, plan, model=model, noise=False).frame
    predicted = xd.predict(model, plan.assign(kind="pose")).frame
    names = [f"measured_{name}" for name in POSE]
    np.testing.assert_allclose(exact[names], predicted[names], atol=1e-12)


def test_poses_at_commands_are_predicted_and_deflections_refused(plan: pd.DataFrame) -> None:
    """What is attained at commands that make up for the geometry lies at the targets, which no deflection shows."""
    found = xd.identify(ROBOT, xd.simulate(CONFIG, plan, seed=2).text).model
    values = found.values.copy()
    values[-42:] += 2e-4 * np.random.default_rng(4).normal(size=42)
    model = replace(found, values=values)
    commands = xd.compensate(model, plan.head(6).assign(mass_kg=1.0, com_x_m=0.0, com_y_m=0.0, com_z_m=0.1)).frame
    targets = commands[[f"target_{name}" for name in POSE]].to_numpy()
    assert np.abs(commands[POSE].to_numpy() - targets).max() > 2e-5
    size = np.array([2e-6] * 3 + [6e-6] * 3)
    poses, deflections = commands.copy(), commands.copy()
    poses[[f"s{name}" for name in POSE]] = deflections[[f"s{name}" for name in POSE]] = size
    poses[[f"measured_{name}" for name in POSE]] = targets + size * np.random.default_rng(3).normal(size=targets.shape)
    deflections[["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]] = 1e-6
    assert xd.verify(model, poses, config=CONFIG).result.consistent
    with pytest.raises(InputError, match="deflections do not show where it is"):
        xd.verify(model, deflections, config=CONFIG)
