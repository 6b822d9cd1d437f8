"""The page of a diagnosis says what the diagnosis says, and shows foreign text as text."""

import io
import json
import re
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.effects.legs.transmission import LegBacklash
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.result import Diagnosis
from expdesign.report import words
from expdesign.report.diagnosis_report import DiagnosisResult
from expdesign.report.diagnosis_texts import in_prose
from expdesign.report.page import content_of, render
from expdesign.report.said import Said
from tests.cases import robot
from tests.chain.places import rows
from tests.identification.experiments import read
from tests.report.conftest import EVIL_NAME, text_of

NAME = "bipod-unequal"


@cache
def diagnosis(kind: str) -> Diagnosis:
    """`explained`: play in leg 1; `unexplained`: four times the noise; `consistent`; each with foreign columns."""
    here = robot(NAME)
    frame = rows(NAME, "wrench", series=7)
    frame = frame[[c for c in frame if not str(c).startswith("abs_")]]
    # Over short ways there are few screw pitches to look for.
    frame[list(here.configuration)] *= 0.1
    frame["remark <b>"] = np.random.default_rng(1).standard_normal(len(frame))
    recordings: Recordings = read(frame, here, source=f"{EVIL_NAME}.csv")
    chain = Chain(here, (LegBacklash.from_text(here, "leg 1", "middle"),))
    gap = 2e-5 if kind == "explained" else 0.0
    exact = chain.predict(row_data(recordings, here), np.array([1.0, 1.0, gap]))
    size = 4.0 if kind == "unexplained" else 1.0
    noise = size * np.array(recordings.deviations) * np.random.default_rng(4).standard_normal(exact.shape)
    result = diagnose(here, replace(recordings, deflections=exact + noise))
    assert result.verdict == kind
    return result


def diagnosed(result: Diagnosis, at_targets: Any = None) -> DiagnosisResult:
    """What `diagnose` returns, without the file of the robot and the model."""
    return DiagnosisResult(None, None, result, 3, at_targets=at_targets)  # type: ignore[arg-type]


@cache
def page(kind: str) -> str:
    return render(diagnosed(diagnosis(kind)).page())


def text(kind: str) -> str:
    return text_of(page(kind))


def plain(shown: str) -> str:
    """One space wherever there is any."""
    return " ".join(shown.split())


def number(value: float, digits: int = 3) -> str:
    return plain(words.number(value, digits))


KINDS = ["consistent", "explained", "unexplained"]


@pytest.mark.parametrize("kind", KINDS)
def test_verdict_and_errors_are_there(kind: str) -> None:
    result, shown = diagnosis(kind), text(kind)
    opening = {
        "consistent": "These recordings show no missing physics",
        "explained": "With the physics named below it does",
        "unexplained": "lacks physics that the library does not have",
    }
    assert opening[kind] in shown
    assert all(opening[other] not in shown for other in KINDS if other != kind)
    for value in (result.errors.test_before, result.errors.test_after):
        assert number(value) in shown
    before_and_after = "Before and after" if result.findings else "Errors"
    for heading in (before_and_after, "Residuals", "What was considered", "Next steps"):
        assert heading in shown
    assert ("Where the mismatch is" in shown) == (kind != "consistent")


def test_findings_are_told_with_their_numbers() -> None:
    result, shown = diagnosis("explained"), text("explained")
    (finding,) = result.findings
    assert plain(finding.sentence) in shown
    assert f"Probability {number(finding.probability, 2)}" in shown
    value, low, high = finding.parameters["gap_m"]
    assert "gap (µm)" in shown
    assert number(1e6 * value) in shown
    assert f"{number(1e6 * low)} to {number(1e6 * high)}" in shown
    assert "The mismatch appears in" in shown
    assert in_prose(result.location.region) in shown
    assert "model.yaml 'bi<b>pod</b>" in shown


def test_nothing_is_named_where_nothing_was_found() -> None:
    shown = text("consistent")
    assert "What was left out" not in shown
    assert "The mismatch appears in" not in shown


def test_places_of_the_mismatch_are_listed_with_their_tests() -> None:
    result, shown = diagnosis("explained"), text("explained")
    for probe in (*result.location.components, *result.location.patterns):
        assert in_prose(probe.name) in shown
    first = result.location.components[0]
    assert first.name == "leg 1"
    assert number(first.explained, 4) in shown
    assert "stands out" in shown


