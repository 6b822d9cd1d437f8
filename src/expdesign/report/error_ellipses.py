"""Error ellipses at the targets: data for `error_ellipses.js`, the figure and the table."""

from itertools import combinations
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.error_ellipses import TargetCovariances, ellipse_scale, principal_axes
from expdesign.planning.problem import DesignProblem
from expdesign.report import words
from expdesign.report.blocks import Block, DataTable, Option, Selector
from expdesign.report.error_budget import ErrorBudget
from expdesign.report.figures import axis, chart

PROBABILITY = 0.95
"""Of the error to lie inside an ellipse."""
CAPTION = (
    "Principal axes of the error to expect with design {design}, as standard deviations: the largest of each part, "
    "the smallest of both together, and the direction in which the largest lies."
)


def planes(problem: DesignProblem) -> list[tuple[int, int, int]]:
    """Target and two axes of the same unit of every view."""
    pairs = [pair for block in _blocks(problem) for pair in combinations(block, 2)]
    return [(target, *pair) for target in range(len(problem.targets.weights)) for pair in pairs]


def view_data(problem: DesignProblem, budget: ErrorBudget) -> dict[str, Any]:
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
    return {"scale": ellipse_scale(PROBABILITY), "views": views}


def of_design(problem: DesignProblem, covariances: TargetCovariances, design: int) -> list[list[float]]:
    """Covariances (µm², µrad²) of every view: xx, xy, yy of noise, then of load errors, to five digits."""
    entries = []
    for target, i, j in planes(problem):
        parts = (covariances.noise[design, target], covariances.load[design, target])
        entries.append([float(f"{1e12 * part[place]:.4g}") for part in parts for place in ((i, i), (i, j), (j, j))])
    return entries


def cells(problem: DesignProblem, covariances: TargetCovariances, budget: ErrorBudget) -> list[list[list[str]]]:
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
            names = [_name(budget.axes[axis]) for axis in block]
            for design, rows in enumerate(tables):
                largest = 1e6 * float(total[0][design, 0])
                rows.append(
                    [
                        f"target {target + 1}, {' '.join(names)}",
                        words.micro_unit(budget.axes[block[0]]),
                        *(words.number(1e6 * float(one[0][design, 0]), scale=largest) for one in (noise, load, total)),
                        words.number(1e6 * float(total[0][design, -1]), scale=largest),
                        _direction(total[1][design, :, 0]),
                    ]
                )
    return tables


def ellipse_blocks(problem: DesignProblem, first: list[list[str]], number: str) -> list[Block]:
    """The figure with its selector, and the table."""
    options = []
    for index, (target, i, j) in enumerate(planes(problem)):
        names = [_name(problem.loaded.robot.coordinates.deflection[column]) for column in (i, j)]
        options.append(Option(str(index), f"Target {target + 1}: {names[0]} and {names[1]}", index == 0))
    if not options:
        return []
    percent = words.given(100.0 * PROBABILITY)
    figure = chart(
        "ellipses", "Error ellipses at the targets", [],
        f"In {percent} of 100 calibrations with this plan the error that is left at the target lies inside the ellipse "
        "(normal errors). Noise of the measurements and errors of the load have their own ellipses; their covariances "
        "add. Dotted: the tolerance, where it is near enough to be seen.",
        "Ellipses of the error in two coordinates. The table below has the principal axes of all of them.",
        x=axis("", zeroline=True), y=axis("", zeroline=True, scaleanchor="x"), height=440, filename="error-ellipses",
        showlegend=True,
    )  # fmt: skip
    table = DataTable(
        "ellipse-table",
        CAPTION.replace("{design}", number),
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
