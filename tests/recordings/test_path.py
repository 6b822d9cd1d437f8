"""A table of recordings passes few files on its way to a diagnosis, and comes back to none that it has left twice."""

import sys
from collections import Counter
from itertools import groupby
from pathlib import Path
from types import FrameType

import numpy as np
import pytest

import expdesign as xd
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.io.table import Table
from expdesign.planning.problem_file import read_problem
from expdesign.planning.result import plan_of

ROOT = Path(xd.__file__).parent
CONFIG = ROOT.parents[1] / "configs" / "bipod.yaml"
OWN = ("io/table.py", "chain/recordings/recordings.py")
"""Of the table and of the recordings themselves, which are asked everywhere."""
MOST_FILES, MOST_TIMES = 15, 2


def files_entered(recordings: Path) -> list[str]:
    """Files whose functions a table or recordings are given to, in this order, until the diagnosis has them."""
    entered: list[str] = []

    def follow(frame: FrameType, event: str, argument: object) -> None:
        code = frame.f_code
        if event != "call" or not code.co_filename.startswith(str(ROOT)):
            return
        name = str(Path(code.co_filename).relative_to(ROOT))
        given = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
        carried = any(isinstance(frame.f_locals.get(each), Table | LoadedPoints) for each in given)
        if carried and name not in OWN:
            entered.append(name)
        if carried and name.startswith("diagnosis/"):
            raise KeyboardInterrupt

    before = sys.getprofile()
    try:
        sys.setprofile(follow)
        with pytest.raises(KeyboardInterrupt):
            xd.diagnose(CONFIG.parent / "robots" / "bipod.yaml", recordings)
    finally:
        sys.setprofile(before)
    return [name for name, _ in groupby(entered)]


def test_a_table_passes_few_files(tmp_path: Path) -> None:
    problem = read_problem(CONFIG)
    plan = plan_of(problem, problem.space.sample(6, np.random.default_rng(2)))
    xd.simulate(problem, plan, seed=1).frame.to_csv(tmp_path / "recordings.csv", index=False)
    entered = files_entered(tmp_path / "recordings.csv")
    assert entered[-1].startswith("diagnosis/")
    assert len(set(entered)) <= MOST_FILES
    assert max(Counter(entered).values()) <= MOST_TIMES, Counter(entered)
