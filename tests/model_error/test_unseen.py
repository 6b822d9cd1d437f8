"""What a plan would not show of missing physics, and the plan that shows it."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import expdesign
from expdesign.assurance.model_error.meir import Meir
from expdesign.assurance.model_error.unseen import SHARE, unseen_by
from expdesign.chain.component import Part
from expdesign.planning.criteria.criterion import known_criteria
from tests.acceptance.test_recommended import TWO_LEGS
from tests.design.problems import BIPOD, problem

SPRINGS = {"model_error": {"physics": ["leg_nonlinear_stiffness"]}}


def plan_at(case: Any, poses: int) -> Any:
    """Measurements (m, g) drawn at so many poses."""
    drawn = case.space.sample(case.space.measurements, np.random.default_rng(3))
    of_pose = drawn[np.arange(len(drawn)) % poses]
    return case.space.canonical(np.where(case.space.of_pose, of_pose, drawn)[None])[0]


def test_a_plan_at_one_pose_is_told_what_it_cannot_see_and_the_fewest_further_measurements() -> None:
    case = problem(BIPOD, SPRINGS | {"experiment.measurements": 4})
    plan = plan_at(case, 1)
    found = unseen_by(case, plan)
    assert found is not None
    assert found.poor == "one pose"
    assert "a spring that is not linear" in found.sentence
    assert found.error > SHARE
    checked = found.checked
    assert checked is not None
    assert len(checked.decisions) == 4 + checked.further
    np.testing.assert_array_equal(checked.decisions[:4], plan)
    index = next(k for k, e in enumerate(Meir(case).physics) if e.effect.phrase == found.phrase)

    def hidden(decisions: Any) -> float:
        configurations, loads = case.space.decode(decisions[None])
        return float(np.sqrt(Meir(case).hidden(case.assess(configurations, loads)).axes[0, index].max()))

    assert hidden(checked.decisions) <= SHARE < hidden(checked.decisions[:-1])
    total = known_criteria()["total"].values(checked.problem.assessed(checked.decisions[None]))[0]
    assert f"becomes {total:.4g})" in found.sentence
    assert "min more" not in found.sentence


@pytest.mark.parametrize("base", [BIPOD, TWO_LEGS])
@pytest.mark.parametrize("poses", [1, 4])
def test_what_further_measurements_leave_is_the_largest_of_all_physics(base: dict[str, Any], poses: int) -> None:
    """At any component, not at that one alone of which the plan hides most."""
    case = problem(base, {"experiment.measurements": 4})
    found = unseen_by(case, plan_at(case, poses))
    assert found is not None
    checked, everything = found.checked, Meir(case)
    assert checked is not None
    hidden = np.sqrt(everything.hidden(checked.problem.assessed(checked.decisions[None])).axes[0]).max(axis=(1, 2))
    counts = [entry.effect.component.part is not Part.PAYLOAD for entry in everything.physics]
    largest = int(np.where(counts, hidden, 0.0).argmax())
    assert checked.left == pytest.approx(hidden[largest], rel=1e-9)
    assert checked.phrase == everything.physics[largest].effect.phrase
    assert f"would leave at most {checked.left:.2g} of a tolerance hidden, from {checked.phrase}" in found.sentence
    assert ("still more than a third" in found.sentence) is not checked.shows
    assert checked.left < 0.9 * found.error


def test_a_plan_that_hides_little_gets_the_sentence_at_one_pose_only() -> None:
    little = {"model_error": {"physics": ["leg_nonlinear_stiffness"], "sizes": {"leg_nonlinear_stiffness": 1e-9}}}
    case = problem(BIPOD, little | {"experiment.measurements": 4})
    assert unseen_by(case, plan_at(case, 4)) is None
    found = unseen_by(case, plan_at(case, 1))
    assert found is not None
    assert found.checked is None
    assert found.sentence.endswith("no other physics costs more.")


def test_run_writes_the_plan_that_shows_it(tmp_path: Path) -> None:
    few = {"population": 8, "generations": 2, "seed": 1, "polish": False}
    costs = {"pose_change": 10, "mass_change": 3, "reading": 1}
    case = problem(BIPOD, SPRINGS | {"optimiser": few, "experiment.costs": costs})
    result = expdesign.run(case)
    assert result.unseen is not None
    assert result.unseen.checked is not None
    assert result.unseen.sentence in result.lines
    assert "min more, total" in result.unseen.sentence
    result.save(tmp_path / "run")
    checked = (tmp_path / "run" / "plan-checked.csv").read_text(encoding="utf-8").splitlines()
    assert len(checked) - 1 == len(result.plan) + result.unseen.checked.further
    judged = expdesign.evaluate(case, tmp_path / "run" / "plan-checked.csv").criteria["value"]
    assert f"becomes {judged['total']:.4g})" in result.unseen.sentence
    assert "cannot rule out" in (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
