"""Two finished runs, and a browser to look at their reports."""

import html
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from expdesign.planning.front import Front
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import search
from expdesign.report.design_report import RunResult
from expdesign.report.page import render
from expdesign.report.said import Said
from tests.commands.calls import config_file
from tests.design.problems import BIPOD
from tests.design.problems import problem as changed_problem

ROOT = Path(__file__).parents[2]

# Everything that a page could mistake for markup.
EVIL_NAME = "bi<b>pod</b> </script><script>document.title='broken'</script> <!-- & \"co\" {{ 7 * 7 }}"


def text_of(page: str) -> str:
    """What a person reads: the page without markup and scripts, with one space wherever there is any."""
    bare = re.sub(r"<(script|style)\b.*?</\1>", " ", page, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", bare)).split())


@dataclass(frozen=True)
class Case:
    """A run and its report."""

    problem: DesignProblem
    front: Front
    run: dict[str, Any]
    said: Said
    html: str
    path: Path


def _case(problem: DesignProblem, bound_share: float | None, folder: Path) -> Case:
    front = search(problem)
    run = {
        "seed": 1,
        "versions": {"expdesign": "0.1.0"},
        "wall_s": 1.5,
        "evaluations": front.evaluations,
        "hypervolume": front.hypervolume,
        "duir_lower_bound": None if bound_share is None else bound_share * float(front.criteria["duir"].min()),
        "duir_lower_bound_certified_on": "40 candidates",
    }
    path = folder / "report.html"
    result = RunResult(problem, front, run)
    page = render(result.page())
    path.write_text(page, encoding="utf-8")
    return Case(problem, front, run, result.said, page, path)


@pytest.fixture(scope="session")
def hexapod(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """Two objectives, two targets, a payload, four sources of load error and a known lower bound."""
    folder = tmp_path_factory.mktemp("hexapod")
    config = config_file(folder, {"optimiser": {"population": 24, "generations": 6, "polish": False}})
    return _case(read_problem(config), 0.8, folder)


@pytest.fixture(scope="session")
def bipod(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """Three objectives in the plane, a free wrench, and a name full of markup."""
    changes = {
        "robot.name": EVIL_NAME,
        "experiment.measurements": 3,
        "experiment.load.fy_N": [-500, 500],
        "experiment.deflection_noise.std": {"dx_m": 1e-6, "dy_m": 1e-6},
        "experiment.load_error": [
            {"source": "wrench", "std": [2, 2], "shared": True},
            {"source": "direction", "std": 0.002, "shared": False},
        ],
        "targets": [
            {"pose": [0.1, 0.7], "wrench": [100, -400], "tolerance": {"dx_m": 1e-5, "dy_m": 1e-5}},
            {"pose": [-0.2, 0.8], "wrench": [0, -400], "tolerance": {"dy_m": 1e-5}},
        ],
        "objectives": ["duir", "feir", "o1"],
        "optimiser": {"population": 20, "generations": 8, "polish": False},
    }
    return _case(changed_problem(BIPOD, changes), None, tmp_path_factory.mktemp("bipod"))


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A headless Chromium that saves downloads into `browser.downloads`."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed (extra `dev`)")
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    driver = shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("no Chromium here (Debian: apt-get install chromium chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for argument in (
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-quic",
        "--no-first-run",
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--window-size=1280,1000",
        f"--user-data-dir={tmp_path_factory.mktemp('profile')}",
    ):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    session = webdriver.Chrome(options=options, service=webdriver.ChromeService(executable_path=driver))
    session.downloads = tmp_path_factory.mktemp("downloads")
    behaviour = {"behavior": "allow", "downloadPath": str(session.downloads)}
    session.execute_cdp_cmd("Browser.setDownloadBehavior", behaviour)
    yield session
    session.quit()
