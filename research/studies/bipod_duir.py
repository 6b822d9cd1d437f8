"""Study 1 of the thesis: where to identify a bipod so that its position along x is accurate in spite of noise."""

from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.repeated import standard_deviation
from expdesign.assurance.validation.simulation import simulate
from expdesign.io.schema import Count, Number, Positive, Section
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.report.words import with_error
from research.studies.drawing import COLOURS, draw_densities, draw_map, panels
from research.studies.position_maps import (
    BEST_COLOUR,
    COORDINATES,
    MICRO,
    best_index,
    grid_assessment,
    map_frame,
    mark_best,
    plan_at,
)
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, density_rows, number, rows_of

INDICES = ("o1", "o2", "o3", "o4", "o5", "o_tp", "o_mv")
TITLES = {"u11": "B₁U₁₁ (µm²)", "o_tp": "O_TP = O_MV (m²)"} | {f"o{i}": f"O{i}" for i in range(1, 6)}


class PositionSection(Section):
    """One identification position; `theory_*` are figures of the reconstruction (theory.md 11), where it has some."""

    at: Annotated[list[Number], Field(min_length=2, max_length=2)] = Field(
        description="Identification position `[x, y]` in pose coordinates (m)."
    )
    theory_um: Positive | None = Field(
        default=None,
        description="Standard deviation of x predicted by the reconstruction (µm). Default: no comparison.",
    )
    theory_montecarlo_um: Positive | None = Field(
        default=None, description="The same by its Monte-Carlo (µm). Default: no comparison."
    )


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    map_step: Count = Field(description="Every how many points of the grid are kept in `map.csv`.")
    positions: Annotated[list[PositionSection], Field(min_length=1)] = Field(
        description="Identification positions of the Monte-Carlo."
    )
    density_um: Positive = Field(description="Half-width of the plotted densities of x (µm).")


