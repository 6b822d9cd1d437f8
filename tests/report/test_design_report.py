"""The numbers in the report of a run are those of its front."""

import io
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from expdesign.assurance.acceptance.planned import planned_budgets, recommended_acceptance
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import design_minutes, pareto_frame, plan_of
from expdesign.planning.schema import CostsSection
from expdesign.report import words
from expdesign.report.acceptance_texts import sentences
from expdesign.report.design_data import criteria_cells
from expdesign.report.design_report import RunResult
from expdesign.report.error_budget import parts
from expdesign.report.page import content_of, render
from tests.report.conftest import text_of


def content(html: str) -> dict[str, Any]:
    parsed: dict[str, Any] = content_of(html)
    return parsed


def visible(html: str) -> pd.DataFrame:
    """The table of designs as it stands in the page."""
    (table,) = re.findall(r'<table id="designs".*?</table>', html, flags=re.DOTALL)
    table = re.sub(r"<caption.*?</caption>|<input[^>]*>", "", table, flags=re.DOTALL)
    cells = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, flags=re.DOTALL) for row in table.split("</tr>")[:-1]]
    plain = [[re.sub(r"<[^>]+>", "", cell).strip() for cell in row] for row in cells]
    return pd.DataFrame(plain[1:], columns=plain[0])


@pytest.fixture(params=["hexapod", "bipod"])
def case(request: pytest.FixtureRequest) -> Any:
    return request.getfixturevalue(request.param)


def test_the_table_of_designs_is_the_front(case: Any) -> None:
    table = visible(case.html)
    assert len(table) == len(case.front)
    for name in ("DUIR", "FEIR", "total"):
        expected = [words.number(float(value), 4) for value in case.front.criteria[name.lower()]]
        assert table[name].tolist() == expected
    labels = table["Design"].tolist()
    assert next(label for label in labels if "recommended" in label).split(" ")[0] == str(case.front.recommended + 1)
    assert next(label for label in labels if "knee" in label).split(" ")[0] == str(case.front.knee + 1)


def test_the_downloads_are_the_files_of_the_run(case: Any) -> None:
    page = content(case.html)
    front = pd.read_csv(io.StringIO(page["csv"]["designs"]["text"]))
    pd.testing.assert_frame_equal(front, pareto_frame(case.front), check_exact=True)
    for index, design in enumerate(page["data"]["designs"]):
        plan = pd.read_csv(io.StringIO(design["csv"]))
        pd.testing.assert_frame_equal(plan, plan_of(case.problem, case.front.decisions[index]), check_exact=True)


def test_the_plan_is_shown_in_millimetres_and_milliradians(case: Any) -> None:
    design = content(case.html)["data"]["designs"][case.front.recommended]
    plan = plan_of(case.problem, case.front.decisions[case.front.recommended])
    position = list(plan.columns).index("x_m")
    shown = [float(row[position].replace("−", "-")) for row in design["plan"]]
    np.testing.assert_allclose(shown, 1e3 * plan["x_m"], atol=0.0005001)


def test_the_figure_of_the_front_shows_the_front(case: Any) -> None:
    trace = content(case.html)["figures"]["front"]["data"][0]
    x, y = case.front.objectives[:2]
    np.testing.assert_array_equal(trace["x"], case.front.criteria[x])
    np.testing.assert_array_equal(trace["y"], case.front.criteria[y])


def with_gravity_known(problem: DesignProblem) -> DesignProblem:
    """Without the error that acts at the targets as well, which FEIR leaves out."""
    loaded = problem.loaded
    sources = tuple(source for source in loaded.sources if source.source != "direction")
    return replace(problem, loaded=LoadedRobot(loaded.robot, loaded.load, sources, loaded.regressor, loaded.physics))


def test_the_error_budget_adds_up_to_the_criteria(case: Any) -> None:
    weights = case.problem.targets.weights / case.problem.targets.weights.sum()
    here = with_gravity_known(case.problem)
    assessment = here.assess(*here.space.decode(case.front.decisions))
    for design, budget in enumerate(planned_budgets(here, assessment)):
        of_axes = parts(budget) / budget.tolerance[..., None]  # noise, load and both, then each source
        squares = np.nansum(of_axes**2, axis=1)[:, :3]
        rms = dict(zip(("duir", "feir", "total"), np.sqrt(weights @ squares), strict=True))
        for name, found in rms.items():
            np.testing.assert_allclose(found, here.criteria[name].values(assessment)[design], rtol=1e-12)


def test_each_source_of_load_error_is_what_feir_is_without_the_others(case: Any) -> None:
    """Removing the other sources from the problem leaves the share that the budget gives to one, where the estimator
    does not weigh them.
    """
    weighted = replace(with_gravity_known(case.problem), estimator="weighted")
    loaded = weighted.loaded
    assessment = weighted.assess(*weighted.space.decode(case.front.decisions))
    budgets_of = planned_budgets(weighted, assessment)
    found = np.array([[one.deviation for one in budget.contributions[1:]] for budget in budgets_of])
    measured = loaded.measure(*weighted.space.decode(case.front.decisions))
    for index, source in enumerate(loaded.sources):
        alone = type(assessment)(
            replace(
                measured,
                load_errors=measured.load_errors[..., measured.sources[index]],
                sources=(slice(None),),
            ),
            case.problem.noise,
            (source.shared,),
            case.problem.targets,
            estimator="weighted",
        )
        np.testing.assert_allclose(found[:, index], np.sqrt(alone.force_variance), rtol=1e-9)


