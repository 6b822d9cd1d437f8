"""The files in docs/extending.md work when they are put where they say they belong."""

import importlib
import json
import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from scipy.spatial.transform import Rotation

from expdesign.chain.models.model_file import read_model
from expdesign.estimation.identify import identify
from expdesign.io.yaml_reader import parse_yaml
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import read_robot, robot_from_document
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.search import search
from expdesign.plugins import forget
from expdesign.report.design_report import RunResult
from expdesign.report.page import render
from tests.commands.calls import call
from tests.design import problems
from tests.design.optimality.central_differences import errors_of_gradients
from tests.design.problems import changed
from tests.identification.experiments import read

PAGE = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r'```python title="(?:src/)?([^"]+)"\n(.*?)```', PAGE, flags=re.DOTALL))

BIPOD = changed(
    problems.BIPOD,
    {
        "experiment.load.fy_N": [-500, 500],
        "experiment.deflection_noise.std": {"dx_m": 1e-6, "dy_m": 1e-6},
        "experiment.load_error": [{"source": "wrench", "std": [2, 2]}],
        "targets": [{"pose": [0.1, 0.7], "wrench": [100, -400], "tolerance": {"dx_m": 1e-5, "dy_m": 1e-5}}],
        "optimiser": {"population": 12, "generations": 5, "polish": True},
    },
)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """Put a file of the page into its package, for the time of one test."""
    placed: list[str] = []

    def put(path: str) -> None:
        file = tmp_path / "places" / path
        file.parent.mkdir(parents=True)
        file.write_text(FILES[path], encoding="utf-8")
        package = importlib.import_module(str(Path(path).parent).replace("/", "."))
        monkeypatch.setattr(package, "__path__", [*package.__path__, str(file.parent)])
        placed.append(f"{package.__name__}.{file.stem}")
        forget()

    yield put
    for module in placed:
        sys.modules.pop(module, None)
    forget()


def test_the_page_has_a_file_of_every_kind() -> None:
    folders = {str(Path(path).parent) for path in FILES}
    assert folders == {
        "expdesign/planning/criteria",
        "expdesign/mechanics/robots",
        "expdesign/mechanics/loads/errors",
        "expdesign/chain/effects",
        "expdesign/chain/ports/places",
    }


def test_a_new_criterion_is_optimised_and_reported(place: Callable[[str], None]) -> None:
    """The criterion has no derivative of its own: it spans a front, is polished and has a proximity to optimality."""
    place("expdesign/planning/criteria/ellipsoid.py")
    case = replace(problems.problem(BIPOD, {"objectives": ["ellipsoid", "feir"]}), estimator="weighted")
    front = search(case)
    assert len(front) > 3
    root = case.assess(*case.space.decode(front.decisions)).noise_root[:, 0] / 1e-5
    axes = np.linalg.svd(root, compute_uv=False)
    np.testing.assert_allclose(front.criteria["ellipsoid"], np.sqrt(axes.prod(axis=1)), rtol=1e-9)
    assert np.nanmedian(front.kktpm) < 1e-3
    rough = search(replace(case, optimiser=case.optimiser.with_values(polish=False)))
    assert np.isfinite(rough.kktpm).all()
    assert len(front) > len(rough)  # between corners of the ranges gradients alone find designs
    assert errors_of_gradients(case, front.decisions[:1], ["ellipsoid"])["ellipsoid"] < 1e-6
    unbounded = {"duir_lower_bound": None, "duir_lower_bound_certified_on": "not asked"}
    assert "error ellipsoid" in render(RunResult(case, front, unbounded).page())


