"""The vocabulary of figures: traces by what they show, and the figure around them.

Colours are names of page.css (`accent`, `noise`, `load`), so that they follow the light and the dark look.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.io.output import csv_text
from expdesign.report.blocks import Download, Figure

Trace = dict[str, Any]
Values = Sequence[Any] | FloatArray


def colour(name: str) -> str:
    """A colour of page.css."""
    return f"var(--{name})"


def bars(name: str, labels: Sequence[str], values: Values, shade: str, **look: Any) -> Trace:
    """Upright bars."""
    return {"type": "bar", "name": name, "x": labels, "y": values, "marker": {"color": colour(shade)}, **look}


def bars_across(name: str, labels: Sequence[str], values: Values, shade: str, **look: Any) -> Trace:
    """Lying bars, for long labels."""
    return bars(name, labels, values, shade, **look) | {"orientation": "h", "x": values, "y": labels}


def points(
    name: str, x: Values, y: Values, shade: str, *, size: float = 8, symbol: str = "circle", **look: Any
) -> Trace:
    """Single points."""
    marker = {"color": colour(shade), "size": size, "symbol": symbol}
    return {"type": "scatter", "mode": "markers", "name": name, "x": x, "y": y, "marker": marker, **look}


def curve(
    name: str, x: Values, y: Values, shade: str = "", *, width: float = 2, dash: str = "solid", **look: Any
) -> Trace:
    """A line; without a shade in the next colour of its own."""
    line = {"width": width, "dash": dash, **({"color": colour(shade)} if shade else {})}
    return {"type": "scatter", "mode": "lines", "name": name, "x": x, "y": y, "line": line, **look}


def band(x: FloatArray, low: FloatArray, high: FloatArray) -> Trace:
    """The area between two curves."""
    return {
        "type": "scatter", "mode": "lines", "x": np.concatenate([x, x[::-1]]), "y": np.concatenate([high, low[::-1]]),
        "fill": "toself", "fillcolor": "rgba(120,140,180,0.25)", "line": {"width": 0}, "hoverinfo": "skip",
        "showlegend": False,
    }  # fmt: skip


def whiskers(values: Values, low: Values | None = None, shade: str = "") -> dict[str, Any]:
    """Error bars of these lengths; upwards `values` and downwards `low` where they differ."""
    look = {"color": colour(shade)} if shade else {}
    sides = {} if low is None else {"symmetric": False, "arrayminus": low}
    return {"type": "data", "array": values, **sides, **look}


def level(value: float, shade: str = "ink", *, dash: str = "dot", upright: bool = False) -> dict[str, Any]:
    """A line across the whole figure at a value, level or upright."""
    along, across = ("y", "x") if upright else ("x", "y")
    line = {"color": colour(shade), "dash": dash, "width": 1.5 if upright else 1}
    place = {f"{along}ref": "paper", f"{along}0": 0, f"{along}1": 1, f"{across}0": value, f"{across}1": value}
    return {"type": "line", **place, "line": line}


def chart(
    id: str,
    title: str,
    traces: Sequence[Trace],
    caption: str,
    description: str,
    *,
    x: Mapping[str, Any] | str = "",
    y: Mapping[str, Any] | str = "",
    frame: pd.DataFrame | None = None,
    levels: Sequence[Mapping[str, Any]] = (),
    height: int = 420,
    filename: str = "",
    **layout: Any,
) -> Figure:
    """A figure with one pair of axes.

    Args:
        id: of the figure.
        title: of the figure.
        traces: what is drawn.
        caption: what is to be seen.
        description: the same for a person who cannot see it.
        x: title of the axis across, or its whole description.
        y: likewise upwards.
        frame: its data in SI units, saved as CSV; the tables of the page hold them where it is None.
        levels: lines across the figure.
        height: in pixels on a wide screen.
        filename: of picture and CSV, without extension; the figure's id if empty.
        layout: further entries of the layout.
    """
    whole: dict[str, Any] = {
        key: {"title": {"text": one}} if isinstance(one, str) else one
        for key, one in (("xaxis", x), ("yaxis", y))
        if one
    }
    whole |= {"shapes": list(levels)} if levels else {}
    name = filename or id
    csv = None if frame is None else Download(f"{name}.csv", csv_text(frame))
    plot = {"data": list(traces), "layout": {**whole, **layout}}
    return Figure(id, title, plot, caption, description, csv, height=height, filename=name)


def axis(title: str, **further: Any) -> dict[str, Any]:
    """An axis with a title and further properties."""
    return {"title": {"text": title}, **further}
