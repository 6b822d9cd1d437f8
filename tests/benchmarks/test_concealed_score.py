"""The scorer on synthetic answers: what counts as right, and what as wrong."""

from __future__ import annotations

import copy
from math import sqrt

import pytest

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from benchmarks.concealed.answers import NoAnswerError, answer_from, read_answer
from benchmarks.concealed.held_out import HeldOut
from benchmarks.concealed.judgement import Case
from benchmarks.concealed.rates import Rate
from benchmarks.concealed.score import confusion, frame, markdown, table


def truth(kind, *effects, name="case-001", rows=100):
    made = [{"physics": physics, "components": list(places), "chi2_dof_alone": 3.0} for physics, *places in effects]
    facts = {"robot": "H1", "rows": rows, "series": 20, "chi2_dof": 3.0, "true_stiffness": [1.0] * 6}
    return {"case": name, "kind": kind, "effects": made} | facts


def effect(physics, component, probability=0.99, group=()):
    return {
        "physics": physics,
        "component": component,
        "parameters": {},
        "probability": probability,
        "indistinguishable_from": list(group),
    }


FIT = {"noise_rms": 1.0, "train_before": 2.0, "train_after": 1.0, "test_before": 2.0, "test_after": 1.05}


def said(verdict, *effects, location=None, **fit):
    place = {"component": location, "axes": [], "region": "", "share": 0.5} if location else None
    return answer_from({"verdict": verdict, "effects": list(effects), "location": place, "fit": FIT | fit}, 6)


def case(kind, effects, verdict, *conclusions, wall=5.0, name="case-001", later=None, **more):
    return Case(truth(kind, *effects, name=name), said(verdict, *conclusions, **more), wall, "", later, cpu_s=wall)


PLAY = ("leg_backlash", "leg 3")
CREEP = ("creep", "all legs")


def line(cases, start):
    (found,) = [each for each in table(cases) if each.what.startswith(start)]
    return found


def test_right_answers_meet_everything():
    cases = [
        case("none", [], "consistent", test_before=1.0, test_after=1.0),
        case("one", [PLAY], "explained", effect("leg_backlash", "leg 3")),
        case("two", [PLAY, CREEP], "explained", effect("creep", "all legs"), effect("leg_backlash", "leg 3")),
        case("outside", [("cable", "environment")], "unexplained", location="environment"),
    ]
    asked = [each for each in table(cases) if each.asked and "85-95" not in each.what and "further" not in each.what]
    assert len(asked) == 10
    assert all(each.met for each in asked)
    assert [each.faults() for each in cases] == [[], [], [], []]
    assert "None." in markdown(cases, "Title", [])


def test_an_alarm_without_effect_is_false_and_so_is_no_answer():
    silent = Case(truth("none"), None, 1.0, "exit 2: oops")
    cases = [case("none", [], "unexplained"), case("none", [], "consistent"), silent]
    assert line(cases, "false alarms").found.startswith("66.7")
    assert line(cases, "false alarms").met is False
    assert silent.faults() == ["exit 2: oops"]
    assert line(cases, "  diagnoses that gave no answer").found.startswith("33.3")


def test_an_effect_called_consistent_is_not_detected():
    cases = [case("one", [PLAY], "consistent"), case("outside", [("cable", "environment")], "consistent")]
    assert line(cases, "mismatches detected").found.startswith("0.0")
    assert [each.faults() for each in cases] == [["not detected"], ["not detected"]]


def test_first_counts_the_first_conclusion_only():
    second = case("one", [PLAY], "explained", effect("creep", "leg 3"), effect("leg_backlash", "leg 3"))
    assert not second.first_right
    assert not second.first_or_group_right
    assert second.faults() == ["other physics first"]


def test_a_declared_group_counts_for_the_group_alone():
    grouped = case("one", [PLAY], "explained", effect("creep", "leg 3", group=["leg_backlash"]))
    assert not grouped.first_right
    assert grouped.first_or_group_right
    assert grouped.faults() == ["first only within its group"]


@pytest.mark.parametrize(
    ("named", "right"),
    [
        ("leg 3", True),
        (["leg 3"], True),
        (["leg 3", "leg 4"], False),
        ("leg 4", False),
        ("all legs", False),
        ([], False),
    ],
)
def test_component_may_be_a_name_or_a_list(named, right):
    assert case("one", [PLAY], "explained", effect("leg_backlash", named)).component_right is right


@pytest.mark.parametrize(
    ("named", "right"), [("leg 1", True), (["leg 1", "leg 2"], True), (["leg 1", "leg 2", "leg 3"], False)]
)
def test_a_coupling_is_at_either_of_its_legs(named, right):
    answer = effect("leg_coupling", named)
    assert case("one", [("leg_coupling", "leg 1", "leg 2")], "explained", answer).component_right is right


def test_a_list_of_all_legs_is_all_legs():
    every = [f"leg {leg}" for leg in range(1, 7)]
    assert case("one", [CREEP], "explained", effect("creep", every)).component_right
    assert not case("one", [CREEP], "explained", effect("creep", every[:5])).component_right


def test_the_location_stands_in_where_nothing_is_concluded():
    assert case("one", [PLAY], "unexplained", location="leg 3").component_right
    assert not case("one", [PLAY], "unexplained", location="leg 1").component_right


def test_both_need_a_conclusion_each():
    both = [PLAY, CREEP]
    one_for_two = case("two", both, "explained", effect("leg_backlash", "leg 3", group=["creep"]))
    assert not one_for_two.both_found()
    grouped = effect("thermal_drift", "all legs", group=["creep"])
    by_group = case("two", both, "explained", effect("leg_backlash", "leg 3"), grouped)
    assert by_group.both_found()
    assert not by_group.both_found(groups=False)
    crossed = case(
        "two",
        both,
        "explained",
        effect("leg_backlash", "leg 3", group=["creep"]),
        effect("leg_backlash", "leg 2"),
    )
    assert crossed.both_found()


