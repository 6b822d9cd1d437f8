"""The reports in a real browser: they load, react to mouse and keyboard, and save files."""

import io
import itertools
import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from expdesign.planning.accuracy_map import accuracy_maps
from expdesign.planning.criteria.error_ellipses import target_covariances
from expdesign.planning.result import pareto_frame, plan_of
from expdesign.report import words
from expdesign.report.design_data import plan_cells

WAIT_S = 30.0


def until(condition: Callable[[], Any]) -> Any:
    """The first true value of `condition`; waits for the browser."""
    end = time.monotonic() + WAIT_S
    while not (value := condition()):
        assert time.monotonic() < end, "the browser did not get there"
        time.sleep(0.05)
    return value


class Screen:
    """A report that is open in the browser."""

    def __init__(self, browser: Any, case: Any) -> None:
        self.browser, self.case = browser, case
        for kind in ("browser", "performance"):
            browser.get_log(kind)
        for file in browser.downloads.iterdir():
            file.unlink()
        browser.get(case.path.as_uri())
        until(lambda: self.run("return document.documentElement.dataset.ready === 'true'"))

    def run(self, script: str, *arguments: Any) -> Any:
        return self.browser.execute_script(script, *arguments)

    def find(self, selector: str) -> Any:
        return self.browser.find_element("css selector", selector)

    def text(self, id: str) -> str:
        return str(self.run("return document.getElementById(arguments[0]).textContent", id))

    def rows(self, id: str) -> list[list[str]]:
        script = "return [...document.getElementById(arguments[0]).tBodies[0].rows].map("
        cells: list[list[str]] = self.run(script + "row => [...row.cells].map(cell => cell.textContent))", id)
        return cells

    def click(self, selector: str) -> None:
        element = self.find(selector)
        self.run("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", element)
        element.click()

    def click_point(self, figure: str, trace: int, point: int) -> None:
        """Click on a point of a figure, with a real pointer."""
        from selenium.webdriver import ActionChains  # noqa: PLC0415 (only where there is a browser)

        place = self.run(
            """
            const plot = document.getElementById(arguments[0]);
            plot.scrollIntoView({block: 'center', behavior: 'instant'});
            const {xaxis, yaxis, _size: size} = plot._fullLayout;
            const {x: across, y: up} = plot.data[arguments[1]];
            const x = xaxis.l2p(across[arguments[2]]), y = yaxis.l2p(up[arguments[2]]);
            const box = plot.getBoundingClientRect();
            return [Math.round(box.left + size.l + x), Math.round(box.top + size.t + y)];
            """,
            figure,
            trace,
            point,
        )
        actions = ActionChains(self.browser)
        actions.w3c_actions.pointer_action.move_to_location(*place)  # type: ignore[no-untyped-call]
        actions.w3c_actions.pointer_action.click()
        actions.perform()

    def download(self, selector: str, name: str) -> bytes:
        self.click(selector)
        file: Path = self.browser.downloads / name
        until(lambda: file.exists() and file.stat().st_size > 0)
        return file.read_bytes()

    def shows(self, design: int) -> None:
        """Assert that the whole page shows one design."""
        case = self.case
        until(lambda: self.text("plan-title") == f"Plan of design {design + 1}")
        assert self.rows("plan") == plan_cells(plan_of(case.problem, case.front.decisions[design]))
        assert self.text("chosen-text").startswith(f"Design {design + 1}")
        assert words.number(float(case.front.criteria["total"][design]), 4) in self.text("chosen-text")
        assert f"Plan of design {design + 1}:" in self.text("plan-caption")
        assert self.run("return document.querySelector('#designs input:checked').value") == str(design)
        ring = self.run("const trace = document.getElementById('front').data[3]; return [trace.x[0], trace.y[0]]")
        assert ring == [case.front.criteria[name][design] for name in case.front.objectives[:2]]


@pytest.fixture
def hexapod_screen(browser: Any, hexapod: Any) -> Iterator[Screen]:
    yield Screen(browser, hexapod)
    assert_quiet(browser)


@pytest.fixture
def bipod_screen(browser: Any, bipod: Any) -> Iterator[Screen]:
    yield Screen(browser, bipod)
    assert_quiet(browser)


