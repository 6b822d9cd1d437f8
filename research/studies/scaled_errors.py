"""Appendix B of the thesis: what scaling by G_U and by G_C makes of correlated measurement errors."""

from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from scipy.linalg import block_diag
from scipy.stats import norm

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.validation.repeated import standard_deviation
from expdesign.io.schema import Count, Number
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.deflection_noise import reference_whitener
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.report.words import axis as axis_name
from expdesign.report.words import with_error
from research.studies.drawing import COLOURS, panels
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, density_rows, rows_of

SCALINGS = {"G_U": "standard deviations alone (G_U)", "G_C": "whole covariance (G_C)"}

Pose = Annotated[list[Number], Field(min_length=6, max_length=6)]


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    poses: Annotated[list[Pose], Field(min_length=1)] = Field(description="Poses of the measurements (m, rad).")
    series: Annotated[list[Count], Field(min_length=1)] = Field(description="Series number of each measurement.")


class ScaledErrors(Study):
    """Variances and correlations of measurement errors before and after scaling."""

    title = "Appendix B: scaled measurement errors are uncorrelated and of equal variance"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = problem_from_document(document.where("problem"))
        poses, series = np.array(settings.poses, dtype=float), np.array(settings.series)
        errors, covariance = _errors(problem, poses, series, settings)
        names = [
            f"{axis_name(name)} {row + 1}"
            for row in range(len(series))
            for name in problem.loaded.robot.coordinates.deflection
        ]
        scalings = {"G_U": np.diag(1.0 / np.sqrt(np.diag(covariance))), "G_C": _whitener(problem, poses, series)}
        deviations, correlations, densities = [], [], []
        for name, scaling in scalings.items():
            scaled = errors @ scaling.T
            expected = scaling @ covariance @ scaling.T
            deviations.append(_deviations(name, names, scaled, expected))
            correlations.append(_correlations(name, names, scaled, expected))
            for index in range(6):
                rows = density_rows(f"{name} {names[index]}", scaled[:, index], 4.0, 1.0)
                densities.append(rows.assign(scaling=name))
        return {
            "deviations": StudyTable(pd.concat(deviations, ignore_index=True)),
            "correlations": StudyTable(pd.concat(correlations, ignore_index=True), digits=5),
            "density": StudyTable(pd.concat(densities, ignore_index=True), digits=4),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        correlations, density = tables["correlations"], tables["density"]
        figure, axes = panels(1, 3, 3.3, 3.0)
        for axis, (scaling, title) in zip(axes, SCALINGS.items()):
            rows = correlations[correlations["scaling"] == scaling]
            names = list(dict.fromkeys([*rows["first"], *rows["second"]]))
            matrix = np.eye(len(names))
            for row in rows_of(rows):
                i, j = names.index(row.first), names.index(row.second)
                matrix[i, j] = matrix[j, i] = row.correlation
            image = axis.imshow(matrix, vmin=-1.0, vmax=1.0, cmap="RdBu_r", interpolation="none")
            axis.set_title(title)
            axis.set_xlabel("scaled component")
        axes[0].set_ylabel("scaled component")
        figure.colorbar(image, ax=axes[:2], shrink=0.8, label="correlation in the Monte-Carlo")
        shown = density[density["scaling"] == "G_C"]
        for index, (_, rows) in enumerate(shown.groupby("series", sort=False)):
            axes[2].step(rows["centre"], rows["density"], where="mid", color=COLOURS[index], linewidth=0.9)
        axes[2].plot(rows["centre"], rows["normal"], color="#000000", linewidth=0.9, linestyle=(0, (4, 2)))
        axes[2].set_title("six components by G_C")
        axes[2].set_xlabel("scaled error")
        axes[2].set_ylim(bottom=0.0)
        return {"correlations": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        deviations, correlations = tables["deviations"], tables["correlations"]
        largest = {
            scaling: float(np.abs(column(rows, "correlation_expected")).max())
            for scaling, rows in correlations.groupby("scaling")
        }
        seen = {
            scaling: float(np.abs(column(rows, "correlation")).max())
            for scaling, rows in correlations.groupby("scaling")
        }
        score = (column(correlations, "correlation") - column(correlations, "correlation_expected")) / column(
            correlations, "correlation_se"
        )
        return [
            Text("## Proof in numbers"),
            Text(
                "With V = S·Sᵀ the scaled errors S⁻¹·ε have covariance S⁻¹·S·Sᵀ·S⁻ᵀ = I: equal variances, no "
                "correlation, no unit. Division by the standard deviations alone (G_U) makes the variances equal, and "
                "leaves the correlations. Independence, beyond correlation, needs normal errors."
            ),
            Picture("correlations", "Correlations of all scaled components, and densities of those of the first row."),
            Text(
                f"Of {len(correlations) // 2} pairs of components the largest correlation is {largest['G_U']:.3f} "
                f"with G_U, and 0 with G_C (predicted; in {settings.samples} draws no pair exceeds "
                f"{seen['G_C']:.4f}). The {len(score)} correlations lie within {np.abs(score).max():.2f} standard "
                "errors of the prediction; for the largest of so many, "
                f"{corrected_limit(len(score)):.2f} has the same chance as three has for one."
            ),
            Shown(
                ["component, measurement", "std with G_C", "predicted", "z", "share within ±1", "predicted", "z"],
                [
                    [
                        row.component,
                        with_error(row.std, row.std_se),
                        f"{row.std_predicted:.4f}",
                        f"{(row.std - row.std_predicted) / row.std_se:+.2f}",
                        with_error(row.within_one, row.within_one_se),
                        f"{row.within_one_predicted:.4f}",
                        f"{(row.within_one - row.within_one_predicted) / row.within_one_se:+.2f}",
                    ]
                    for row in rows_of(deviations[deviations["scaling"] == "G_C"])
                ],
            ),
        ]


def corrected_limit(comparisons: int) -> float:
    """The number of standard errors that the largest of many normal scores exceeds as rarely as one exceeds three."""
    return float(norm.isf(0.5 * (1.0 - (1.0 - 2.0 * norm.sf(3.0)) ** (1.0 / comparisons))))


def _errors(
    problem: DesignProblem, poses: FloatArray, series: IntArray, settings: Settings
) -> tuple[FloatArray, FloatArray]:
    """Errors (s, 6m) of the deflections of the plan, and their covariance (6m, 6m)."""
    pose_map = problem.loaded.robot.jacobians(poses).pose
    generator = np.random.default_rng(settings.seed)
    drawn = problem.noise.drawn(series, settings.samples, generator, pose_map)
    root = np.linalg.inv(_whitener(problem, poses, series))
    return drawn.reshape(settings.samples, -1), root @ root.T


def _whitener(problem: DesignProblem, poses: FloatArray, series: IntArray) -> FloatArray:
    """G_C of all measurements together (6m, 6m): across those that share a reference, and within each."""
    within = problem.noise.whitener_at(problem.loaded.robot.jacobians(poses).pose)
    blocks = np.broadcast_to(within, (len(poses), *within.shape[-2:]))
    across = np.kron(reference_whitener(series), np.eye(within.shape[-1]))
    whitener: FloatArray = across @ block_diag(*blocks)
    return whitener


def _deviations(scaling: str, names: list[str], scaled: FloatArray, expected: FloatArray) -> pd.DataFrame:
    """Standard deviation of every scaled component, and its share within one (0.6827 for a normal one)."""
    found = standard_deviation(scaled)
    share = (np.abs(scaled) < 1.0).mean(axis=0)
    return pd.DataFrame(
        {
            "scaling": scaling,
            "component": names,
            "std": found.value,
            "std_se": found.standard_error,
            "std_predicted": np.sqrt(np.diag(expected)),
            "within_one": share,
            "within_one_se": np.sqrt(share * (1.0 - share) / len(scaled)),
            "within_one_predicted": 0.682689492,
        }
    )


def _correlations(scaling: str, names: list[str], scaled: FloatArray, expected: FloatArray) -> pd.DataFrame:
    """Correlation of every pair of scaled components; its standard error is (1 − ρ²)/√N."""
    found = np.asarray(np.corrcoef(scaled.T))
    deviation = np.sqrt(np.diag(expected))
    predicted = expected / np.outer(deviation, deviation)
    first, second = np.triu_indices(len(names), 1)
    return pd.DataFrame(
        {
            "scaling": scaling,
            "first": [names[i] for i in first],
            "second": [names[j] for j in second],
            "correlation": found[first, second],
            "correlation_se": (1.0 - found[first, second] ** 2) / np.sqrt(len(scaled)),
            "correlation_expected": np.where(np.abs(predicted) < 1e-9, 0.0, predicted)[first, second],
        }
    )
