"""A search that somebody ends has its usual results with what was there; one that is watched has the same bytes."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from tests.watching.runs import config_file

import expdesign as xd
from expdesign.planning.search import Progress
from expdesign.report.stored import page_text


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return config_file(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def states(config: Path) -> list[Progress]:
    """Every state that a whole run reports."""
    seen: list[Progress] = []
    xd.run(config, follow=seen.append, timed=False)
    return seen


def test_a_watched_run_gives_the_same_bytes(config: Path) -> None:
    plain, watched = xd.run(config, timed=False), xd.run(config, follow=lambda state: False, timed=False)
    assert watched.files() == plain.files()
    assert page_text(watched.page()) == page_text(plain.page())
    assert "ended_by_hand" not in plain.record


@pytest.mark.parametrize("part", [0.0, 0.3, 0.6, 0.9, 1.0])
def test_a_run_that_is_ended_has_its_usual_results(
    config: Path, states: list[Progress], part: float, tmp_path: Path
) -> None:
    """Whichever state somebody ends at: the first generation, a later one, the last."""
    last = round(part * (len(states) - 1))
    seen: list[Progress] = []

    def follow(state: Progress) -> bool:
        seen.append(state)
        return len(seen) > last

    found = xd.run(config, follow=follow)
    assert [state.hypervolume for state in seen[: last + 1]] == [state.hypervolume for state in states[: last + 1]]
    assert len(seen) == last + 1
    assert found.record["ended_by_hand"] == f"generation {states[last].generation}, {states[last].note}"
    found.save(tmp_path / "out")
    names = {".expdesign.json", "pareto.csv", "plan.csv", "plans.csv", "report.html", "report.json", "run.json"}
    assert {file.name for file in (tmp_path / "out").iterdir()} == names
    assert "Ended by hand" in (tmp_path / "out" / "report.json").read_text(encoding="utf-8")
    # What was on the screen is in the results, but for the resolution with which poses can be set.
    shown = states[last].front.min(axis=0)
    reached = pd.read_csv(tmp_path / "out" / "pareto.csv")[["duir", "feir"]].to_numpy().min(axis=0)
    assert np.all(reached <= shown * (1.0 + 1e-6))
    judged = xd.evaluate(config, tmp_path / "out" / "plan.csv").record
    best = found.front.criteria["total"].min()
    assert judged["total"] == pytest.approx(best, rel=1e-9)
