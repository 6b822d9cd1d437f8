"""Appendix A: poses from measured points, and what it gains to know how their errors are correlated."""

from dataclasses import replace
from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from scipy.spatial.transform import Rotation

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import ExactCompensation
from expdesign.assurance.validation.repeated import root_mean_square
from expdesign.chain.readings.registration import pose_covariance, registered
from expdesign.io.schema import Number
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.deflection_noise import DeflectionNoise
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from research.studies.drawing import COLOURS, panels
from research.studies.pose_errors import AXES, MICRO, deviation_frame, deviation_table, plan_of
from research.studies.study import Picture, Piece, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, rows_of

SCALINGS = {"G_C": "correlations known (G_C)", "G_U": "standard deviations alone (G_U)"}


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    plan: Annotated[list[list[Number]], Field(min_length=1)] = Field(
        description="Measurements: pose (m, rad), mass (kg), centre of mass (m)."
    )
    pose: Annotated[list[Number], Field(min_length=6, max_length=6)] = Field(
        description="Pose at which the covariance of the registration is compared (m, rad)."
    )


class PoseMeasurement(Study):
    """Registration of points, its covariance, and identification with and without its correlations."""

    title = "Appendix A: a pose from measured points"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = problem_from_document(document.where("problem"))
        plan = plan_of(problem, settings.plan)
        if np.any(plan.configurations[:, 3:]):
            what = "the covariance is that of the zero orientation, at which all poses of `plan` have to be"
            raise document.where("plan").fault(what, "Set the three angles to 0.")
        section = problem.config["experiment"]["deflection_noise"]["points"]
        points, deviation = np.array(section["positions"]), float(section["std_m"])
        covariance = problem.noise.covariance / 2.0
        return {
            "registration": StudyTable(_registration(problem, settings, points, deviation)),
            "correlation": StudyTable(_correlation(covariance)),
            "gain": StudyTable(_gain(problem, plan, settings, points, deviation)),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        gain = tables["gain"]
        figure, axes = panels(1, 2, 3.4, 2.6)
        for axis, (block, rows) in zip(axes, gain.groupby("block", sort=False)):
            heights = column(rows, "rms")
            axis.bar(range(len(rows)), heights, yerr=3.0 * column(rows, "rms_se"), color=COLOURS[:2], width=0.6)
            axis.set_xticks(range(len(rows)), list(rows["scaling"]))
            axis.set_ylabel(f"RMS of the {block}")
            axis.set_ylim(0.0, 1.25 * heights.max())
        return {"gain": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        strongest = max(rows_of(tables["correlation"]), key=lambda row: abs(row.correlation))
        value = {(row.scaling, row.block): row.rms_predicted for row in rows_of(tables["gain"])}
        blocks = list(dict.fromkeys(tables["gain"]["block"]))
        gains = [100.0 * (value["G_U", block] / value["G_C", block] - 1.0) for block in blocks]
        return [
            Text("## Registration"),
            Text(
                "Points of an artefact are measured, and the pose that fits them best is found by singular value "
                "decomposition. Its covariance follows from the linearised rigid motion, σ²(ΣBᵀB)⁻¹. Here at the pose "
                f"{settings.pose} (m, rad), from {settings.samples} registrations:"
            ),
            deviation_table(tables["registration"], {"axis": "axis"}),
            Text(
                "The frame does not lie at the centroid of the points, so that translations and rotations are "
                f"correlated: {strongest.first} and {strongest.second} by {strongest.correlation:+.2f} at the zero "
                "pose (the reconstruction, with other points: 0.57)."
            ),
            Text("## Identification"),
            Text(
                "Every deflection is the difference of two registered poses. The legs are identified with the whole "
                "covariance (G_C, `deflection_noise.points` or `covariance`) or with its diagonal alone (G_U, `std`), "
                "and the exact compensation is solved at the target. Without the correlations the RMS error of the "
                f"translation is {gains[0]:.1f} % and that of the rotation {gains[1]:.1f} % larger. "
                "(The reconstruction's figures, for its own plan and points: 0.635 against 0.584 µm, 8.7 %, and "
                "5.44 against 5.05 µrad, 7.7 %.)"
            ),
            Picture("gain", "RMS of the attained error, bars: three standard errors."),
            deviation_table(tables["gain"], {"description": "scaling", "block": "RMS of the"}, "rms"),
        ]


def _registration(problem: DesignProblem, settings: Settings, points: FloatArray, deviation: float) -> pd.DataFrame:
    """Standard deviations of the pose coordinates at the pose of the configuration."""
    jacobians = problem.loaded.robot.jacobians(np.array(settings.pose))
    rates = jacobians.pose @ np.linalg.inv(jacobians.forward)
    generator = np.random.default_rng([settings.seed, 1])
    measured = points @ jacobians.rotation.T + generator.normal(0.0, deviation, (settings.samples, *points.shape))
    rotation, position = registered(points, measured)
    turns = Rotation.from_matrix(rotation @ jacobians.rotation.T).as_rotvec()
    errors = np.concatenate([position, turns], axis=1) @ rates.T
    return deviation_frame({}, errors, pose_covariance(points, deviation, jacobians.rotation, rates))


def _correlation(covariance: FloatArray) -> pd.DataFrame:
    deviation = np.sqrt(np.diag(covariance))
    table = covariance / np.outer(deviation, deviation)
    pairs = [(i, j) for i in range(6) for j in range(i + 1, 6) if abs(table[i, j]) > 0.01]
    names = [axis.split(" ")[0] for axis in AXES]
    return pd.DataFrame([{"first": names[i], "second": names[j], "correlation": table[i, j]} for i, j in pairs])


def _gain(problem: DesignProblem, plan: Plan, settings: Settings, points: FloatArray, deviation: float) -> pd.DataFrame:
    """RMS of the attained translation and rotation with the two scalings."""
    noise = problem.noise
    diagonal = DeflectionNoise.from_deviations(noise.axes, np.sqrt(np.diag(noise.covariance)))
    readings = _readings(problem, plan, settings, points, deviation)
    true = problem.loaded.robot.compliance
    compensation = ExactCompensation(
        problem.loaded, problem.targets.configurations[0], problem.target_wrenches[0], true
    )
    rows = []
    for scaling, here in (("G_C", noise), ("G_U", diagonal)):
        weighted = replace(problem, noise=here)
        gain = weighted.assess(plan.configurations[None], plan.loads[None], plan.series[None]).gain[0]
        errors = compensation.attained(np.einsum("ipk,sik->sp", gain, readings)).errors
        reach = problem.targets.observation[0] @ gain
        covariance = np.einsum("iak,kl,ibl->ab", reach, noise.covariance, reach)
        for block, part in (("translation (µm)", slice(0, 3)), ("rotation (µrad)", slice(3, 6))):
            found = root_mean_square(MICRO * np.linalg.norm(errors[:, part], axis=1))
            rows.append(
                {
                    "scaling": scaling,
                    "description": SCALINGS[scaling],
                    "block": block,
                    "rms": float(found.value),
                    "rms_se": float(found.standard_error),
                    "rms_predicted": MICRO * float(np.sqrt(np.trace(covariance[part, part]))),
                }
            )
    return pd.DataFrame(rows)


def _readings(
    problem: DesignProblem, plan: Plan, settings: Settings, points: FloatArray, deviation: float
) -> FloatArray:
    """Deflections (s, m, 6) as differences of registered poses, orientation near zero (angles are then the turns)."""
    measured = problem.loaded.measure(plan.configurations, plan.loads)
    exact = measured.observation @ problem.loaded.robot.compliance
    generator = np.random.default_rng([settings.seed, 2])
    readings = np.empty((settings.samples, *exact.shape))
    for index, deflection in enumerate(exact):
        poses = []
        for pose in (np.zeros(6), deflection):
            turned = points @ Rotation.from_rotvec(pose[3:]).as_matrix().T + pose[:3]
            noise = generator.normal(0.0, deviation, (settings.samples, *points.shape))
            rotation, position = registered(points, turned + noise)
            poses.append(np.concatenate([position, Rotation.from_matrix(rotation).as_rotvec()], axis=1))
        readings[:, index] = poses[1] - poses[0]
    return readings
