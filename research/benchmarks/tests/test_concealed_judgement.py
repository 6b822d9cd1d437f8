"""What counts as right and what as wrong, on answers and truths that are written down here."""

from __future__ import annotations

import copy
import json
from collections.abc import Sequence
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from research.benchmarks.concealed.answers import Answer, Effect, NoAnswerError, answer_from, read_answer
from research.benchmarks.concealed.held_out import Predicted
from research.benchmarks.concealed.judgement import Judged, covered
from research.benchmarks.concealed.program import Outcome
from research.benchmarks.concealed.rates import Rate
from research.benchmarks.concealed.score import Line, by_kind, frame, markdown, table

FIT = {"noise_rms": 1.0, "train_before": 2.0, "train_after": 1.0, "test_before": 2.0, "test_after": 1.05}
PLAY, CREEP, CABLE = ("leg_backlash", "leg 3"), ("creep", "all legs"), ("cable", "environment")
USUAL = Outcome(9.0, 8.0, 500.0)
GOOD = Predicted(4.0, 0.3, 4.1, 3.7, np.array([0.5, -0.5, 3.0, 0.1]))


def said(physics: str, component: object, probability: float = 0.99, group: tuple[str, ...] = ()) -> dict[str, Any]:
    entry = {"physics": physics, "component": component, "probability": probability}
    return entry | {"indistinguishable_from": list(group)}


def answer(verdict: str, *effects: dict[str, Any], at: object = None, candidates: tuple[Any, ...] = ()) -> Answer:
    location = None if at is None else {"component": at, "candidates": list(candidates)}
    content = {"verdict": verdict, "effects": list(effects), "location": location, "fit": FIT}
    return answer_from(content, 6, Path("nowhere"))


def case(
    family: str,
    there: Sequence[tuple[str, ...]],
    answered: Answer | None,
    predicted: Predicted | None = GOOD,
    name: str = "case-001",
    names: tuple[str, ...] | None = None,
    outcome: Outcome = USUAL,
    rows: int = 80,
    problem: str = "",
) -> Judged:
    """A case whose effects are (physics, parts ...); their names are their own but outside the library."""
    listed = family in ("one", "two", "left_out")
    effects = [
        {"physics": physics, "parts": list(parts), "curves": [], "mismatch_in_std": 4.0}
        | {"names": list(names) if names is not None else [physics] * listed}
        for physics, *parts in there
    ]
    truth = {"case": name, "family": family, "effects": effects, "robot": "H1", "rows": rows, "mismatch_in_std": 4.0}
    return Judged(truth | {"later_noise_rms": 1.0, "made_for": ["creep"]}, outcome, answered, predicted, problem)


def line(cases: list[Judged], start: str) -> Line:
    (found,) = [each for each in table(cases) if each.what.startswith(start)]
    return found


def test_right_answers_meet_everything() -> None:
    quiet = Predicted(1.0, 0.3, 1.0, 1.0)
    cases = [
        case("none", [], answer("consistent"), quiet),
        case("one", [PLAY], answer("explained", said(*PLAY, 0.97)), Predicted(2.0, 0.2, 2.0, 1.02)),
        case("two", [PLAY, CREEP], answer("explained", said(*CREEP), said(*PLAY)), Predicted(2.0, 0.2, 2.0, 1.02)),
        case("outside", [CABLE], answer("unexplained", at="environment")),
        case("alone", [("strange", "leg 1")], answer("modelled", said("law", "leg 1"), at="leg 1")),
        case("left_out", [PLAY], answer("modelled", said("law", "leg 3"), at="leg 3")),
        case("second_source", [("gap", "leg 2")], answer("modelled", said("law", "leg 2"), at="leg 2")),
    ]
    asked = [each for each in table(cases) if each.asked and each.met is not None]
    assert len(asked) == 31
    assert all(each.met for each in asked)
    assert [each.faults() for each in cases] == [[]] * 7
    assert "None." in markdown(cases, "Title", [])


