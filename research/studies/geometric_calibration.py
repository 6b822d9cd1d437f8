"""Appendix I: DUIR for geometric calibration, by itself, with unknown frames, and together with stiffness."""

from dataclasses import replace
from typing import Annotated, Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.io.schema import Positive
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.sampling import starting_designs
from research.studies.drawing import COLOURS, panels
from research.studies.pose_errors import MICRO, deviation_frame, deviation_table
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, rows_of

_BATCH = 2000


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    load: dict[str, object] = Field(
        description="Loads of the variant that identifies geometry and stiffness together, as `experiment.load`."
    )
    payload: dict[str, object] = Field(description="Payload of its targets, as `targets[].payload`.")
    plan_seed: Annotated[int, Field(strict=True, ge=0)] = Field(description="Seed of the plan.")
    geometry_error_m: Positive = Field(description="Standard deviation of the true errors of the geometry (m).")


class GeometricCalibration(Study):
    """Monte-Carlo of a non-linear geometric calibration against U, and ranks of all variants."""

    title = "Appendix I: DUIR for geometric calibration"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = problem_from_document(document.where("problem"))
        poses = _poses(problem, settings)
        attained, linearity = _montecarlo(problem, poses, settings)
        return {
            "attained": StudyTable(attained),
            "variants": StudyTable(_variants(document, settings, poses)),
            "linearity": StudyTable(linearity, digits=3),
            "rank": StudyTable(_ranks(problem, poses)),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        rank = tables["rank"]
        figure, (axis,) = panels(1, 1, 4.2, 2.8)
        axis.plot(column(rank, "poses"), column(rank, "duir"), marker="o", color=COLOURS[0], markersize=3)
        axis.set_yscale("log")
        axis.set_xlabel("measured poses")
        axis.set_ylabel("DUIR (tolerances)")
        return {"poses": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        rank = rows_of(tables["rank"])
        least = next(row for row in rank if row.rank == row.parameters)
        relative = float(tables["linearity"]["relative"].max())
        cells = [
            [row.calibration, row.frames, row.wanted, f"{row.rank} of {row.parameters}", _number(row.duir)]
            for row in rows_of(tables["variants"])
        ]
        return [
            Text("## Parameters"),
            Text(
                f"{least.parameters} parameters: the coordinates of twelve joints and the lengths of six legs. Each "
                f"pose gives six readings; {least.poses} poses are the fewest that identify all of them here, and what "
                "fewer leave out is never hidden: DUIR has then no value."
            ),
            Picture("poses", "DUIR of the first poses of the plan; it exists from the fewest that identify all."),
            Text(
                "The same plan for every variant. With unknown frames of the instrument and the artefact 12 "
                "parameters more are in the model and none of them adds to the rank; the pose that the instrument will "
                "read is predicted as well as with known frames, the pose in the robot's own frame not at all."
            ),
            Shown(["calibrated", "frames", "wanted at the target", "rank", "DUIR (tolerances)"], cells),
            Text("## Attained"),
            Text(
                f"{settings.samples} repetitions of the whole calibration: a robot whose joints and lengths are wrong "
                f"by {1e3 * settings.geometry_error_m:g} mm, measured poses with noise, least squares, a corrected "
                "command, and the pose that it attains, all with the non-linear kinematics. The standard deviation is "
                f"compared with √U_ii. Attained errors and −A^g_D·ε_π differ by {relative:.1g} of their size, about "
                "the size of the wrong geometry beside the robot's (the reconstruction's figure: 7·10⁻⁵)."
            ),
            deviation_table(tables["attained"], {"axis": "axis"}),
        ]


def _number(value: float) -> str:
    return "cannot be predicted" if np.isnan(value) else f"{value:.4g}"


def _poses(problem: DesignProblem, settings: Settings) -> FloatArray:
    space = problem.space
    decisions = starting_designs(problem, 1, np.random.default_rng(settings.plan_seed))
    return space.decode(decisions[0])[0]


def _assess(problem: DesignProblem, poses: FloatArray, loads: FloatArray | None = None) -> Any:
    given = np.zeros((len(poses), len(problem.loaded.load.columns))) if loads is None else loads
    return problem.assess(poses[None], given[None])


def _ranks(problem: DesignProblem, poses: FloatArray) -> pd.DataFrame:
    rows = []
    for count in range(4, len(poses) + 1):
        here = _assess(problem, poses[:count])
        duir = float(known_criteria()["duir"].values(here)[0])
        rows.append({"poses": count, "rank": int(here.rank[0]), "parameters": here.parameters, "duir": duir})
    return pd.DataFrame(rows)


def _variants(document: YamlDocument, settings: Settings, poses: FloatArray) -> pd.DataFrame:
    """The same poses for every calibration."""
    rows: list[dict[str, object]] = []
    for calibration, frames in (
        ("geometric", "known"),
        ("geometric", "unknown"),
        ("both", "known"),
        ("both", "unknown"),
        ("elastostatic", "known"),
    ):
        problem = _variant(document, settings, calibration, frames)
        loads = None
        if calibration != "geometric":
            drawn = starting_designs(problem, 1, np.random.default_rng(settings.plan_seed))
            loads = problem.space.decode(drawn[0])[1]
        wanted = [("reading of the instrument", problem)]
        if frames == "unknown":
            rows_of_target = problem.targets.observation.copy()
            rows_of_target[..., : problem.loaded.regressor.redundant] = 0.0
            own = replace(problem, targets=replace(problem.targets, observation=rows_of_target))
            wanted.append(("pose in the robot's own frame", own))
        for name, here in wanted:
            assessment = _assess(here, poses, loads)
            rows.append(
                {
                    "calibration": calibration,
                    "frames": frames,
                    "wanted": name,
                    "rank": int(assessment.rank[0]),
                    "parameters": assessment.parameters,
                    "duir": float(known_criteria()["duir"].values(assessment)[0]),
                }
            )
    return pd.DataFrame(rows)


def _variant(document: YamlDocument, settings: Settings, calibration: str, frames: str) -> DesignProblem:
    part = document.where("problem")
    content: dict[str, Any] = dict(part.content)
    content["experiment"] = {**content["experiment"], "calibration": calibration, "frames": frames}
    if calibration != "geometric":
        content["experiment"]["load"] = settings.load
        content["targets"] = [{**target, "payload": settings.payload} for target in content["targets"]]
    return problem_from_document(YamlDocument(part.source, part.folder, content))


def _montecarlo(problem: DesignProblem, poses: FloatArray, settings: Settings) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Standard deviation of the attained pose at the first target, and how far it is from linear."""
    robot = problem.loaded.robot.inverse_kinematics
    joints = len(robot.geometry)
    count = joints + len(robot.stiffness)
    truth = settings.geometry_error_m * np.random.default_rng(settings.plan_seed).standard_normal(count)
    geometry, lengths = robot.geometry + truth[:joints], truth[joints:]
    exact = robot.pose_of(robot.lengths(poses) + lengths, poses, geometry)
    assessment = _assess(problem, poses)
    gain, wanted = assessment.gain[0], problem.targets.observation[0]
    target = problem.targets.configurations[0]
    deviations = np.sqrt(np.diag(problem.noise.covariance))

    def attained(noise: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Attained errors and −A^g_D·ε_π of readings with noise (s, m, 6)."""
        found = np.einsum("ipk,sik->sp", gain, exact - poses + noise)
        commands = target - found @ wanted.T
        pose = robot.pose_of(robot.lengths(commands) + lengths, commands, geometry)
        return pose - target, -(found - truth) @ wanted.T

    errors = []
    for batch, start in enumerate(range(0, settings.samples, _BATCH)):
        generator = np.random.default_rng([settings.seed, batch])
        drawn = generator.standard_normal((min(_BATCH, settings.samples - start), *poses.shape)) * deviations
        errors.append(attained(drawn)[0])
    samples = np.concatenate(errors)
    root = assessment.noise_root[0, 0]
    # One fixed noise: how the error that it makes differs from the linear one.
    fixed = np.random.default_rng(settings.plan_seed + 1).standard_normal((1, *poses.shape)) * deviations
    difference = [a - b for a, b in zip(attained(fixed), attained(0.0 * fixed))]
    relative = np.linalg.norm(difference[0] - difference[1]) / np.linalg.norm(difference[1])
    bias = MICRO * attained(0.0 * fixed)[0][0, :3]
    linearity = pd.DataFrame({"relative": [float(relative)], "bias_um": [float(np.linalg.norm(bias))]})
    return deviation_frame({}, samples, root @ root.T), linearity
