"""The page of a repeated plan says what came out, and draws it."""

import html
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.assurance.validation.repeated import Repeated, repeat
from expdesign.report import words
from expdesign.report.blocks import Figure
from expdesign.report.montecarlo_report import MonteCarloResult
from expdesign.report.page import Page, render
from tests.cases import ALL_ERRORS, setup
from tests.report.conftest import EVIL_NAME, text_of
from tests.report.test_in_browser import until


@cache
def repeated(errors: bool = True) -> Repeated:
    here = setup("irregular", "payload", errors=ALL_ERRORS if errors else ())
    plan = here.plan(np.random.default_rng(21), 4)
    problem = here.problem()
    object.__setattr__(problem, "source", f"{EVIL_NAME}.yaml")
    return repeat(problem, plan, 4000, 22)


def reported(result: Repeated) -> Page:
    return MonteCarloResult(result).page()


@cache
def page(errors: bool = True) -> str:
    return render(reported(repeated(errors)))


def test_criteria_and_their_prediction_are_there() -> None:
    result, shown = repeated(), text_of(page())
    for cause in ("duir", "feir", "total"):
        found, predicted = result.criteria[cause]
        assert words.with_error(float(found.value), float(found.standard_error)) in shown
        assert f"predicted {words.number(predicted, 4)}" in shown
    assert f"all {len(result.scores())} comparisons lie within three standard errors" in shown


def test_what_differs_is_said() -> None:
    """The same samples beside the prediction for half the noise."""
    result = repeated()
    wrong = Repeated(result.problem, result.plan, dict(result.causes), "normal", 1)
    wrong.__dict__["deviations"] = {
        cause: (estimate, predicted / 2.0) for cause, (estimate, predicted) in result.deviations.items()
    }
    shown = text_of(render(reported(wrong)))
    assert "The prediction holds" not in shown
    assert "differ by more than three standard errors" in shown


def test_without_load_errors_they_are_not_drawn() -> None:
    figures = [block for section in reported(repeated(False)).sections for block in section.blocks]
    names = {trace["name"] for figure in figures if isinstance(figure, Figure) for trace in figure.plot["data"]}
    assert not any("load errors" in name for name in names)


def test_identifiers_are_unique_and_names_are_escaped() -> None:
    ids = re.findall(r'\bid="([^"]+)"', page())
    assert len(ids) == len(set(ids))
    assert EVIL_NAME not in re.sub(r"<script.*?</script>", "", page(), flags=re.DOTALL)
    assert EVIL_NAME in html.unescape(page())


def test_figures_are_drawn_in_a_browser(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    path.write_text(page(), encoding="utf-8")
    browser.get_log("browser")
    browser.get(path.as_uri())
    count = "return document.querySelectorAll('.plot > .plot-container').length"
    until(lambda: browser.execute_script(count) == 3)  # agreement, and densities at two targets
    panels = browser.execute_script("return document.querySelectorAll('#densities-1 .subplot').length")
    assert panels == 5  # axes that matter
    assert browser.get_log("browser") == []
