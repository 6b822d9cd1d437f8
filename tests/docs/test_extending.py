"""The files in docs/extending.md work when they are put where they say they belong."""

import importlib
import json
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml
from tests.commands.calls import CONFIG, ROBOT, call

from expdesign.criteria.criterion import known_criteria
from expdesign.design.problem import DesignProblem
from expdesign.design.problem_file import problem_from_document
from expdesign.design.search import search
from expdesign.files.yaml_reader import parse_yaml
from expdesign.report.design_report import design_report
from expdesign.report.page import render
from thesis_studies.making import read_frame
from thesis_studies.study import known_studies

PAGE = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r'```python title="src/([^"]+)"\n(.*?)```', PAGE, flags=re.DOTALL))

BIPOD = {
    "schema_version": 1,
    "robot": {
        "name": "bipod",
        "kind": "bipod",
        "home": [0.0, 0.6],
        "base_joints": [[-0.5, 0.0], [0.5, 0.0]],
        "actuator_stiffness": [1e7, 1.3e7],
    },
    "experiment": {
        "measurements": 2,
        "poses": {"bounds": {"x_m": [-0.3, 0.3], "y_m": [-0.2, 0.3]}},
        "load": {"kind": "wrench", "fx_N": [-500, 500], "fy_N": [-500, 500]},
        "deflection_noise": {"std": {"dx_m": 1e-6, "dy_m": 1e-6}},
        "load_error": [{"source": "wrench", "std": [2, 2]}],
    },
    "targets": [{"pose": [0.1, 0.1], "wrench": [100, -400], "tolerance": {"dx_m": 1e-5, "dy_m": 1e-5}}],
    "optimiser": {"population": 12, "generations": 5, "polish": True},
}


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
        known_criteria.cache_clear()
        known_studies.cache_clear()

    yield put
    for module in placed:
        sys.modules.pop(module, None)
    known_criteria.cache_clear()
    known_studies.cache_clear()


def problem(changes: dict[str, object]) -> DesignProblem:
    return problem_from_document(parse_yaml(yaml.safe_dump({**BIPOD, **changes}), "run.yaml", Path()))


def test_the_page_has_a_file_of_every_kind() -> None:
    folders = {str(Path(path).parent) for path in FILES}
    assert folders == {
        "expdesign/criteria",
        "expdesign/robots",
        "expdesign/loads/errors",
        "expdesign/chain/effects",
        "thesis_studies",
    }


def test_a_new_criterion_is_optimised_and_reported(place: Callable[[str], None]) -> None:
    place("expdesign/criteria/worst.py")
    case = problem({"objectives": ["worst", "feir"]})
    front = search(case)
    variance = case.assess(*case.space.decode(front.genes)).noise_variance[:, 0]
    np.testing.assert_allclose(front.criteria["worst"], np.sqrt(variance.max(axis=1)) / 1e-5, rtol=1e-9)
    assert "worst axis" in render(design_report(case, front, {}))


def test_a_new_robot_is_planned_for_and_drawn(place: Callable[[str], None]) -> None:
    place("expdesign/robots/gantry.py")
    robot = {"name": "portal", "kind": "gantry", "actuator_stiffness": [2e6, 1e6]}
    case = problem({"robot": robot})
    np.testing.assert_allclose(case.loaded.robot.jacobians(np.array([0.1, 0.2])).pose, np.eye(2))
    front = search(case)
    # Each drive yields along its own axis only: U_xx is what the forces along x alone determine.
    _, loads = case.space.decode(front.genes)
    expected = (1e-6**2 / (loads[..., 0] ** 2).sum(axis=1)) * 100.0**2
    variance = case.assess(*case.space.decode(front.genes)).noise_variance[:, 0, 0]
    np.testing.assert_allclose(variance, expected, rtol=1e-9)
    assert "The robot and its load" in render(design_report(case, front, {}))