class BipodDuir(Study):
    """Maps of the criteria over the identification position, and Monte-Carlo of the attained x."""

    title = "Study 1: measurement noise and the position of a bipod along x"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = problem_from_document(document.where("problem"))
        poses, assessment = grid_assessment(problem)
        values = {name: known_criteria()[name].values(assessment) for name in INDICES}
        values["u11"] = assessment.weighted(assessment.noise_variance)[:, 0]
        columns = {name: values[name] for name in ("u11", *INDICES[:-1])}
        montecarlo, density = _montecarlo(problem, settings)
        return {
            "map": StudyTable(map_frame(poses, columns, settings.map_step), digits=5),
            "best": StudyTable(_best(poses, values)),
            "montecarlo": StudyTable(montecarlo),
            "density": StudyTable(density, digits=4),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        chart, best = tables["map"], tables["best"].set_index("criterion")
        figure, axes = panels(2, 4, 2.9, 2.5)
        shown = ("u11", "o_tp", "o1", "o2", "o3", "o4", "o5")
        for axis, name in zip(axes, shown):
            draw_map(axis, column(chart, "x_m"), column(chart, "y_m"), column(chart, name), TITLES[name])
            mark_best(axis, *best.loc[name, ["x_m", "y_m"]])
        axes[-1].set_axis_off()
        axes[-1].text(0.0, 0.6, "★ best position\nx and y of the pose in m", color=BEST_COLOUR)
        densities, (axis, ratio) = panels(1, 2, 4.2, 3.0)
        draw_densities(axis, tables["density"], "x attained − x wanted (µm)")
        table = tables["montecarlo"]
        predicted = column(table, "std_um_predicted")
        ratio.errorbar(
            np.arange(len(table)) + 1,
            column(table, "std_um") / predicted,
            yerr=3.0 * column(table, "std_um_se") / predicted,
            fmt="o",
            color=COLOURS[0],
            capsize=3,
        )
        ratio.axhline(1.0, color="#475569", linewidth=0.8)
        ratio.set_xlabel("position")
        ratio.set_ylabel("Monte-Carlo / √(B₁U₁₁)")
        ratio.set_title("bars: three standard errors")
        return {"maps": figure, "densities": densities}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        best, montecarlo = tables["best"], tables["montecarlo"]
        least, *others = column(best, "u11").tolist()
        low, high = min(others), max(others)
        text = (
            f"One measurement at (x, y) identifies both legs. The least variance of x after compensation is B₁U₁₁ = "
            f"{least:.3f}; at the positions that the other criteria prefer it is {low:.3f} to {high:.3f}, i.e. "
            f"{100 * (low / least - 1):.0f} to {100 * (high / least - 1):.0f} % larger. The reconstruction's figures "
            "are 0.679, and 0.884 (O1, O3, O5), 1.002 (O2, O4) and 0.885 (O_TP); they are reproduced."
        )
        return [
            Text("## Maps"),
            Text(f"{text} {COORDINATES}"),
            Picture("maps", "Criteria over the identification position. O1 to O5 are to be large, the others small."),
            Shown(
                ["best by", "x (m)", "y (m)", "value", "B₁U₁₁ there (µm²)", "√(B₁U₁₁) (µm)", "larger than the best by"],
                [
                    [
                        TITLES.get(row.criterion, "O_MV (m²)"),
                        f"{row.x_m:.2f}",
                        f"{row.y_m:.2f}",
                        number(row.value),
                        f"{row.u11:.4f}",
                        f"{np.sqrt(row.u11):.4f}",
                        f"{100 * (row.u11 / least - 1):.1f} %",
                    ]
                    for row in rows_of(best)
                ],
            ),
            Text("## Monte-Carlo"),
            Text(
                f"{settings.samples} repetitions at every position: noise is drawn, the legs are identified, the "
                "exact compensation is solved and the attained x compared with the wanted one. The prediction is "
                "√(B₁U₁₁). Standard errors are one σ; z is their number between prediction and Monte-Carlo. The last "
                "columns are the reconstruction's own figures for its own draws of 100000."
            ),
            Picture("densities", "Density of the error of x at each position (steps), and the predicted one (dashed)."),
            Shown(
                ["position", "x (m)", "y (m)", "Monte-Carlo std of x (µm)", "√(B₁U₁₁) (µm)", "z", "prediction there",
                 "Monte-Carlo there"],
                [
                    [
                        str(row.position),
                        f"{row.x_m:.2f}",
                        f"{row.y_m:.2f}",
                        with_error(row.std_um, row.std_um_se),
                        f"{row.std_um_predicted:.4f}",
                        f"{(row.std_um - row.std_um_predicted) / row.std_um_se:+.2f}",
                        number(row.theory_um),
                        number(row.theory_montecarlo_um),
                    ]
                    for row in rows_of(montecarlo)
                ],
            ),
        ]  # fmt: skip


def _best(poses: FloatArray, values: dict[str, FloatArray]) -> pd.DataFrame:
    """Best position of every criterion, its value, and U₁₁ there."""
    rows = []
    for name in ("u11", *INDICES):
        index = best_index(name, values[name])
        x, y = poses[index].tolist()
        rows.append({"criterion": name, "x_m": x, "y_m": y, "value": values[name][index], "u11": values["u11"][index]})
    return pd.DataFrame(rows)


def _montecarlo(problem: DesignProblem, settings: Settings) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Standard deviations of x, and its densities."""
    rows, densities = [], []
    for index, position in enumerate(settings.positions):
        plan = plan_at(problem, np.array(position.at))
        result = simulate(problem, plan, settings.samples, settings.seed + index, load_errors=False)
        x = MICRO * result.errors[:, 0, 0]
        deviation, predicted = standard_deviation(x), MICRO * np.sqrt(result.predicted_covariance[0, 0, 0])
        rows.append(
            {
                "position": index + 1,
                "x_m": position.at[0],
                "y_m": position.at[1],
                "std_um": float(deviation.value),
                "std_um_se": float(deviation.standard_error),
                "std_um_predicted": float(predicted),
                "theory_um": position.theory_um or np.nan,
                "theory_montecarlo_um": position.theory_montecarlo_um or np.nan,
            }
        )
        name = f"{index + 1}: ({position.at[0]:.2f}, {position.at[1]:.2f})"
        densities.append(density_rows(name, x, settings.density_um, float(predicted)))
    return pd.DataFrame(rows), pd.concat(densities, ignore_index=True)
