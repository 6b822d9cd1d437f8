"""The page of an identification: its numbers, its units, and that all of it can be saved."""

import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from expdesign.report import words
from expdesign.report.page import content_of
from tests.commands.calls import ROBOT, call, recordings_file
from tests.report.test_in_browser import until


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("identification")
    assert call("identify", ROBOT, recordings_file(place), "--out", place / "out") == 0
    return place / "out"


@pytest.fixture(scope="module")
def page(folder: Path) -> dict[str, Any]:
    html = (folder / "report.html").read_text(encoding="utf-8")
    content: dict[str, Any] = content_of(html)
    return content | {"html": html}


def test_stiffness_is_shown_in_newtons_per_micrometre_and_saved_in_si(folder: Path, page: dict[str, Any]) -> None:
    found = json.loads((folder / "identification.json").read_text(encoding="utf-8"))["stiffness"]
    assert list(found) == page["figures"]["stiffness-figure"]["data"][0]["x"]
    estimates = np.array([values[0] for values in found.values()])
    np.testing.assert_allclose(page["figures"]["stiffness-figure"]["data"][0]["y"], 1e-6 * estimates)
    saved = pd.read_csv(io.StringIO(page["csv"]["stiffness-table"]["text"]))
    np.testing.assert_allclose(saved["stiffness"], estimates)
    np.testing.assert_allclose(saved["compliance"], 1.0 / estimates)
    for value in estimates:
        assert words.number(1e-6 * value, 4) in page["html"]
    assert "N/µm" in page["html"]


def test_every_figure_and_table_can_be_saved(page: dict[str, Any]) -> None:
    buttons = re.findall(r'data-csv="([^"]+)"', page["html"])
    assert set(buttons) == {
        *page["csv"],
        "robot",
        "robot-above",
    }  # their script has the data of the state that is shown
    for file in page["csv"].values():
        assert len(pd.read_csv(io.StringIO(file["text"]))) > 0


def test_it_opens_in_a_browser_without_an_error(browser: Any, folder: Path) -> None:
    browser.get_log("browser")
    browser.get((folder / "report.html").as_uri())
    drawn = "return [...document.querySelectorAll('.plot')].map(plot => plot.querySelectorAll('.main-svg').length > 0)"
    until(lambda: all(browser.execute_script(drawn)))
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []


def test_the_stiffnesses_come_first(page: dict[str, Any]) -> None:
    sections = re.findall(r'<section id="([^"]+)"', page["html"])
    assert sections[:3] == ["result", "stiffness", "fit"]
    assert page["data"]["view"]["labels"] == page["figures"]["stiffness-figure"]["data"][0]["x"]
