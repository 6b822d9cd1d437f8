"""The laboratory sheet as a page for printing: what is set, what is done, and room for what is read."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from jinja2 import Environment, FileSystemLoader

from expdesign.files.units import measured_column

DECIMALS = {"length": 6, "angle": 6, "mass": 6, "force": 6, "moment": 6}
"""Digits that are shown, after the point in SI units."""
_BLANKS = ("Date", "Operator", "Instrument", "Temperature")


def sheet_page(frame: pd.DataFrame, title: str, summary: str, notes: Sequence[str]) -> str:
    """The page.

    Args:
        frame: the sheet, texts and numbers; empty cells are to be filled in.
        title: of the page.
        summary: what is measured and how long it takes.
        notes: what to do with the sheet, below the table.
    """
    environment = Environment(loader=FileSystemLoader(Path(__file__).parent), autoescape=True)
    names = [str(name) for name in frame.columns if not str(name).startswith("s") or name in ("sequence", "series")]
    rows = []
    before: dict[str, str] = {}
    for _, row in frame.iterrows():
        texts = {name: _text(name, row[name]) for name in names}
        cells = [{"text": texts[name], "kind": _kind(name, texts, before)} for name in names]
        kind = "reference" if "reference" in texts["do"] else ""
        stop = any(texts[name] != before.get(name) for name in names if name in _set_points(names))
        rows.append({"cells": cells, "kind": f"{kind} stop".strip() if stop else kind})
        before = texts
    page = environment.get_template("sheet.html")
    header = [_headed(name) for name in names]
    return page.render(title=title, summary=summary, blanks=_BLANKS, header=header, rows=rows, notes=notes)


def _set_points(names: Sequence[str]) -> list[str]:
    """The pose: what stands between `series` and the load."""
    after = list(names)[list(names).index("series") + 1 :]
    return [name for name in after[: after.index("do")] if name[:1] in "xyzrq"]


def _kind(name: str, texts: dict[str, str], before: dict[str, str]) -> str:
    if texts[name] == "":
        return "blank"
    if name == "do":
        return "text"
    return "same" if name not in ("sequence", "plan_row") and texts[name] == before.get(name) else ""


def _headed(name: str) -> str:
    measured = measured_column(name)
    if measured is None:
        return name.replace("_", " ")
    unit = measured.unit.name.replace("um", "µm").replace("urad", "µrad").replace("deg", "°").replace("_s2", "/s²")
    return f"{measured.base.replace('_', ' ')} ({unit})"


def _text(name: str, cell: object) -> str:
    if not isinstance(cell, float):
        return str(cell)
    measured = measured_column(name)
    if measured is None or measured.unit.dimension not in DECIMALS:
        return f"{cell:.9g}"
    si = round(measured.unit.to_si(cell), DECIMALS[measured.unit.dimension])
    return f"{measured.unit.from_si(si) + 0.0:.9g}"
