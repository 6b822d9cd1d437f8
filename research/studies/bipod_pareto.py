"""Study 3 of the thesis: measurement noise against force errors, by an exhaustive grid and by NSGA-II."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.validation.repeated import mean, standard_deviation
from expdesign.assurance.validation.simulation import simulate
from expdesign.io.schema import Count, Positive
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.front import knee, non_dominated
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.search import search
from expdesign.report.words import with_error
from research.studies.drawing import COLOURS, panels
from research.studies.error_norm import planar_norm_moments
from research.studies.position_maps import COORDINATES, MICRO, best_index, grid_assessment, plan_at
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, density_rows, rows_of

CRITERIA = ("duir", "feir", "total", "o1", "o2", "o3", "o4", "o5", "o_tp")
TITLES = {
    "duir": "DUIR",
    "feir": "FEIR",
    "total": "least total",
    "compromise": "compromise of the scaled front",
    "o_tp": "O_TP = O_MV",
} | {f"o{i}": f"O{i}" for i in range(1, 6)}
DRAWN = ("duir", "feir", "compromise", "total", "o2")


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    grid_points: Count = Field(description="Points of the exhaustive grid per axis.")
    density_um: Positive = Field(description="Upper end of the plotted densities of the length of the error (µm).")


class BipodPareto(Study):
    """Fronts of DUIR against FEIR by two searches, and Monte-Carlo at the best position of every criterion."""

    title = "Study 3: measurement noise and force errors at once, the Pareto front of a bipod"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = problem_from_document(document.where("problem"))
        poses, assessment = grid_assessment(problem, settings.grid_points)
        values = {name: known_criteria()[name].values(assessment) for name in CRITERIA}
        pairs = np.stack([values["duir"], values["feir"]], axis=1)
        front = non_dominated(pairs)
        front = front[np.argsort(pairs[front, 0], kind="stable")]
        found = search(problem)
        genetic = np.stack([found.criteria["duir"], found.criteria["feir"]], axis=1)
        places = {name: best_index(name, values[name]) for name in CRITERIA}
        places["compromise"] = int(front[knee(pairs[front])])
        montecarlo, density = _montecarlo(problem, settings, poses, pairs, places)
        return {
            "front": StudyTable(_front_frame(poses, pairs, front)),
            "front-nsga2": StudyTable(_levels(pairs[front], genetic), digits=3),
            "agreement": StudyTable(_agreement(pairs, front, genetic, settings.grid_points), digits=2),
            "montecarlo": StudyTable(montecarlo),
            "density": StudyTable(density, digits=4),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        front, levels, best = tables["front"], tables["front-nsga2"], tables["montecarlo"]
        figure, (objective, scaled, position) = panels(1, 3, 3.4, 3.1)
        x, y = column(front, "duir"), column(front, "feir")
        objective.plot(x, y, ".", color=COLOURS[0], markersize=4, label="exhaustive grid")
        objective.plot(
            column(levels, "duir"),
            column(levels, "feir"),
            color=COLOURS[1],
            linewidth=1,
            label="NSGA-II",
            drawstyle="steps-post",
        )
        scaled.plot(column(front, "duir_scaled"), column(front, "feir_scaled"), ".", color=COLOURS[0], markersize=4)
        position.plot(column(front, "x_m"), column(front, "y_m"), ".", color=COLOURS[0], markersize=4)
        rows = {row.best_by: row for row in rows_of(best)}
        for name, marker, colour in (("compromise", "D", COLOURS[3]), ("total", "*", COLOURS[2])):
            row = rows[name]
            style: dict[str, Any] = {"marker": marker, "color": colour, "linestyle": "none", "markersize": 9}
            objective.plot(row.duir, row.feir, label=TITLES[name], **style)
            position.plot(row.x_m, row.y_m, **style)
            scaled.plot((row.duir - x.min()) / np.ptp(x), (row.feir - y.min()) / np.ptp(y), **style)
        _label(objective, "DUIR (µm)", "FEIR (µm)", "front")
        objective.legend(fontsize=7)
        _label(scaled, "DUIR, scaled", "FEIR, scaled", "scaled front")
        _label(position, "x of the pose (m)", "y of the pose (m)", "positions on the front")
        densities, (axis,) = panels(1, 1, 5.4, 3.2)
        for index, name in enumerate(DRAWN):
            shown = tables["density"][tables["density"]["series"] == name]
            axis.step(shown["centre"], shown["density"], where="mid", color=COLOURS[index], label=TITLES[name])
        _label(axis, "length of the error (µm)", "density", "identified at the best position by")
        axis.set_ylim(bottom=0.0)
        axis.legend(fontsize=7)
        return {"front": figure, "densities": densities}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        agreement = rows_of(tables["agreement"])[0]
        totals = {row.best_by: float(np.hypot(row.duir, row.feir)) for row in rows_of(tables["montecarlo"])}
        front = column(tables["front"], "feir")
        jump = int(np.argmin(np.diff(front)))
        return [
            Text("## Front"),
            Text(
                f"The exhaustive grid ({settings.grid_points} × {settings.grid_points} positions) has "
                f"{len(tables['front'])} designs on its front. Moving a position on it by one step of the grid changes "
                f"a criterion by up to {agreement.grid_step_um:g} µm. NSGA-II's front, which is not bound to the grid, "
                f"would have to be shifted by {agreement.nsga2_behind_um:g} µm to be nowhere behind the grid's, and "
                f"the grid's by {agreement.grid_behind_um:g} µm to be nowhere behind NSGA-II's: both are within the "
                "step."
            ),
            Text(
                f"The front jumps: FEIR falls from {front[jump]:.3f} to {front[jump + 1]:.3f} µm where the best "
                "position moves from the upper to the lower edge of the workspace. The compromise of the scaled front "
                "depends on where the front ends and knows nothing of this: its total error is "
                f"{totals['compromise']:.3f} µm, while the least total is {totals['total']:.3f} µm."
            ),
            Picture("front", "The front by both searches, the same scaled, and where its positions lie."),
            Text("## Best positions, and what they attain"),
            Text(
                f"{COORDINATES} {settings.samples} repetitions at each position with noise and force errors. The "
                "length of the error in the plane is predicted from the eigenvalues of its covariance (mean: complete "
                "elliptic integral); z is the number of standard errors between Monte-Carlo and prediction."
            ),
            Picture("densities", "Density of the length of the error in the plane, identified at the best positions."),
            Shown(
                ["best by", "x (m)", "y (m)", "DUIR (µm)", "FEIR (µm)", "std of x (µm)", "predicted", "z",
                 "mean length (µm)", "predicted", "z", "std of the length (µm)", "predicted", "z"],
                [
                    [TITLES[row.best_by], f"{row.x_m:.2f}", f"{row.y_m:.2f}", f"{row.duir:.4f}", f"{row.feir:.4f}"]
                    + [text for name in ("std_x_um", "mean_um", "std_um") for text in _compared(row, name)]
                    for row in rows_of(tables["montecarlo"])
                ],
            ),
        ]  # fmt: skip


def _label(axis: Axes, x: str, y: str, title: str) -> None:
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    axis.set_title(title)


def _compared(row: object, name: str) -> list[str]:
    value, error, predicted = (float(getattr(row, f"{name}{end}")) for end in ("", "_se", "_predicted"))
    return [with_error(value, error), f"{predicted:.4f}", f"{(value - predicted) / error:+.2f}"]


def _front_frame(poses: FloatArray, pairs: FloatArray, front: IntArray) -> pd.DataFrame:
    values = pairs[front]
    scaled = (values - values.min(axis=0)) / np.ptp(values, axis=0)
    columns = np.concatenate([poses[front].round(9), values, scaled], axis=1)
    return pd.DataFrame(columns, columns=["x_m", "y_m", "duir", "feir", "duir_scaled", "feir_scaled"])


def _levels(grid: FloatArray, genetic: FloatArray) -> pd.DataFrame:
    """Least FEIR that NSGA-II attains with at most the DUIR of each design of the grid's front (where it has one)."""
    allowed = genetic[None, :, 0] <= grid[:, None, 0] * (1.0 + 1e-9)
    least = np.where(allowed, genetic[None, :, 1], np.inf).min(axis=1)
    frame = pd.DataFrame({"duir": grid[:, 0], "feir": least})
    return frame[np.isfinite(least)].iloc[::2].reset_index(drop=True)


