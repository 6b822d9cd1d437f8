"""A run configuration is read as it is meant, and what is wrong with it is said with file, key and remedy."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from expdesign.errors import ExpdesignError, InputError, SingularConfigurationError
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.planning.problem_file import problem_from_document, read_problem
from tests import oracle
from tests.design.problems import BIPOD, HEXAPOD, changed, problem

NAN, INF = float("nan"), float("inf")
NOISE = "experiment.deflection_noise"
STD = f"{NOISE}.std"
BOUNDS = "experiment.poses.bounds"


def test_hexapod_configuration() -> None:
    found = problem(HEXAPOD)
    robot = found.loaded.robot
    assert isinstance(robot, Hexapod)
    assert robot.leg_length == (0.24, 0.36)
    assert robot.orientation == "fixed-xyz"
    np.testing.assert_array_equal(robot.gravity, [0.0, 0.0, -9.80665])
    assert [(s.source, s.shared) for s in found.loaded.sources] == [
        ("com", True),
        ("mass", True),
        ("direction", True),
        ("wrench", False),
    ]
    np.testing.assert_allclose(np.diag(found.noise.covariance), np.array([5e-7] * 3 + [2e-6] * 3) ** 2)
    assert not found.noise.shared_reference
    assert [criterion.name for criterion in found.objectives] == ["duir", "feir"]
    assert (found.optimiser.population, found.optimiser.generations, found.optimiser.seed) == (16, 6, 3)
    expected = np.zeros((2, 6))
    expected[0, [0, 2, 3]] = 1.0 / np.array([1e-6, 1e-6, 1e-5]) ** 2
    expected[1, 1] = 1.0 / 2e-6**2
    np.testing.assert_allclose(found.targets.importance, expected)
    np.testing.assert_array_equal(found.targets.weights, [1.0, 2.0])
    for index, mass in enumerate([26.5, 20.0]):
        turned = oracle.kinematics(robot, found.targets.configurations[index]).rotation
        centre = np.array(HEXAPOD["targets"][index]["payload"]["com_m"])
        wrench = oracle.payload_wrench(np.array([mass, *centre, *robot.gravity]), turned)
        np.testing.assert_allclose(found.target_wrenches[index], wrench, atol=1e-9)
        expected_map = oracle.observation(robot, found.targets.configurations[index], wrench)
        np.testing.assert_allclose(found.targets.observation[index], expected_map, rtol=1e-9, atol=1e-9)


def test_a_target_may_have_its_own_gravity() -> None:
    found = problem(HEXAPOD, {"targets.0.gravity_m_s2": [0.0, 9.0, -4.0]})
    np.testing.assert_allclose(found.target_wrenches[0, :3], 26.5 * np.array([0.0, 9.0, -4.0]))
    np.testing.assert_allclose(found.target_wrenches[1, :3], 20.0 * np.array([0.0, 0.0, -9.80665]))


def test_noise_axes_may_stand_in_any_order() -> None:
    found = problem(HEXAPOD, {STD: {"drz_rad": 3e-6, "dx_m": 1e-6, "drx_rad": 2e-6}})
    np.testing.assert_array_equal(found.noise.axes, [0, 3, 5])
    np.testing.assert_allclose(np.sqrt(np.diag(found.noise.covariance)), [1e-6, 2e-6, 3e-6])


def test_a_covariance_is_taken_as_it_stands() -> None:
    matrix = [[1e-12, 5e-13], [5e-13, 4e-12]]
    found = problem(BIPOD, {NOISE: {"covariance": matrix, "shared_reference": True}})
    np.testing.assert_allclose(found.noise.covariance, matrix)
    assert found.noise.shared_reference


def test_robot_and_candidates_in_files(tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "r.yaml").write_text(yaml.safe_dump(BIPOD["robot"]))
    (tmp_path / "poses.csv").write_text("note,y_m,x_m\na,0.5,0.1\nb,0.6,-0.1\n")
    changes = {"robot": "robots/r.yaml", "experiment.poses": {"candidates": "poses.csv"}}
    found = problem(BIPOD, changes, tmp_path)
    poses, _ = found.space.decode(np.array([[0.0, 0.0, -600.0], [1.0, 0.0, -600.0]]))
    np.testing.assert_array_equal(poses, [[0.1, 0.5], [-0.1, 0.6]])
    assert found.config["robot"]["name"] == "bipod"


WRONG: list[tuple[dict[str, Any], dict[str, Any], str, str]] = [
    # configuration, changes, key that the message names, word of the message
    (BIPOD, {"schema_version": ...}, "schema_version", "missing"),
    (BIPOD, {"schema_version": 2}, "schema_version", "1"),
    (BIPOD, {"experiment.measurments": 3}, "experiment.measurments", "Did you mean `measurements`"),
    (BIPOD, {"objectivs": ["duir", "feir"]}, "objectivs", "Did you mean `objectives`"),
    (BIPOD, {"experiment.shared_reference": True}, "experiment.shared_reference", f"It belongs in `{NOISE}`"),
    (BIPOD, {"experiment.seed": 3}, "experiment.seed", "It belongs in `optimiser`"),
    (BIPOD, {"experiment.objectives": ["duir"]}, "experiment.objectives", "It belongs in the top level"),
    (BIPOD, {"robot.kind": "bipd"}, "robot.kind", "Did you mean `bipod`"),
    (BIPOD, {"robot.kind": ...}, "robot.kind", "missing"),
    (BIPOD, {"robot.stiffness": [1, 2]}, "robot.stiffness", "actuator_stiffness"),
    (BIPOD, {"robot": [1]}, "robot", ""),
    (BIPOD, {"robot": "none.yaml"}, "robot", "none.yaml"),
    (BIPOD, {"robot.actuator_stiffness": [1e7]}, "robot.actuator_stiffness", "2"),
    (BIPOD, {"robot.actuator_stiffness.0": -1e7}, "robot.actuator_stiffness[0]", "greater"),
    (BIPOD, {"robot.actuator_stiffness.0": "1e7 N"}, "robot.actuator_stiffness[0]", "unit of force"),
    (BIPOD, {"robot.home.1": NAN}, "robot.home[1]", "finite"),
    (BIPOD, {"robot.home": [0.0, 0.0, 0.0]}, "robot.home", "2"),
    (BIPOD, {"robot.gravity_m_s2": [0.0, 0.0, -9.8]}, "robot.gravity_m_s2", "two"),
    (BIPOD, {"robot.limits": {"leg_length": [0.9, 0.2]}}, "robot.limits.leg_length", "shorter"),
    (BIPOD, {"experiment.measurements": 0}, "experiment.measurements", "1"),
    (BIPOD, {"experiment.measurements": 2.5}, "experiment.measurements", "whole"),
    (BIPOD, {"experiment.measurements": True}, "experiment.measurements", "whole"),
    (BIPOD, {f"{BOUNDS}.x_m": [0.3, -0.3]}, "experiment.poses.bounds.x_m", "wrong way round"),
    (BIPOD, {f"{BOUNDS}.x_m": [0.3, INF]}, "experiment.poses.bounds.x_m", "finite"),
    (BIPOD, {f"{BOUNDS}.x_m": [0.3, True]}, "experiment.poses.bounds.x_m", "finite"),
    (BIPOD, {f"{BOUNDS}.z_m": 0.0}, "experiment.poses.bounds.z_m", "unknown"),
    (BIPOD, {f"{BOUNDS}.x_m": {"choices": []}}, "experiment.poses.bounds.x_m", "at least one"),
    (BIPOD, {f"{BOUNDS}.x_m": {"choice": [1]}}, "experiment.poses.bounds.x_m.choice", "choices"),
    (BIPOD, {"experiment.poses": {}}, "experiment.poses", "exactly one"),
    (BIPOD, {"experiment.poses.grid": {"x_m": [0, 1, 3]}}, "experiment.poses", "exactly one"),
    (BIPOD, {"experiment.poses": {"grid": {"x_m": [0, 1, 0]}}}, "experiment.poses.grid.x_m", "points"),
    (BIPOD, {"experiment.poses": {"grid": {"x_m": [0, 1, 2.5]}}}, "experiment.poses.grid.x_m", "whole"),
    (BIPOD, {"experiment.poses": {"grid": {"x_m": [1, 0, 3]}}}, "experiment.poses.grid.x_m", "wrong way round"),
    (BIPOD, {"experiment.poses": {"candidates": "none.csv"}}, "experiment.poses.candidates", "none.csv"),
    (BIPOD, {"experiment.load.kind": "weight"}, "experiment.load.kind", "payload"),
    (BIPOD, {"experiment.load.mass_kg": 1}, "experiment.load.mass_kg", "no meaning"),
    (BIPOD, {"experiment.load.fz_N": 1}, "experiment.load.fz_N", "no meaning"),
    (BIPOD, {"experiment.load": {"kind": "payload"}}, "experiment.load.mass_kg", "missing"),
    (BIPOD, {f"{STD}.dx_m": -1e-6}, f"{STD}.dx_m", "greater"),
    (BIPOD, {f"{STD}.dx_m": 0}, f"{STD}.dx_m", "greater"),
    (BIPOD, {f"{STD}.dx_m": NAN}, f"{STD}.dx_m", "finite"),
    (BIPOD, {f"{STD}.dx_m": "1 urad"}, f"{STD}.dx_m", "unit of angle"),
    (BIPOD, {f"{STD}.dx_m": None}, f"{STD}.dx_m", "number"),
    (BIPOD, {f"{STD}.dz_m": 1e-6}, f"{STD}.dz_m", "unknown axis"),
    (BIPOD, {STD: {}}, STD, "no axis"),
    (BIPOD, {STD: ...}, NOISE, "exactly one"),
    (BIPOD, {NOISE: {"covariance": [[1e-12, 0], [1e-12, 1e-12]]}}, f"{NOISE}.covariance", "symmetric"),
    (BIPOD, {NOISE: {"covariance": [[1, 2], [2, 1]]}}, f"{NOISE}.covariance", "positive definite"),
    (BIPOD, {NOISE: {"covariance": [[1]]}}, f"{NOISE}.covariance", "2×2"),
    (BIPOD, {"experiment.load_error.0.source": "wrnch"}, "experiment.load_error[0].source", "wrench"),
    (BIPOD, {"experiment.load_error.0.source": "mass"}, "experiment.load_error[0].source", "no `mass` error"),
    (BIPOD, {"experiment.load_error.0.std": [1.0]}, "experiment.load_error[0].std", "2 standard deviations"),
    (BIPOD, {"experiment.load_error.0.std.0": -1.0}, "experiment.load_error[0].std[0]", "at least 0"),
    (BIPOD, {"experiment.load_error.0.shared": "maybe"}, "experiment.load_error[0].shared", "true"),
    (BIPOD, {"targets": []}, "targets", "1"),
    (BIPOD, {"targets": {}}, "targets", "list"),
    (BIPOD, {"targets.0.pose": [0.1]}, "targets[0].pose", "2 numbers"),
    (BIPOD, {"targets.0.wrench": [0.1]}, "targets[0].wrench", "2 numbers"),
    (BIPOD, {"targets.0.wrench": ...}, "targets[0]", "exactly one"),
    (BIPOD, {"targets.0.tolerance": {}}, "targets[0].tolerance", "at least one"),
    (BIPOD, {"targets.0.tolerance.dx_m": 0.0}, "targets[0].tolerance.dx_m", "greater"),
    (BIPOD, {"targets.0.tolerance.dx": 1.0}, "targets[0].tolerance.dx", "dx_m"),
    (BIPOD, {"targets.0.weight": -1.0}, "targets[0].weight", "greater"),
    (BIPOD, {"targets.0.gravity_m_s2": [0, 0, 1]}, "targets[0].gravity_m_s2", "2 numbers"),
    (BIPOD, {"aggregate": "median"}, "aggregate", "mean"),
    (BIPOD, {"objectives": []}, "objectives", "at least one"),
    (BIPOD, {"objectives": ["duir", "duir"]}, "objectives", "twice"),
    (BIPOD, {"objectives": ["duir", "fir"]}, "objectives[1]", "feir"),
    (BIPOD, {"optimiser.population": 2}, "optimiser.population", "4"),
    (BIPOD, {"optimiser.generations": 0}, "optimiser.generations", "1"),
    (BIPOD, {"optimiser.seed": -1}, "optimiser.seed", "0"),
    (BIPOD, {"optimiser.algorithm": "nsga3"}, "optimiser.algorithm", "nsga2"),
    (HEXAPOD, {"robot.base_joints.5": ...}, "robot.base_joints", "6"),
    (HEXAPOD, {"robot.platform_joints.2": [0.1, 0.2]}, "robot.platform_joints[2]", "3"),
    (HEXAPOD, {"robot.orientation": "xyz"}, "robot.orientation", "fixed-xyz"),
    (HEXAPOD, {"experiment.load.mass_kg": [-1.0, 5.0]}, "experiment.load.mass_kg", "negative"),
    (HEXAPOD, {"experiment.load.gravity.tilt_rad": 0.1}, "experiment.load.gravity.tilt_rad", "tilt_x_rad"),
    (HEXAPOD, {"targets.0.payload.com_m": [0.0]}, "targets[0].payload.com_m", "3 numbers"),
    (HEXAPOD, {"targets.0.payload.mass_kg": -1}, "targets[0].payload.mass_kg", "greater"),
    (HEXAPOD, {"targets.1.pose": [0.3, 0, 0, 0, 0, 0]}, "targets[1].pose", "beyond the robot's limits: leg"),
]


@pytest.mark.parametrize(("base", "changes", "key", "word"), WRONG, ids=lambda value: str(value)[:60])
def test_what_is_wrong_is_said(base: dict[str, Any], changes: dict[str, Any], key: str, word: str) -> None:
    with pytest.raises(InputError) as error:
        problem(base, changes)
    assert error.value.where.startswith("run.yaml")
    assert error.value.where.endswith(f", {key}")
    assert word in error.value.message
    assert error.value.remedy, error.value.message
    assert "\n" not in error.value.message


@pytest.mark.parametrize("content", [None, [], "text", 3])
def test_a_configuration_is_a_mapping(content: Any, tmp_path: Path) -> None:
    path = tmp_path / "run.yaml"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(InputError, match="mapping") as error:
        read_problem(path)
    assert str(path) in error.value.where


def test_a_singular_target_is_an_error() -> None:
    with pytest.raises(SingularConfigurationError) as error:
        problem(BIPOD, {"targets.0.pose": [0.1, 0.001]})
    assert error.value.where.endswith("targets[0].pose")
    assert isinstance(error.value, ExpdesignError)
    assert error.value.remedy


def test_robot_in_a_broken_file_is_named_by_its_own_file(tmp_path: Path) -> None:
    (tmp_path / "r.yaml").write_text(yaml.safe_dump(changed(BIPOD["robot"], {"home": [0.0]})))
    with pytest.raises(InputError) as error:
        problem(BIPOD, {"robot": "r.yaml"}, tmp_path)
    assert "r.yaml" in error.value.where
    assert error.value.where.endswith(", home")


def test_candidates_with_a_bad_cell_name_row_and_column(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text("x_m,y_m\n0.1,0.5\n0.1,abc\n")
    with pytest.raises(InputError) as error:
        problem(BIPOD, {"experiment.poses": {"candidates": "poses.csv"}}, tmp_path)
    assert error.value.where.endswith("poses.csv, row 3, column y_m")


@pytest.mark.parametrize("poses", [None, {"grid": {"x_m": [-0.2, 0.2, 5], "y_m": 0.0}}, {"candidates": "poses.csv"}])
def test_the_resolved_configuration_is_a_configuration_of_the_same_problem(tmp_path: Path, poses: object) -> None:
    """It can be read anywhere: the robot and the candidates are written out, and reading it changes nothing."""
    configs = Path(__file__).parents[2] / "configs"
    content = yaml.safe_load((configs / "bipod.yaml").read_text())
    content["robot"] = str(configs / "robots/bipod.yaml")
    if poses is not None:
        content["experiment"]["poses"] = poses
    (tmp_path / "poses.csv").write_text("x_m,y_m\n0.1,0.05\n-0.1,-0.05\n")
    first = problem_from_document(YamlDocument("first", tmp_path, content))
    again = problem_from_document(YamlDocument("again", Path("/nowhere"), first.config))
    assert again.config == first.config
    np.testing.assert_array_equal(again.space.lower, first.space.lower)
    decisions = first.space.sample(20, np.random.default_rng(1))
    np.testing.assert_array_equal(again.space.decode(decisions)[0], first.space.decode(decisions)[0])