def test_an_alarm_without_effect_is_false_and_so_is_no_answer() -> None:
    silent = case("none", [], None, None, problem="exit 2: oops")
    cases = [case("none", [], answer("unexplained")), case("none", [], answer("consistent")), silent]
    assert line(cases, "consistent: alarms").found.startswith("66.7")
    assert line(cases, "consistent: alarms").met is False
    assert silent.faults() == ["exit 2: oops"]


@pytest.mark.parametrize(
    ("answered", "faults"),
    [
        (answer("consistent"), ["not detected"]),
        (answer("explained", said("creep", "leg 3"), said(*PLAY)), ["other physics first"]),
        (answer("explained", said("creep", "leg 3", group=("leg_backlash",))), ["first only within its group"]),
        (answer("explained", said("leg_backlash", "leg 4")), ["other component"]),
    ],
    ids=["consistent", "second", "group", "component"],
)
def test_what_is_wrong_where_physics_shall_be_named(answered: Answer, faults: list[str]) -> None:
    assert case("one", [PLAY], answered).faults() == faults


@pytest.mark.parametrize(
    ("there", "named", "right"),
    [
        (PLAY, "leg 3", True),
        (PLAY, ["leg 3"], True),
        (PLAY, ["leg 3", "leg 4"], False),
        (PLAY, "leg 4", False),
        (PLAY, "all legs", False),
        (PLAY, [], False),
        (("leg_coupling", "leg 1", "leg 2"), "leg 1", True),
        (("leg_coupling", "leg 1", "leg 2"), ["leg 1", "leg 2"], True),
        (("leg_coupling", "leg 1", "leg 2"), ["leg 1", "leg 2", "leg 3"], False),
        (CREEP, [f"leg {leg}" for leg in range(1, 7)], True),
        (CREEP, [f"leg {leg}" for leg in range(1, 6)], False),
    ],
)
def test_all_components_named_are_those_of_an_effect(there: tuple[str, ...], named: object, right: bool) -> None:
    assert case("one", [there], answer("explained", said(there[0], named))).component_right is right


def test_the_location_stands_in_where_nothing_is_concluded() -> None:
    assert case("one", [PLAY], answer("unexplained", at="leg 3")).component_right
    assert not case("one", [PLAY], answer("unexplained", at="leg 1")).component_right


@pytest.mark.parametrize(
    ("effects", "groups", "without"),
    [
        ([said(*PLAY, group=("creep",))], False, False),
        ([said(*PLAY), said("thermal_drift", "all legs", group=("creep",))], True, False),
        ([said(*PLAY, group=("creep",)), said("leg_backlash", "leg 2")], True, False),
        ([said(*CREEP), said(*PLAY)], True, True),
    ],
    ids=["one for two", "by group", "crossed", "both"],
)
def test_both_need_a_conclusion_each(effects: list[dict[str, Any]], groups: bool, without: bool) -> None:
    found = case("two", [PLAY, CREEP], answer("explained", *effects))
    assert (found.both_found(), found.both_found(groups=False)) == (groups, without)


def test_outside_is_unexplained_or_unknown() -> None:
    known, unknown = said("creep", "leg 1"), said("unknown", "payload")
    assert case("outside", [CABLE], answer("unexplained", known)).declared_unknown
    assert case("outside", [CABLE], answer("explained", unknown)).declared_unknown
    assert not case("outside", [CABLE], answer("explained", known)).declared_unknown
    cases = [case("outside", [CABLE], answer("unexplained", *each)) for each in ([known], [])]
    assert line(cases, "unexplained or unknown").met is True
    assert line(cases, "  known physics concluded").found.startswith("50.0")


