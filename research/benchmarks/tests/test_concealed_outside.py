"""Cases outside the library are hidden at the size stated, inside the region of the recordings, and judged as said."""

from __future__ import annotations

import json
import sys
from collections import Counter

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from research.benchmarks.concealed.bench import Order
from research.benchmarks.concealed.experiments import Wishes, draw_interleaved
from research.benchmarks.concealed.judgement import judge
from research.benchmarks.concealed.program import Outcome, Program, diagnosis
from research.benchmarks.concealed.robots import HEXAPODS
from research.benchmarks.concealed.unlisted.beyond import first_part
from research.benchmarks.concealed.unlisted.cases import (
    LISTED,
    OTHER_FORMS,
    UNLISTED,
    counts_of,
    draw_case,
    orders,
)
from research.laboratory.elements.forms import FORMS as FORM_ELEMENTS
from research.laboratory.elements.unlisted import UNLISTED as UNLISTED_ELEMENTS

POSE = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]


@pytest.fixture(scope="module")
def case():
    return draw_case(Order("alone", ("screw_wear",), "H1"), np.random.default_rng([3, 1]))


def test_every_element_outside_the_library_has_a_recipe():
    assert set(UNLISTED) == set(UNLISTED_ELEMENTS)
    assert set(OTHER_FORMS) == set(FORM_ELEMENTS)
    assert len(UNLISTED) >= 24


def test_a_known_name_that_is_no_wrong_one_is_an_identifier():
    for element in (UNLISTED_ELEMENTS | FORM_ELEMENTS).values():
        assert set(element.also) <= set(LISTED), element


def test_families_are_drawn_in_the_numbers_asked_for():
    drawn_orders = orders(counts_of(150, 60, 200), seed=5)
    found = Counter(order.family for order in drawn_orders)
    assert found["left_out"] == 60
    assert found["none"] == 200
    assert sum(found.values()) - 260 == 150
    assert {order.physics[0] for order in drawn_orders if order.family == "alone"} == set(UNLISTED)
    assert {order.physics[0] for order in drawn_orders if order.family == "left_out"} == set(LISTED)
    assert drawn_orders == orders(counts_of(150, 60, 200), seed=5)
    assert drawn_orders != orders(counts_of(150, 60, 200), seed=6)


def test_a_seed_repeats(case):
    again = draw_case(Order("alone", ("screw_wear",), "H1"), np.random.default_rng([3, 1]))
    pd.testing.assert_frame_equal(case.recordings, again.recordings)
    assert case.truth == again.truth
    assert not case.recordings.equals(
        draw_case(Order("alone", ("screw_wear",), "H1"), np.random.default_rng(9)).recordings
    )


@pytest.mark.parametrize(
    "order",
    [
        Order("alone", ("place_friction",), "bipod"),
        Order("pair", ("rubber_base", "holding_droop"), "irregular"),
        Order("beside", ("bellows", "payload_com_offset"), "H_large"),
        Order("form", ("dahl_friction",), "moving-xyz"),
        Order("left_out", ("leg_backlash",), "H1"),
        Order("none", ("hose",), "H1"),
    ],
    ids=lambda order: order.family,
)
def test_each_family_shows_as_much_as_it_shall(order):
    case = draw_case(order, np.random.default_rng([4, 2]))
    assert 60 <= len(case.recordings) <= 150
    assert case.truth["family"] == order.family
    effects = case.truth["effects"]
    assert [effect["physics"] for effect in effects] == ([] if order.family == "none" else list(order.physics))
    assert all(1.8 <= effect["mismatch_in_std"] <= 11.1 for effect in effects)
    assert all(effect["parts"] for effect in effects)
    assert case.truth["without"] == (["leg_backlash"] if order.family == "left_out" else [])
    if order.family == "none":
        assert case.truth["mismatch_in_std"] < 0.1


