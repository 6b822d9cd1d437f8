"""Appendices E and F of the thesis: RMS of the attained error against the square root of the trace."""

from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.assurance.validation.repeated import root_mean_square
from expdesign.assurance.validation.simulation import Simulation, simulate
from expdesign.io.schema import Count, Positive
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.elastostatics.measurements import Distribution
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.sampling import starting_designs
from expdesign.report.words import with_error
from research.studies.drawing import COLOURS, panels
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, density_rows, rows_of

CAUSES: dict[str, tuple[bool, bool, Distribution]] = {
    "noise": (True, False, "normal"),
    "normal load errors": (False, True, "normal"),
    "uniform load errors": (False, True, "uniform"),
}
PARTS = {"translation": (slice(0, 3), "µm"), "rotation": (slice(3, 6), "µrad")}
MICRO = 1e6


class Settings(StudySection):
    """Configuration of the study."""

    configuration: str = Field(description="Run configuration of the study; the path is relative to this file.")
    plans: Count = Field(description="Number of random plans.")
    density_um: Positive = Field(
        description="Upper end of the plotted densities of the length of the translation (µm)."
    )


class ErrorRms(Study):
    """RMS of the length of the attained translation and rotation, for random plans."""

    title = "Appendices E and F: RMS of the error against the square root of the trace"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = replace(read_problem(document.folder / settings.configuration), estimator="weighted")
        rows, densities = [], []
        for number, plan in enumerate(_plans(problem, settings)):
            for cause, (noise, load_errors, distribution) in CAUSES.items():
                result = simulate(
                    problem,
                    plan,
                    settings.samples,
                    settings.seed + number,
                    noise=noise,
                    load_errors=load_errors,
                    distribution=distribution,
                )
                rows += _rows(number + 1, cause, result)
                if number == 0:
                    lengths = MICRO * np.linalg.norm(result.errors[:, 0, :3], axis=1)
                    densities.append(density_rows(cause, lengths, settings.density_um, low=0.0))
        return {
            "rms": StudyTable(pd.DataFrame(rows)),
            "density": StudyTable(pd.concat(densities, ignore_index=True), digits=4),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        table = tables["rms"]
        figure, (ratios, densities) = panels(1, 2, 4.4, 3.2)
        for index, (cause, rows) in enumerate(table.groupby("cause", sort=False)):
            predicted = column(rows, "rms_predicted")
            place = np.arange(len(rows)) + 0.2 * (index - 1)
            bars = 3.0 * column(rows, "rms_se") / predicted
            ratio = column(rows, "rms") / predicted
            ratios.errorbar(place, ratio, yerr=bars, fmt="o", markersize=3, color=COLOURS[index], label=str(cause))
        ratios.axhline(1.0, color="#475569", linewidth=0.8)
        ratios.set_xlabel("plan and part (translation, rotation)")
        ratios.set_ylabel("RMS / √(trace), bars: three standard errors")
        for index, (cause, rows) in enumerate(tables["density"].groupby("series", sort=False)):
            densities.step(rows["centre"], rows["density"], where="mid", color=COLOURS[index], label=str(cause))
            first = table[(table["cause"] == cause) & (table["part"] == "translation")].iloc[0]
            densities.axvline(first["rms_predicted"], color=COLOURS[index], linestyle=(0, (4, 2)), linewidth=0.9)
        densities.set_xlabel("length of the translation error (µm)")
        densities.set_ylabel("density")
        densities.set_ylim(bottom=0.0)
        densities.legend(fontsize=7)
        densities.set_title("first plan; dashed: √(trace)")
        return {"rms": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        table = tables["rms"]
        score = (column(table, "rms") - column(table, "rms_predicted")) / column(table, "rms_se")
        return [
            Text("## Identity"),
            Text(
                "E‖e‖² = tr Cov(e) + ‖E e‖², and E e = 0: the RMS of the length of the translation is √tr(tU) for "
                "measurement noise, and √tr(tZ·Σ_F·tZᵀ) for load errors, and likewise for the rotation. Nothing in it "
                "asks for a normal distribution."
            ),
            Picture("rms", "Monte-Carlo against the square root of the trace, and the densities behind it."),
            Text(
                f"{settings.samples} repetitions each, with the exact compensation at the target. All {len(table)} "
                f"lie within {np.abs(score).max():.2f} standard errors of the prediction."
            ),
            Shown(
                ["plan", "cause", "part", "RMS", "√(trace)", "z"],
                [
                    [
                        str(row.plan),
                        row.cause,
                        f"{row.part} ({PARTS[row.part][1]})",
                        with_error(row.rms, row.rms_se),
                        f"{row.rms_predicted:.4f}",
                        f"{(row.rms - row.rms_predicted) / row.rms_se:+.2f}",
                    ]
                    for row in rows_of(table)
                ],
            ),
        ]


def _plans(problem: DesignProblem, settings: Settings) -> list[Plan]:
    """Plans drawn at random; which ones depends on the configuration alone, not on the seed of the samples."""
    decisions = starting_designs(problem, settings.plans, np.random.default_rng(0))
    poses, loads = problem.space.decode(decisions)
    series = np.arange(1, problem.space.measurements + 1)
    return [Plan(*pair, series) for pair in zip(poses, loads)]


def _rows(number: int, cause: str, result: Simulation) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    for part, (axes, _) in PARTS.items():
        lengths = MICRO * np.linalg.norm(result.errors[:, 0, axes], axis=1)
        found = root_mean_square(lengths)
        trace = np.trace(result.predicted_covariance[0, axes, axes])
        row: dict[str, object] = {"plan": number, "cause": cause, "part": part, "rms": float(found.value)}
        rows.append(row | {"rms_se": float(found.standard_error), "rms_predicted": MICRO * float(np.sqrt(trace))})
    return rows
