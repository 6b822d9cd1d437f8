"""Error ellipses at the targets, and maps of the error to expect over the workspace.

Each is data for a script (`error_ellipses.js`, `accuracy_map.js`) and a figure; the ellipses have a table as well.
"""

import base64
from itertools import combinations
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.budget import UncertaintyBudget
from expdesign.planning.accuracy_map import AccuracyMap
from expdesign.planning.criteria.error_ellipses import TargetCovariances, ellipse_scale, principal_axes
from expdesign.planning.problem import DesignProblem
from expdesign.report import words
from expdesign.report.blocks import Block, DataTable, Selector, choices
from expdesign.report.figures import axis, chart

_ELLIPSE = 0.95
"""Probability of the error to lie inside an ellipse."""

ELLIPSE_CAPTION = (
    "Principal axes of the error to expect with design {design}, as standard deviations: the largest of each part, "
    "the smallest of both together, and the direction in which the largest lies."
)


def planes(problem: DesignProblem) -> list[tuple[int, int, int]]:
    """Target and two axes of the same unit of every view."""
    pairs = [pair for block in _blocks(problem) for pair in combinations(block, 2)]
    return [(target, *pair) for target in range(len(problem.targets.weights)) for pair in pairs]


def ellipse_views(problem: DesignProblem, budget: UncertaintyBudget) -> dict[str, Any]:
    """What does not depend on the design."""
    views = []
    for target, first, second in planes(problem):
        tolerance = budget.tolerance[target, [first, second]]
        views.append(
            {
                "target": target + 1,
                "axes": [_name(budget.axes[axis]) for axis in (first, second)],
                "columns": [budget.axes[axis] for axis in (first, second)],
                "unit": words.micro_unit(budget.axes[first]),
                "tolerance": 1e6 * tolerance,
            }
        )
    return {"scale": ellipse_scale(_ELLIPSE), "views": views}


def ellipses_of(problem: DesignProblem, covariances: TargetCovariances, design: int) -> list[list[float]]:
    """Covariances (µm², µrad²) of every view: xx, xy, yy of noise, then of load errors, to five digits."""
    entries = []
    for target, i, j in planes(problem):
        parts = (covariances.noise[design, target], covariances.load[design, target])
        entries.append([float(f"{1e12 * part[place]:.4g}") for part in parts for place in ((i, i), (i, j), (j, j))])
    return entries


def ellipse_cells(
    problem: DesignProblem, covariances: TargetCovariances, axes: tuple[str, ...]
) -> list[list[list[str]]]:
    """Rows of the table of every design: per target, translations and rotations."""
    tables: list[list[list[str]]] = [[] for _ in covariances.noise]
    for target in range(len(problem.targets.weights)):
        for block in _blocks(problem):
            if len(block) < 2:
                continue
            within = np.ix_(block, block)
            noise, load, total = (
                principal_axes(part[:, target][:, within[0], within[1]])
                for part in (covariances.noise, covariances.load, covariances.total)
            )
            names = [_name(axes[axis]) for axis in block]
            for design, rows in enumerate(tables):
                largest = 1e6 * float(total[0][design, 0])
                rows.append(
                    [
                        f"target {target + 1}, {' '.join(names)}",
                        words.micro_unit(axes[block[0]]),
                        *(words.number(1e6 * float(one[0][design, 0]), scale=largest) for one in (noise, load, total)),
                        words.number(1e6 * float(total[0][design, -1]), scale=largest),
                        _direction(total[1][design, :, 0]),
                    ]
                )
    return tables


