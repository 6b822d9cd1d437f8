"""`expdesign check --gradients`."""

from pathlib import Path

import pytest
from tests.commands.calls import CONFIG, call, refusal, yaml_file
from tests.design.problems import BIPOD, changed

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality import differentiated


def test_every_criterion_of_the_example_passes(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("check", CONFIG, "--gradients") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines if line.endswith(" pass")] == list(known_criteria())
    assert "1e-06" in next(line for line in lines if line.lstrip().startswith("quantity"))


def test_a_wrong_gradient_is_an_exit_status(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    right = differentiated.to_variables
    monkeypatch.setattr(differentiated, "to_variables", lambda problem, values: 1.001 * right(problem, values))
    assert call("check", CONFIG, "--gradients") == 1
    captured = capsys.readouterr()
    assert captured.out.count(" fail") == len(known_criteria())
    assert "wrong" in captured.err


def test_without_continuous_variables_there_is_nothing_to_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    load = {"kind": "wrench", "fx_N": {"choices": [-100, 100]}, "fy_N": -900.0}
    changes = {"experiment.poses": {"bounds": {"x_m": 0.1, "y_m": 0.6}}, "experiment.load": load}
    path = yaml_file(tmp_path / "run.yaml", changed(BIPOD, changes))
    assert call("check", path) == 0
    assert "no gradients to check" in refusal(capsys, "check", path, "--gradients")