def assert_quiet(browser: Any) -> None:
    """No error in the console and no request to any network since the page was opened."""
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    asked = [entry["params"]["request"]["url"] for entry in messages if entry["method"] == "Network.requestWillBeSent"]
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []


@contextmanager
def emulated(browser: Any, system: str) -> Iterator[None]:
    """The colours that the system asks for."""
    features = [{"name": "prefers-color-scheme", "value": system}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    try:
        yield
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def another(case: Any) -> int:
    """The design that lies farthest from all others in the figure of the front and is not marked there."""
    first, second = (np.array(case.front.criteria[name]) for name in case.front.objectives[:2])
    scaled = np.stack([first / np.ptp(first), second / np.ptp(second)], axis=-1)
    distance = np.linalg.norm(scaled[:, None] - scaled, axis=-1) + 1e9 * np.eye(len(scaled))
    nearest = distance.min(axis=-1)
    nearest[[case.front.recommended, case.front.knee]] = 0.0
    return int(np.argmax(nearest))


def test_what_stands_in_the_page_is_what_its_script_shows(hexapod_screen: Screen) -> None:
    """Choosing another design and coming back gives the tables and sentences that were written by Python."""
    screen = hexapod_screen
    ids: tuple[str, ...] = (
        "plan",
        "budget-table",
        "accuracy",
        "chosen-text",
        "accuracy-title",
        "plan-caption",
        "ellipse-table",
    )
    ids += ("ellipse-table-caption", "deviations-text", "criteria-table")
    squeezed = "return document.getElementById(arguments[0]).textContent.replace(/\\s+/g, ' ').trim()"
    source = screen.case.path.read_text(encoding="utf-8")
    parsed = """
        const page = new DOMParser().parseFromString(arguments[0], 'text/html');
        return page.getElementById(arguments[1]).textContent.replace(/\\s+/g, ' ').trim();
    """
    static = [screen.run(parsed, source.split('<script type="application/json"')[0], id) for id in ids]
    screen.click("#choose-knee")
    screen.shows(screen.case.front.knee)
    screen.click("#choose-recommended")
    screen.shows(screen.case.front.recommended)
    without_spaces = [text.replace(" ", "") for text in static]
    assert [screen.run(squeezed, id).replace(" ", "") for id in ids] == without_spaces


def test_a_click_on_the_front_chooses_the_design(hexapod_screen: Screen) -> None:
    design = another(hexapod_screen.case)
    hexapod_screen.click_point("front", 0, design)
    hexapod_screen.shows(design)


def test_the_keyboard_chooses_designs(hexapod_screen: Screen) -> None:
    screen, front = hexapod_screen, hexapod_screen.case.front
    start, following = front.recommended, (front.recommended + 1) % len(front)
    chosen = screen.find("#designs input:checked")
    chosen.send_keys("\ue015")  # arrow down
    screen.shows(following)
    assert screen.run("return document.activeElement.value") == str(following)
    screen.run("return document.activeElement").send_keys("\ue013")  # arrow up
    screen.shows(start)


def test_the_plan_of_the_chosen_design_is_saved(hexapod_screen: Screen) -> None:
    screen, case = hexapod_screen, hexapod_screen.case
    design = another(case)
    screen.click(f"#designs tbody tr:nth-child({design + 1}) td:nth-child(2)")
    screen.shows(design)
    saved = screen.download("button[data-csv=plan]", f"plan-design-{design + 1}.csv")
    table = pd.read_csv(io.BytesIO(saved))
    pd.testing.assert_frame_equal(table, plan_of(case.problem, case.front.decisions[design]), check_exact=True)


def test_every_figure_and_table_is_saved(bipod_screen: Screen) -> None:
    screen = bipod_screen
    front = pd.read_csv(io.BytesIO(screen.download("button[data-csv=front]", "pareto.csv")))
    pd.testing.assert_frame_equal(front, pareto_frame(screen.case.front), check_exact=True)
    number = screen.case.front.recommended + 1
    budget = screen.download("button[data-csv=budget]", f"error-budget-design-{number}.csv")
    table = pd.read_csv(io.BytesIO(budget))
    variance = table["noise_std"] ** 2 + table["load_std"] ** 2
    pd.testing.assert_series_equal(table["total_std"] ** 2, variance, check_names=False, rtol=1e-5)
    robot = pd.read_csv(io.BytesIO(screen.download("button[data-csv=robot]", "robot.csv")))
    assert list(robot.columns) == ["part", "line", "x_m", "y_m"]
    for figure, name in (("front", "front"), ("budget", "error-budget")):
        picture = screen.download(f"button[data-picture=svg][data-of={figure}]", f"{name}.svg")
        assert picture.startswith(b"<svg")
    assert screen.download("button[data-picture=png][data-of=robot]", "robot.png").startswith(b"\x89PNG")


def test_the_robot_in_space_is_saved(hexapod_screen: Screen) -> None:
    assert hexapod_screen.download("button[data-picture=png][data-of=robot]", "robot.png").startswith(b"\x89PNG")
    assert hexapod_screen.download("button[data-picture=svg][data-of=robot]", "robot.svg").startswith(b"<svg")


def test_the_robot_steps_through_measurements_and_targets(hexapod_screen: Screen) -> None:
    screen = hexapod_screen
    legs = "return document.getElementById('robot').data.find(trace => trace.name === 'legs').x"
    seen, texts = [screen.run(legs)], [screen.text("state-text")]
    for _ in range(screen.run("return document.getElementById('state').options.length") - 1):
        screen.click("button[data-of=state][data-step='1']")
        seen.append(screen.run(legs))
        texts.append(screen.text("state-text"))
    targets = len(screen.case.problem.targets.weights)
    assert len(seen) == screen.case.problem.space.measurements + targets
    assert all(one != following for one, following in itertools.pairwise(texts))
    assert "Load:" in texts[-1]
    screen.click("button[data-of=state][data-step='1']")
    assert screen.run(legs) == seen[0]


def test_any_two_criteria_span_the_figure(bipod_screen: Screen) -> None:
    screen, front = bipod_screen, bipod_screen.case.front
    screen.find("#horizontal option[value=o1]").click()
    script = "return document.getElementById('front').data[0].x"
    until(lambda: screen.run(script) == front.criteria["o1"].tolist())
    design = another(screen.case)
    screen.click_point("front", design, 0)
    until(lambda: screen.text("plan-title") != f"Plan of design {front.recommended + 1}")


def test_the_ellipses_are_those_of_the_covariance(hexapod_screen: Screen) -> None:
    """The outline that is drawn, and saved, is Mahalanobis-distant from the middle by the 95 % quantile."""
    screen, case = hexapod_screen, hexapod_screen.case
    covariances = target_covariances(case.problem.assess(*case.problem.space.decode(case.front.decisions)))
    options = screen.run("return document.getElementById('ellipse-view').options.length")
    assert options == 6 * len(case.problem.targets.weights)
    for _ in range(options - 1):
        screen.click("button[data-of=ellipse-view][data-step='1']")
    design = another(case)
    screen.click(f"#designs tbody tr:nth-child({design + 1}) td:nth-child(2)")
    screen.shows(design)
    target = len(case.problem.targets.weights)
    saved = screen.download("button[data-csv=ellipses]", f"error-ellipses-target-{target}.csv")
    outlines = pd.read_csv(io.BytesIO(saved))
    assert list(outlines.columns) == ["part", "dry_rad", "drz_rad"]
    parts = {"both": covariances.total, "measurement noise": covariances.noise, "load errors": covariances.load}
    for name, covariance in parts.items():
        points = outlines.loc[outlines["part"] == name, ["dry_rad", "drz_rad"]].to_numpy()
        block = covariance[design, -1, 4:6, 4:6]
        distance = np.einsum("ki,ij,kj->k", points, np.linalg.inv(block), points)
        np.testing.assert_allclose(distance, -2.0 * np.log(0.05), rtol=1e-3)  # χ² of two degrees of freedom


@pytest.mark.parametrize("name", ["hexapod", "bipod"])
def test_the_map_of_accuracy_is_that_of_the_chosen_plan(browser: Any, name: str, request: Any) -> None:
    case = request.getfixturevalue(name)
    screen = Screen(browser, case)
    design = another(case)
    screen.click(f"#designs tbody tr:nth-child({design + 1}) td:nth-child(2)")
    screen.shows(design)
    screen.click("button[data-of=map-view][data-step='-1']")  # the last map
    chart = accuracy_maps(case.problem)[-1]
    noise, load = case.problem.assess(*case.problem.space.decode(case.front.decisions)).parameter_covariance
    expected = chart.rms((noise + load)[design])
    saved = pd.read_csv(
        io.BytesIO(screen.download("button[data-csv=map]", f"accuracy-map-target-{chart.target + 1}.csv"))
    )
    np.testing.assert_allclose(saved["rms_tolerances"].to_numpy().reshape(expected.shape), expected, rtol=1e-3)
    shown = screen.run("return document.getElementById('map').data[0].z")
    np.testing.assert_allclose(np.array(shown, dtype=float), expected, rtol=1e-3)
    assert_quiet(browser)


def test_every_button_that_saves_data_saves_data(hexapod_screen: Screen) -> None:
    screen = hexapod_screen
    ids = screen.run("return [...document.querySelectorAll('button[data-csv]')].map(button => button.dataset.csv)")
    assert {"front", "designs", "plan", "robot", "budget", "budget-table", "ellipses", "ellipse-table"} < set(ids)
    given = "const file = report.csv[arguments[0]]; return typeof file === 'function' ? file() : file"
    for id in ids:
        file = screen.run(given, id)
        assert file["filename"].endswith(".csv")
        table = pd.read_csv(io.StringIO(file["text"]))
        assert len(table) > 0


def test_no_chart_can_be_sent_to_a_server(hexapod_screen: Screen) -> None:
    """plotly's bar of tools holds, unless told otherwise, a button that uploads the data to its maker."""
    titles = hexapod_screen.run(
        "return [...document.querySelectorAll('.modebar-btn')].map(button => button.dataset.title || button.title)"
    )
    assert titles
    assert [title for title in titles if "hare" in title or "loud" in title] == []
    contexts = hexapod_screen.run("return [...document.querySelectorAll('.plot')].map(plot => plot._context)")
    assert all(not context["showSendToCloud"] and context["plotlyServerURL"] == "" for context in contexts)


def test_the_look_follows_the_system_and_the_button(browser: Any, hexapod: Any) -> None:
    colours = """
        return [getComputedStyle(document.body).backgroundColor,
                document.getElementById('front')._fullLayout.paper_bgcolor];
    """
    try:
        with emulated(browser, "light"):
            screen = Screen(browser, hexapod)
            light = screen.run(colours)
        with emulated(browser, "dark"):
            dark = until(lambda: (now := screen.run(colours)) != light and now[1] != light[1] and now)
            screen.click("#theme")
            until(lambda: screen.run(colours) == light)
            screen.click("#theme")
            until(lambda: screen.run(colours) == dark)
    finally:
        browser.execute_script("try { localStorage.clear(); } catch { /* none for files */ }")


def test_nothing_is_wider_than_a_phone(browser: Any, hexapod: Any) -> None:
    metrics = {"width": 390, "height": 800, "deviceScaleFactor": 1, "mobile": True}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    try:
        screen = Screen(browser, hexapod)
        assert screen.run("return document.documentElement.scrollWidth") <= 390
        assert screen.run("return document.documentElement.clientWidth") == 390
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_printing_turns_the_figures_light_and_to_the_width_of_paper_and_back(browser: Any, bipod: Any) -> None:
    state = """
        return [...document.querySelectorAll('.plot')].map(
            plot => [plot._fullLayout.width, plot._fullLayout.paper_bgcolor]);
    """
    with emulated(browser, "dark"):
        screen = Screen(browser, bipod)
        before = screen.run(state)
        screen.run("window.dispatchEvent(new Event('beforeprint'))")
        until(lambda: all(width <= 660 and colour == "#ffffff" for width, colour in screen.run(state)))
        assert not any(colour == "#ffffff" for _, colour in before)
        screen.run("window.dispatchEvent(new Event('afterprint'))")
        until(lambda: screen.run(state) == before)


def test_the_printed_page_leaves_out_what_only_a_screen_can_use(browser: Any, hexapod: Any) -> None:
    """Neither the table of all designs nor buttons are printed; the chosen design's tables are, in full."""
    shown = "return getComputedStyle(document.querySelector(arguments[0])).display !== 'none'"
    screen = Screen(browser, hexapod)
    try:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        for selector in (".choosing", ".tools", "nav", "#theme", ".selector"):
            assert not screen.run(shown, selector), selector
        for selector in ("#plan", "#budget-table", "#deviations-text", "#front", "#chosen-text"):
            assert screen.run(shown, selector), selector
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_without_webgl_the_robot_is_drawn_in_the_plane(browser: Any, hexapod: Any) -> None:
    """Old computers and remote desktops have no WebGL: legs, platform and force are drawn as a parallel projection."""
    without = """
        const original = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
            return /webgl/.test(kind) ? null : original.call(this, kind, ...rest);
        };
    """
    script = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": without})
    try:
        screen = Screen(browser, hexapod)
        types = screen.run("return document.getElementById('robot').data.map(trace => trace.type)")
        assert set(types) == {"scatter"}
        legs = screen.run("return document.getElementById('robot').data.find(trace => trace.name === 'legs')")
        assert len([value for value in legs["x"] if value is not None]) == 12
        spans = [max(filter(None, legs[axis])) - min(filter(None, legs[axis])) for axis in "xy"]
        assert min(spans) > 0.1  # neither squeezed to a line nor to a point
        moved = []
        for _ in range(screen.case.problem.space.measurements - 1):  # a plan may stay at a pose
            screen.click("button[data-of=state][data-step='1']")
            moved.append(
                screen.run("return document.getElementById('robot').data.find(trace => trace.name === 'legs').x")
            )
        assert any(one != legs["x"] for one in moved)
        assert screen.download("button[data-picture=svg][data-of=robot]", "robot.svg").startswith(b"<svg")
        assert_quiet(browser)
    finally:
        browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)


