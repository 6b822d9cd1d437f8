"""Figures that all studies share: one look, and SVG text that is the same every time."""

import io
import re
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from expdesign.arrays import FloatArray

COLOURS = ("#0b66c3", "#c2410c", "#15803d", "#7e22ce", "#a16207", "#0e7490", "#be185d", "#475569")
"""Colours of series, in order; distinguishable on white and with colour-vision deficiencies."""
MAP = "viridis"
_PATH = re.compile(r' d="[^"]*"')
_DECIMALS = re.compile(r"-?\d+\.\d+")
_STYLE: dict[Any, Any] = {
    "svg.hashsalt": "expdesign",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.grid": False,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "path.simplify": True,
    "path.simplify_threshold": 0.3,
}


def panels(rows: int, columns: int, width: float = 3.2, height: float = 2.6) -> tuple[Figure, list[Axes]]:
    """A figure of equal panels, in reading order; sizes in inches for each panel."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(columns * width, rows * height), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False)
    for axis in axes.ravel():
        axis.spines[["top", "right"]].set_visible(False)
    return figure, list(axes.ravel())


def svg_text(figure: Figure) -> str:
    """The figure as SVG: no date, no random identifiers, text as text."""
    stream = io.StringIO()
    with mpl.rc_context(_STYLE):
        figure.savefig(stream, format="svg", metadata={"Date": None})
    text = _PATH.sub(lambda match: _DECIMALS.sub(_shortened, match.group()), stream.getvalue())
    return "\n".join(line.strip() for line in text.splitlines()) + "\n"


def _shortened(match: re.Match[str]) -> str:
    """A coordinate rounded to a twentieth of a point, which is not visible."""
    return f"{float(match.group()):.1f}"


def draw_map(axis: Axes, x: FloatArray, y: FloatArray, values: FloatArray, title: str, lines: int = 5) -> None:
    """Colours and contour lines of values at points of a regular grid, given in any order; NaN is left blank.

    The colours are an image of one pixel per point: filled contours would be many times heavier.
    """
    across, along = np.unique(x), np.unique(y)
    grid = np.full((len(along), len(across)), np.nan)
    grid[np.searchsorted(along, y), np.searchsorted(across, x)] = values
    half_x, half_y = (across[1] - across[0]) / 2.0, (along[1] - along[0]) / 2.0
    extent = (across[0] - half_x, across[-1] + half_x, along[0] - half_y, along[-1] + half_y)
    image = axis.imshow(grid, extent=extent, origin="lower", cmap=MAP, interpolation="none")
    axis.contour(across, along, grid, levels=lines, colors="white", linewidths=0.5)
    bar = axis.figure.colorbar(image, ax=axis, shrink=0.9)
    bar.ax.tick_params(labelsize=7)
    axis.locator_params(nbins=4)
    axis.set_title(title)


def draw_densities(axis: Axes, table: pd.DataFrame, label: str) -> None:
    """Densities by series (steps) and, where the table has them, the predicted normal densities (dashed)."""
    for index, (name, rows) in enumerate(table.groupby("series", sort=False)):
        colour = COLOURS[index % len(COLOURS)]
        axis.step(rows["centre"], rows["density"], where="mid", color=colour, label=str(name), linewidth=1.2)
        if "normal" in rows:
            axis.plot(rows["centre"], rows["normal"], color=colour, linewidth=0.8, linestyle=(0, (4, 2)))
    axis.set_ylim(bottom=0.0)
    axis.set_xlabel(label)
    axis.set_ylabel("density")
    axis.legend(fontsize=7)