def test_a_new_source_of_load_error_counts_in_feir(place: Callable[[str], None]) -> None:
    place("expdesign/loads/errors/ratio.py")
    experiment = {**BIPOD["experiment"], "load_error": [{"source": "ratio", "std": 0.01}]}  # type: ignore[dict-item]
    case = problem({"experiment": experiment})
    genes = case.space.sample(2, np.random.default_rng(1))[None]
    feir = known_criteria()["feir"].values(case.assess(*case.space.decode(genes)))
    # One common ratio makes all compliances, and so the deflection at the target, wrong by the same share.
    deflection = case.targets.observation[0] @ case.loaded.robot.compliance
    np.testing.assert_allclose(feir, 0.01 * np.linalg.norm(deflection) / 1e-5, rtol=1e-9)


def test_a_new_effect_is_simulated_and_found(place: Callable[[str], None], tmp_path: Path) -> None:
    place("expdesign/chain/effects/leg_settling.py")
    names = [f"leg {leg} compliance" for leg in range(1, 7)]
    model = {
        "kind": "model",
        "schema_version": 1,
        "robot": yaml.safe_load(ROBOT.read_text(encoding="utf-8")),
        "compliance": {f"leg {leg}": 2.0e-7 for leg in range(1, 7)},
        "effects": [{"physics": "leg_settling", "component": "leg 2", "parameters": {"settling_m": 6.0e-6}}],
        "parameters": [*names, "leg_settling / leg 2 / settling_m"],
        "covariance": np.zeros((7, 7)).tolist(),
    }
    (tmp_path / "model.yaml").write_text(yaml.safe_dump(model), encoding="utf-8")
    rng = np.random.default_rng(2)
    columns = "sequence,series,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad,mass_kg,com_x_m,com_y_m,com_z_m"
    rows = [
        [k, k, *rng.uniform(-0.02, 0.02, 3), *rng.uniform(-0.1, 0.1, 3), rng.choice([5.0, 10.0, 26.5]),
         *rng.uniform(-0.1, 0.1, 2), 0.12]
        for k in range(1, 25)
    ]  # fmt: skip
    text = "\n".join([columns, *(",".join(map(str, row)) for row in rows)])
    (tmp_path / "plan.csv").write_text(text + "\n", encoding="utf-8")
    simulated = ("simulate", CONFIG, tmp_path / "plan.csv", "--model", tmp_path / "model.yaml")
    assert call(*simulated, "--no-load-errors", "--out", tmp_path / "recordings.csv") == 0
    assert call("diagnose", ROBOT, tmp_path / "recordings.csv", "--out", tmp_path / "out") == 0
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text(encoding="utf-8"))
    assert found["verdict"] == "explained"
    (effect,) = found["effects"]
    assert effect["component"] == "leg 2"
    assert "leg_settling" in (effect["physics"], *effect["indistinguishable_from"])
    if effect["physics"] == "leg_settling":
        _, low, high = effect["parameters"]["settling_m"]
        assert low < 6.0e-6 < high


def test_a_study(place: Callable[[str], None], tmp_path: Path) -> None:
    """1 kg on two legs at 60°: each carries m·g/(2·sin 60°), and the point sags by m·g·(c₁ + c₂)/(4·sin² 60°)."""
    place("thesis_studies/sag.py")
    content = {"assumed": ["everything"], "robot": BIPOD["robot"], "masses_kg": [1.0, 10.0]}
    (tmp_path / "sag.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    assert call("study", "sag", "--configurations", tmp_path, "--out", tmp_path / "out") == 0
    kept = tmp_path / "out" / "sag"
    assert sorted(path.name for path in kept.iterdir()) == ["README.md", "sag.csv", "sag.svg", "study.json"]
    frame = read_frame((kept / "sag.csv").read_text(encoding="utf-8"))
    expected = 1e6 * 9.80665 * (1e-7 + 1.0 / 1.3e7) / 3.0
    assert frame["sag_um"].tolist() == pytest.approx([expected, 10.0 * expected], rel=1e-5)
    assert "- everything" in (kept / "README.md").read_text(encoding="utf-8")
