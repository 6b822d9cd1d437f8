"""Reference poses (theory.md 9.H): exactness, noise price (C12), and the way from a plan to recordings."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.errors import InputError
from expdesign.estimation.preparation.thermal_correction import (
    MeasuredPoses,
    correct_poses,
    deflections,
    measured_poses,
    repeatability,
)
from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot_file import RobotFile
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.deflection_noise import ReferencedNoise, series_by_pose
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import protocol_frame
from expdesign.planning.sampling import starting_designs
from tests.commands.calls import call
from tests.design.problems import HEXAPOD, problem
from tests.oracle import Array

REFERENCE = [0.005, 0.0, 0.01, 0.03, 0.0, 0.05]
POSE_NOISE = np.array([5e-7] * 3 + [2e-6] * 3) / np.sqrt(2.0)


def planned(*, interpolate: bool = False) -> tuple[DesignProblem, Plan, Hexapod, pd.DataFrame]:
    """A problem with a plan drawn for it, its robot, and the protocol that is to be filled in."""
    changes = {
        "experiment.reference_pose": {"pose": REFERENCE, "interpolate": interpolate},
        "experiment.load.gravity": ...,
        "experiment.measurements": 4,
    }
    here = problem(HEXAPOD, changes)
    space = here.space
    decisions = starting_designs(here, 1, np.random.default_rng(4))[0]
    configurations, loads = space.decode(decisions)
    plan, robot = Plan(configurations, loads, series_by_pose(configurations)), here.loaded.robot
    frame = protocol_frame(here, plan)
    assert isinstance(robot, Hexapod)
    assert frame is not None
    return here, plan, robot, frame


def measured(frame: pd.DataFrame, robot: ParallelRobot, growth: Array, noise: Array) -> pd.DataFrame:
    """The protocol filled in: legs grown by `growth` (N, 6), base model's deflection, noise (N, 6)."""
    commands = frame[list(robot.coordinates.pose)].to_numpy(dtype=float)
    grown = robot.pose_of(robot.lengths(commands) + growth, commands)
    frame = frame.copy()
    for axis, name in enumerate(robot.coordinates.pose):
        frame[f"measured_{name}"] = (grown + base_deflections(robot, frame) + noise)[:, axis]
    for axis, name in enumerate(robot.coordinates.deviation):
        frame[name] = POSE_NOISE[axis]
    return frame


def base_deflections(robot: ParallelRobot, frame: pd.DataFrame) -> Array:
    points = points_from_table(parse_table(csv_text(frame.drop(columns="kind")), "frame"), robot)
    return observation_matrix(robot.jacobians(points.configurations), points.wrenches) @ robot.compliance


def read(frame: pd.DataFrame, robot: ParallelRobot) -> MeasuredPoses:
    return measured_poses(parse_table(csv_text(frame), "poses.csv"), robot)


