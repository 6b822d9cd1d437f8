"""Study 2 of the thesis: where to identify a bipod so that errors of the applied force do little harm."""

from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.repeated import standard_deviation
from expdesign.assurance.validation.simulation import simulate
from expdesign.io.schema import Count, Number, Positive
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.elastostatics.measurements import Distribution
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.report.words import with_error
from research.studies.drawing import draw_densities, draw_map, panels
from research.studies.position_maps import (
    COORDINATES,
    MICRO,
    best_index,
    grid_assessment,
    map_frame,
    mark_best,
    plan_at,
)
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, density_rows, rows_of

DISTRIBUTIONS: tuple[Distribution, ...] = ("normal", "uniform")
TITLES = {"zeta1_um": "ζ₁ (x, µm)", "zeta2_um": "ζ₂ (y, µm)"}
DRAWN = 3
"""Positions whose densities are drawn."""


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    map_step: Count = Field(description="Every how many points of the grid are kept in `map.csv`.")
    positions: Annotated[list[Annotated[list[Number], Field(min_length=2, max_length=2)]], Field(min_length=DRAWN)] = (
        Field(description="Identification positions `[x, y]` of the Monte-Carlo in pose coordinates (m).")
    )
    density_um: Positive = Field(description="Half-width of the plotted densities (µm).")


class BipodFeir(Study):
    """Maps of ζ₁ and ζ₂ over the identification position, and Monte-Carlo of force errors."""

    title = "Study 2: errors of the applied force and the position of a bipod"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = problem_from_document(document.where("problem"))
        poses, assessment = grid_assessment(problem)
        deviations = MICRO * np.sqrt(assessment.force_variance[:, 0])
        columns: dict[str, FloatArray] = {"zeta1_um": deviations[:, 0], "zeta2_um": deviations[:, 1]}
        best = [{"criterion": name} | _at(poses, columns, best_index(name, values)) for name, values in columns.items()]
        montecarlo, density = _montecarlo(problem, settings)
        return {
            "map": StudyTable(map_frame(poses, columns, settings.map_step), digits=5),
            "best": StudyTable(pd.DataFrame(best)),
            "montecarlo": StudyTable(montecarlo),
            "density": StudyTable(density, digits=4),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        chart = tables["map"]
        figure, axes = panels(1, 2, 3.6, 3.0)
        for axis, best in zip(axes, rows_of(tables["best"])):
            values = column(chart, best.criterion)
            draw_map(axis, column(chart, "x_m"), column(chart, "y_m"), values, TITLES[best.criterion])
            mark_best(axis, best.x_m, best.y_m)
            axis.set_xlabel("x of the pose (m)")
        axes[0].set_ylabel("y of the pose (m)")
        densities, pair = panels(1, 2, 4.2, 3.0)
        table = tables["density"]
        for axis, distribution in zip(pair, DISTRIBUTIONS):
            rows = table[table["distribution"] == distribution]
            shown = rows if distribution == "normal" else rows.drop(columns="normal")
            draw_densities(axis, shown, "x attained − x wanted (µm)")
            axis.set_title(f"{distribution} force errors")
        return {"maps": figure, "densities": densities}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        best, montecarlo = rows_of(tables["best"]), tables["montecarlo"]
        return [
            Text("## Maps"),
            Text(COORDINATES),
            Picture("maps", "Standard deviations of x and y after compensation that force errors cause."),
            Shown(
                ["best for", "x (m)", "y (m)", "ζ₁ there (µm)", "ζ₂ there (µm)"],
                [
                    [TITLES[row.criterion], f"{row.x_m:.2f}", f"{row.y_m:.2f}", f"{row.zeta1_um:.4f}",
                     f"{row.zeta2_um:.4f}"]
                    for row in best
                ],
            ),
            Text("## Monte-Carlo"),
            Text(
                f"{settings.samples} repetitions at every position: the force that acts is the assumed one and an "
                "error, the legs are identified with the assumed one, and the exact compensation is solved. z is the "
                "number of standard errors between prediction and Monte-Carlo. The bound is the largest error that "
                "uniform force errors can cause, Σ_j |Z_ij|·√3·H_j, which the prediction gives as well."
            ),
            Picture("densities", "Density of the error of x at the first positions (steps), and the predicted one."),
            Shown(
                ["position", "x (m)", "y (m)", "force errors", "std of x (µm)", "ζ₁ (µm)", "z", "std of y (µm)",
                 "ζ₂ (µm)", "z", "bound of x, y (µm)"],
                [
                    [
                        str(row.position),
                        f"{row.x_m:.2f}",
                        f"{row.y_m:.2f}",
                        row.distribution,
                        with_error(row.x_um, row.x_um_se),
                        f"{row.x_um_predicted:.4f}",
                        f"{(row.x_um - row.x_um_predicted) / row.x_um_se:+.2f}",
                        with_error(row.y_um, row.y_um_se),
                        f"{row.y_um_predicted:.4f}",
                        f"{(row.y_um - row.y_um_predicted) / row.y_um_se:+.2f}",
                        f"{row.bound_x_um:.3f}, {row.bound_y_um:.3f}",
                    ]
                    for row in rows_of(montecarlo)
                ],
            ),
        ]  # fmt: skip


def _at(poses: FloatArray, columns: dict[str, FloatArray], index: int) -> dict[str, float]:
    x, y = poses[index].tolist()
    return {"x_m": x, "y_m": y} | {name: float(values[index]) for name, values in columns.items()}


def _montecarlo(problem: DesignProblem, settings: Settings) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Standard deviations of x and y for both distributions of the force error, and densities of x."""
    rows, densities = [], []
    deviation = problem.loaded.sources[0].deviation
    for index, position in enumerate(settings.positions):
        plan = plan_at(problem, np.array(position))
        for distribution in DISTRIBUTIONS:
            seed = settings.seed + index
            result = simulate(problem, plan, settings.samples, seed, noise=False, distribution=distribution)
            errors = MICRO * result.errors[:, 0]
            found = standard_deviation(errors)
            predicted = MICRO * np.sqrt(np.diag(result.predicted_covariance[0]))
            bound = MICRO * np.abs(result.assessment.force_sensitivity()[0, 0]) @ (np.sqrt(3.0) * deviation)
            row: dict[str, object] = {"position": index + 1, "x_m": position[0], "y_m": position[1]}
            row["distribution"] = distribution
            for axis, name in enumerate(("x", "y")):
                row[f"{name}_um"] = float(found.value[axis])
                row[f"{name}_um_se"] = float(found.standard_error[axis])
                row[f"{name}_um_predicted"] = float(predicted[axis])
                row[f"bound_{name}_um"] = float(bound[axis])
            rows.append(row)
            if index < DRAWN:
                name = f"{index + 1}: ({position[0]:.2f}, {position[1]:.2f})"
                density = density_rows(name, errors[:, 0], settings.density_um, float(predicted[0]))
                densities.append(density.assign(distribution=distribution))
    return pd.DataFrame(rows), pd.concat(densities, ignore_index=True)
