"""Appendix D: the centre of mass of a payload of 120 kg is not where it is assumed."""

from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.simulation import simulate
from expdesign.io.schema import Number, Positive
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from research.studies.drawing import draw_densities, panels
from research.studies.pose_errors import AXES, MICRO, deviation_frame, deviation_table, plan_of
from research.studies.study import Picture, Piece, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import density_rows, rows_of

MILLI = 1e3
"""mm in a metre."""


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    plan: Annotated[list[list[Number]], Field(min_length=1)] = Field(
        description="Measurements: pose (m, rad), mass (kg), centre of mass (m)."
    )
    density_mm: Positive = Field(description="Half-width of the plotted densities of the centre of mass (mm).")
    density_deviations: Positive = Field(
        description="Half-width of the plotted densities of the error, in standard deviations."
    )


class CentreOfMass(Study):
    """Densities of the errors of the centre of mass, and of what they leave after compensation."""

    title = "Appendix D: an error of the centre of mass of 120 kg"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = problem_from_document(document.where("problem"))
        plan = plan_of(problem, settings.plan)
        frames, outputs = [], []
        for name in ("normal", "uniform"):
            result = simulate(problem, plan, settings.samples, settings.seed, noise=False, distribution=name)
            covariance = result.predicted_covariance[0]
            frames.append(deviation_frame({"distribution": name}, result.errors[:, 0], covariance))
            for axis, label in enumerate(AXES):
                deviation = MICRO * float(np.sqrt(covariance[axis, axis]))
                half = deviation * settings.density_deviations
                rows = density_rows(label, MICRO * result.errors[:, 0, axis], half, deviation)
                rows.insert(0, "distribution", name)
                outputs.append(rows)
        return {
            "residual": StudyTable(pd.concat(frames, ignore_index=True)),
            "uncompensated": StudyTable(_uncompensated(problem)),
            "input": StudyTable(_inputs(problem, settings), digits=4),
            "output": StudyTable(pd.concat(outputs, ignore_index=True), digits=4),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        given, (axis,) = panels(1, 1, 4.2, 2.8)
        draw_densities(axis, tables["input"], "error of the centre of mass along x, y or z (mm)")
        found, axes = panels(2, 3, 3.0, 2.4)
        for place, label in zip(axes, AXES):
            rows = tables["output"][tables["output"]["series"] == label]
            shown = rows.assign(series=rows["distribution"])
            draw_densities(place, shown, f"error along {label}")
        return {"input": given, "output": found}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        size = float(np.linalg.norm([row.deflection for row in rows_of(tables["uncompensated"])[:3]]))
        normal = tables["residual"][tables["residual"]["distribution"] == "normal"]["std_predicted"].to_numpy()
        return [
            Text("## What goes in"),
            Text(
                f"In each of {settings.samples} repetitions one error of the centre of mass, the same for all "
                "measurements, is drawn: normal, or uniform with the same standard deviation. There is no noise."
            ),
            Picture("input", "Density of the error of the centre of mass along one axis."),
            Text("## What comes out"),
            Text(
                "All legs are identified with the assumed centre of mass, the exact compensation is solved and the "
                f"attained pose compared with the wanted one. Without compensation the target deflects by {size:.2f} "
                f"µm; what is left has standard deviations of {_listed(normal[:3])} µm and {_listed(normal[3:])} µrad: "
                "rotations suffer most. The prediction is √(Z·L·Σ_δ·Lᵀ·Zᵀ)_ii, whatever the distribution."
            ),
            Picture(
                "output", "Density of the attained error along each axis (steps), and the predicted normal (dashed)."
            ),
            deviation_table(tables["residual"], {"distribution": "distribution", "axis": "axis"}),
        ]


def _listed(values: FloatArray) -> str:
    return ", ".join(f"{value:.3f}" for value in values)


def _uncompensated(problem: DesignProblem) -> pd.DataFrame:
    deflection = MICRO * problem.targets.observation[0] @ problem.loaded.robot.compliance
    return pd.DataFrame({"axis": AXES, "deflection": deflection})


def _inputs(problem: DesignProblem, settings: Settings) -> pd.DataFrame:
    """Densities of δ along the first axis, as the simulation draws it."""
    deviation = MILLI * float(problem.loaded.sources[0].deviation[0])
    generator = np.random.default_rng([settings.seed, 9])
    samples = {
        "normal": deviation * generator.standard_normal(settings.samples),
        "uniform": deviation * generator.uniform(-np.sqrt(3.0), np.sqrt(3.0), settings.samples),
    }
    return pd.concat([density_rows(name, drawn, settings.density_mm) for name, drawn in samples.items()])