def drift(count: int, seed: int) -> Array:
    """Growth of every leg (m), micrometres, the same for a reference and the pose after it."""
    steps = np.random.default_rng(seed).normal(0.0, 1e-6, (count // 2 + 1, 6)).cumsum(axis=0) + 3e-6
    return np.repeat(steps, 2, axis=0)[:count]


@pytest.mark.parametrize("interpolate", [False, True])
def test_what_evaluate_charges_is_what_correct_pays(interpolate: bool) -> None:
    here, plan, robot, frame = planned(interpolate=interpolate)
    assert len(frame) == (5 if interpolate else 4) * len(plan)
    filled = measured(frame, robot, np.zeros((len(frame), 6)), np.zeros((len(frame), 6)))
    poses = read(filled, robot)
    found = deflections(poses, correct_poses(robot, poses, interpolate=interpolate))
    assert isinstance(here.noise, ReferencedNoise)
    expected = here.noise.covariance_at(robot.jacobians(plan.configurations).pose)
    assert found.covariance is not None
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-9, atol=1e-22)
    duir = known_criteria()["duir"]
    priced = duir.values(here.assess(plan.configurations[None], plan.loads[None]))[0]
    free = problem(HEXAPOD, {"experiment.load.gravity": ..., "experiment.measurements": 4})
    plain = duir.values(free.assess(plan.configurations[None], plan.loads[None]))[0]
    # T is near the identity: about √2 without interpolation, √1.25 with it.
    assert priced / plain == pytest.approx(np.sqrt(1.25 if interpolate else 2.0), rel=0.1)


def test_growth_that_lasts_from_reference_to_pose_is_removed_exactly() -> None:
    _, _, robot, frame = planned()
    growth = drift(len(frame), 1)
    commands = frame[list(robot.coordinates.pose)].to_numpy(dtype=float)
    grown = robot.pose_of(robot.lengths(commands) + growth, commands)
    filled = measured(frame, robot, growth, np.zeros((len(frame), 6)))
    for axis, name in enumerate(robot.coordinates.pose):
        filled[f"measured_{name}"] = grown[:, axis]
    poses = read(filled, robot)
    corrected = correct_poses(robot, poses)
    # All poses are those of the legs as the first reference found them.
    first = robot.pose_of(robot.lengths(commands) + growth[0], commands)[corrected.rows]
    np.testing.assert_allclose(corrected.after, first, atol=1e-13)
    assert np.abs(corrected.before - first).max() > 1e-6


def test_interpolation_removes_a_steady_drift() -> None:
    _, _, robot, frame = planned(interpolate=True)
    time = np.random.default_rng(8).uniform(1.0, 5.0, len(frame)).cumsum()
    frame.insert(1, "time_s", time)
    growth = np.outer(time, [1e-7, 2e-7, -1e-7, 0.5e-7, 0.0, 1e-7])
    filled = measured(frame, robot, growth, np.zeros((len(frame), 6)))
    poses = read(filled, robot)
    exact = base_deflections(robot, frame)
    errors = {}
    for interpolate in (False, True):
        found = deflections(poses, correct_poses(robot, poses, interpolate=interpolate))
        rows = np.flatnonzero(~poses.reference)[found.index]
        errors[interpolate] = np.abs(found.after - exact[rows])[:, 2].max()
        before = np.abs(found.before - exact[rows])[:, 2].max()
    # What is left of the drift is of second order: deflection times growth over the size of the robot.
    assert errors[True] < 1e-9
    assert before > errors[False] > 1e-7


def test_repeated_poses_scatter_as_predicted_after_the_correction() -> None:
    _, _, robot, _ = planned()
    generator = np.random.default_rng(5)
    visits = 150
    pose = [0.01, -0.01, 0.0, 0.05, 0.02, 0.0]
    rows = []
    for visit in range(visits):
        for kind, place in (("reference", REFERENCE), ("pose", pose)):
            row = {"sequence": 2 * visit + (kind == "pose") + 1, "series": 2 * visit + (kind == "pose"), "kind": kind}
            rows.append({**row, **dict(zip(robot.coordinates.pose, place, strict=True)), "mass_kg": 0.0}
                        | dict.fromkeys(robot.coordinates.centre_of_mass, 0.0))  # fmt: skip
    frame = pd.DataFrame(rows)
    noise = generator.standard_normal((2 * visits, 6)) * POSE_NOISE
    poses = read(measured(frame, robot, drift(2 * visits, 3), noise), robot)
    found = repeatability(poses, correct_poses(robot, poses))
    assert found.noise_after is not None
    assert found.noise_before is not None
    np.testing.assert_allclose(found.after, found.noise_after, rtol=4.0 / np.sqrt(2 * visits))
    assert (found.before > 5.0 * found.noise_before).all()
    np.testing.assert_allclose(found.noise_before, POSE_NOISE, rtol=1e-9)


def test_from_plan_to_identification(tmp_path: Path) -> None:
    _, plan, robot, frame = planned()
    generator = np.random.default_rng(11)
    noise = generator.standard_normal((len(frame), 6)) * POSE_NOISE
    filled = measured(frame, robot, 6.0 * drift(len(frame), 6), noise)
    file, out, record = tmp_path / "poses.csv", tmp_path / "recordings.csv", tmp_path / "record.json"
    file.write_text(csv_text(filled), encoding="utf-8")
    robot_file = tmp_path / "robot.yaml"
    robot_file.write_text(
        "name: H1\nkind: hexapod\nhome: [0, 0, 0.3]\n"
        f"base_joints: {robot.base_joints.tolist()}\nplatform_joints: {robot.platform_joints.tolist()}\n"
        f"actuator_stiffness: {robot.stiffness.tolist()}\n",
        encoding="utf-8",
    )
    assert call("correct", robot_file, file, "--out", out, "--record", record) == 0
    written = pd.read_csv(out)
    assert len(written) == len(plan)
    result = xd.correct(robot_file, file)
    assert result.residuals is not None
    before, after = result.residuals
    assert after[2] < 0.5 * before[2]
    # The rows of a series are counted from one unloaded pose, whose noise they have in common.
    assert result.frame.groupby("series")["reference"].nunique().eq(1).all()
    identified = xd.identify(robot_file, out).result
    assert identified.goodness.p_value is not None
    assert identified.goodness.p_value > 0.001
    deviation = np.sqrt(np.diag(identified.covariance))
    assert (np.abs(identified.compliance.estimate - robot.compliance) < 4.0 * deviation).all()


def shifted(frame: pd.DataFrame, column: str, row: int) -> pd.DataFrame:
    """A cell of a column stands twice, and those after it a row too late."""
    values = frame[column].to_numpy()
    return frame.assign(**{column: np.concatenate([values[: row + 1], values[row:-1]])})


def test_swapped_columns_of_recorded_poses_are_asked_about() -> None:
    _, _, robot, frame = planned()
    filled = measured(frame, robot, np.zeros((len(frame), 6)), np.zeros((len(frame), 6)))
    names = {"measured_x_m": "measured_y_m", "measured_y_m": "measured_x_m"}
    for columns, asked in ((names, True), ({}, False)):
        table = parse_table(csv_text(filled[filled["kind"] == "pose"].rename(columns=columns)), "poses.csv")
        findings = recordings_findings(recordings_from_table(table, robot), robot)
        assert ["measured_x_m and measured_y_m swapped" in one.likely for one in findings] == [True] * asked


def test_why_there_are_no_residuals_and_which_columns_have_no_meaning(caplog: pytest.LogCaptureFixture) -> None:
    _, _, robot, frame = planned()
    filled = measured(frame, robot, np.zeros((len(frame), 6)), np.zeros((len(frame), 6))).assign(foo_bar=3)
    for name in robot.coordinates.pose:
        filled[f"measured_{name}"] = 2.0 * filled[name] - filled[f"measured_{name}"]
    with caplog.at_level("INFO", "expdesign"):
        result = xd.correct(RobotFile(robot, YamlDocument("robot", Path(), {})), filled)
    assert "columns without a meaning here, kept but not used: foo_bar" in caplog.text
    assert result.residuals is None
    assert "identified stiffnesses are negative" in result.unidentified
    assert any(line.startswith("no residuals of identification: ") for line in result.said.statements)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda frame: frame.iloc[1:], "no reference before the first pose"),
        (lambda frame: frame.assign(kind="pose"), "no reference before"),
        (lambda frame: frame.assign(kind="ref"), "neither `reference` nor `pose`"),
        (lambda frame: frame.assign(mass_kg=5.0), "a reference has a load"),
        (lambda frame: frame.assign(measured_z_m=12.0), "away from the commanded pose"),
        (lambda frame: frame.drop(columns="measured_z_m"), "the column is missing"),
        (lambda frame: frame.assign(x_m=frame["x_m"].where(frame.index != 2, 0.001)), "reference pose differs"),
        (lambda frame: frame.drop(index=[1]), "does not begin with an unloaded pose"),
        (lambda frame: frame.drop(columns=["mass_kg"]), "poses.csv: there is no load"),
        (
            lambda frame: frame.rename(columns={"measured_x_m": "measured_y_m", "measured_y_m": "measured_x_m"}),
            "Are the columns measured_x_m and measured_y_m swapped",
        ),
        (lambda frame: shifted(frame, "measured_ry_rad", 4), "Does the column measured_ry_rad stand one row too late"),
        (lambda frame: shifted(frame, "measured_x_m", 0), "Does the column measured_x_m stand one row too late"),
    ],
)
def test_what_is_wrong_is_named(change: object, words: str, tmp_path: Path) -> None:
    _, _, robot, frame = planned()
    filled = measured(frame, robot, np.zeros((len(frame), 6)), np.zeros((len(frame), 6)))
    changed = csv_text(change(filled))  # type: ignore[operator]
    path = tmp_path / "poses.csv"
    path.write_text(changed, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        xd.correct(RobotFile(robot, YamlDocument("robot", Path(), {})), path)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"experiment.deflection_noise": {"std": {"dx_m": 1e-6, "dz_m": 1e-6}}}, "measured on all axes"),
        ({"experiment.reference_pose": {"pose": [0.0] * 5}}, "6 numbers"),
        ({"experiment.reference_pose": {"pose": [0.5, 0, 0, 0, 0, 0]}}, "beyond the robot's limits"),
    ],
)
def test_a_reference_pose_that_cannot_be_is_named(changes: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        problem(HEXAPOD, {"experiment.reference_pose": {"pose": REFERENCE}, **changes})