RRR = {
    "name": "triangle",
    "kind": "planar-rrr",
    "home": [0.0, 0.0],
    "base_joints": [[0.0, 0.5], [-0.433, -0.25], [0.433, -0.25]],
    "platform_joints": [[0.0, 0.1], [-0.0866, -0.05], [0.0866, -0.05]],
    "crank_m": 0.3,
    "coupler_m": 0.3,
    "actuator_stiffness": [2e4, 3e4, 2.5e4],
}
RRR_RUN = {
    "schema_version": 1,
    "robot": RRR,
    "experiment": {
        "measurements": 12,
        "poses": {"bounds": {"x_m": [-0.08, 0.08], "y_m": [-0.08, 0.08], "rz_rad": [-0.3, 0.3]}},
        "load": {"kind": "wrench", "fx_N": [-300, 300], "fy_N": [-300, 300], "mz_Nm": [-30, 30]},
        "deflection_noise": {"std": {"dx_m": 1e-6, "dy_m": 1e-6, "drz_rad": 1e-5}},
        "load_error": [{"source": "wrench", "std": [0.2, 0.2, 0.02]}],
    },
    "targets": [
        {"pose": [0.02, 0.01, 0.1], "wrench": [100, -200, 5],
         "tolerance": {"dx_m": 1e-5, "dy_m": 1e-5, "drz_rad": 1e-4}}
    ],
    "optimiser": {"population": 12, "generations": 4, "polish": True},
}  # fmt: skip


