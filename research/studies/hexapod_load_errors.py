"""Chapter 4, study 2: an error of the moment about x and what it does to z along X, by the criterion H₂Z₃₄."""

from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.repeated import root_mean_square
from expdesign.assurance.validation.simulation import Simulation, simulate
from expdesign.io.schema import Number, Positive
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.report.words import with_error
from research.studies.drawing import COLOURS, panels
from research.studies.pose_errors import MICRO
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, rows_of
from research.studies.true_robot import with_stiffness

MILLI = 1e3
"""mm in a metre."""
Z, MX = 2, 3
"""Row and column of Z that the study is about."""


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    stiffness: Annotated[list[Positive], Field(min_length=6, max_length=6)] = Field(
        description="Stiffness of the legs (N/m)."
    )
    places_m: Annotated[list[Number], Field(min_length=2)] = Field(description="Places along x (m).")
    shown_m: Annotated[list[Number], Field(min_length=1)] = Field(
        description="Those of them at which the Monte-Carlo is run (m)."
    )
    payload: Annotated[list[Number], Field(min_length=4, max_length=4)] = Field(
        description="Payload of the measurement: mass (kg), centre of mass (m)."
    )


class HexapodLoadErrors(Study):
    """Z₃₄ along X for equal and unequal legs, and the efficiency of the compensation of z."""

    title = "Chapter 4, study 2: load errors of a hexapod, positioning along X"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        equal = document.where("problem")
        curves = []
        for name, stiffness in (("equal", None), ("unequal", np.array(settings.stiffness))):
            for place in settings.places_m:
                problem = _at(equal, place, stiffness)
                z34 = _criterion(problem, settings)
                curves.append({"legs": name, "place_mm": MILLI * place, "z34_per_N": z34})
        rows = [
            _repeated(_at(equal, place, np.array(settings.stiffness)), place, settings) for place in settings.shown_m
        ]
        return {"criterion": StudyTable(pd.DataFrame(curves)), "efficiency": StudyTable(pd.DataFrame(rows))}

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        figure, (left, right) = panels(1, 2, 3.8, 2.7)
        for colour, (name, rows) in zip(COLOURS, tables["criterion"].groupby("legs", sort=False)):
            left.plot(column(rows, "place_mm"), 1e9 * column(rows, "z34_per_N"), color=colour, label=f"{name} legs")
        left.set_xlabel("place along X (mm)")
        left.set_ylabel("Z₃₄ (nm per N·m)")
        left.legend(fontsize=7)
        table = tables["efficiency"]
        right.errorbar(
            column(table, "place_mm"),
            100.0 * column(table, "efficiency"),
            yerr=300.0 * column(table, "efficiency_se"),
            fmt="o",
            color=COLOURS[0],
            capsize=3,
            label="Monte-Carlo",
        )
        right.plot(
            column(table, "place_mm"),
            100.0 * column(table, "efficiency_predicted"),
            color=COLOURS[7],
            label="predicted",
        )
        right.set_xlabel("place along X (mm)")
        right.set_ylabel("efficiency on z (%)")
        right.legend(fontsize=7)
        return {"along-x": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        criterion = tables["criterion"]
        equal = criterion[criterion["legs"] == "equal"]
        z34 = column(equal, "z34_per_N")
        at_zero, ends = float(z34[np.abs(column(equal, "place_mm")).argmin()]), z34[[0, -1]]
        table = rows_of(tables["efficiency"])
        best = min(table, key=lambda row: row.z_um_predicted)
        worst = max(table, key=lambda row: row.z_um_predicted)
        return [
            Text("## The criterion"),
            Text(
                "One measurement identifies all legs, at the pose and under the load at which the robot is then "
                "positioned. An error of the moment about x of that measurement moves z by Z₃₄ = −[J̌K⁻¹Jᵀ]₃₄. With "
                f"equal legs it is {_zero(at_zero)} at x = 0, even in x, and {ends[0]:.2g} and {ends[1]:.2g} 1/N "
                "at the ends (the reconstruction: 4.4·10⁻⁹ at ±30 mm); with unequal legs the zero moves."
            ),
            Picture(
                "along-x",
                "Left: Z₃₄ along X. Right: 1 − RMS error of z over its deflection; bars: three standard errors.",
            ),
            Text("## Efficiency on z"),
            Text(
                f"Unequal legs, {settings.samples} repetitions with an error of the moment in the identification and "
                "none of the noise; the positioning itself has the right load. Among the poses compared, x = "
                f"{best.place_mm:g} mm is the least affected ({best.z_um_predicted:.3f} µm) and x = {worst.place_mm:g} "
                f"mm the most ({worst.z_um_predicted:.3f} µm)."
            ),
            Shown(
                [
                    "x (mm)",
                    "deflection of z (µm)",
                    "RMS error of z (µm)",
                    "H₂Z₃₄ (µm)",
                    "z",
                    "efficiency",
                    "predicted",
                ],
                [
                    [
                        f"{row.place_mm:g}",
                        f"{row.deflection_um:.3f}",
                        with_error(row.z_um, row.z_um_se),
                        f"{row.z_um_predicted:.4g}",
                        f"{(row.z_um - row.z_um_predicted) / row.z_um_se:+.2f}",
                        f"{100 * row.efficiency:.2f} %",
                        f"{100 * row.efficiency_predicted:.2f} %",
                    ]
                    for row in table
                ],
            ),
        ]


def _zero(value: float) -> str:
    return "0" if abs(value) < 1e-13 else f"{value:.2g}"


def _at(document: YamlDocument, place: float, stiffness: FloatArray | None) -> DesignProblem:
    """The problem with its target at a place along X, of a robot with the given stiffness."""
    content = dict(document.content)
    content["targets"] = [{**target, "pose": [place, 0.0, 0.0, 0.0, 0.0, 0.0]} for target in content["targets"]]
    problem = problem_from_document(YamlDocument(document.source, document.folder, content))
    return problem if stiffness is None else with_stiffness(problem, stiffness)


def _plan(problem: DesignProblem, settings: Settings) -> Plan:
    """One measurement at the target with the target's own load."""
    loads = np.concatenate([settings.payload, problem.loaded.robot.gravity])
    return Plan(problem.targets.configurations[:1], loads[None], np.array([1]))


def _criterion(problem: DesignProblem, settings: Settings) -> float:
    plan = _plan(problem, settings)
    assessment = problem.assess(plan.configurations[None], plan.loads[None])
    return float(assessment.force_sensitivity()[0, 0, Z, MX])


def _repeated(problem: DesignProblem, place: float, settings: Settings) -> dict[str, float]:
    """RMS of z, its prediction, and the efficiency of its compensation."""
    result: Simulation = simulate(problem, _plan(problem, settings), settings.samples, settings.seed, noise=False)
    found = root_mean_square(MICRO * result.errors[:, 0, Z])
    deviation = float(problem.loaded.sources[0].deviation[MX])
    predicted = MICRO * deviation * abs(_criterion(problem, settings))
    deflection = MICRO * float((problem.targets.observation[0] @ problem.loaded.robot.compliance)[Z])
    return {
        "place_mm": MILLI * place,
        "deflection_um": deflection,
        "z_um": float(found.value),
        "z_um_se": float(found.standard_error),
        "z_um_predicted": predicted,
        "efficiency": 1.0 - float(found.value) / abs(deflection),
        "efficiency_se": float(found.standard_error) / abs(deflection),
        "efficiency_predicted": 1.0 - predicted / abs(deflection),
    }