def ellipse_blocks(problem: DesignProblem, first: list[list[str]], number: str) -> list[Block]:
    """The figure with its selector, and the table."""
    names = [_name(column) for column in problem.loaded.robot.coordinates.deflection]
    options = choices(f"Target {target + 1}: {names[i]} and {names[j]}" for target, i, j in planes(problem))
    if not options:
        return []
    percent = words.given(100.0 * _ELLIPSE)
    figure = chart(
        "ellipses", "Error ellipses at the targets", [],
        f"In {percent} of 100 calibrations with this plan the error that is left at the target lies inside the ellipse "
        "(normal errors). Noise of the measurements and errors of the load have their own ellipses; their covariances "
        "add. Straight dotted lines: the tolerance, where it is near enough to be seen.",
        "Ellipses of the error in two coordinates. The table below has the principal axes of all of them.",
        x=axis("", zeroline=True), y=axis("", zeroline=True, scaleanchor="x"), height=440, filename="error-ellipses",
        showlegend=True,
    )  # fmt: skip
    table = DataTable(
        "ellipse-table",
        ELLIPSE_CAPTION.replace("{design}", number),
        ["Target, axes", "Unit", "Noise, largest σ", "Load error, largest σ", "Both, largest σ", "Both, smallest σ",
         "Direction of the largest"],
        first,
    )  # fmt: skip
    return [Selector("ellipse-view", "Show", options, step=True), figure, table]


def _blocks(problem: DesignProblem) -> tuple[list[int], list[int]]:
    """Axes in m and axes in rad."""
    coordinates = problem.loaded.robot.coordinates
    return list(range(coordinates.translations)), list(range(coordinates.translations, coordinates.n))


def _name(deflection: str) -> str:
    return words.axis(deflection).removeprefix("d")


def _direction(vector: FloatArray) -> str:
    if not np.isfinite(vector).all():
        return words.UNDETERMINED
    return f"({', '.join(words.fixed(float(value), 2) for value in vector)})"


def map_views(problem: DesignProblem, maps: list[AccuracyMap]) -> list[dict[str, Any]]:
    """What does not depend on the design: the grids, and W(X) packed so that the map is a product with C."""
    charts = []
    names = problem.loaded.robot.configuration
    for one in maps:
        columns = [words.plan_column(names[column]) for column in one.axes]
        pose = problem.targets.configurations[one.target]
        charts.append(
            {
                "target": one.target + 1,
                "columns": [names[column] for column in one.axes],
                "titles": [column.heading for column in columns],
                "factors": [column.factor for column in columns],
                "grid": [np.round(values, 9) for values in (one.across, one.up)],
                "at": pose[list(one.axes)],
                "weight": packed(one.weight, doubled=True),
            }
        )
    return charts


def packed(matrices: FloatArray, *, doubled: bool = False) -> str:
    """Upper triangles of symmetric matrices (..., p, p) as base64 of little-endian 32-bit floats.

    With `doubled`, entries off the diagonal count twice: tr(W·C) is the product of the packed W and C.
    """
    rows, columns = np.triu_indices(matrices.shape[-1])
    entries = matrices[..., rows, columns] * np.where((rows != columns) & doubled, 2.0, 1.0)
    # Bits of the mantissa that no map shows would only make the page larger.
    kept = entries.astype("<f4").view("<u4") & np.uint32(0xFFFFF800)
    return base64.b64encode(kept.astype("<u4").tobytes()).decode("ascii")


def map_blocks(problem: DesignProblem, maps: list[AccuracyMap]) -> list[Block]:
    """The figure with its selector; nothing where no coordinate varies."""
    if not maps:
        return []
    names = problem.loaded.robot.configuration
    titles = [words.plan_column(name).title for name in names]
    texts = (f"About target {one.target + 1}: {' and '.join(titles[column] for column in one.axes)}" for one in maps)
    figure = chart(
        "map", "Accuracy to expect over the workspace", [],
        "RMS error that is left after calibration with this plan, in tolerances, if the target with its load and its "
        "tolerances stood elsewhere; its other coordinates stay as they are. Dots: where the plan measures, seen in "
        "this plane. Blank: out of the robot's reach, or nearly singular.",
        "Map of the expected error over two coordinates; the data can be saved as CSV.",
        x=axis(""), y=axis(""), height=440, filename="accuracy-map", showlegend=True,
    )  # fmt: skip
    return [Selector("map-view", "Show", choices(texts), step=True), figure]
