"""A geometric calibration from the plan to the prediction, by the commands and by the API."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.app.api.configuration import problem_of
from expdesign.assurance.comparison.contenders import distinct_criteria
from expdesign.errors import InputError
from expdesign.planning.optimality.certificate import Certificate
from tests.commands.calls import ROBOT, call, config_file

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


LOAD = {"fx_N": [-50.0, 50.0], "fy_N": [-50.0, 50.0], "fz_N": [-300.0, -100.0]}


def poses(count: int, seed: int = 1) -> pd.DataFrame:
    reach = np.array([0.03, 0.03, 0.02, 0.15, 0.15, 0.2])
    return pd.DataFrame(np.random.default_rng(seed).uniform(-reach, reach, (count, 6)), columns=POSE)


def changed(folder: Path, change: dict[str, object], targets: dict[str, object] | None = None) -> Path:
    """The configuration with another experiment, and more in its targets."""
    count = len(yaml.safe_load(CONFIG.read_text(encoding="utf-8"))["targets"])
    changes = {f"experiment.{key}": value for key, value in change.items()}
    changes |= {f"targets.{i}.{key}": value for i in range(count) for key, value in (targets or {}).items()}
    return config_file(folder, changes, "hexapod-geometric")


def test_monte_carlo_of_the_geometry_agrees_with_the_criteria() -> None:
    """10,000 experiments with non-linear kinematics; no compared figure is 4 standard errors from its prediction."""
    result = xd.montecarlo(CONFIG, poses(14), samples=10_000)
    duir = result.criteria.loc["duir"]
    assert duir["standard_error"] < 0.006 * duir["predicted"]
    assert abs(duir["z"]) < 4.0
    assert np.abs(result.result.scores()).max() < 4.0
    assert result.result.residual < 1e-12
    assert result.result.causes["total"].estimates.shape == (10_000, 42)


def test_monte_carlo_of_geometry_and_stiffness_agrees_with_the_criteria(tmp_path: Path) -> None:
    """Poses under uncertain loads: noise, load errors and both."""
    wrench = {"kind": "wrench", **LOAD}
    error = [{"source": "wrench", "std": [1.0, 1.0, 2.0, 0.1, 0.1, 0.1], "shared": False}]
    config = changed(
        tmp_path, {"calibration": "both", "load": wrench, "load_error": error, "measurements": 20},
        {"wrench": [20.0, 0.0, -200.0, 0.0, 0.0, 0.0]},
    )  # fmt: skip
    generator, plan = np.random.default_rng(2), poses(20)
    for name, (low, high) in LOAD.items():
        plan[name] = generator.uniform(low, high, 20)
    plan = plan.assign(mx_Nm=0.0, my_Nm=0.0, mz_Nm=0.0)
    result = xd.montecarlo(config, plan, samples=10_000)
    assert set(result.criteria.index) == {"duir", "feir", "total"}
    assert (result.criteria["z"].abs() < 4.0).all()
    assert (result.criteria["standard_error"] < 0.012 * result.criteria["predicted"]).all()
    assert np.abs(result.result.scores()).max() < 4.5


def test_unknown_frames_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown frames"):
        xd.montecarlo(changed(tmp_path, {"frames": "unknown"}), poses(14), samples=100)


def test_the_next_poses_promise_what_the_longer_plan_has(tmp_path: Path) -> None:
    """DUIR of the recorded plan and of both together, as `evaluate` has them."""
    plan = poses(12)
    plan.to_csv(tmp_path / "plan.csv", index=False)
    call("simulate", CONFIG, tmp_path / "plan.csv", "--out", tmp_path / "poses.csv")
    found = xd.plan_next(CONFIG, tmp_path / "poses.csv", count=2)
    assert found.undetermined is None
    assert found.before == pytest.approx(xd.evaluate(CONFIG, plan).criteria.loc["duir", "value"], rel=1e-6)
    longer = pd.concat([plan, found.frame[POSE]])
    assert found.after[-1] == pytest.approx(xd.evaluate(CONFIG, longer).criteria.loc["duir", "value"], rel=1e-6)
    assert found.after[-1] < 0.93 * found.before


def test_deflections_do_not_continue_a_geometric_calibration(tmp_path: Path) -> None:
    plan = poses(4).assign(fz_N=-100.0, fx_N=0.0, fy_N=0.0, mx_Nm=0.0, my_Nm=0.0, mz_Nm=0.0)
    plan = plan.assign(**{f"d{name}": 1e-6 for name in POSE}, sequence=range(1, 5), series=range(1, 5))
    plan.to_csv(tmp_path / "deflections.csv", index=False)
    with pytest.raises(InputError, match="measured poses"):
        xd.plan_next(CONFIG, tmp_path / "deflections.csv")


def bipod(folder: Path, measurements: int, targets: list[list[float]]) -> Path:
    """The geometric calibration of the bipod."""
    first = yaml.safe_load((CONFIG.parent / "bipod.yaml").read_text(encoding="utf-8"))["targets"][0]
    del first["wrench"]
    changes: dict[str, object] = {"experiment.calibration": "geometric", "experiment.measurements": measurements}
    changes |= {"experiment.load": ..., "experiment.load_error": ..., "objectives": ["duir", "o1"]}
    return config_file(folder, changes | {"targets": [first | {"pose": pose} for pose in targets]}, "bipod")


def test_the_bound_where_the_best_plan_identifies_nothing_but_the_target(tmp_path: Path) -> None:
    """Six measurements at the one target: two axes of one tolerance each with a sixth of the variance, √(2/6)."""
    bound = Certificate(problem_of(bipod(tmp_path, 6, [[0.1, -0.05]])), 1.0).bound()
    assert bound.value == pytest.approx(np.sqrt(1.0 / 3.0), rel=1e-4)


def test_designs_of_a_bipods_geometry_are_compared(tmp_path: Path) -> None:
    """Six parameters from four poses; DUIR, which is `total` here, is searched once, FEIR, which is 0, not at all."""
    file = bipod(tmp_path, 4, [[0.1, -0.05], [-0.2, 0.1], [0.0, 0.25], [0.2, 0.2]])
    searched = distinct_criteria(problem_of(file), seed=1)
    assert "duir" in searched
    assert not {"feir", "total"} & set(searched)
    result = xd.compare(file, samples=400, generations=1, random=2)
    (judgement,) = result.judgements
    finite = np.isfinite(judgement.attained)
    assert finite.sum() >= 6
    off = (judgement.attained - judgement.values["total"]) / judgement.attained_standard_error
    assert np.abs(off[finite]).max() < 4.0
    best = {one.name: index for index, one in enumerate(judgement.contenders)}
    assert judgement.same_plan[best["total"]] == judgement.same_plan[best["duir"]]
    assert judgement.values["total"][best["duir"]] == pytest.approx(np.nanmin(judgement.values["total"]), rel=1e-9)
