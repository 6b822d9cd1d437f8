"""Stored reports: made again they are the same bytes, and nothing but a stored report is taken for one."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from tests.commands.calls import CONFIG, ROBOT, call, plan_file, recordings_file, refusal
from tests.sweeps.small import SMALL

from expdesign.errors import InputError
from expdesign.report.blocks import (
    DataTable,
    Download,
    Figure,
    KeyFigure,
    KeyFigures,
    PageSection,
    Paragraph,
    SideBySide,
)
from expdesign.report.page import Page, render
from expdesign.report.stored import page_from_text, page_text, remake_report

PAGE = Page(
    "</script><b>title</b>",
    "ünïcode − 1e−3",
    [
        PageSection("a", "A", (KeyFigures((KeyFigure("x", "1", "m"),)), Paragraph("text", live=True))),
        PageSection(
            "b",
            "B",
            [
                SideBySide(
                    [Figure("f", "F", {"data": [{"y": np.array([0.1, np.nan, 1e-17])}]}, "c", "d")],
                    [DataTable("t", "T", ("x",), (("1",),), Download("x.csv", "x\n1\n"), chosen=0)],
                )
            ],
        ),
    ],
    data={"list": (1, 2.5, None, True), "size": np.int64(3)},
    scripts=("design_report.js",),
)


def test_the_page_from_its_text_is_the_page() -> None:
    text = page_text(PAGE)
    assert render(page_from_text(text, "here")) == render(PAGE)
    assert page_text(page_from_text(text, "here")) == text


@pytest.mark.parametrize("command", ["run", "identify", "diagnose", "montecarlo"])
def test_a_report_made_again_is_the_same(tmp_path: Path, command: str) -> None:
    """Of `compare` too: tests/comparison."""
    out = tmp_path / "out"
    inputs: list[object] = [ROBOT, recordings_file(tmp_path)] if command in ("identify", "diagnose") else [CONFIG]
    if command == "montecarlo":
        inputs += [plan_file(tmp_path), "--samples", 100]
    if command == "run":
        content = SMALL | {"optimiser": {"population": 8, "generations": 2, "polish": False}}
        inputs = [tmp_path / "config.yaml"]
        (tmp_path / "config.yaml").write_text(yaml.safe_dump(content))
    assert call(command, *inputs, "--out", out) == 0
    first = (out / "report.html").read_bytes()
    (out / "report.html").unlink()
    assert call("report", out) == 0
    assert (out / "report.html").read_bytes() == first


@pytest.mark.parametrize(
    ("content", "word"),
    [
        ("{", "not a stored report"),
        ("[]", "not a stored report"),
        ('{"part": "Path"}', "unknown part `Path`"),
        ('{"part": "Page"}', "not a stored report"),
        ('{"part": "Page", "title": "t", "subtitle": "s", "sections": ["a"]}', "not a stored report"),
        (page_text(PAGE).replace("design_report.js", "../errors.py"), "not a stored report"),
    ],
)
def test_what_is_no_stored_report_is_refused(tmp_path: Path, content: str, word: str) -> None:
    (tmp_path / "report.json").write_text(content)
    with pytest.raises(InputError, match=word):
        remake_report(tmp_path)
    assert not (tmp_path / "report.html").exists()


def test_a_folder_without_results(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan_file(tmp_path)
    for folder, word in ((tmp_path, "nothing that a report"), (tmp_path / "no", "no such folder"), (CONFIG, "a file")):
        assert word in refusal(capsys, "report", folder)


def test_texts_stay_texts() -> None:
    assert json.loads(page_text(PAGE))["title"] == PAGE.title
    assert "<b>title</b>" not in render(page_from_text(page_text(PAGE), "here"))