def test_everything_is_reached_with_the_keyboard_and_has_a_name(hexapod_screen: Screen) -> None:
    """Every control can be focused and says what it is; one main region."""
    nameless = hexapod_screen.run(
        """
        const controls = document.querySelectorAll('button, select, input, a, [role=region], [role=img]');
        return [...controls].filter((element) => {
            const label = element.labels && element.labels[0];
            const ids = (element.getAttribute('aria-labelledby') || '').split(' ');
            const by = ids.map((id) => document.getElementById(id));
            const name = element.getAttribute('aria-label') || element.textContent.trim() || element.dataset.title
                || (label && label.textContent.trim()) || by.map((node) => node && node.textContent).join('');
            return !name && !element.closest('.modebar');
        }).map((element) => element.outerHTML.slice(0, 120));
        """
    )
    assert nameless == []
    assert hexapod_screen.run("return document.querySelectorAll('main').length") == 1
    ids = hexapod_screen.run("return [...document.querySelectorAll('[id]')].map(element => element.id)")
    named = [id for id in ids if not id.startswith(("topdefs", "clip", "legend", "defs", "g"))]
    assert len(named) == len(set(named))


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_texts_stand_out_from_their_background(hexapod_screen: Screen, theme: str) -> None:
    """Contrast of at least 4.5 to 1 (WCAG 2.1 AA) for text, and of 3 to 1 for what is drawn."""
    colours = """
        document.documentElement.dataset.theme = arguments[0];
        const style = getComputedStyle(document.documentElement);
        return Object.fromEntries(arguments[1].map((name) => [name, style.getPropertyValue(name).trim()]));
    """
    text = ("--ink", "--muted", "--accent", "--accent-ink")
    drawn = ("--noise", "--load", "--total", "--recommended", "--knee", "--design", "--platform", "--force")
    series = tuple(f"--series-{number}" for number in range(1, 7))
    names = [*text, *drawn, *series, "--card", "--paper", "--accent-soft"]
    found = hexapod_screen.run(colours, theme, names)

    def luminance(colour: str) -> float:
        parts = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        return float(linear @ [0.2126, 0.7152, 0.0722])

    def contrast(one: str, other: str) -> float:
        high, low = sorted((luminance(found[one]), luminance(found[other])), reverse=True)
        return (high + 0.05) / (low + 0.05)

    for background in ("--card", "--paper"):
        for name in text[:3]:
            assert contrast(name, background) >= 4.5, (name, background)
    assert contrast("--ink", "--accent-soft") >= 4.5
    for name in (*drawn, *series):
        assert contrast(name, "--card") >= 3.0, name