def _agreement(pairs: FloatArray, front: IntArray, genetic: FloatArray, points: int) -> pd.DataFrame:
    """Additive ε-indicators between the fronts, and how much one step of the grid changes a criterion on the front."""
    grid = pairs.reshape(points, points, 2)
    rows, columns = np.divmod(front, points)
    change = 0.0
    for step in (-1, 1):
        for across, along in ((step, 0), (0, step)):
            there = grid[np.clip(rows + across, 0, points - 1), np.clip(columns + along, 0, points - 1)]
            change = max(change, float(np.abs(there - pairs[front]).max()))
    return pd.DataFrame(
        {
            "grid_step_um": [change],
            "nsga2_behind_um": [behind(genetic, pairs[front])],
            "grid_behind_um": [behind(pairs[front], genetic)],
        }
    )


def behind(front: FloatArray, other: FloatArray) -> float:
    """Least shift of `front` (a, 2) after which every point of `other` (b, 2) is weakly dominated by one of it."""
    return float((front[None] - other[:, None]).max(axis=-1).min(axis=1).max())


def _montecarlo(
    problem: DesignProblem, settings: Settings, poses: FloatArray, pairs: FloatArray, places: dict[str, int]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Error of x and length of the error at every place, and densities of the latter."""
    rows, densities = [], []
    for number, (name, index) in enumerate(places.items()):
        result = simulate(problem, plan_at(problem, poses[index]), settings.samples, settings.seed + number)
        errors = MICRO * result.errors[:, 0]
        covariance = MICRO**2 * result.predicted_covariance[0]
        lengths = np.linalg.norm(errors, axis=1)
        predicted = (np.sqrt(covariance[0, 0]), *planar_norm_moments(covariance))
        found = (standard_deviation(errors[:, 0]), mean(lengths), standard_deviation(lengths))
        row: dict[str, object] = {"best_by": name, "x_m": poses[index, 0].round(9), "y_m": poses[index, 1].round(9)}
        row |= {"duir": pairs[index, 0], "feir": pairs[index, 1]}
        for quantity, estimate, expected in zip(("std_x_um", "mean_um", "std_um"), found, predicted):
            row[quantity] = float(estimate.value)
            row[f"{quantity}_se"] = float(estimate.standard_error)
            row[f"{quantity}_predicted"] = float(expected)
        rows.append(row)
        if name in DRAWN:
            densities.append(density_rows(name, lengths, settings.density_um, low=0.0))
    return pd.DataFrame(rows), pd.concat(densities, ignore_index=True)
