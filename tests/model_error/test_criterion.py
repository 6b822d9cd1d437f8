"""MEIR as a criterion: in configurations, searches, evaluations and diagnoses."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import expdesign as xd
from expdesign.assurance.model_error.meir import Meir, meir_of_problem
from expdesign.assurance.model_error.statement import hidden_by_plan
from expdesign.errors import InputError
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.sampling import starting_designs
from expdesign.planning.search import search
from expdesign.report.blocks import DataTable, Figure
from tests.commands.calls import config_file
from tests.model_error.problems import CONFIGS

SMALL = {"objectives": ["total", "meir"], "optimiser": {"population": 16, "generations": 6, "seed": 1}}


def written(folder: Path, changes: dict[str, Any], name: str = "bipod", **experiment: Any) -> Path:
    return config_file(folder, changes | {f"experiment.{key}": value for key, value in experiment.items()}, name)


def problem(folder: Path, changes: dict[str, Any], **experiment: Any) -> DesignProblem:
    return read_problem(written(folder, changes, **experiment))


def meir_of(here: DesignProblem) -> Meir:
    found = meir_of_problem(here)
    assert found is not None
    return found


def test_only_who_asks_for_it_pays_for_it(tmp_path: Path) -> None:
    assert problem(tmp_path, {}).further == ()
    assert [c.name for c in problem(tmp_path, {"model_error": {}}).further] == ["meir"]
    asked = problem(tmp_path, {"objectives": ["total", "meir"]})
    assert asked.objectives[1] is asked.further[0]
    assert "meir" not in known_criteria()


@pytest.mark.slow
def test_a_front_of_total_and_meir(tmp_path: Path) -> None:
    here = problem(tmp_path, SMALL, measurements=4)
    front = search(here)
    again = search(here)
    meir, total = front.criteria["meir"], front.criteria["total"]
    np.testing.assert_array_equal(meir, again.criteria["meir"])
    assert front.objectives == ("total", "meir")
    assert (np.diff(total) > 0.0).all()
    assert (np.diff(meir) < 0.0).all()
    whole = meir_of(here).values(here.assess(*here.space.decode(front.decisions)))
    np.testing.assert_allclose(meir, whole, rtol=1e-12)
    # The plan by total alone hides more.
    alone = search(replace(here, objectives=(known_criteria()["duir"], known_criteria()["feir"])))
    assert meir.min() < alone.criteria["meir"][alone.recommended]


@pytest.mark.parametrize(
    ("section", "place", "said"),
    [
        ({"physics": []}, "model_error", "no physics is left"),
        ({"physics": ["link_compliance"]}, "model_error.physics", "link_compliance"),
        ({"sizes": {"leg_backlash": 0.0}}, "model_error.sizes.leg_backlash", "prior size 0"),
        ({"sizes": {"leg_backlashes": 1.0}}, "model_error.sizes", "`leg_backlash`"),
        ({"level": 0.9}, "model_error", "does not exist"),
    ],
)
def test_bad_input_says_where(tmp_path: Path, section: dict[str, Any], place: str, said: str) -> None:
    path = written(tmp_path, {"model_error": section})
    with pytest.raises(InputError, match=said) as caught:
        read_problem(path)
    assert caught.value.where.endswith(f"config.yaml, {place}")
    assert caught.value.remedy


def test_geometric_calibration_has_no_meir(tmp_path: Path) -> None:
    path = written(tmp_path, {"model_error": {}}, "bipod", calibration="both", measurements=6)
    with pytest.raises(InputError, match="elastostatic calibration only"):
        read_problem(path)


def test_a_plan_without_degrees_of_freedom_notices_nothing(tmp_path: Path) -> None:
    here = problem(tmp_path, {"model_error": {}})
    designs = starting_designs(here, 1, np.random.default_rng(0))
    hidden = hidden_by_plan(here, here.assess(*here.space.decode(designs)), "this plan")
    assert hidden.freedom == 0
    assert "this plan cannot show missing physics" in hidden.sentence
    assert all(each.noticed == np.inf for each in hidden.physics)


def test_evaluate_names_what_is_hidden(tmp_path: Path) -> None:
    path = written(tmp_path, {"model_error": {"without": ["leg_coupling"]}}, measurements=4)
    here = read_problem(path)
    designs = starting_designs(here, 1, np.random.default_rng(0))
    configurations = here.space.decode(designs)[0][0]
    columns = "x_m,y_m,fx_N,fy_N\n"
    rows = "\n".join(f"{x!r},{y!r},0,-1000" for x, y in configurations.tolist())
    (tmp_path / "plan.csv").write_text(columns + rows + "\n", encoding="utf-8")
    result = xd.evaluate(path, tmp_path / "plan.csv")
    record = result.record
    assert record["hidden"]["meir"] == pytest.approx(record["meir"])
    assert result.criteria.loc["meir", "value"] == pytest.approx(record["meir"])
    assert record["hidden"]["effects"][0]["error"] == record["hidden"]["meir"]
    assert not any(each["physics"] == "leg_coupling" for each in record["hidden"]["effects"])


def test_consistent_recordings_say_what_may_still_be_hidden(tmp_path: Path) -> None:
    # Errors of the loads have the size that the recordings show, and a plan those that are declared.
    exact = {"model_error": {"physics": ["leg_coupling", "leg_backlash"]}, "experiment.load_error": ...}
    path = written(tmp_path, exact, measurements=5)
    here = read_problem(path)
    designs = starting_designs(here, 1, np.random.default_rng(1))[0]
    configurations, loads = here.space.decode(designs)
    true = here.loaded.measure(configurations, loads).observation @ here.loaded.robot.compliance
    noisy = true + np.random.default_rng(2).normal(scale=1e-6, size=true.shape)
    lines = ["sequence,series,x_m,y_m,fx_N,fy_N,dx_m,dy_m,sx_m,sy_m"]
    for index, (pose, moved) in enumerate(zip(configurations.tolist(), noisy.tolist(), strict=True), start=1):
        lines.append(",".join(map(repr, [index, index, *pose, 0.0, -1000.0, *moved, 1e-6, 1e-6])))
    (tmp_path / "recordings.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    robot = CONFIGS / "robots" / "bipod.yaml"
    found = xd.diagnose(robot, tmp_path / "recordings.csv", targets=path)
    assert found.verdict == "consistent"
    hidden = found.record["hidden"]
    assert hidden["freedom"] == 8
    assert {each["physics"] for each in hidden["effects"]} <= {"leg_coupling", "leg_backlash"}
    # Recordings of this plan hide what the plan hides.
    planned = meir_of(here).values(here.assess(configurations[None], loads[None]))[0]
    assert hidden["meir"] == pytest.approx(planned, rel=1e-5)
    assert "hidden" not in xd.diagnose(robot, tmp_path / "recordings.csv").record
    assert any(section.id == "hidden" for section in found.page().sections)
    with pytest.raises(InputError, match="this is about a hexapod"):
        xd.diagnose(robot, tmp_path / "recordings.csv", targets=CONFIGS / "hexapod-h1.yaml")


def test_the_report_of_a_run_shows_what_is_hidden(tmp_path: Path) -> None:
    changes = {**SMALL, "optimiser": {"population": 8, "generations": 2, "seed": 1, "polish": False}}
    result = xd.run(written(tmp_path, changes, measurements=3))
    assert list(result.pareto.columns).index("meir") > 0
    assert result.record["meir"] == pytest.approx(float(result.front.criteria["meir"][result.front.recommended]))
    section = next(each for each in result.page().sections if each.id == "hidden")
    assert len(section.blocks) == 3
    figure, table = section.blocks[1], section.blocks[2]
    assert isinstance(figure, Figure)
    assert isinstance(table, DataTable)
    diamonds = [trace for trace in figure.plot["data"] if "diamond" in str(trace.get("marker"))]
    bars = [trace for trace in figure.plot["data"] if trace not in diamonds]
    # Detection limits an error where its bar ends.
    assert {name for trace in diamonds for name in trace["y"]} <= {name for trace in bars for name in trace["y"]}
    assert bars
    # Every effect is noticed in time by this plan, or by another, or by none; one that is not needs another.
    column = table.columns.index("Noticed in time by")
    below = [row[column] == "this plan" for row in table.rows]
    assert below == sorted(below)
    assert 0 < sum(below) < len(below)
