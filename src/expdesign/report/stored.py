"""A report page as data, so that it can be made again, in the look of the day, without the work that led to it.

A folder of results holds `report.json` (what the page says: texts, tables, figures) beside `report.html` (the same with
style, scripts and plotly.js, fifty times as large). The page is always rendered from the former, so that one that is
made again is the same byte for byte as long as the look is the same.
"""

import dataclasses
import json
import shlex
from pathlib import Path
from typing import Any

from jinja2 import TemplateError

from expdesign.errors import InputError
from expdesign.io.output import PART, plain, write_file
from expdesign.io.written import Purpose, note_written, require_free, unchanged
from expdesign.io.yaml_reader import read_text
from expdesign.report import blocks
from expdesign.report.blocks import HERE
from expdesign.report.page import Page, known_scripts, render

CONTENT, PAGE = "report.json", "report.html"
_DAMAGED = "The file is damaged, or of another version: run the command that made the folder again."
_PARTS: dict[str, type[Any]] = {"Page": Page} | {
    name: value for name, value in vars(blocks).items() if dataclasses.is_dataclass(value) and isinstance(value, type)
}


def write_report(folder: Path, page: Page, place: Path | None = None) -> None:
    """Write `report.json` and `report.html` into a folder, whose final place (for commands in the page) is `place`."""
    text = page_text(page)
    write_file(folder / CONTENT, text)
    write_file(folder / PAGE, render(page_from_text(_in(place or folder, text), str(folder / CONTENT))))


def remake_report(folder: Path, *, force: bool = False) -> Path:
    """Make `report.html` of a folder of results again from its `report.json`.

    Args:
        folder: of results.
        force: whether a page that somebody changed, or that has no record, is replaced as well.

    Returns:
        the path of the page.

    Raises:
        InputError: the folder holds no results that are known, or they are damaged.
    """
    content = folder / CONTENT
    if not folder.is_dir():
        what = "this is a file, not a folder" if folder.exists() else "there is no such folder"
        raise InputError(what, where=str(folder), remedy="Name a folder that a command wrote (`--out`).")
    if not content.is_file():
        what = f"nothing that a report can be made of lies here (`{CONTENT}` is missing)"
        remedy = "Name the folder that `run`, `identify`, `diagnose`, `compare`, `montecarlo` or a sweep's run wrote."
        raise InputError(what, where=str(folder), remedy=remedy)
    page = page_from_text(_in(folder, read_text(content)), str(content))
    try:
        html = render(page)
    except (TemplateError, AttributeError, TypeError, ValueError) as error:  # parts of a wrong kind
        raise InputError(f"this is not a stored report ({error})", where=str(content), remedy=_DAMAGED) from None
    purpose = None
    if not unchanged(folder / PAGE):
        purpose = Purpose("report", (str(content),))
        require_free(folder / PAGE, purpose, force=force)
    write_file(folder / PAGE, html)
    note_written(folder, [PAGE], purpose)
    return folder / PAGE


def _in(folder: Path, text: str) -> str:
    """The text of a page whose commands name files of the folder as they are seen from the current one."""
    seen = "" if folder == Path() else f"{shlex.quote(str(folder))}/"
    return text.replace(HERE, json.dumps(seen, ensure_ascii=False)[1:-1])


def page_text(page: Page) -> str:
    """A page as JSON, with arrays as lists and what is not finite as null."""
    return json.dumps(plain(page), ensure_ascii=False, allow_nan=False, separators=(",", ":")) + "\n"


def page_from_text(text: str, source: str) -> Page:
    """The page that `page_text` wrote.

    Raises:
        InputError: the text is not such a page; `source` names it.
    """
    try:
        page = _decoded(json.loads(text))
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"this is not a stored report ({error})", where=source, remedy=_DAMAGED) from None
    if not isinstance(page, Page) or not set(page.scripts) <= known_scripts():
        raise InputError("this is not a stored report", where=source, remedy=_DAMAGED)
    return page


def _decoded(value: Any) -> Any:
    if isinstance(value, list):
        return [_decoded(entry) for entry in value]
    if not isinstance(value, dict):
        return value
    fields = {key: _decoded(entry) for key, entry in value.items() if key != PART}
    if PART not in value:
        return fields
    if value[PART] not in _PARTS:
        raise ValueError(f"unknown part `{value[PART]}`")
    return _PARTS[value[PART]](**fields)
