"""Every task is done once, however slowly its results are taken."""

import time
from functools import partial
from pathlib import Path

from expdesign.app.parallel import Processes, results


def leave_a_mark(task: tuple[str, int]) -> int:
    folder, number = task
    with (Path(folder) / f"{number}.txt").open("a", encoding="utf-8") as stream:
        stream.write("done\n")
    return number


def test_a_slow_reader_of_results_makes_no_work_twice(tmp_path: Path) -> None:
    """While a result is written others arrive, which once was taken for the end of their worker."""
    tasks = [(str(tmp_path), number) for number in range(12)]
    found = []
    for index, result in results(leave_a_mark, tasks, partial(Processes, 2)):
        time.sleep(0.05)
        found.append((index, result))
    assert sorted(found) == [(number, number) for number in range(12)]
    assert [(tmp_path / f"{number}.txt").read_text() for number in range(12)] == ["done\n"] * 12