def test_held_out_series_lie_inside_the_recordings(case):
    seen, later = case.recordings, case.later
    assert not set(seen["sequence"]) & set(later["sequence"])
    assert seen["sequence"].min() < later["sequence"].min()
    assert later["sequence"].max() < seen["sequence"].max()
    poses = seen[POSE].drop_duplicates().to_numpy()
    for pose in later[POSE].drop_duplicates().to_numpy():  # on a line between two seen poses
        gaps = []
        for one in range(len(poses)):
            for other in range(one + 1, len(poses)):
                line = poses[other] - poses[one]
                share = float((pose - poses[one]) @ line / (line @ line))
                gaps.append(np.abs(poses[one] + share * line - pose).max() if 0 < share < 1 else np.inf)
        assert min(gaps) < 2e-5
    loads = [name for name in ("mass_kg", "fx_N", "fz_N") if name in seen]
    assert (later[loads].abs().max() <= seen[loads].abs().max() + 1e-9).all()


def test_the_judges_rows_hold_true_values_that_the_questions_do_not(case):
    true = [name for name in case.later if str(name).startswith("true_")]
    assert true
    assert not [name for name in case.recordings if str(name).startswith("true_")]
    errors = np.concatenate([(case.later[n] - case.later[n[5:]]) / case.later["s" + n[6:]] for n in true])
    assert np.std(errors) == pytest.approx(1.0, abs=5 / np.sqrt(2 * len(errors)))


def test_a_true_curve_is_the_leg_compliance_on_the_lengths_that_were_used(case):
    (curve,) = case.truth["effects"][0]["curves"]
    leg = int(curve["component"].split()[1]) - 1
    wear = case.truth["effects"][0]["elements"][0]
    at, values = np.array(curve["inputs"]), np.array(curve["values"])
    softer = 1 + wear["softening"] * np.exp(-(((at - wear["centre_m"]) / wear["width_m"]) ** 2) / 2)
    assert values == pytest.approx(softer / case.truth["true_stiffness"][leg])


def test_what_was_answered_is_not_asked_again_and_a_failure_is_one(case, tmp_path):
    said = "import sys, pathlib; pathlib.Path('/dev/null').read_text(); sys.exit('no library')"
    program = Program([sys.executable, "-c", said], tmp_path)
    case.truth["case"] = "case-001"
    outcome = program.ask(case)
    assert outcome.problem == "exit 1: no library"
    assert outcome.memory_MB > 0
    kept = tmp_path / "answers" / "case-001" / "outcome.json"
    kept.write_text(json.dumps({"wall_s": 1.0, "cpu_s": 2.0, "problem": "", "memory_MB": 3.0}), encoding="utf-8")
    assert program.ask(case) == Outcome(1.0, 2.0, 3.0)
    assert judge(case, outcome, kept.parent).faults() == ["exit 1: no library"]


def test_entries_are_left_out_through_one_seam():
    plain = diagnosis(["expdesign"], "out", [])
    assert plain == ["expdesign", "diagnose", "robot.yaml", "recordings.csv", "--out", "out"]
    assert diagnosis(["expdesign"], "out", ["creep"])[-2:] == ["out", "creep"]
    assert diagnosis(["expdesign"], "out", ["creep"])[2] == "research.benchmarks.concealed.withheld"


def test_points_after_the_end_of_the_campaign_are_later_than_all_that_was_seen():
    rng = np.random.default_rng(8)
    whole = draw_interleaved(HEXAPODS["H1"](rng), Wishes(time=True), rng)
    cut = first_part(whole)
    assert len(cut.rows) + len(cut.later) == len(whole.rows) + len(whole.later)
    assert len(cut.fitted) == len(cut.rows)
    assert not set(cut.rows["series"]) & set(cut.later["series"])
    end = cut.rows["time_s"].max()
    assert cut.later.groupby("series")["time_s"].max().min() > end
    assert 1.4 * end < cut.later["time_s"].max() < 2.0 * end