def _settled(robot: Robot, pose: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    """Deflection by small steps of the inverse kinematics alone: q(X + ΔX) = q(X) + c∘τ, τ by virtual work."""
    step, eye = 1e-6, np.eye(3)
    lengths = robot.inverse_kinematics.lengths
    rates = np.stack([(lengths(pose + step * e) - lengths(pose - step * e)) / (2 * step) for e in eye], axis=-1)
    torques = np.linalg.solve(rates.T, wrench)
    return np.linalg.solve(rates, torques / robot.stiffness)


def test_a_new_family_of_robots_is_planned_identified_diagnosed_and_read_by_markers(
    place: Callable[[str], None], tmp_path: Path
) -> None:
    place("expdesign/mechanics/robots/planar_rrr.py")
    (tmp_path / "run.yaml").write_text(yaml.safe_dump(RRR_RUN), encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(RRR), encoding="utf-8")
    robot = read_robot(tmp_path / "robot.yaml")
    pose, wrench = np.array([0.03, -0.02, 0.2]), np.array([50.0, -80.0, 4.0])
    jacobians = robot.jacobians(pose)
    found = jacobians.pose @ (robot.compliance * (jacobians.forward.T @ wrench))
    np.testing.assert_allclose(found, _settled(robot, pose, wrench), rtol=1e-6)
    assert call("run", tmp_path / "run.yaml", "--out", tmp_path / "plan") == 0
    plans = sorted((tmp_path / "plan").rglob("*.csv"))
    assert plans
    _identify_and_diagnose(tmp_path)


def random_plan(folder: Path, count: int) -> tuple[Path, np.ndarray, np.ndarray]:
    """A plan of the triangle, and its poses and wrenches."""
    rng = np.random.default_rng(5)
    poses = rng.uniform([-0.08, -0.08, -0.3], [0.08, 0.08, 0.3], (count, 3))
    wrenches = rng.uniform([-300, -300, -30], [300, 300, 30], (count, 3))
    plan = pd.DataFrame(np.hstack([poses, wrenches]), columns=["x_m", "y_m", "rz_rad", "fx_N", "fy_N", "mz_Nm"])
    plan.insert(0, "series", np.arange(1, count + 1))
    plan.insert(0, "sequence", np.arange(1, count + 1))
    plan.to_csv(folder / "plan.csv", index=False)
    return folder / "plan.csv", poses, wrenches


def _identify_and_diagnose(folder: Path) -> None:
    """Play in one limb is concealed in simulated recordings, and found; without it they are consistent."""
    random_plan(folder, 40)
    for name, concealed in (("sound", []), ("play", ["--conceal", "leg_backlash at leg 2, middle, 4e-4"])):
        recordings = folder / f"{name}.csv"
        assert call("simulate", folder / "run.yaml", folder / "plan.csv", *concealed,
                    "--no-load-errors", "--seed", "4", "--out", recordings) == 0  # fmt: skip
        assert call("diagnose", folder / "robot.yaml", recordings, "--out", folder / f"{name}-out") == 0
    sound, play = (
        json.loads((folder / f"{name}-out" / "diagnosis.json").read_text(encoding="utf-8"))
        for name in ("sound", "play")
    )
    assert sound["verdict"] == "consistent"
    assert play["verdict"] == "explained"
    first = play["effects"][0]
    assert (first["physics"], first["component"]) == ("leg_backlash", "leg 2")
    _, low, high = first["parameters"]["gap_rad"]
    assert low < 4e-4 < high
    assert call("identify", folder / "robot.yaml", folder / "sound.csv", "--out", folder / "identified") == 0
    identified = read_model(folder / "identified" / "model.yaml")
    np.testing.assert_allclose(identified.compliance, 1.0 / np.array(RRR["actuator_stiffness"]), rtol=2e-2)


def test_markers_on_a_new_family_show_its_compliances(place: Callable[[str], None]) -> None:
    """Two markers of a platform in the plane, seen from somewhere in space by an instrument that is turned."""
    place("expdesign/mechanics/robots/planar_rrr.py")
    robot = robot_from_document(parse_yaml(yaml.safe_dump(RRR), "robot.yaml", Path()))
    rng = np.random.default_rng(9)
    count, true = 60, np.array([6e-5, 4e-5, 3e-5])
    poses = rng.uniform([-0.08, -0.08, -0.3], [0.08, 0.08, 0.3], (count, 3))
    wrenches = rng.uniform([-300, -300, -30], [300, 300, 30], (count, 3))
    jacobians = robot.jacobians(poses)
    forces = np.einsum("nij,ni->nj", jacobians.forward, wrenches)
    reached = poses + np.einsum("nij,nj->ni", jacobians.pose, true * forces)
    places = {"a": np.array([0.05, 0.0, 0.02]), "b": np.array([-0.03, 0.04, 0.02])}
    frame = Rotation.from_euler("xyz", [0.3, -0.2, 1.0])
    table = pd.DataFrame(np.hstack([poses, wrenches]), columns=["x_m", "y_m", "rz_rad", "fx_N", "fy_N", "mz_Nm"])
    table["marker"] = np.resize(["a", "b"], count)
    turned = Rotation.from_euler("z", reached[:, 2:])
    points = np.c_[reached[:, :2], np.zeros(count)] + turned.apply([places[name] for name in table["marker"]])
    seen = frame.inv().apply(points - [1.0, 2.0, 0.5]) + 1e-6 * rng.standard_normal((count, 3))
    table[["px_m", "py_m", "pz_m"]] = seen
    table[["spx_m", "spy_m", "spz_m"]] = 1e-6
    table.insert(0, "series", np.arange(1, count + 1))
    table.insert(0, "sequence", np.arange(1, count + 1))
    result = identify(robot, read(table, robot))
    deviation = np.sqrt(np.diag(result.covariance))
    assert (np.abs(result.compliance.estimate - true) < 4.0 * deviation).all()
    assert (deviation < 0.02 * true).all()


def test_a_new_source_of_load_error_counts_in_feir(place: Callable[[str], None]) -> None:
    place("expdesign/mechanics/loads/errors/ratio.py")
    case = problems.problem(BIPOD, {"experiment.load_error": [{"source": "ratio", "std": 0.01}]})
    decisions = case.space.sample(2, np.random.default_rng(1))[None]
    feir = known_criteria()["feir"].values(case.assess(*case.space.decode(decisions)))
    # One common ratio makes all compliances, and so the deflection at the target, wrong by the same share.
    deflection = case.targets.observation[0] @ case.loaded.robot.compliance
    np.testing.assert_allclose(feir, 0.01 * np.linalg.norm(deflection) / 1e-5, rtol=1e-9)
