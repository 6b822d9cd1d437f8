"""MEIR as a criterion: in configurations, searches, evaluations, diagnoses and every statement of accuracy."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.assurance.model_error.meir import Meir, meir_of_problem
from expdesign.assurance.model_error.statement import AccuracyStatement, hidden_by_plan
from expdesign.errors import InputError
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.targets import GivenVariances
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.result import plan_of
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


PARTS = {"noise", "load_errors", "total", "hidden", "hidden_physics", "hidden_component", "sentence"}


@pytest.fixture(scope="module")
def weighted(tmp_path_factory: pytest.TempPathFactory) -> DesignProblem:
    section = {"physics": ["leg_coupling", "leg_backlash", "passive_joint_compliance"]}
    changes = {"model_error": section | {"without": ["passive_joint_compliance"]}}
    return problem(tmp_path_factory.mktemp("weighted"), changes, estimator="weighted")


@pytest.fixture(scope="module")
def evaluation(weighted: DesignProblem) -> xd.EvaluationResult:
    return xd.evaluate(weighted, plan(weighted))


def plan(weighted: DesignProblem) -> pd.DataFrame:
    decisions = weighted.space.sample(6, np.random.default_rng(2))
    return plan_of(weighted, decisions)


def test_of_a_plan(weighted: DesignProblem, evaluation: xd.EvaluationResult) -> None:
    stated = evaluation.accuracy
    record = evaluation.record
    assert (stated.noise, stated.load_errors, stated.total, stated.hidden.meir) == pytest.approx(
        (record["duir"], record["feir"], record["total"], record["meir"])
    )
    assert set(record["accuracy"]) == PARTS
    assert record["hidden"]["meir"] == evaluation.criteria.loc["meir", "value"] == record["meir"]
    assert record["hidden"]["effects"][0]["error"] == record["hidden"]["meir"]
    assert {each["physics"] for each in record["hidden"]["effects"]} == {"leg_coupling", "leg_backlash"}
    assert f"{record['total']:.3g} tolerances" in stated.sentence
    assert f"{record['meir']:.3g} tolerances" in stated.sentence


def test_of_recordings(weighted: DesignProblem, evaluation: xd.EvaluationResult, tmp_path: Path) -> None:
    """Recordings that follow the plan state what the plan promised, in the identification and in the diagnosis."""
    recordings = xd.simulate(weighted, plan(weighted), seed=3).frame
    robot = CONFIGS / "robots" / "bipod.yaml"
    identified = xd.identify(robot, recordings, targets=weighted)
    planned = evaluation.accuracy
    assert identified.at_targets.accuracy.noise == pytest.approx(planned.noise, rel=1e-6)
    assert identified.at_targets.accuracy.load_errors == pytest.approx(planned.load_errors, rel=1e-2)
    assert identified.at_targets.accuracy.hidden.meir == pytest.approx(planned.hidden.meir, rel=1e-6)
    assert set(identified.record["accuracy"]) == PARTS
    identified.save(tmp_path)
    assert "What may still be hidden" in (tmp_path / "report.html").read_text(encoding="utf-8")
    diagnosed = xd.diagnose(robot, recordings, targets=weighted)
    assert diagnosed.verdict == "consistent"
    # Of a few rows the diagnosis predicts the average over what may be there, which adds a little.
    assert planned.noise <= diagnosed.record["accuracy"]["noise"] < 1.01 * planned.noise
    hidden = diagnosed.record["hidden"]
    assert hidden["freedom"] == 10
    assert {each["physics"] for each in hidden["effects"]} == {"leg_coupling", "leg_backlash"}
    assert hidden["meir"] == pytest.approx(planned.hidden.meir, rel=1e-5)
    assert any(section.id == "hidden" for section in diagnosed.page().sections)
    with pytest.raises(InputError, match="this is about a hexapod"):
        xd.diagnose(robot, recordings, targets=CONFIGS / "hexapod-h1.yaml")


def test_variances_are_summed_as_the_criteria_do(weighted: DesignProblem) -> None:
    assessment = weighted.assess(*weighted.space.decode(weighted.space.sample(5, np.random.default_rng(0))[None]))
    given = GivenVariances(weighted.targets, assessment.noise_variance[0], assessment.force_variance[0])
    parts = {"duir": given.noise_variance, "feir": given.force_variance}
    for name, part in parts.items():
        expected = known_criteria()[name].values(assessment)[0]
        assert float(given.aggregated(given.weighted(part))) == pytest.approx(float(expected))
    assert AccuracyStatement.of(given, None) is None
