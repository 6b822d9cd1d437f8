"""The tutorial does what it says: its commands run in an empty folder and print what stands below them."""

import re
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
SPACE = re.compile(" +")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def loaded(name: str) -> ModuleType:
    return import_module(f"docs.{name}")


@pytest.fixture(scope="module")
def steps(tmp_path_factory: pytest.TempPathFactory) -> Any:
    tutorial = loaded("tutorial")
    text = tutorial.PAGE.read_text(encoding="utf-8")
    return list(tutorial.follow(text, tmp_path_factory.mktemp("empty")))


def test_every_output_is_what_the_page_shows(steps: Any) -> None:
    """The words are the same; numbers may differ a little where another linear algebra leads to another optimum."""
    assert len(steps) >= 10
    for step in steps:
        printed, shown = (SPACE.sub(" ", NUMBER.sub("#", text)) for text in (step.printed, step.shown))
        assert printed == shown, step.command
    for step in steps:
        if step.command.startswith("expdesign identify"):
            for shown, printed in zip(step.shown.splitlines()[1:7], step.printed.splitlines()[1:7], strict=True):
                assert shown.split()[:2] == printed.split()[:2]
                stiffness = [float(NUMBER.findall(line)[1]) for line in (shown, printed)]
                assert abs(stiffness[1] / stiffness[0] - 1.0) < 0.05


def test_what_was_hidden_is_found_and_the_robot_is_compensated(steps: Any) -> None:
    diagnosed = next(step for step in steps if step.command.startswith("expdesign diagnose"))
    assert "Verdict: explained." in diagnosed.printed
    gap, low, high = (float(text) for text in re.findall(r"[\d.]+", diagnosed.printed.split("Leg 3 has")[1])[:3])
    assert low < 6.0 < high
    assert abs(gap - 6.0) < 1.5
    rows = [[float(text) for text in line.split()] for line in steps[-1].printed.splitlines()[1:]]
    assert len(rows) == 2
    for row in rows:
        bent, left = row[0::2], row[1::2]
        assert max(map(abs, bent)) > 10.0
        assert max(map(abs, left)) < 0.5  # half the tolerance of a micrometre


def test_the_documentation_is_built_without_a_broken_link(tmp_path: Path) -> None:
    pytest.importorskip("mkdocs", reason="mkdocs is not installed (extra `docs`)")
    pytest.importorskip("mkdocstrings", reason="mkdocstrings is not installed (extra `docs`)")
    import subprocess  # noqa: PLC0415
    import sys  # noqa: PLC0415

    built = tmp_path / "site"
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-d", str(built)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    pages = {page.stem for page in built.glob("*.html")}
    assert {page.stem for page in (ROOT / "docs").glob("*.md")} <= pages
    for page in built.glob("*.html"):
        text = page.read_text(encoding="utf-8")
        fetched = re.findall(r"<(?:script|link|img)[^>]*(?:src|href)=\"(https?:[^\"]*)", text)
        assert [address for address in fetched if 'rel="canonical"' not in address] == [], page.name


def test_links_to_files_of_the_project_are_checked() -> None:
    pytest.importorskip("mkdocs", reason="mkdocs is not installed (extra `docs`)")
    pages = loaded("pages")

    class Page:
        class file:  # noqa: N801 (as mkdocs calls it)
            src_path = "x.md"

    assert pages.on_page_markdown("[H1](../configs/hexapod-h1.yaml)", Page) == "H1 (`configs/hexapod-h1.yaml`)"
    with pytest.raises(Exception, match="does not exist"):
        pages.on_page_markdown("[H1](../configs/no-such-file.yaml)", Page)
