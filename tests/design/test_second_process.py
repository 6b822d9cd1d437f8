"""A second process does every other part of a work, with the same results as one."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml
from tests.design.problems import BIPOD, HEXAPOD, changed, problem
from tests.oracle import Array

import expdesign as xd
from expdesign.design.parts import by_halves, one_after_another
from expdesign.design.problem import DesignProblem
from expdesign.design.second_process import SecondProcess, TwoProcesses, second_process_helps
from expdesign.errors import InputError

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes cannot copy themselves here")


def where(problem: DesignProblem, number: int) -> tuple[int, int, int]:
    return problem.space.measurements, number, os.getpid()


def refuses(problem: DesignProblem, number: int) -> int:
    if number == 1:
        raise InputError("not this one", where="here", remedy="Take another.")
    return number


def ends(problem: DesignProblem, number: int, pid: int) -> int:
    if os.getpid() != pid:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def scaled(problem: DesignProblem, rows: Array, factors: Array, offset: float) -> Array:
    return rows * factors[:, None] + offset


@pytest.fixture
def two() -> Iterator[SecondProcess]:
    parts = SecondProcess(problem(BIPOD))
    yield parts
    parts.close()


def test_every_other_part_is_done_by_the_copy_and_all_are_in_order(two: SecondProcess) -> None:
    told: list[int] = []
    found = two(where, [(number,) for number in range(5)], told.append)
    assert [number for _, number, _ in found] == [0, 1, 2, 3, 4]
    assert {measurements for measurements, _, _ in found} == {2}
    assert [pid == os.getpid() for *_, pid in found] == [True, False, True, False, True]
    assert sorted(told) == [0, 1, 2, 3, 4]


def test_what_a_part_raises_in_the_copy_is_raised_here_and_the_next_work_is_done(two: SecondProcess) -> None:
    with pytest.raises(InputError, match="not this one"):
        two(refuses, [(0,), (1,)])
    assert two(refuses, [(2,), (3,)]) == [2, 3]


def test_what_a_part_raises_here_ends_the_copy_whose_answer_nobody_takes(two: SecondProcess) -> None:
    with pytest.raises(InputError):
        two(refuses, [(1,), (5,)])
    assert two(refuses, [(2,), (3,)]) == [2, 3]


def test_parts_of_a_copy_that_is_lost_are_done_here(two: SecondProcess) -> None:
    pid, told = os.getpid(), list[int]()
    assert two(ends, [(number, pid) for number in range(4)], told.append) == [0, 1, 2, 3]
    assert sorted(told) == [0, 1, 2, 3]
    assert [done for *_, done in two(where, [(0,), (1,)])] == [pid, pid]


def test_an_executor_ends_the_copy_of_the_problem_before() -> None:
    with TwoProcesses() as executor:
        first, second = executor(problem(BIPOD)), executor(problem(HEXAPOD))
        assert {pid for *_, pid in first(where, [(0,), (1,)])} == {os.getpid()}
        assert [measurements for measurements, _, _ in second(where, [(0,), (1,)])] == [3, 3]
    assert {pid for *_, pid in second(where, [(0,), (1,)])} == {os.getpid()}


@pytest.mark.parametrize("count", [1, 7, 8, 13])
def test_halves_come_back_in_the_order_of_the_rows(count: int, two: SecondProcess) -> None:
    rows, factors = np.random.default_rng(1).normal(size=(count, 3)), np.arange(1.0, count + 1.0)
    expected = rows * factors[:, None] + 2.0
    for parts in (two, one_after_another(problem(BIPOD))):
        np.testing.assert_array_equal(by_halves(parts, scaled, (rows, factors), (2.0,)), expected)


@pytest.mark.skipif(not second_process_helps(), reason="one processor alone")
def test_a_run_by_two_processes_gives_the_same_bytes(tmp_path: Path) -> None:
    document = changed(BIPOD, {"optimiser.population": 12, "optimiser.generations": 20, "optimiser.polish": True})
    config = tmp_path / "config.yaml"
    config.write_text(yaml.safe_dump(document), encoding="utf-8")
    one, two = (xd.run(config, timed=False, workers=workers) for workers in (1, 2))
    assert one.files() == two.files()
