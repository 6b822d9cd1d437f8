"""The accuracy statement carries what may be hidden beside noise and load errors, in every command that makes one."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.assurance.model_error.statement import AccuracyStatement
from expdesign.io.yaml_reader import read_yaml
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.targets import GivenVariances
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.result import plan_of
from tests.model_error.problems import CONFIGS

PARTS = {"noise", "load_errors", "total", "hidden", "hidden_physics", "hidden_component", "sentence"}


@pytest.fixture(scope="module")
def problem() -> DesignProblem:
    document = read_yaml(CONFIGS / "bipod.yaml")
    section = {"physics": ["leg_coupling", "leg_backlash"]}
    content = {**document.content, "model_error": section}
    content["experiment"] = {**content["experiment"], "estimator": "weighted"}
    return problem_from_document(replace(document, content=content))


@pytest.fixture(scope="module")
def evaluation(problem: DesignProblem) -> xd.EvaluationResult:
    return xd.evaluate(problem, plan(problem))


def plan(problem: DesignProblem) -> pd.DataFrame:
    decisions = problem.space.sample(6, np.random.default_rng(2))
    return plan_of(problem, decisions)


def test_of_a_plan(problem: DesignProblem, evaluation: xd.EvaluationResult) -> None:
    stated = evaluation.accuracy
    record = evaluation.record
    assert (stated.noise, stated.load_errors, stated.total, stated.hidden.meir) == pytest.approx(
        (record["duir"], record["feir"], record["total"], record["meir"])
    )
    assert set(record["accuracy"]) == PARTS
    assert f"{record['total']:.3g} tolerances" in stated.sentence
    assert f"{record['meir']:.3g} tolerances" in stated.sentence


def test_of_recordings(problem: DesignProblem, evaluation: xd.EvaluationResult, tmp_path: Path) -> None:
    """Recordings that follow the plan state what the plan promised, in the identification and in the diagnosis."""
    recordings = xd.simulate(problem, plan(problem), seed=3).frame
    robot = CONFIGS / "robots" / "bipod.yaml"
    identified = xd.identify(robot, recordings, targets=problem)
    planned = evaluation.accuracy
    assert identified.at_targets.accuracy.noise == pytest.approx(planned.noise, rel=1e-6)
    assert identified.at_targets.accuracy.load_errors == pytest.approx(planned.load_errors, rel=1e-2)
    assert identified.at_targets.accuracy.hidden.meir == pytest.approx(planned.hidden.meir, rel=1e-6)
    assert set(identified.record["accuracy"]) == PARTS
    identified.save(tmp_path)
    assert "What may still be hidden" in (tmp_path / "report.html").read_text(encoding="utf-8")
    diagnosed = xd.diagnose(robot, recordings, targets=problem)
    if diagnosed.verdict == "consistent":
        assert diagnosed.at_targets.accuracy is not None
        # Of a few rows the diagnosis predicts the average over what may be there, which adds a little.
        assert planned.noise <= diagnosed.record["accuracy"]["noise"] < 1.01 * planned.noise


def test_variances_are_summed_as_the_criteria_do(problem: DesignProblem) -> None:
    assessment = problem.assess(*problem.space.decode(problem.space.sample(5, np.random.default_rng(0))[None]))
    given = GivenVariances(problem.targets, assessment.noise_variance[0], assessment.force_variance[0])
    parts = {"duir": given.noise_variance, "feir": given.force_variance}
    for name, part in parts.items():
        expected = known_criteria()[name].values(assessment)[0]
        assert float(given.aggregated(given.weighted(part))) == pytest.approx(float(expected))
    assert AccuracyStatement.of(given, None) is None