def test_calibration_counts_physics_at_its_component() -> None:
    right = answer("explained", said(*PLAY, 0.9))
    cases = [case("one", [PLAY], right) for _ in range(9)]
    cases.append(case("one", [PLAY], answer("explained", said("leg_backlash", "leg 4", 0.9))))
    about = "right of the conclusions given 85-95"
    assert line(cases, about).found.startswith("90.0 ± 9.5 %")
    assert line(cases, about).met is True
    assert line(cases[:5], about).met is False
    certain = case("one", [PLAY], answer("explained", said(*PLAY, 1.0)))
    assert "1 of 1" in line([certain], "right of the conclusions given 99-100").found


def test_held_out_error_is_taken_as_declared_and_on_further_series() -> None:
    good = case("one", [PLAY], answer("explained", said(*PLAY)), Predicted(2.0, 0.2, 2.0, 1.02))
    poor = case("one", [PLAY], answer("explained", said(*PLAY)), Predicted(1.0, 0.9, 1.0, 1.3))
    assert line([good], "held-out RMS / noise floor, median of explained, as declared").found.startswith("1.050")
    assert line([good], "held-out RMS / noise floor, median of explained, on further").found.startswith("1.020")
    assert line([good], "readings predicted worse").met is True
    assert line([good, poor], "readings predicted worse").met is False


def test_time_is_judged_up_to_100_rows() -> None:
    slow, quick, late = (
        case("none", [], answer("consistent"), rows=rows, outcome=Outcome(50.0, cpu, 500.0))
        for rows, cpu in ((200, 60.0), (100, 10.0), (100, 11.0))
    )
    assert line([slow, quick], "processor time, up to").met is True
    assert line([slow, quick, late], "processor time, up to").met is False


def test_located_means_the_component_named_first_is_accepted() -> None:
    there = [("strange", "platform", "payload")]
    assert case("alone", there, answer("unexplained", at="payload")).located
    assert case("alone", there, answer("modelled", at=["platform", "leg 1"])).located
    assert not case("alone", there, answer("modelled", at=["leg 1", "platform"])).located
    assert not case("alone", there, answer("consistent")).located
    assert case("alone", there, answer("explained", said("platform_compliance", "platform"))).located


def test_a_wrong_name_is_known_physics_above_one_half_that_is_not_there_in_any_form() -> None:
    there, names = [("strange", "leg 1")], ("leg_backlash",)
    effects = [
        said("leg_backlash", "leg 1"),
        said("creep", "leg 2", 0.4),
        said("law", "leg 3"),
        said("unknown", "base"),
    ]
    assert case("alone", there, answer("explained", *effects), names=names).misnamed == []
    wrong = case("alone", there, answer("explained", said("creep", "leg 1", 0.6)), names=names)
    assert [each.physics for each in wrong.misnamed] == ["creep"]
    assert "wrongly named creep" in wrong.faults()
    assert [each.physics for each in case("alone", there, answer("explained", *effects)).strays] == [
        *("creep", "law", "unknown")
    ]


def test_the_table_counts_what_happened() -> None:
    sure = ({"component": "leg 1", "probability": 0.9},)
    right = case("alone", [("strange", "leg 1")], answer("modelled", at="leg 1", candidates=sure))
    told = answer("explained", said("creep", "leg 1"), at="leg 1")
    wrong = case("alone", [("strange", "base")], told, Predicted(4.0, 2.0, 4.1, 4.5, GOOD.standardised))
    quiet, alarm = (case("none", [], answer(verdict)) for verdict in ("consistent", "unexplained"))
    lines = {line.what: line for line in table([right, wrong, quiet, alarm])}
    assert "(1 of 2" in lines["outside the library: located first"].found
    assert "(1 of 2" in lines["outside the library: held-out RMS below 1"].found
    assert "(1 of 2" in lines["outside the library: readings predicted worse than by base, > 2 %"].found
    assert "(1 of 2" in lines["outside the library: known physics named wrongly, p > 0.5"].found
    assert lines["outside the library: verdicts"].found == "modelled 1, explained 1"
    assert "(1 of 2" in lines["consistent: alarms"].found
    assert "(1 of 1" in lines["located right where given 85-95 %"].found
    assert lines["true values within 1.96 predicted standard deviations"].found.startswith("75 %")
    text = markdown([right, wrong, quiet, alarm], "Title", ["fact"])
    assert "wrongly named creep, located elsewhere, held-out 2.00, worse than base" in text


