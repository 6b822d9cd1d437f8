"""What a sweep asks for: which runs there are, what makes each what it is, and what is wrong is said beforehand."""

from pathlib import Path

import pytest
import yaml

from expdesign.app.sweeps.runs import SweepRun, sweep_runs
from expdesign.errors import InputError
from expdesign.io.yaml_reader import read_yaml
from tests.sweeps.small import SMALL, sweep_file


def runs_of(folder: Path, **content: object) -> list[SweepRun]:
    return sweep_runs(read_yaml(sweep_file(folder, **content)))


def test_every_combination_of_cases_and_values_the_last_key_fastest(tmp_path: Path) -> None:
    cases = [{"experiment.load.fy_N": -500}, {"experiment.load.fy_N": -1000}]
    vary = {"experiment.measurements": [1, 2], "optimiser.seed": {"from": 4, "to": 8, "step": 2}}
    runs = runs_of(tmp_path, vary=vary, cases=cases)
    keys = ("experiment.load.fy_N", "experiment.measurements", "optimiser.seed")
    found = [tuple(run.values[key] for key in keys) for run in runs]
    assert found == [(load, count, seed) for load in (-500, -1000) for count in (1, 2) for seed in (4, 6, 8)]
    assert [run.number for run in runs] == list(range(1, 13))
    assert {run.config["experiment"]["load"]["fy_N"] for run in runs[:6]} == {-500.0}
    assert len({run.identity for run in runs}) == 12


def test_keys_reach_into_lists_and_into_the_robot_s_file(tmp_path: Path) -> None:
    vary = {"targets[0].tolerance.dx_m": [2e-6], "experiment.load_error.0.shared": [True], "robot.name": ["other"]}
    (run,) = runs_of(tmp_path, vary=vary)
    assert run.config["targets"][0]["tolerance"] == {"dx_m": 2e-6, "dy_m": 1e-6}
    assert run.config["experiment"]["load_error"][0]["shared"] is True
    assert run.config["robot"]["name"] == "other"
    assert run.config["robot"]["kind"] == "bipod"


def test_files_are_relative_to_the_file_that_names_them(tmp_path: Path) -> None:
    (tmp_path / "near").mkdir()
    robot = yaml.safe_load((tmp_path.parent / SMALL["robot"]).read_text()) | {"name": "near"}
    (tmp_path / "near" / "robot.yaml").write_text(yaml.safe_dump(robot))
    (tmp_path / "near" / "poses.csv").write_text("x_m,y_m\n0.1,0.0\n-0.1,0.1\n")
    vary = {"robot": ["near/robot.yaml"], "experiment.poses": [{"grid": {"x_m": [-0.1, 0.1, 3]}}]}
    (run,) = runs_of(tmp_path, vary=vary)
    assert run.config["robot"]["name"] == "near"
    cases = [{"experiment.poses": {"candidates": str(tmp_path / "near" / "poses.csv")}}]
    (run,) = runs_of(tmp_path, cases=cases)
    assert run.config["experiment"]["poses"] == {"candidates": [[0.1, 0.0], [-0.1, 0.1]]}


def test_the_identity_is_of_what_is_computed(tmp_path: Path) -> None:
    """The order of keys, defaults that are written out and where a file lies do not count; values do."""
    (plain,) = runs_of(tmp_path, vary={"aggregate": ["mean"]})
    (again,) = runs_of(tmp_path, vary={"optimiser.polish": [False]})
    (other,) = runs_of(tmp_path, vary={"optimiser.seed": [9]})
    assert plain.identity == again.identity != other.identity


WRONG = {
    "key": ({"vary": {"experiment.measurments": [1]}}, "Did you mean `measurements`"),
    "key of the sweep": ({"vry": {"experiment.measurements": [1]}}, "Did you mean `vary`"),
    "key of a range": ({"vary": {"optimiser.seed": {"from": 1, "too": 2}}}, "Did you mean `to`"),
    "value": ({"vary": {"experiment.measurements": [2, -1]}}, "run 2 (experiment.measurements = -1)"),
    "second value of a second key": ({"vary": {"aggregate": ["mean"], "robot": ["no.yaml"]}}, "no.yaml"),
    "way through a number": ({"vary": {"experiment.measurements.count": [1]}}, "`experiment.measurements` has no keys"),
    "index": ({"vary": {"targets[3].weight": [1]}}, "counted from 0"),
    "nothing": ({}, "nothing varies"),
    "no value": ({"vary": {"aggregate": []}}, "no value"),
    "empty range": ({"vary": {"optimiser.seed": {"from": 3, "to": 2}}}, "is empty"),
    "twice": ({"vary": {"aggregate": ["max"]}, "cases": [{"aggregate": "mean"}]}, "also under `vary`"),
    "too many": ({"vary": {"optimiser.seed": {"from": 1, "to": 999_999}}}, "999999 runs"),
    "no configuration": ({"config": "no.yaml", "vary": {"aggregate": ["max"]}}, "no.yaml"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_said_before_the_first_run(tmp_path: Path, name: str) -> None:
    content, words = WRONG[name]
    with pytest.raises(InputError) as caught:
        runs_of(tmp_path, **content)  # type: ignore[arg-type]
    assert words in caught.value.message
    assert "sweep.yaml" in caught.value.message