@pytest.mark.parametrize("kind", KINDS)
def test_foreign_text_stays_text(kind: str) -> None:
    """The name of the file and of a column hold markup; neither becomes any, in the page or in its scripts."""
    content = page(kind)
    assert EVIL_NAME in text(kind)
    assert "document.title='broken'</script>" not in content
    assert "remark <b>" not in re.sub(r"<script\b.*?</script>", "", content, flags=re.DOTALL)
    opened, closed = (len(re.findall(tag, content)) for tag in (r"<script\b", r"</script>"))
    assert opened == closed


@pytest.mark.parametrize("kind", KINDS)
def test_no_figure_holds_a_number_that_is_none(kind: str) -> None:
    assert content_of(page(kind))["figures"]
    assert not {"NaN", "Infinity"} & set(re.findall(r"\w+", json.dumps(content_of(page(kind))["figures"])))


def test_the_stiffness_beside_the_physics_is_that_of_the_model() -> None:
    """Play takes its share of the deflection: the legs come out as stiff as they are, and stiffer than alone."""
    result, shown = diagnosis("explained"), text("explained")
    saved = pd.read_csv(io.StringIO(content_of(page("explained"))["csv"]["stiffness-table"]["text"]))
    true = result.robot.stiffness
    np.testing.assert_array_less(saved["low"], true * 1.02)
    np.testing.assert_array_less(true * 0.98, saved["high"])
    assert saved["stiffness"][0] > saved["springs_alone"][0]
    lines = diagnosed(result).lines
    for name, value in zip(saved["actuator"], saved["stiffness"], strict=True):
        assert any(line.startswith(name) and f" {words.number(1e-6 * value, 4)} " in line for line in lines)
        assert number(1e-6 * value, 4) in shown


def test_what_could_be_in_its_place_is_printed_as_well() -> None:
    result = diagnosis("explained")
    (finding,) = result.findings
    doubtful = replace(finding, indistinguishable=("leg_coupling",), rival=result.model)
    doubted = replace(result, findings=(doubtful,))
    printed = "\n".join(diagnosed(doubted).lines)
    assert "do not distinguish it from the force in one leg deflects another" in printed
    assert "plan-next.csv" in printed
    assert "plan-next.csv" not in "\n".join(diagnosed(result).lines)


def test_an_unexplained_mismatch_has_a_place_and_a_next_step() -> None:
    lines = diagnosed(diagnosis("unexplained")).lines
    assert lines[0].startswith("Verdict: unexplained.")
    place, following = (next(line for line in lines if text in line) for text in ("points to ", "Inspect "))
    assert place.split("points to ")[1].split(";")[0] in following
    assert place in text("unexplained")
    assert following in text("unexplained")


def test_what_may_be_hidden_is_said_where_nothing_is_missing() -> None:
    hidden = "The worst that these recordings could hide is a soft base: 1.5 tolerances."
    assert hidden in diagnosed(diagnosis("consistent"), SimpleNamespace(said=Said("", [hidden]))).lines


def test_the_part_that_is_concerned_stands_out() -> None:
    view = content_of(page("explained"))["data"]["view"]
    assert view["concerned"] == [[0, 2]]  # leg 1, from its base joint to the tool point
    assert content_of(page("consistent"))["data"]["view"]["concerned"] == []


def test_a_single_wrong_row_is_called_an_outlier() -> None:
    result = diagnosis("consistent")
    wrong = np.array(result.recordings.deflections)
    wrong[5] *= 10.0
    found = diagnose(result.robot, replace(result.recordings, deflections=wrong))
    (finding,) = found.findings
    line = result.recordings.lines[5]
    assert finding.sentence == f"Row {line} is an outlier: no model explains it."
    assert not any("refits" in text for text in diagnosed(found).lines)


def test_an_effect_that_is_kept_is_not_called_next_to_impossible() -> None:
    result = diagnosis("explained")
    (found,) = result.findings
    doubted = replace(result, findings=(replace(found, probability=1e-9),))
    said = next(line for line in diagnosed(doubted).lines if "play" in line)
    assert "below 1e-6" not in said
    assert "another place or cause is likelier" in said
    assert any("Probability 0." in line for line in diagnosed(result).lines)
