"""A report page: one HTML file that needs no network, from sections of blocks.

The page brings its style, its scripts, plotly.js (once) and its data along; a content security policy in it forbids
any request. Every text is escaped, in the HTML as well as in the embedded JSON. Library and data are compressed (gzip,
RFC 1952) and unpacked by the browser, which makes a page a third of what it would be.

    page = Page(title="Stiffness of my hexapod", subtitle="...", sections=[
        Section("result", "Result", [Paragraph("..."), DataTable(...), Figure(...)]),
    ])
    html = render(page)
"""

import base64
import gzip
import html
import json
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape
from plotly.offline import get_plotlyjs

from expdesign.io.output import plain
from expdesign.report.blocks import HERE, Block, DataTable, Figure, PageSection, SideBySide

_FOLDER = Path(__file__).parent
# Tile maps, which no page has, are a third of plotly.js: the source of their web worker, one text of half a megabyte;
# the body of their library, a module that is run when the first map is drawn; and its style.
_TILE_MAPS = (
    (re.compile(r"exports='(?:[^\\']|\\.){100000,}+'", flags=re.DOTALL), "exports=''"),
    (
        re.compile(
            r"(=\w+\(\(\)=>\{)[\w$]+\(\);[\w$]+=\{\};(?:(?!\}\);var [\w$]+=W\().){100000,}+(\}\);var [\w$]+=W\()",
            flags=re.DOTALL,
        ),
        r"\1\2",
    ),
    (re.compile(r"textContent='\.maplibregl-map(?:[^\\']|\\.)*+'", flags=re.DOTALL), "textContent=''"),
)


_NO_STYLE = re.compile(r"[^\w .,-]")
"""Characters of a footer that do not go into the style of printed pages, where they could end the text."""


@dataclass(frozen=True)
class Page:
    """What a report page says.

    Attributes:
        title: of the page and its first heading.
        subtitle: one line below it.
        sections: in order; the navigation lists them. One without any block is left out.
        data: what the page's own script works on, as JSON; the script reads `report.data`.
        scripts: names of JavaScript files beside this one that run after `page.js`, in order.
        footer: one line at the end, and at the foot of every printed page.
    """

    title: str
    subtitle: str
    sections: Sequence[PageSection]
    data: Mapping[str, Any] = field(default_factory=dict)
    scripts: Sequence[str] = ()
    footer: str = ""

    def __post_init__(self) -> None:
        """Leave out what is empty."""
        object.__setattr__(self, "sections", [section for section in self.sections if section.blocks])


def render(page: Page, folder: Path = Path()) -> str:
    """The page as HTML; commands in it name files of `folder`, where it will lie, as seen from the current one."""
    here = "" if folder == Path() else f"{shlex.quote(str(folder))}/"
    environment = Environment(
        loader=FileSystemLoader(_FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"code": _with_code, "placed": lambda text: text.replace(HERE, here)}
    blocks = [block for section in page.sections for block in _flat(section.blocks)]
    figures = {block.id: block.plot for block in blocks if isinstance(block, Figure)}
    csv = {
        block.id: {"filename": block.csv.filename, "text": block.csv.text}
        for block in blocks
        if isinstance(block, Figure | DataTable) and block.csv is not None
    }
    return environment.get_template("page.html").render(
        page=page,
        style=Markup(_text("page.css")),
        printed_footer=Markup(_NO_STYLE.sub("", page.footer)),
        plotly=_packed_plotly() if figures else None,
        content=packed(embedded_json({"figures": figures, "csv": csv, "data": page.data})),
        scripts=[Markup(_text(name)) for name in ("page.js", *page.scripts)],
        unpacking=Markup(_text("unpack.js")),
    )


def _with_code(text: str) -> Markup:
    """A text, escaped, whose `parts between such marks` are set as code."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def packed(text: str) -> Markup:
    """A text compressed, as characters that can stand in a `<script>` element."""
    # Level 9 takes a quarter longer than 6, for a page that is 0.2 % shorter.
    return Markup(base64.urlsafe_b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode("ascii"))


def content_of(page: str) -> Any:
    """What `render` embedded in a page: figures, tables to be saved, and the data of its scripts."""
    match = re.search(r'<script type="text/plain" id="report-content">(.*?)</script>', page, flags=re.DOTALL)
    if match is None:
        raise ValueError("this is no report page")
    return json.loads(gzip.decompress(base64.urlsafe_b64decode(match[1])))


@lru_cache(maxsize=1)
def _packed_plotly() -> Markup:
    """plotly.js without what it draws tile maps with."""
    library = get_plotlyjs()
    for part, rest in _TILE_MAPS:
        library = part.sub(rest, library)
    return packed(library)


def plot_text(text: str) -> str:
    """User text for a place inside a plotly figure, which reads some HTML tags."""
    return html.escape(text, quote=False)


def embedded_json(content: Any) -> Markup:
    """`content` as JSON that can stand in a `<script>` element; arrays become lists and NaN becomes null."""
    text = json.dumps(plain(content), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


def _flat(blocks: Iterable[Block]) -> Iterable[Block]:
    for block in blocks:
        if isinstance(block, SideBySide):
            yield from _flat(block.left)
            yield from _flat(block.right)
        else:
            yield block


def _text(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")
