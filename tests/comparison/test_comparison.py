"""Comparison of criteria: what is attained is what theory predicts, and only what means the same is overlaid."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

import expdesign as xd
from expdesign.assurance.comparison.comparable import differences, require_comparable
from expdesign.assurance.comparison.contenders import Contender, drawn
from expdesign.assurance.comparison.correlation import spearman
from expdesign.assurance.comparison.judgement import Judgement, judge
from expdesign.errors import InputError
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.certificate import LowerBound
from expdesign.planning.plan import Plan
from expdesign.planning.search import search_single
from expdesign.report.comparison_figures import cross_table
from expdesign.report.comparison_report import ComparisonResult, agreement
from tests.commands.calls import Printed, call, refusal
from tests.design.problems import BIPOD, HEXAPOD, changed, problem

SAMPLES = 3000


@pytest.fixture(scope="module")
def judged() -> dict[str, Judgement]:
    """Random designs of a hexapod with load errors, with both ways of averaging over targets."""
    mean = problem(HEXAPOD)
    largest = problem(changed(HEXAPOD, {"aggregate": "max"}))
    contenders = drawn(mean, 12, 3)
    return {"mean": judge(mean, contenders, SAMPLES, 5), "max": judge(largest, contenders, SAMPLES, 5)}


@pytest.mark.parametrize("aggregate", ["mean", "max"])
def test_the_attained_accuracy_is_what_total_predicts(judged: dict[str, Judgement], aggregate: str) -> None:
    """theory.md 4 and 5: √(DUIR² + FEIR²) is the RMS error; deviations are within the standard errors (χ² of 12)."""
    found = judged[aggregate]
    z = (found.attained - found.values["total"]) / found.attained_standard_error
    assert np.abs(z).max() < 4.0
    # All designs meet the same draws, so that their z are not independent: only their common size is tested.
    assert np.sqrt((z**2).mean()) < 2.5


def test_standard_errors_are_those_of_repeated_comparisons() -> None:
    """The standard error of the ratio, which uses that both designs meet the same draws, against 40 repetitions."""
    mean = problem(BIPOD)
    contenders = drawn(mean, 3, 1)
    repeated = [judge(mean, contenders, 200, seed) for seed in range(40)]
    best = repeated[0].best
    other = (best + 1) % 3
    ratios = np.array([one.attained[other] / one.attained[best] for one in repeated])
    claimed = np.mean([one.attained_ratio_standard_error[other] for one in repeated if one.best == best])
    # The standard deviation of 40 values is known to 11 %.
    assert ratios.std(ddof=1) == pytest.approx(claimed, rel=0.4)


def test_ratios_are_to_the_best_and_larger_is_worse(judged: dict[str, Judgement]) -> None:
    found = judged["mean"]
    frame = found.frame()
    for name, criterion in known_criteria().items():
        ratio = frame[f"{name}_ratio"]
        assert ratio.min() == 1.0
        best = frame[name].idxmax() if criterion.maximise else frame[name].idxmin()
        assert ratio[best] == 1.0
    assert frame["attained_ratio"].min() == 1.0
    assert frame["attained_ratio_standard_error"][found.best] == 0.0


def test_spearman_is_that_of_scipy() -> None:
    generator = np.random.default_rng(4)
    first, second = generator.integers(0, 6, (2, 30)).astype(float)
    assert float(spearman(first, second)) == pytest.approx(spearmanr(first, second).statistic, rel=1e-12)
    assert float(spearman(first, np.exp(first))) == pytest.approx(1.0)
    assert np.isnan(spearman(first, np.ones(30)))


OTHER: dict[str, tuple[str, Any, str]] = {
    "tolerance": ("targets.0.tolerance.dx_m", 3e-6, "`targets[0].tolerance.dx_m`"),
    "pose": ("targets.0.pose", [0.11, 0.6], "`targets[0].pose[0]`"),
    "noise": ("experiment.deflection_noise.std.dx_m", 3e-6, "`experiment.deflection_noise.std.dx_m`"),
    "averaging": ("aggregate", "max", "`aggregate` is 'max' here and 'mean' there"),
}


@pytest.mark.parametrize("name", OTHER)
def test_what_means_something_else_is_refused_with_the_reason(name: str) -> None:
    key, value, words = OTHER[name]
    first, other = problem(BIPOD), problem(changed(BIPOD, {key: value}))
    with pytest.raises(InputError) as caught:
        require_comparable([first, first, other])
    assert words in caught.value.message
    assert "argument `separate`" in caught.value.message


def test_what_one_wants_to_compare_is_not_refused() -> None:
    first = problem(BIPOD)
    for key, value in (("experiment.measurements", 3), ("optimiser.seed", 9), ("experiment.load.fy_N", -500.0)):
        assert differences(first, problem(changed(BIPOD, {key: value}))) == []


@pytest.fixture(scope="module")
def compared() -> ComparisonResult:
    """Two configurations of the bipod that differ in the number of measurements, with a plan of the user's."""
    configs = [dict(BIPOD), changed(BIPOD, {"experiment.measurements": 3})]
    problems = []
    for index, config in enumerate(configs):
        found = problem(config)
        problems.append(type(found)(**{**vars(found), "source": f"config{index}.yaml"}))
    mine = pd.DataFrame({"x_m": [0.05], "y_m": [0.7], "fx_N": [0.0], "fy_N": [-1000.0]})
    return xd.compare(*problems, plans={"mine": mine}, samples=400, random=6, generations=3)


