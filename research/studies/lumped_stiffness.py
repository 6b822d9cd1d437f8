"""Appendix G: approximate stiffness from a series of vertical loads, then all six legs, then deflections elsewhere."""

from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.repeated import root_mean_square
from expdesign.assurance.validation.simulation import simulate
from expdesign.estimation.identify import identify
from expdesign.io.schema import Number, Positive
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.report.words import with_error
from research.studies.drawing import COLOURS, panels
from research.studies.pose_errors import AXES, MICRO, plan_of
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, rows_of
from research.studies.true_robot import recorded, with_stiffness
from research.studies.vertical_series import exact_deflections, measured_series, repeated_lines

MILLI = 1e3
"""mm in a metre."""
Z = 2


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    vertical_N: Annotated[list[Number], Field(min_length=2)] = Field(description="Vertical forces of the series (N).")
    plan: Annotated[list[list[Number]], Field(min_length=1)] = Field(
        description="Measurements: pose (m, rad), force (N), moment (N·m)."
    )
    true_stiffness: Annotated[list[Positive], Field(min_length=6, max_length=6)] = Field(
        description="Stiffness of the legs of the simulated robot (N/m)."
    )
    recordings_seed: Annotated[int, Field(strict=True, ge=0)] = Field(description="Seed of the simulated recordings.")
    places_m: Annotated[list[Number], Field(min_length=2)] = Field(
        description="Places along x and along y at which deflections are predicted (m)."
    )
    load: Annotated[list[Number], Field(min_length=6, max_length=6)] = Field(description="Wrench there (N, N·m).")


