"""Comparisons and repeated experiments have the same bytes wherever their parts are done."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import expdesign as xd
from expdesign.app.parallel import Processes, each_of
from expdesign.errors import NotIdentifiableError
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.report.page import render
from tests.commands.calls import CONFIG, ROBOT, Printed, call, plan_file, refusal
from tests.sweeps.small import CONFIGS, SMALL, Sent

COMPARED = {"samples": 50, "random": 2, "generations": 2, "seed": 3}


def small(folder: Path) -> Path:
    """The bipod over a small grid, with two measurements."""
    content = SMALL | {"experiment": SMALL["experiment"] | {"measurements": 2}}
    path = folder / "config.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return path


def texts(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def test_a_comparison_by_an_executor(tmp_path: Path) -> None:
    config = small(tmp_path)
    steps: list[tuple[int, int]] = []
    here = xd.compare(config, **COMPARED)  # type: ignore[arg-type]
    there = xd.compare(
        config,
        **COMPARED,  # type: ignore[arg-type]
        executors=Sent,
        callback=lambda title, done, total, note: steps.append((done, total)),
    )
    here.save(tmp_path / "here")
    there.save(tmp_path / "there")
    assert texts(tmp_path / "here") == texts(tmp_path / "there")
    assert [done for done, _ in steps] == list(range(1, len(steps) + 1))
    assert steps[-1][0] <= steps[-1][1]


@pytest.mark.parametrize("truth", [None, "robot"])
def test_experiments_by_an_executor(tmp_path: Path, truth: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also with a truth of its own, which travels as well."""
    monkeypatch.setattr("expdesign.assurance.validation.simulation._BATCH", 150)
    really = None
    if truth is not None:
        content = yaml.safe_load(ROBOT.read_text(encoding="utf-8"))
        content["actuator_stiffness"] = [1.1 * float(value) for value in content["actuator_stiffness"]]
        really = tmp_path / "truth.yaml"
        really.write_text(yaml.safe_dump(content), encoding="utf-8")
    plan = plan_file(tmp_path)
    options: dict[str, Any] = {"samples": 400, "seed": 5, "truth": really}
    steps: list[tuple[int, int]] = []
    here = xd.montecarlo(CONFIG, plan, **options)
    there = xd.montecarlo(
        CONFIG,
        plan,
        **options,
        executors=Sent,
        callback=lambda title, done, total, note: steps.append((done, total)),
    )
    assert there.record == here.record
    assert render(there.page()) == render(here.page())
    assert steps == [(done, 9) for done in range(10)]  # three causes of three batches


def test_processes_repeat_experiments(tmp_path: Path) -> None:
    """By the command, and really in other processes."""
    plan = plan_file(tmp_path)
    for name, workers in (("one", 1), ("two", 2)):
        options = ["--samples", 200, "--workers", workers, "--out", tmp_path / name]
        assert call("montecarlo", CONFIG, plan, *options) == 0
    assert texts(tmp_path / "one") == texts(tmp_path / "two")


def condition(problem: DesignProblem, factor: float) -> float:
    robot = problem.loaded.robot
    return factor * float(robot.jacobians(robot.reference_configuration()).condition)


def unidentified(problem: DesignProblem) -> None:
    raise NotIdentifiableError("nothing is known", where=problem.source, remedy="Measure.")


@pytest.mark.parametrize("name", ["ur5", "hexapod-geometric", "rubin-camera"])
def test_a_problem_arrives_as_it_left(name: str) -> None:
    """With files beside the configuration (a URDF), and every criterion the same to the last bit."""
    problem = read_problem(CONFIGS / f"{name}.yaml")
    generator = np.random.default_rng(1)
    decisions = problem.space.sample(problem.space.measurements, generator).reshape(1, problem.space.measurements, -1)
    ((_, there),) = each_of(problem, Sent)(values, [(decisions,)])
    assert there == values(problem, decisions)
    found = dict(each_of(problem, Sent)(condition, [(1.0,), (2.0,)]))
    assert found == {index: condition(problem, factor) for index, factor in enumerate((1.0, 2.0))}


def values(problem: DesignProblem, decisions: Any) -> list[float]:
    assessment = problem.assess(*problem.space.decode(decisions))
    return [float(criterion.values(assessment)[0]) for criterion in problem.criteria.values()]


def test_an_error_says_the_same_wherever_it_happens(tmp_path: Path) -> None:
    problem = read_problem(small(tmp_path))
    with pytest.raises(NotIdentifiableError) as caught:
        list(each_of(problem, partial(Processes, 1))(unidentified, [()]))
    assert caught.value.message == f"{problem.source}: nothing is known. Measure."


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # of Dask and its event loop
def test_a_cluster_gives_the_bytes_of_one_process(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="Dask is not installed (extra `cluster`)")
    config, plan = small(tmp_path), plan_file(tmp_path)
    compared = ["--samples", 50, "--random", 2, "--generations", 2]
    commands: dict[str, list[object]] = {
        "compare": [config, *compared],
        "montecarlo": [CONFIG, plan, "--samples", 25_000],
    }
    options: dict[str, Any] = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster:
        for name, arguments in commands.items():
            assert call(name, *arguments, "--out", tmp_path / f"{name}-here") == 0
            there = ["--cluster", cluster.scheduler_address, "--out", tmp_path / f"{name}-there"]
            assert call(name, *arguments, *there) == 0
            assert texts(tmp_path / f"{name}-here") == texts(tmp_path / f"{name}-there")


def test_nobody_answers(tmp_path: Path, capsys: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed", reason="Dask is not installed (extra `cluster`)")

    def refuse(*values: object, **options: object) -> None:
        raise OSError("timed out")

    monkeypatch.setattr(distributed, "Client", refuse)
    assert "no scheduler answers at tcp://127.0.0.1:1" in refusal(
        capsys, "compare", small(tmp_path), "--out", tmp_path / "out", "--cluster", "tcp://127.0.0.1:1"
    )