def test_one_table_has_the_budget_and_what_is_accepted(case: Any) -> None:
    """Rows of the recommended design: noise, sources and U of the decision that `run.json` records."""
    decision = recommended_acceptance(case.problem, case.front)
    design = content(case.html)["data"]["designs"][case.front.recommended]
    budget = decision.budget
    assert design["sentences"] == sentences(decision)
    assert len(design["budget"]) == int(budget.matters.sum())
    for row, (target, axis) in zip(design["budget"], np.argwhere(budget.matters), strict=True):
        assert row[0] == f"target {target + 1}, {words.axis(budget.axes[axis])}"
        assert row[2] == words.number(1e6 * float(budget.contributions[0].deviation[target, axis]))
        assert words.number(1e6 * float(budget.expanded[target, axis])) in row
        assert row[-2] == decision.axis_verdict(target, axis)
    assert case.html.count("comes from</h") == 1


def test_the_plan_stands_before_the_choice_of_another(case: Any) -> None:
    places = [case.html.index(f'<section id="{name}"') for name in ("summary", "design", "choice", "errors", "run")]
    assert places == sorted(places)


def test_measurements_are_at_as_many_poses_as_differ(case: Any) -> None:
    configurations, _ = case.problem.space.decode(case.front.decisions[case.front.recommended])
    poses = len({tuple(row) for row in configurations.round(9).tolist()})
    assert f"at {words.count(poses, 'pose')}" in case.html


def test_the_time_of_the_plan_is_among_the_cards(hexapod: Any) -> None:
    assert "Time of the plan" not in hexapod.html
    problem = replace(hexapod.problem, costs=CostsSection(pose_change=2.0, mass_change=10.0, reading=0.5))
    minutes = design_minutes(problem, hexapod.front)
    page = render(RunResult(problem, hexapod.front, hexapod.run).page())
    card = page.split("Time of the plan", 1)[1][:200]
    assert f">{words.number(float(minutes[hexapod.front.recommended]))}<" in card


def test_criteria_that_are_zero_for_every_design_are_left_out(hexapod: Any) -> None:
    zero = {name: np.zeros(len(hexapod.front)) for name in ("o1", "o2", "o3", "o4", "o5")}
    front = replace(hexapod.front, criteria=hexapod.front.criteria | zero)
    assert {"O1", "O5"}.isdisjoint(row[0][:2] for row in criteria_cells(front, 0))
    assert "O1" in {row[0][:2] for row in criteria_cells(hexapod.front, 0)}


def test_the_lower_bound_is_compared_with_the_recommended_design(hexapod: Any, bipod: Any) -> None:
    sentence = hexapod.said.sentences[-1]
    duir = hexapod.front.criteria["duir"]
    above = 100.0 * (duir[hexapod.front.recommended] / (0.8 * duir.min()) - 1.0)
    assert f"No plan of {words.count(hexapod.problem.space.measurements, 'measurement')}" in sentence
    assert f"{words.number(float(above), 2)}\u00a0% above this bound" in sentence
    assert bipod.said.sentences[-1] == "No lower bound of DUIR: 40 candidates."
    assert "No plan of" not in bipod.html
    shown = "".join(text_of(hexapod.html).split())
    assert all("".join(text.replace("`", "").split()) in shown for text in hexapod.said.sentences)


def test_legs_are_as_long_in_the_picture_as_the_robot_says(case: Any) -> None:
    """The drawn legs against the robot's actuator lengths, and the force's line against the wrench's moment."""
    view = content(case.html)["data"]["view"]
    robot = case.problem.loaded.robot
    configurations, _ = case.problem.space.decode(case.front.decisions)
    points = np.array(view["states"]).reshape(len(view["states"]), -1, view["dimension"])
    (legs,) = (part["paths"] for part in view["parts"] if part["role"] == "actuator")
    lengths = robot.lengths(configurations.reshape(-1, configurations.shape[-1]))
    drawn = np.stack([np.linalg.norm(points[:, a] - points[:, b], axis=-1) for a, b in legs], axis=-1)
    np.testing.assert_allclose(drawn[: len(lengths)], lengths, atol=1e-4)


def test_the_force_acts_where_its_moment_says(hexapod: Any) -> None:
    """Lever × arrow in the picture is the moment of the wrench at every target, on the scale of the force."""
    view = content(hexapod.html)["data"]["view"]
    points = np.array(view["states"]).reshape(len(view["states"]), -1, 3)
    wrenches = hexapod.problem.target_wrenches
    at_targets = points[-len(wrenches) :]
    arrow = at_targets[:, view["tip"]] - at_targets[:, view["contact"]]
    lever = at_targets[:, view["contact"]] - at_targets[:, view["origin"]]
    scale = np.linalg.norm(wrenches[:, :3], axis=-1) / np.linalg.norm(arrow, axis=-1)
    np.testing.assert_allclose(arrow * scale[:, None], wrenches[:, :3], atol=1e-3 * np.abs(wrenches[:, :3]).max())
    np.testing.assert_allclose(
        np.cross(lever, arrow) * scale[:, None], wrenches[:, 3:], atol=2e-3 * np.abs(wrenches[:, 3:]).max()
    )


def test_a_plan_that_may_be_better_is_said_in_one_sentence(hexapod: Any) -> None:
    duir = float(hexapod.front.criteria["duir"].min())
    assert "if there is one, is at most 20\u00a0% better." in hexapod.said.sentences[-1]
    at_bound = RunResult(hexapod.problem, hexapod.front, {"duir_lower_bound": duir})
    assert "if there is one" not in at_bound.lines[-1]