def test_outside_is_unexplained_or_unknown():
    there = [("cable", "environment")]
    known = effect("creep", "leg 1")
    unknown = effect("unknown", "payload")
    assert case("outside", there, "unexplained", known).declared_unknown
    assert case("outside", there, "explained", unknown).declared_unknown
    assert not case("outside", there, "explained", known).declared_unknown
    cases = [case("outside", there, "unexplained", known), case("outside", there, "unexplained")]
    assert line(cases, "outside the library").met is True
    assert line(cases, "  outside: known physics").found.startswith("50.0")


def test_calibration_counts_physics_at_its_component():
    right = effect("leg_backlash", "leg 3", 0.9)
    cases = [case("one", [PLAY], "explained", right) for _ in range(9)]
    cases.append(case("one", [PLAY], "explained", effect("leg_backlash", "leg 4", 0.9)))
    assert line(cases, "right of the conclusions given 85-95").met is True
    assert line(cases, "right of the conclusions given 85-95").found.startswith("90.0 ± 9.5 %")
    sure = [case("one", [PLAY], "explained", right) for _ in range(5)]
    assert line(sure, "right of the conclusions given 85-95").met is False
    certain = case("one", [PLAY], "explained", effect("leg_backlash", "leg 3", 1.0))
    assert "1 of 1" in line([certain], "  given 99-100").found
    wrong = case("none", [], "explained", effect("unknown", "leg 3", 0.6))
    assert "0 of 1" in line([wrong], "  given 50-70").found


def test_held_out_error_is_taken_as_declared_and_on_further_series():
    good = case("one", [PLAY], "explained", effect(*PLAY), later=HeldOut(2.0, 1.02, 1.0))
    poor = case("one", [PLAY], "explained", effect(*PLAY), later=HeldOut(1.0, 1.3, 1.0), test_after=2.1)
    assert line([good], "held-out RMS / noise floor, median of explained, as declared").found.startswith("1.050")
    assert line([good], "held-out RMS / noise floor, median of explained, on further").found.startswith("1.020")
    for source in ("as declared", "on further series"):
        what = f"held-out RMS worse than base by more than 2 %, {source}"
        assert line([good], what).met is True
        assert line([good, poor], what).met is False
    unexplained = case("one", [PLAY], "unexplained", test_after=9.0, test_before=9.0)
    assert line([good, unexplained], "held-out RMS / noise floor, median of explained, as declared").met is True


def test_time_is_judged_up_to_150_rows():
    slow = Case(truth("none", rows=200), said("consistent"), 70.0, cpu_s=60.0)
    quick = Case(truth("none", rows=100), said("consistent"), 50.0, cpu_s=10.0)
    late = Case(truth("none", rows=100), said("consistent"), 31.0, cpu_s=31.0)
    assert line([slow, quick], "processor time").met is True
    assert line([slow, quick, late], "processor time").met is False


def test_report_lists_confusion_and_failures():
    cases = [
        case("one", [PLAY], "explained", effect("creep", "leg 3"), name="case-007"),
        case("one", [PLAY], "explained", effect("leg_backlash", "leg 3"), name="case-008"),
        case("one", [PLAY], "unexplained", name="case-009"),
    ]
    assert confusion(cases) == [["leg_backlash", "3", "3", "1", "1", "2", "creep 1, leg_backlash 1, (unexplained) 1"]]
    text = markdown(cases, "Title", ["2026-01-01, seed 3"])
    assert "seed 3" in text
    assert "case-007" in text
    assert "case-008" not in text
    assert "other physics first" in text
    assert list(frame(cases)["case"]) == ["case-007", "case-008", "case-009"]


def test_rates_have_binomial_errors():
    rate = Rate(90, 100)
    assert rate.standard_error == pytest.approx(sqrt(0.9 * 0.1 / 100))
    low, high = rate.interval
    assert low == pytest.approx(0.8256, abs=1e-4)
    assert high == pytest.approx(0.9448, abs=1e-4)
    assert Rate(50, 50).interval[0] == pytest.approx(1 / (1 + 1.96**2 / 50), abs=1e-12)
    assert str(Rate(0, 0)) == "no cases"


GOOD = {"verdict": "explained", "effects": [effect(*PLAY)], "location": None, "fit": FIT}


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("verdict",), "perhaps"),
        (("effects", 0, "probability"), 1.2),
        (("effects", 0, "component"), "leg 9"),
        (("effects", 0, "component"), "the third leg"),
        (("fit", "test_after"), "small"),
    ],
)
def test_an_answer_out_of_form_is_none(tmp_path, path, value):
    import json  # noqa: PLC0415

    content = copy.deepcopy(GOOD)
    inner = content
    for key in path[:-1]:
        inner = inner[key]  # type: ignore[assignment]
    inner[path[-1]] = value
    (tmp_path / "diagnosis.json").write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(NoAnswerError, match=r"diagnosis\.json"):
        read_answer(tmp_path / "diagnosis.json", 6)


@pytest.mark.parametrize("key", ["verdict", "effects", "fit"])
def test_a_missing_key_is_no_answer(tmp_path, key):
    import json  # noqa: PLC0415

    (tmp_path / "diagnosis.json").write_text(json.dumps({k: v for k, v in GOOD.items() if k != key}), encoding="utf-8")
    with pytest.raises(NoAnswerError, match="KeyError"):
        read_answer(tmp_path / "diagnosis.json", 6)
    with pytest.raises(NoAnswerError, match=r"no diagnosis\.json"):
        read_answer(tmp_path / "elsewhere.json", 6)