def test_every_criterion_s_design_beats_random_ones_by_it(compared: ComparisonResult) -> None:
    frame = compared.frame
    assert set(frame["configuration"]) == {"config0", "config1"}
    assert set(frame["origin"]) == {"optimised", "random", "given"}
    assert len(frame) == 2 * (len(known_criteria()) + 6 + 1)
    for name in known_criteria():
        here = frame[frame["configuration"] == "config1"].set_index("design")[f"{name}_ratio"]
        assert here[name] <= min(here[f"random {number}"] for number in range(1, 7))
    assert len(compared.plan("config1", "total")) == 3
    page = compared.page()
    assert [section.id for section in page.sections][:2] == ["summary", "several"]


def test_the_command_writes_what_the_interfaces_say(tmp_path: Path, capsys: Printed) -> None:
    config, out = Path("configs/bipod.yaml").resolve(), tmp_path / "out"
    options = ["--samples", 50, "--random", 5, "--generations", 1]
    assert call("compare", config, "--out", out, *options) == 0
    assert {"comparison.csv", "correlation.csv", "report.html", "plan-bipod-total.csv"} <= {
        p.name for p in out.iterdir()
    }
    correlation = pd.read_csv(out / "correlation.csv")
    assert set(correlation["criterion"]) == set(known_criteria())
    assert correlation["coefficient"].between(-1.0, 1.0).all()
    assert call("compare", config, "--out", tmp_path / "again", *options) == 0
    assert (tmp_path / "again" / "comparison.csv").read_bytes() == (out / "comparison.csv").read_bytes()
    capsys.readouterr()
    for wrong in (["--plan", "mine"], ["--plan", "total=plan.csv"], ["--samples", 1]):
        assert call("compare", config, "--out", tmp_path / "no", *wrong) == 2
        assert capsys.readouterr().err.startswith(f"expdesign: {wrong[0]}: ")
    assert "given twice" in refusal(capsys, "compare", config, config, "--out", tmp_path / "no")


@pytest.mark.parametrize("name", ["o1", "o3", "feir"])
def test_the_design_of_a_criterion_is_a_local_optimum_of_it(name: str) -> None:
    """No small move within the limits improves the design that a search from a short one's design ends at."""
    few = problem(HEXAPOD)
    criterion = known_criteria()[name]
    sign = -1.0 if criterion.maximise else 1.0
    few = replace(few, optimiser=few.optimiser.with_values(polish=True, generations=None))
    start = search_single(few, criterion, seed=1, generations=1)
    found = search_single(few, criterion, seed=1, start=start.decisions).decisions
    scores = sign * criterion.values(few.assess(*few.space.decode(found)))
    best = found[int(np.argmin(scores))]
    assert scores.min() <= sign * start.criteria[name][0]
    generator = np.random.default_rng(2)
    span = few.space.upper - few.space.lower
    moves = 0.01 * generator.standard_normal((400, *best.shape)) * span * ~few.space.discrete
    near = np.clip(best + moves, few.space.lower, few.space.upper)
    poses, loads = few.space.decode(near)
    values = sign * criterion.values(few.assess(poses, loads))[few.loaded.robot.usable(poses).all(axis=1)]
    assert len(values) > 0
    assert values.min() > scores.min() - 1e-3 * abs(scores.min())


def test_the_same_plan_is_recognised_in_any_order() -> None:
    mean = problem(HEXAPOD)
    first, other = drawn(mean, 2, 3)
    order = np.arange(len(first.plan))[::-1]
    turned = Plan(first.plan.configurations[order], first.plan.loads[order], first.plan.series[order])
    contenders = [Contender("o1", "optimised", first.plan), Contender("o3", "optimised", other.plan)]
    contenders.append(Contender("o5", "optimised", turned))
    found = judge(mean, contenders, 100, 1)
    assert found.same_plan.tolist() == [0, 1, 0]
    assert found.frame()["same_plan_as"].tolist() == ["", "", "o1"]
    again = judge(mean, [contenders[0], contenders[1], replace(contenders[0], name="o5")], 100, 1)
    assert sorted(map(sorted, again.agreeing())) == [[0, 2], [1]]
    assert sorted(*again.agreeing(100.0)) == [0, 1, 2]
    (text,) = agreement(found)
    assert "lead to two different plans" in text
    assert "O1 and O5" in text
    assert len(cross_table(0, found).rows) == 2  # also without random designs


def test_a_bound_holds_for_plans_of_its_length(tmp_path: Path) -> None:
    """A plan of more measurements may leave less than the bound for fewer."""
    case = problem(BIPOD)
    one = drawn(case, 1, 3)[0]
    plan = one.plan
    poses, loads = np.repeat(plan.configurations, 2, axis=0), np.repeat(plan.loads, 2, axis=0)
    longer = Plan(poses, loads, np.repeat(plan.series, 2))
    twice = replace(one, name="twice", plan=longer)
    found = judge(case, [one, twice], 200, 1)
    assert found.longer.tolist() == [False, True]
    bound = LowerBound(0.9 * float(found.values["total"][0]), "")
    result = ComparisonResult(("c",), (found,), ([],), (bound,), together=True, settings={})
    (text,) = [each for each in result.lines if "lower bound" in each]
    assert "the best design of them is 11\u00a0% above this bound" in text
    assert f"designs with more measurements: twice ({2 * case.space.measurements})" in text
