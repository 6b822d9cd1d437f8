"""The page of a run in a real browser: the front grows, a button ends the run, and the report opens."""

import threading
import time
from pathlib import Path
from typing import Any

import pytest
from tests.report.test_in_browser import until
from tests.watching.runs import config_file

import expdesign as xd
from expdesign.app.api.run import RunResult
from expdesign.app.watching.server import Watched, serve
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import Follow, Progress


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search and a browser share the processor here."""
    monkeypatch.setattr("tests.report.test_in_browser.WAIT_S", 120.0)


def paced(watched: Watched) -> Follow:
    """Follows a search that is held back a little, so that it goes on for as long as the browser looks."""

    def follow(state: Progress) -> bool:
        time.sleep(0.05)
        return watched.follow(state)

    return follow


def shown(browser: Any) -> int:
    """Points of the front that are drawn."""
    return int(
        browser.execute_script("const p = document.getElementById('front'); return p.data ? p.data[0].x.length : 0")
    )


def errors(browser: Any) -> list[str]:
    return [entry["message"] for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]


@pytest.mark.parametrize("width", [1280, 390])
def test_the_front_grows_and_the_run_is_ended(browser: Any, tmp_path: Path, width: int) -> None:
    config = config_file(tmp_path, optimiser={"population": 16, "generations": 2000, "seed": 1, "polish": True})
    problem = read_problem(config)
    watched = Watched(problem, str(tmp_path / "out"))
    results: list[RunResult] = []
    browser.set_window_size(width, 900)
    browser.get_log("browser")

    def work() -> None:
        with serve(watched) as watch:
            addresses.append(watch.address)
            found = xd.run(problem, callback=watched.stage, follow=paced(watched))
            results.append(found)
            page = found.save(tmp_path / "out")
            watched.ended("ended")
            watch.report = page

    addresses: list[str] = []
    worker = threading.Thread(target=work)
    worker.start()
    try:
        until(lambda: addresses)
        browser.get(addresses[0])
        until(lambda: shown(browser) > 1)
        drawn = int(browser.execute_script("return document.documentElement.dataset.drawn"))
        until(lambda: int(browser.execute_script("return document.documentElement.dataset.drawn")) > drawn)
        assert "generation" in browser.find_element("id", "said").text
        wide = browser.execute_script("return document.documentElement.scrollWidth - window.innerWidth")
        assert wide <= 0, "the page is wider than the screen"
        assert not browser.find_element("id", "axes").is_displayed()
        browser.find_element("id", "end").click()
        until(lambda: browser.current_url.endswith("/report"))
        until(lambda: browser.execute_script("return document.documentElement.dataset.unpacked") == "true")
    finally:
        watched.end_it()
        worker.join()
        browser.set_window_size(1280, 1000)
    assert "Calibration plan" in browser.title
    assert errors(browser) == []
    assert "ended_by_hand" in results[0].record


def test_the_page_says_that_the_command_is_gone(browser: Any, tmp_path: Path) -> None:
    problem = read_problem(config_file(tmp_path))
    watched = Watched(problem, "results/mine")
    with serve(watched) as watch:
        watched.stage("searching", 1, 2, "")
        browser.get(watch.address)
        until(lambda: "generation 1 of 2" in browser.find_element("id", "said").text)
    until(lambda: "The command has ended" in browser.find_element("id", "said").text)
    assert not browser.find_element("id", "end").is_enabled()
    browser.get_log("browser")  # the questions that nobody answered
