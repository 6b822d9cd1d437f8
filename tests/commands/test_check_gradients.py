"""`expdesign check --gradients`."""

from pathlib import Path

import pytest
from tests.commands.calls import CONFIG, call, refusal

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality import differentiated

SMALL = """schema_version: 1
robot:
  name: bipod
  kind: bipod
  home: [0.0, 0.0]
  base_joints: [[-0.5, 0.0], [0.5, 0.0]]
  actuator_stiffness: [1.0e7, 1.3e7]
experiment:
  measurements: 2
  poses: {bounds: {x_m: 0.1, y_m: 0.6}}
  load: {kind: wrench, fx_N: {choices: [-100, 100]}, fy_N: -900.0}
  deflection_noise: {std: {dx_m: 1.0e-6, dy_m: 1.0e-6}}
targets:
  - {pose: [0.1, 0.6], wrench: [0.0, -1000.0], tolerance: {dx_m: 1.0e-6}}
"""


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
    path = tmp_path / "run.yaml"
    path.write_text(SMALL, "utf-8")
    assert call("check", path) == 0
    assert "no gradients to check" in refusal(capsys, "check", path, "--gradients")