class LumpedStiffness(Study):
    """The way to a table of stiffnesses, and how well it predicts deflections along X and Y."""

    title = "Appendix G: lumped stiffness of the legs"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = problem_from_document(document.where("problem"))
        true = with_stiffness(problem, np.array(settings.true_stiffness))
        series = exact_deflections(true, settings.vertical_N)
        found = identify(
            problem.loaded.robot, recorded(true, plan_of(problem, settings.plan), settings.recordings_seed)
        )
        stiffness = pd.DataFrame(
            {
                "leg": np.arange(6) + 1,
                "true": 1e-6 * true.loaded.robot.stiffness,
                "estimate": 1e-6 * found.stiffness.estimate,
                "low": 1e-6 * found.stiffness.low,
                "high": 1e-6 * found.stiffness.high,
            }
        )
        along = _along(true, found.compliance.estimate, settings)
        return {
            "series": StudyTable(measured_series(true, settings.vertical_N, series, settings.recordings_seed)),
            "line": StudyTable(repeated_lines(true, settings.vertical_N, series, settings.samples, settings.seed)),
            "stiffness": StudyTable(stiffness),
            "along": StudyTable(along, digits=5),
            "residual": StudyTable(_residuals(true, settings)),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        series, along = tables["series"], tables["along"]
        figure, (line, x_axis, y_axis) = panels(1, 3, 3.3, 2.6)
        line.plot(column(series, "force_N"), column(series, "z_um"), "o", color=COLOURS[0], markersize=4)
        line.plot(column(series, "force_N"), column(series, "line_um"), color=COLOURS[7])
        line.set_xlabel("vertical force (N)")
        line.set_ylabel("deflection of z (µm)")
        for axis, direction in ((x_axis, "X"), (y_axis, "Y")):
            rows = along[along["along"] == direction]
            for colour, label in zip(COLOURS, AXES[:3]):
                part = rows[rows["axis"] == label]
                axis.plot(column(part, "place_mm"), column(part, "measured"), "o", color=colour, markersize=3)
                axis.plot(column(part, "place_mm"), column(part, "predicted"), color=colour, label=label)
            axis.set_xlabel(f"place along {direction} (mm)")
            axis.set_ylabel("deflection (µm)")
            axis.legend(fontsize=7)
        return {"deflections": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        line = {row.quantity: row for row in rows_of(tables["line"])}
        along = tables["along"]
        left, size = column(along, "measured") - column(along, "predicted"), column(along, "measured")
        translations = np.isin(along["axis"], AXES[:3])
        explained = 100.0 * (1.0 - np.linalg.norm(left[translations]) / np.linalg.norm(size[translations]))
        summary = [
            [label, f"{_rms(size[rows]):.3f}", f"{_rms(left[rows]):.3f}", f"{np.abs(left[rows]).max():.3f}"]
            for label in AXES
            if (rows := (along["axis"] == label).to_numpy()).any()
        ]
        return [
            Text("## Vertical loads"),
            Text(
                "A series of vertical forces at the zero pose; its slope s of z gives one stiffness for all legs, "
                "apk = 1/(s·Σu_z²). Lines through the origin of repeated series have the mean and the standard "
                "deviation below, and a sum of squares about the line that is that of the noise: the robot is linear."
            ),
            Shown(
                ["quantity", "Monte-Carlo", "predicted", "z"],
                [
                    [
                        row.quantity,
                        with_error(row.value, row.value_se),
                        f"{row.value_predicted:.6g}",
                        f"{(row.value - row.value_predicted) / row.value_se:+.2f}",
                    ]
                    for row in line.values()
                ],
            ),
            Text("## All legs"),
            Text("The same robot, six measurements on all axes:"),
            Shown(
                ["leg", "true (N/µm)", "identified (N/µm)", "95 % interval"],
                [
                    [str(row.leg), f"{row.true:.3f}", f"{row.estimate:.3f}", f"{row.low:.3f} to {row.high:.3f}"]
                    for row in rows_of(tables["stiffness"])
                ],
            ),
            Text("## Deflections along X and Y"),
            Text(
                "Predicted with these stiffnesses and measured (full equilibrium, with noise) at poses that were not "
                f"fitted; of the translations, 1 − ‖residual‖/‖deflection‖ = {explained:.1f} % is explained."
            ),
            Picture(
                "deflections", "Left: the vertical series. Others: measured (dots) and predicted deflections (lines)."
            ),
            Shown(["axis", "RMS deflection", "RMS residual", "largest residual"], summary),
            Text(
                f"RMS residual at these poses from {settings.samples} repetitions of measurement, identification and "
                "prediction, beside √(noise² + prediction's variance):"
            ),
            Shown(
                ["axis", "Monte-Carlo", "predicted", "z"],
                [
                    [
                        row.axis,
                        with_error(row.rms, row.rms_se),
                        f"{row.rms_predicted:.4g}",
                        f"{(row.rms - row.rms_predicted) / row.rms_se:+.2f}",
                    ]
                    for row in rows_of(tables["residual"])
                ],
            ),
        ]


def _rms(values: FloatArray) -> float:
    return float(np.sqrt((values**2).mean()))


def _elsewhere(true: DesignProblem, settings: Settings) -> Plan:
    """The load of the configuration at places along X and along Y."""
    poses = np.array(
        [[*(p if i == axis else 0.0 for i in range(3)), 0, 0, 0] for axis in (0, 1) for p in settings.places_m]
    )
    loads = np.tile(np.array(settings.load), (len(poses), 1))
    return Plan(poses, loads, np.arange(len(poses)) + 1)


def _along(true: DesignProblem, compliance: FloatArray, settings: Settings) -> pd.DataFrame:
    """Deflections predicted and measured once (µm, µrad)."""
    plan = _elsewhere(true, settings)
    measured = MICRO * recorded(true, plan, settings.recordings_seed + 1).deflections
    predicted = MICRO * true.loaded.measure(plan.configurations, plan.loads).observation @ compliance
    labels = [(name, MILLI * place) for name in ("X", "Y") for place in settings.places_m]
    rows = [
        {"along": name, "place_mm": place, "axis": axis, "measured": measured[i, k], "predicted": predicted[i, k]}
        for i, (name, place) in enumerate(labels)
        for k, axis in enumerate(AXES)
    ]
    return pd.DataFrame(rows)


def _residuals(true: DesignProblem, settings: Settings) -> pd.DataFrame:
    """RMS of measured minus predicted over the places, from repetitions, and its prediction."""
    result = simulate(true, plan_of(true, settings.plan), settings.samples, settings.seed, load_errors=False)
    plan = _elsewhere(true, settings)
    observation = true.loaded.measure(plan.configurations, plan.loads).observation
    pose_map = true.loaded.robot.jacobians(plan.configurations).pose
    generator = np.random.default_rng([settings.seed, 2])
    drawn = true.noise.drawn(plan.series, settings.samples, generator, pose_map)
    errors = np.einsum("map,sp->sma", observation, result.estimates - true.loaded.robot.compliance)
    gain = result.assessment.gain[0]
    covariance = np.einsum("ipk,kl,iql->pq", gain, true.noise.covariance, gain)
    variance = np.diag(true.noise.covariance) + np.einsum("map,pq,maq->ma", observation, covariance, observation)
    # One number per repetition, so that places of one repetition, which share an estimate, count once.
    found = root_mean_square(MICRO * np.sqrt(((drawn - errors) ** 2).mean(axis=1)))
    return pd.DataFrame(
        {
            "axis": AXES,
            "rms": found.value,
            "rms_se": found.standard_error,
            "rms_predicted": MICRO * np.sqrt(variance.mean(axis=0)),
        }
    )