def test_the_page_lists_kinds_and_failures() -> None:
    cases = [
        case("one", [PLAY], answer("explained", said("creep", "leg 3")), name="case-007"),
        case("one", [PLAY], answer("explained", said(*PLAY)), name="case-008"),
        case("one", [PLAY], answer("unexplained"), name="case-009"),
    ]
    named = "creep 1, leg_backlash 1, (unexplained) 1"
    assert by_kind(cases) == [["leg_backlash", "3", "3", "2", "1", "4.00", "0.30", named]]
    text = markdown(cases, "Title", ["2026-01-01, seed 3"], every=True)
    assert "seed 3" in text
    assert "- case-007 (one, H1, 80 rows): other physics first. There" in text
    assert "- case-008" not in text
    assert "| 008 | H1, 80 rows |" in text
    assert list(frame(cases)["case"]) == ["case-007", "case-008", "case-009"]


def test_rates_have_binomial_errors() -> None:
    rate = Rate(90, 100)
    assert rate.standard_error == pytest.approx(sqrt(0.9 * 0.1 / 100))
    assert rate.interval == pytest.approx((0.8256, 0.9448), abs=1e-4)
    assert Rate(50, 50).interval[0] == pytest.approx(1 / (1 + 1.96**2 / 50), abs=1e-12)
    assert str(Rate(0, 0)) == "no cases"


def band(shift: float, half: float) -> Effect:
    at = np.linspace(0.2, 0.3, 21)
    mean = 1e-7 * (1 + np.sin(40 * at)) + shift
    curve = pd.DataFrame({"length_m": at, "mean": mean, "low": mean - half, "high": mean + half})
    return Effect("law", ("leg 2",), 0.9, depends_on=("length",), curve=curve)


def test_a_band_is_held_against_the_curve_but_for_the_constant_it_shares_with_the_base() -> None:
    at = np.linspace(0.2, 0.3, 41)
    curve = {"component": "leg 2", "input": "length", "quantity": "compliance_m_per_N"}
    curve |= {"inputs": at.tolist(), "values": (1e-7 * (1 + np.sin(40 * at))).tolist()}
    assert covered(band(-1e-7, 1e-9), curve) == 1.0
    share = covered(band(0.0, 1e-9), curve | {"values": (1e-7 * (1 + np.cos(40 * at))).tolist()})
    assert share is not None
    assert share < 0.3
    assert covered(band(0.0, 1e-9), curve | {"component": "leg 3"}) is None


WRITTEN: dict[str, Any] = {"verdict": "explained", "effects": [said(*PLAY)], "location": None, "fit": FIT}


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("verdict",), "perhaps"),
        (("effects", 0, "probability"), 1.2),
        (("effects", 0, "component"), "leg 9"),
        (("effects", 0, "component"), "the third leg"),
        (("fit", "test_after"), "small"),
        *(((key,), None) for key in ("verdict", "effects", "fit")),
    ],
)
def test_an_answer_out_of_form_is_none(tmp_path: Path, path: tuple[Any, ...], value: object) -> None:
    content: Any = copy.deepcopy(WRITTEN)
    inner = content
    for key in path[:-1]:
        inner = inner[key]
    if value is None:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    with pytest.raises(NoAnswerError, match=r"no diagnosis\.json"):
        read_answer(tmp_path, 6)
    (tmp_path / "diagnosis.json").write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(NoAnswerError, match=r"diagnosis\.json: (Value|Key)Error"):
        read_answer(tmp_path, 6)
