"""Maps of the error to expect over the workspace: data for `accuracy_map.js`, and the figure."""

import base64
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.accuracy_map import AccuracyMap
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.problem import DesignProblem
from expdesign.report import words
from expdesign.report.blocks import Block, Option, Selector
from expdesign.report.figures import axis, chart


def view_data(problem: DesignProblem, maps: list[AccuracyMap]) -> list[dict[str, Any]]:
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
                "titles": [f"{column.title} ({column.unit})" for column in columns],
                "factors": [column.factor for column in columns],
                "grid": [np.round(values, 9) for values in (one.across, one.up)],
                "at": pose[list(one.axes)],
                "weight": packed(one.weight, doubled=True),
            }
        )
    return charts


def of_designs(assessment: Assessment) -> list[str]:
    """The covariance of the compliances of every design, packed."""
    noise, load = assessment.parameter_covariance
    return [packed(covariance) for covariance in noise + load]


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
    options = []
    for index, one in enumerate(maps):
        first, second = (words.plan_column(names[column]).title for column in one.axes)
        text = f"About target {one.target + 1}: {first} and {second}"
        options.append(Option(str(index), text, index == 0))
    figure = chart(
        "map", "Accuracy to expect over the workspace", [],
        "RMS error that is left after calibration with this plan, in tolerances, if the target with its load and its "
        "tolerances stood elsewhere; its other coordinates stay as they are. Dots: where the plan measures, seen in "
        "this plane. Blank: out of the robot's reach, or nearly singular.",
        "Map of the expected error over two coordinates; the data can be saved as CSV.",
        x=axis(""), y=axis(""), height=440, filename="accuracy-map", showlegend=True,
    )  # fmt: skip
    return [Selector("map-view", "Show", options, step=True), figure]
