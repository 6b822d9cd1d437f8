"""The contest takes any command, scores a missing or wrong answer with its reason, and its intervals are right."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from benchmarks.concealed.answers import NoAnswerError
from benchmarks.concealed.case import Case, measured_components, read_case, write_questions, write_truth
from benchmarks.concealed.contest.__main__ import kept_round
from benchmarks.concealed.contest.answers import answer_from, read_answer
from benchmarks.concealed.contest.judgement import judge
from benchmarks.concealed.contest.questions import EXTENTS, Question, questions
from benchmarks.concealed.contest.table import agreement, markdown, median_interval
from benchmarks.concealed.contest.tools import Tool, kept_cost, with_rivals
from benchmarks.concealed.experiments import FEW
from benchmarks.concealed.program import Outcome
from benchmarks.concealed.unlisted.cases import Order

COST = Outcome(1.0, 1.0, 100.0)
RIGHT: dict[str, Any] = {
    "mismatch": True,
    "location": ["payload"],
    "physics": [{"name": "load_direction_tilt", "probability": 0.9}],
}


@pytest.fixture(scope="module")
def question() -> Question:
    order = Order("left_out", ("load_direction_tilt",), "bipod", FEW)
    return Question(7, 1, order, "few")


@pytest.fixture(scope="module")
def case(question: Question) -> Case:
    return question.draw()


@pytest.fixture
def folder(case: Case, tmp_path: Path) -> Path:
    write_questions(case, tmp_path / "case", points=True)
    return tmp_path / "case"


def predictions(case: Case, prefix: str) -> dict[str, list[float]]:
    return {name: case.later[prefix + name].tolist() for name in measured_components(case.later)}


def answered(case: Case, tmp_path: Path, **changed: Any) -> Path:
    path = tmp_path / "answer.json"
    path.write_text(json.dumps(RIGHT | {"predictions": predictions(case, "true_")} | changed), encoding="utf-8")
    return path


def test_the_same_seed_draws_the_same_cases_of_every_class() -> None:
    drawn = questions(3, 2, 1)
    assert drawn == questions(3, 2, 1)
    assert drawn != questions(4, 2, 1)
    counted = {(each.physics, each.rows) for each in drawn}
    assert counted == {(physics, rows) for physics in ("listed", "unlisted", "none") for rows in EXTENTS}
    assert len(drawn) == 2 * (2 + 2 + 1)


def test_a_case_has_as_many_rows_as_its_extent(case: Case) -> None:
    assert FEW.rows[0] <= len(case.recordings) <= FEW.rows[1]


def test_the_question_holds_nothing_of_the_truth(case: Case, folder: Path) -> None:
    assert sorted(path.name for path in folder.iterdir()) == ["points.csv", "recordings.csv", "robot.yaml"]
    columns = (folder / "points.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    assert not [name for name in columns if name.startswith(("true_", "base_"))]
    assert not set(columns) & {*measured_components(case.later), "sx_m", "sy_m"}


def test_a_case_is_read_back_as_it_was(case: Case, folder: Path, tmp_path: Path) -> None:
    write_truth(case, tmp_path / "truth")
    again = read_case(folder, tmp_path / "truth")
    assert again.truth == case.truth
    np.testing.assert_allclose(again.later["true_dx_m"], case.later["true_dx_m"], rtol=1e-12)


def test_the_truth_itself_is_located_named_and_predicted(case: Case, tmp_path: Path) -> None:
    judged = judge("oracle", case, COST, answered(case, tmp_path))
    assert judged.located
    assert judged.named
    assert not judged.misnamed
    assert judged.error == 0.0
    assert not judged.worse
    assert judged.base > 1.5


def test_a_wrong_place_and_a_wrong_name_are_wrong(case: Case, tmp_path: Path) -> None:
    path = answered(case, tmp_path, location=["leg 1", "payload"], physics=[{"name": "creep"}])
    judged = judge("wrong", case, COST, path)
    assert not judged.located
    assert not judged.named
    assert judged.misnamed


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"mismatch": "yes"}, "neither true nor false"),
        ({"location": ["leg 9"]}, "leg 9"),
        ({"location": "payload"}, "no list"),
        ({"physics": [{"name": "creep", "probability": 2}]}, "probability 2"),
        ({"verdict": "consistent"}, "unknown keys"),
        ({"predictions": {"dx_m": [0.0, 0.0, 0.0]}}, "lacks dy_m"),
        ({"predictions": {"dx_m": [0.0], "dy_m": [0.0]}}, "1 numbers for 3 points"),
        ({"predictions": {"dx_m": [0.0, float("nan"), 0.0], "dy_m": [0.0] * 3}}, "not every number is finite"),
    ],
)
def test_what_is_out_of_form_is_refused_with_a_reason(changed: dict[str, Any], reason: str) -> None:
    whole = RIGHT | {"predictions": {"dx_m": [0.0] * 3, "dy_m": [0.0] * 3}}
    assert answer_from(whole, ["dx_m", "dy_m"], 3, 2).mismatch
    with pytest.raises(ValueError, match=reason):
        answer_from(whole | changed, ["dx_m", "dy_m"], 3, 2)


def test_a_file_that_is_no_json_is_no_answer(tmp_path: Path) -> None:
    (tmp_path / "answer.json").write_text("dx_m: 1", encoding="utf-8")
    with pytest.raises(NoAnswerError, match="no JSON"):
        read_answer(tmp_path / "answer.json", ["dx_m"], 1, 2)


@pytest.mark.parametrize(
    ("script", "reason"),
    [
        ("pass", "no answer file"),
        ("import sys; sys.exit('this tool has given up')", "exit 1: this tool has given up"),
        ("import time; time.sleep(60)", "longer than 0.5 s"),
        ("import sys; open(sys.argv[2], 'w').write('[]')", "not an object"),
    ],
)
def test_a_command_without_an_answer_is_scored_as_none(
    case: Case, folder: Path, tmp_path: Path, script: str, reason: str
) -> None:
    tool = Tool("silent", f'{sys.executable} -c "{script}" {{case}} {{answer}}')
    cost = tool.ask(folder, tmp_path / "kept", 0.5 if "sleep" in script else 60.0)
    judged = judge(tool.name, case, cost, tmp_path / "kept" / "answer.json")
    assert reason in judged.problem
    assert judged.answer is None
    assert judged.error == float("inf")
    assert judged.worse
    assert not judged.located
    assert reason in markdown([judged], [])
    assert kept_cost(tmp_path / "kept") == cost


def test_a_command_that_does_not_start_says_so(folder: Path, tmp_path: Path) -> None:
    cost = Tool("none", "no-such-program {case} {answer}").ask(folder, tmp_path / "kept", 5.0)
    assert "does not start" in cost.problem


def test_a_tool_sees_a_copy_of_the_question_alone(folder: Path, tmp_path: Path) -> None:
    script = "import os, sys, json; json.dump([os.getcwd(), os.listdir(sys.argv[1])], open(sys.argv[2], 'w'))"
    Tool("curious", f'{sys.executable} -c "{script}" {{case}} {{answer}}').ask(folder, tmp_path / "kept", 60.0)
    where, seen = json.loads((tmp_path / "kept" / "answer.json").read_text(encoding="utf-8"))
    assert sorted(seen) == ["points.csv", "recordings.csv", "robot.yaml"]
    assert not Path(where).is_relative_to(tmp_path)


def test_a_command_needs_its_placeholders() -> None:
    with pytest.raises(ValueError, match=r"no \{answer\}"):
        Tool.from_text("mine=run {case}")
    with pytest.raises(ValueError, match="NAME=COMMAND"):
        Tool.from_text("run {case} {answer}")


def test_the_median_of_answers_and_none_is_the_median() -> None:
    """The bootstrap covers the median of a normal sample in about 95 % of samples; infinities count as large."""
    assert median_interval([1.0, 2.0, float("inf")])[0] == 2.0
    assert median_interval([1.0, float("inf"), float("inf")])[0] == float("inf")
    generator, inside = np.random.default_rng(5), 0
    for _ in range(200):
        _, low, high = median_interval(generator.normal(size=40).tolist())
        inside += low <= 0.0 <= high
    assert 0.88 <= inside / 200 <= 0.99  # 0.95 with a standard error of 0.015, less the bootstrap's own error


def test_kept_rounds_are_scored_side_by_side(case: Case, tmp_path: Path) -> None:
    for number in (1, 2):
        folder = tmp_path / f"round-{number}"
        name = str(case.truth["case"])
        write_questions(case, folder / "cases" / name, points=True)
        write_truth(case, folder / "truth" / name)
        for tool in ("oracle", "mute"):
            (folder / "answers" / tool / name).mkdir(parents=True)
        answered(case, folder / "answers" / "oracle" / name)
    first, second = (kept_round(tmp_path / f"round-{number}") for number in (1, 2))
    assert [each.tool for each in first] == ["mute", "oracle"]
    text = agreement(first, second)
    assert "| oracle | located | 100 % (21–100) | 100 % (21–100) | yes |" in text
    assert "| mute | below 1 | 0 % (0–79) | 0 % (0–79) | yes |" in text
    assert "Intervals of 10 of 10 figures overlap." in text


@pytest.mark.slow
@pytest.mark.parametrize("tool", with_rivals([]), ids=lambda tool: tool.name)
def test_every_rival_answers_in_form_and_beats_the_base_model(
    case: Case, folder: Path, tmp_path: Path, tool: Tool
) -> None:
    for module in ("sklearn", "pysindy"):
        pytest.importorskip(module, reason="the rivals need the extra `benchmark`")
    cost = tool.ask(folder, tmp_path / "kept", 600.0)
    judged = judge(tool.name, case, cost, tmp_path / "kept" / "answer.json")
    assert judged.problem == ""
    assert judged.detected
    if tool.name == "base model":
        assert judged.error == pytest.approx(judged.base, rel=1e-6)
    else:
        assert judged.error < 0.8 * judged.base
