"""Plans of a robot with several tips: what a measurement of each tells, pinocchio being the oracle."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pinocchio as pin
import pytest

import expdesign as xd
from expdesign.app.api.configuration import problem_of
from expdesign.errors import InputError
from tests.commands.calls import yaml_file
from tests.design.problems import changed, searched
from tests.oracle import Array
from tests.robots import torso

NOISE, TOLERANCE, STEP = 3e-5, 2e-4, 1e-6
TARGETS = {
    "right_hand": [0.2, 0.0, 0.5, 0.3, 0.0, 0.0, 0.0, 0.0],
    "left_hand": [0.2, 0.1, 0.0, 0.0, 0.0, 0.5, 0.3, 0.0],
}
CONFIG: dict[str, Any] = {
    "schema_version": 1,
    "robot": "robot.yaml",
    "experiment": {
        "calibration": "geometric",
        "frames": "unknown",
        "measurements": 60,
        "poses": {"bounds": {f"q{k}_rad": [-0.9, 0.9] for k in range(1, 9)}},
        "deflection_noise": {"std": dict.fromkeys(("dx_m", "dy_m", "dz_m"), NOISE)},
    },
    "targets": [
        {"pose": pose, "tip": tip, "tolerance": dict.fromkeys(("dx_m", "dy_m", "dz_m"), TOLERANCE)}
        for tip, pose in TARGETS.items()
    ],
    "objectives": ["duir"],
    "optimiser": {"population": 8, "generations": 1, "seed": 1, "effort": "quick"},
}


def written(folder: Path, change: dict[str, Any] | None = None) -> Path:
    """The configuration with other values at dotted keys."""
    torso.read_torso(folder)
    return yaml_file(folder / "config.yaml", changed(CONFIG, change or {}))


def plan(count: int, seed: int) -> pd.DataFrame:
    random = np.random.default_rng(seed)
    frame = pd.DataFrame(random.uniform(-0.9, 0.9, (count, 8)), columns=[f"q{k}_rad" for k in range(1, 9)])
    frame = frame.assign(**dict.fromkeys(torso.LIFTED, 0.0), tip=[torso.HANDS[row % 2] for row in range(count)])
    return frame.assign(sequence=range(1, count + 1), series=range(1, count + 1))


def sensitivities(q: Array, hand: str) -> Array:
    """What the instrument reads of a hand's target by all frames of joints, its own pose and both targets, (3, 66)."""
    model = pin.buildModelFromXML(torso.URDF)
    data, full = model.createData(), np.zeros(model.nq)
    numbers = [model.getJointId(name) for name in torso.JOINTS]
    full[[model.joints[number].idx_q for number in numbers]] = q
    drawn = [model.jointPlacements[number].copy() for number in numbers]

    def read(errors: Array) -> Array:
        frames, stand, targets = np.split(errors, [48, 54])
        for number, placed, error in zip(numbers, drawn, frames.reshape(8, 6), strict=True):
            model.jointPlacements[number] = placed * pin.exp6(error)
        pin.framesForwardKinematics(model, data, full)
        target = pin.exp6(targets.reshape(2, 6)[torso.HANDS.index(hand)])
        pose = pin.exp6(stand) * data.oMf[model.getFrameId(hand, pin.FrameType.BODY)] * target
        return np.array(pose.translation)

    steps = STEP * np.eye(66)
    return np.array([(read(step) - read(-step)) / (2.0 * STEP) for step in steps]).T


def test_duir_of_two_hands_is_that_of_all_frames_in_pinocchio(tmp_path: Path) -> None:
    """Zeros, frames, instrument and targets without any choice of a minimal set, by the pseudo-inverse."""
    frame = plan(60, 1)
    found = xd.evaluate(written(tmp_path), frame).criteria.loc["duir", "value"]
    rows = [sensitivities(row[:8].to_numpy(float), row["tip"]) for _, row in frame.iterrows()]
    covariance = NOISE**2 * np.linalg.pinv(np.concatenate(rows).T @ np.concatenate(rows), rcond=1e-10)
    at = [sensitivities(np.array(pose), hand) for hand, pose in TARGETS.items()]
    variances = np.array([np.diag(each @ covariance @ each.T) for each in at]) / TOLERANCE**2
    assert found == pytest.approx(np.sqrt(variances.sum(axis=1).mean()), rel=1e-4)


def test_measurements_of_one_hand_do_not_serve_the_other(tmp_path: Path) -> None:
    alone = plan(60, 1).assign(tip="right_hand")
    values = xd.evaluate(written(tmp_path), alone).criteria["value"].astype(float)
    assert not np.isfinite(values["duir"])


@pytest.mark.parametrize("listed", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_run_chooses_among_tips_and_its_plan_is_read_again(tmp_path: Path, listed: bool) -> None:
    """Of listed poses in every run; within bounds, which takes ten times as long, as a proof."""
    plan(12, 2).drop(columns=["tip", "sequence", "series"]).to_csv(tmp_path / "candidates.csv", index=False)
    few = {"experiment.poses": {"candidates": "candidates.csv"}, "experiment.measurements": 24}
    config = written(tmp_path, few if listed else {})
    run = searched(config)
    assert set(run.plan["tip"]) == set(torso.HANDS)
    run.plan.to_csv(tmp_path / "plan.csv", index=False)
    again = xd.evaluate(config, tmp_path / "plan.csv").criteria.loc["duir", "value"]
    assert again == pytest.approx(float(run.pareto["duir"].min()), rel=1e-9)
    steps = xd.sheet(config, tmp_path / "plan.csv").frame
    assert set(steps["tip"]) == set(torso.HANDS)


def test_tips_can_be_restricted_and_stated_row_by_row(tmp_path: Path) -> None:
    """A file of candidates with the column `tip` is taken as it stands; poses without it are tried at every tip."""
    candidates = plan(4, 2).drop(columns=["sequence", "series"])
    candidates.to_csv(tmp_path / "candidates.csv", index=False)
    candidates.drop(columns="tip").to_csv(tmp_path / "without.csv", index=False)
    for name, poses in (("candidates", 4), ("without", 8)):
        config = written(tmp_path, {"experiment.poses": {"candidates": f"{name}.csv"}})
        assert int(problem_of(config).space.upper[0]) == poses - 1
    config = written(tmp_path, {"experiment.poses.tips": ["left_hand"]})
    assert problem_of(config).space.sample(5, np.random.default_rng(1)).shape == (5, 8)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"targets.0.tip": ...}, r"targets\[0\].tip: the key is missing.*`right_hand`, `left_hand`"),
        ({"targets.0.tip": "right_hnad"}, "no tip of the robot.*right_hand"),
        ({"experiment.poses.tips": ["right_hand", "right_hand"]}, "appears twice"),
        ({"experiment.poses.bounds.tip": [1, 2]}, "Name tips under `tips`"),
        ({"targets.0.pose": [0.0] * 9}, "8 numbers are needed"),
    ],
)
def test_wrong_tips_are_refused(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        xd.evaluate(written(tmp_path, change), plan(10, 1))
