"""A search that somebody ends has its usual results with what was there."""

from pathlib import Path

import pandas as pd
import pytest

import expdesign as xd
from tests.commands.calls import config_file

SHORT = {"population": 16, "generations": 6, "seed": 1, "polish": True}


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bipod with three measurements, so that there is a front."""
    changes = {"optimiser": SHORT, "experiment.measurements": 3}
    return config_file(tmp_path_factory.mktemp("run"), changes, "bipod")


@pytest.fixture(scope="module")
def states(config: Path) -> list[str]:
    """Every state that the search of a whole run reports."""
    seen: list[str] = []
    xd.run(config, callback=lambda stage, done, total, note: seen.append(note) if stage == "searching" else None)
    return seen


@pytest.mark.parametrize("part", [0.0, 0.5, 1.0])
def test_a_run_that_is_ended_has_its_usual_results(
    config: Path, states: list[str], part: float, tmp_path: Path
) -> None:
    """Whichever state somebody ends at: the first generation, a later one, the last."""
    last = round(part * (len(states) - 1))
    seen: list[str] = []

    def callback(stage: str, done: int, total: int, note: str) -> None:
        if stage == "searching":
            seen.append(note)

    found = xd.run(config, callback=callback, ended=lambda: len(seen) > last)
    assert seen == states[: last + 1]
    assert found.record["ended_by_hand"].endswith(states[last].partition(": ")[0])
    found.save(tmp_path / "out")
    names = {".expdesign.json", "pareto.csv", "plan.csv", "plans.csv", "report.html", "run.json"}
    assert {file.name for file in (tmp_path / "out").iterdir()} == names
    assert "Ended by hand" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    pareto = pd.read_csv(tmp_path / "out" / "pareto.csv")
    judged = xd.evaluate(config, tmp_path / "out" / "plan.csv").record
    assert judged["total"] == pytest.approx(pareto["total"].min(), rel=1e-9)
