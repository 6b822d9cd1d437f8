"""A page is one valid, self-contained file, whatever its texts are."""

import itertools
import json
import re
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from plotly.offline import get_plotlyjs

from expdesign.report.blocks import (
    DataTable,
    Download,
    Figure,
    KeyFigure,
    KeyFigures,
    NextSteps,
    Option,
    PageSection,
    Paragraph,
    Selector,
    Sentences,
    SideBySide,
    Subheading,
)
from expdesign.report.page import Page, content_of, embedded_json, packed, plot_text, render

VOID = {"meta", "input", "br", "link", "hr", "img"}
EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(1)> & \"'<!--"


class Structure(HTMLParser):
    """Elements in order with their attributes, and whether every tag is closed in turn."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.problems: list[str] = []
        self.feed(html)
        self.close()
        self.problems += [f"<{tag}> is not closed" for tag in self.open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.problems.append(f"</{tag}> at {self.getpos()} does not close the last open tag")

    def values(self, attribute: str) -> list[str]:
        return [value for _, attributes in self.elements if (value := attributes.get(attribute)) is not None]


def page_of_everything(text: str) -> str:
    figure = Figure("plot", text, {"data": [{"x": np.arange(2.0), "name": plot_text(text)}], "layout": {}}, text, text)
    table = DataTable("rows", text, [text, text], [[text, text]], Download("rows.csv", text), choice="which")
    blocks = (
        Paragraph(text, id="p", live=True),
        Subheading(text),
        Sentences([text]),
        KeyFigures([KeyFigure(text, text, text, text)]),
        NextSteps([(text, text)]),
        Selector("choice-of", text, [Option("a", text)], step=True),
        SideBySide([table], [figure]),
    )
    return render(Page(text, text, [PageSection("all", text, blocks)], data={"text": text}, footer=text))


def without_plotly(html: str) -> str:
    return re.sub(r'(<script type="text/plain" id="plotly">).*?</script>', r"\1</script>", html, flags=re.DOTALL)


@pytest.fixture(scope="module", params=["made up", "hexapod", "bipod"])
def html(request: pytest.FixtureRequest) -> str:
    if request.param == "made up":
        return page_of_everything(EVIL)
    return str(request.getfixturevalue(request.param).html)


def test_every_tag_is_closed_and_every_id_is_unique(html: str) -> None:
    structure = Structure(without_plotly(html))
    assert structure.problems == []
    ids = structure.values("id")
    assert len(set(ids)) == len(ids)
    assert html.startswith("<!DOCTYPE html>")


def test_every_reference_has_its_element(html: str) -> None:
    structure = Structure(without_plotly(html))
    ids = set(structure.values("id"))
    for attribute in ("aria-labelledby", "for", "data-of", "data-csv"):
        assert set(structure.values(attribute)) <= ids
    assert {link[1:] for link in structure.values("href")} <= ids


def test_nothing_is_fetched_from_anywhere(html: str) -> None:
    structure = Structure(without_plotly(html))
    assert structure.values("src") == []
    assert all(link.startswith("#") for link in structure.values("href"))
    assert not any(tag in ("link", "iframe", "object", "img") for tag, _ in structure.elements)
    assert "http://" not in without_plotly(html)
    assert "https://" not in without_plotly(html)
    assert "@import" not in html.split("</style>", maxsplit=1)[0]
    (policy,) = (value for value in structure.values("content") if "default-src" in value)
    assert "default-src 'none'" in policy
    assert "connect-src 'none'" in policy


def test_plotly_is_there_once_and_only_with_figures(html: str) -> None:
    assert html.count('id="plotly"') == 1
    assert 'id="plotly"' not in render(Page("t", "s", [PageSection("a", "A", [Paragraph("p")])]))


def test_the_pages_are_below_two_megabytes(html: str, hexapod: Any) -> None:
    assert max(len(page.encode()) for page in (html, hexapod.html)) <= 2 * 2**20


def test_without_tile_maps_plotly_is_a_third_smaller() -> None:
    """The parts that are left out are found in the version of plotly.js that is installed."""
    whole, kept = packed(get_plotlyjs()), re.search(r'id="plotly">(.*?)</script>', page_of_everything("x"), re.DOTALL)
    assert len(kept[1]) < 0.82 * len(whole)


def test_user_text_never_becomes_markup() -> None:
    structure = Structure(without_plotly(page_of_everything(EVIL)))
    assert [tag for tag, _ in structure.elements].count("img") == 0
    # Data, plotly, the page's own script and what unpacks them; nothing that a text brought along.
    assert [tag for tag, _ in structure.elements].count("script") == 4


def test_a_packed_text_cannot_end_its_element_and_unpacks_to_itself() -> None:
    text = "".join(map(chr, range(1, 2000))) * 20
    found = str(packed(text))
    assert not set("<\"'\\/") & set(found)
    page = f'<script type="text/plain" id="report-content">{packed(json.dumps(text))}</script>'
    assert content_of(page) == text


def test_embedded_json_cannot_end_its_element_and_reads_back() -> None:
    content = {"name": EVIL, "line": "\u2028", "array": np.array([1.5, np.nan]), "many": (np.int64(1), np.inf)}
    text = str(embedded_json(content))
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text) == {"name": EVIL, "line": "\u2028", "array": [1.5, None], "many": [1, None]}


def test_headings_are_not_skipped_and_figures_are_described(html: str) -> None:
    structure = Structure(without_plotly(html))
    levels = [int(tag[1]) for tag, _ in structure.elements if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(below - above <= 1 for above, below in itertools.pairwise(levels))
    tags = [tag for tag, _ in structure.elements]
    assert tags.count("table") == tags.count("caption")
    assert tags.count("figure") == tags.count("figcaption")
    assert all(attributes.get("aria-label") for _, attributes in structure.elements if attributes.get("role") == "img")


def test_marked_words_are_set_as_code_and_all_else_is_text() -> None:
    page = Page("T", "", [PageSection("a", "A", [Sentences(["run `expdesign <b>`, not <i>"]), Paragraph("`x` & `")])])
    shown = render(page)
    assert "<li>run <code>expdesign &lt;b&gt;</code>, not &lt;i&gt;</li>" in shown
    assert "<code>x</code> &amp; `" in shown


def test_numbers_stay_numbers_where_one_of_them_is_said_in_words() -> None:
    rows = [["leg 1", "below 1e-6", "1.0", "pass"], ["leg 2", "0.31", "none", "fail"], ["leg 3", "0.1", "2.0", "pass"]]
    table = DataTable("t", "T", ["a", "p", "tolerance", "result"], rows)
    assert [bool(table.look(column)) for column in range(4)] == [True, False, False, True]
