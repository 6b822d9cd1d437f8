"""Expanded uncertainty against tolerance: the budget adds up, the scaling law holds, intervals cover what they say."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import expdesign as xd
from expdesign.assurance.acceptance.budget import Contribution, UncertaintyBudget
from expdesign.assurance.acceptance.decision import Basis, Decision
from expdesign.assurance.acceptance.planned import check_readings, planned_decisions
from expdesign.assurance.validation.simulation import simulate
from expdesign.errors import InputError
from expdesign.estimation.coverage import STANDARD, Coverage
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.report.acceptance_texts import acceptance_record, sentences
from tests.design.problems import BIPOD, HEXAPOD, plan_for, problem


def decision(case: DesignProblem, plan: Plan) -> Decision:
    return planned_decisions(case, case.assess(plan.configurations[None], plan.loads[None], plan.series[None]))[0]


def test_coverage_factors() -> None:
    assert STANDARD.factor == pytest.approx(2.0, abs=1e-12)
    assert STANDARD.level == pytest.approx(0.9545, abs=1e-4)
    assert Coverage(0.95).factor == pytest.approx(1.959964, abs=1e-6)
    # JCGM 100:2008, table G.2: t_p for 95.45 % and 95 %.
    np.testing.assert_allclose(
        STANDARD.factors(np.array([1, 4, 10, 50, np.inf])), [13.97, 2.87, 2.28, 2.05, 2], atol=0.006
    )
    np.testing.assert_allclose(Coverage(0.95).factors(np.array([1, 10])), [12.71, 2.23], atol=0.006)


def test_the_budget_adds_up_to_the_criteria() -> None:
    """Where no error of the load acts at the targets themselves, as the direction of gravity does."""
    errors = [each for each in HEXAPOD["experiment"]["load_error"] if each["source"] != "direction"]
    case = problem(HEXAPOD, {"experiment.load_error": errors})
    plan = plan_for(case)
    found = decision(case, plan).budget
    assessment = case.assess(plan.configurations[None], plan.loads[None], plan.series[None])
    squares = (found.standard**2 * case.targets.importance).sum(axis=1)
    total = np.sqrt(squares @ case.targets.weights / case.targets.weights.sum())
    assert total == pytest.approx(float(known_criteria()["total"].values(assessment)[0]), rel=1e-12)
    assert [one.name for one in found.contributions] == ["noise", "com", "mass", "wrench"]
    assert np.isinf(found.degrees).all()


def test_estimated_noise_widens_by_student() -> None:
    """Welch-Satterthwaite with one estimated and one known part: ν_eff = u_c⁴/(u₁⁴/ν₁)."""
    one = np.array([[1.0]])
    budget = UncertaintyBudget(
        (Contribution("noise", one, 5.0), Contribution("com", one)), 10 * one, ("dx_m",), STANDARD, 3
    )
    assert budget.degrees[0, 0] == pytest.approx(20.0)
    assert budget.factor[0, 0] == pytest.approx(2.133, abs=0.01)


def copies(plan: Plan, count: int) -> Plan:
    """A plan that is done so many times, with its own references each time."""
    each = np.arange(count)[:, None] * int(plan.series.max())
    poses, loads = (np.tile(values, (count, 1)) for values in (plan.configurations, plan.loads))
    return Plan(poses, loads, (plan.series[None] + each).ravel())


ERRORS: dict[str, dict[str, Any]] = {
    "none": {"experiment.load_error": ...},
    "shared": {"experiment.load_error": [{"source": "com", "std": [0.001] * 3}, {"source": "mass", "std": 0.01}]},
    "independent": {"experiment.load_error": [{"source": "com", "std": [0.001] * 3, "shared": False}]},
    "both": {},
}


@pytest.mark.parametrize("reference", [False, True])
@pytest.mark.parametrize("errors", ERRORS)
@pytest.mark.parametrize("estimator", ["generalised", "weighted"])
def test_the_number_of_repetitions_is_what_an_evaluation_finds(estimator: str, errors: str, reference: bool) -> None:
    changes = {"experiment.deflection_noise.shared_reference": reference, **ERRORS[errors]}
    changes |= {"experiment.estimator": estimator, "experiment.measurements": 6}
    plan = plan_for(problem(HEXAPOD, changes), 3, at_one_pose=reference)
    ratio = decision(problem(HEXAPOD, changes), copies(plan, 5)).budget
    tolerances = {"targets.0.tolerance": dict(zip(ratio.axes, (1.001 * ratio.expanded[0]).tolist(), strict=True))}
    case = problem(HEXAPOD, {**changes, **tolerances, "targets.1.tolerance": {"dy_m": 1.0}})
    found = decision(case, plan)
    assert found.budget.repetition is not None
    np.testing.assert_allclose(np.sqrt(found.budget.repetition.variances(1.0)), found.budget.standard, rtol=1e-9)
    assert found.repetitions_needed is not None
    assert found.repetitions_needed <= 5
    for times in (4, 5):
        again = decision(case, copies(plan, times)).budget
        np.testing.assert_allclose(again.expanded, found.budget.repeated(times), rtol=1e-9)
    times = found.repetitions_needed
    for repeats, passes in ((times, True), (times - 1, False)):
        assert decision(case, copies(plan, repeats)).robot_passes is passes if repeats else times == 1


def test_what_all_measurements_share_no_repetition_removes() -> None:
    case = problem(HEXAPOD, {"targets.0.tolerance": {"dx_m": 1e-12}})
    found = decision(case, plan_for(case))
    assert found.repetitions_needed is None
    assert not found.robot_passes
    assert "No number of repetitions helps" in " ".join(sentences(found))


def test_the_record_names_everything() -> None:
    case = problem(HEXAPOD, {"acceptance": {"coverage": 0.99}})
    record = acceptance_record(decision(case, plan_for(case)))
    assert record["coverage_factor"] == pytest.approx(2.5758, abs=1e-4)
    axes = record["targets"][0]["axes"]
    assert [axis["axis"] for axis in axes] == ["dx_m", "dz_m", "drx_rad"]
    for axis in axes:
        combined = np.sqrt(sum(part**2 for part in axis["budget"].values()))
        assert axis["standard_uncertainty"] == pytest.approx(combined, rel=1e-12)
        assert axis["expanded_uncertainty"] == pytest.approx(record["coverage_factor"] * combined, rel=1e-12)
        assert axis["passes"] is (axis["expanded_uncertainty"] <= axis["tolerance"])
        assert axis["passes"] is (axis["repetitions_until_it_passes"] == 1)
    json.dumps(record, allow_nan=False)


@pytest.mark.parametrize(
    ("section", "words"),
    [({"k": 2, "coverage": 0.95}, "exactly one"), ({"coverage": 95}, "less than 1"), ({"kay": 2}, "Did you mean `k`")],
)
def test_bad_coverage(section: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        problem(BIPOD, {"acceptance": section})


def coverage(shared: bool, samples: int) -> tuple[np.ndarray[Any, Any], float]:
    """Share of simulated calibrations whose attained error lies within ± the stated U, per axis; stated level."""
    changes = {
        "experiment.measurements": 4,
        "experiment.deflection_noise.shared_reference": shared,
        "acceptance": {"coverage": 0.95},
    }
    case = problem(HEXAPOD, changes)
    plan = plan_for(case, 5, at_one_pose=shared)
    budget = decision(case, plan).budget
    errors = simulate(case, plan, samples, 7).errors
    return (np.abs(errors) <= budget.expanded).mean(axis=0)[budget.matters], budget.coverage.level


@pytest.mark.parametrize("shared", [False, True])
def test_intervals_cover_what_they_say(shared: bool) -> None:
    """2,000 calibrations with noise and load errors: 95 % to within 1.5 % (three standard errors)."""
    covered, level = coverage(shared, 2000)
    assert level == 0.95
    np.testing.assert_allclose(covered, 0.95, atol=0.015)


def test_evaluate_and_run_say_it(tmp_path: Path) -> None:
    result = xd.run(problem(BIPOD))
    result.save(tmp_path / "run")
    record = json.loads((tmp_path / "run" / "run.json").read_text())["acceptance"]
    judged = xd.evaluate(result.problem, result.plan)
    assert judged.record["acceptance"]["targets"] == record["targets"]
    assert "Acceptance" in (tmp_path / "run" / "report.html").read_text()


def test_a_plan_is_expected_to_pass_or_not() -> None:
    case = problem(HEXAPOD)
    plan = plan_for(case)
    for factor, verdict, opening in (
        (1e3, "expected to pass", "The robot is expected to pass"),
        (1e-3, "not expected to pass", "The robot is not expected to pass"),
    ):
        tolerance = {"dx_m": factor * 1e-6, "dz_m": factor * 1e-6}
        found = decision(problem(HEXAPOD, {"targets.0.tolerance": tolerance, "targets.1.tolerance": tolerance}), plan)
        assert acceptance_record(found)["verdict"] == found.verdict == verdict
        assert sentences(found)[0].startswith(opening)
    assert decision(case, plan).basis is Basis.PLAN


def test_as_many_check_readings_as_are_said_prove_conformity() -> None:
    """Instrument of 2 um, tolerance 3 um, U 0.6 um: 8 readings, with which 95 % of such robots pass, but not with 4."""
    one = np.array([[1.0]])
    budget = UncertaintyBudget((Contribution("noise", 3e-7 * one),), 3e-6 * one, ("dx_m",), STANDARD, 3)
    needed = check_readings(budget, 2e-6 * one)
    assert needed == 8
    generator = np.random.default_rng(1)

    def proven(readings: int) -> float:
        error = 3e-7 * generator.standard_normal(20000) + 2e-6 / np.sqrt(readings) * generator.standard_normal(20000)
        return float((np.abs(error) + 2.0 * 2e-6 / np.sqrt(readings) <= 3e-6).mean())

    assert proven(needed) > 0.945
    assert proven(needed - 1) < 0.9545 + 0.003
    assert proven(4) < 0.7
    assert check_readings(budget, np.full((1, 1), np.nan)) == 0
    wide = UncertaintyBudget((Contribution("noise", 2e-6 * one),), 3e-6 * one, ("dx_m",), STANDARD, 3)
    assert check_readings(wide, 2e-6 * one) == 0


def test_the_plan_says_how_many_check_readings_verify_will_need() -> None:
    tolerance = {"dx_m": 5e-6, "dz_m": 5e-6}
    case = problem(HEXAPOD, {"targets.0.tolerance": tolerance, "targets.1.tolerance": tolerance})
    found = decision(case, plan_for(case))
    assert found.check_readings is not None
    assert f"will need {found.check_readings} independent check reading" in " ".join(sentences(found))
    assert acceptance_record(found)["check_readings"] == found.check_readings
