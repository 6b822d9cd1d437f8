"""Chapter 4, study 1: identification of a hexapod and compensation at poses along X and along Y."""

from typing import Annotated, Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.compensation import ExactCompensation
from expdesign.assurance.validation.repeated import root_mean_square
from expdesign.assurance.validation.simulation import simulate
from expdesign.estimation.identify import identify
from expdesign.io.schema import Number, Positive
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from research.studies.drawing import COLOURS, panels
from research.studies.equilibrium import EquilibriumPlant
from research.studies.pose_errors import MICRO, deviation_table, plan_of
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, rows_of
from research.studies.true_robot import recorded, with_stiffness

MILLI = 1e3
"""mm in a metre."""
NORMAL_95 = 1.959963984540054
BLOCKS = {"translation (µm)": slice(0, 3), "rotation (µrad)": slice(3, 6)}


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    plan: Annotated[list[list[Number]], Field(min_length=1)] = Field(
        description="Measurements: pose (m, rad), mass (kg), centre of mass (m)."
    )
    true_stiffness: Annotated[list[Positive], Field(min_length=6, max_length=6)] = Field(
        description="Stiffness of the legs of the simulated robot (N/m)."
    )
    recordings_seed: Annotated[int, Field(strict=True, ge=0)] = Field(description="Seed of the simulated recordings.")
    places_m: Annotated[list[Number], Field(min_length=1)] = Field(
        description="Places along x and along y at which the robot is compensated (m)."
    )


class HexapodCompensation(Study):
    """One experiment from plan to compensated poses, and many repetitions of it against the prediction."""

    title = "Chapter 4, study 1: identification and compensation of a hexapod"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = _along(document.where("problem"), settings.places_m)
        true = with_stiffness(problem, np.array(settings.true_stiffness))
        plan = plan_of(problem, settings.plan)
        found = identify(problem.loaded.robot, recorded(true, plan, settings.recordings_seed))
        stiffness = pd.DataFrame(
            {
                "leg": np.arange(6) + 1,
                "true": 1e-6 * true.loaded.robot.stiffness,
                "estimate": 1e-6 * found.stiffness.estimate,
                "low": 1e-6 * found.stiffness.low,
                "high": 1e-6 * found.stiffness.high,
            }
        )
        attained = _attained(true, plan, found.compliance.estimate, settings)
        repeated, coverage = _repeated(true, plan, settings)
        fit = pd.DataFrame([{"chi2": found.fit.chi2, "dof": found.fit.dof, "p_value": found.goodness.p_value}])
        return {
            "stiffness": StudyTable(stiffness.merge(coverage, on="leg")),
            "fit": StudyTable(fit, digits=4),
            "attained": StudyTable(attained, digits=4),
            "repeated": StudyTable(repeated),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        figure, axes = panels(2, 2, 3.6, 2.4)
        attained, repeated = tables["attained"], tables["repeated"]
        for place, (direction, block) in zip(axes, [(d, b) for d in ("X", "Y") for b in BLOCKS]):
            rows = attained[(attained["along"] == direction) & (attained["block"] == block)]
            expected = repeated[(repeated["along"] == direction) & (repeated["block"] == block)]
            x = column(rows, "place_mm")
            place.plot(x, column(rows, "without"), color=COLOURS[1], marker="s", markersize=3, label="not compensated")
            place.plot(x, column(rows, "with"), color=COLOURS[0], marker="o", markersize=3, label="compensated")
            place.plot(
                x, column(expected, "rms_predicted"), color=COLOURS[7], linestyle=(0, (4, 2)), label="predicted RMS"
            )
            place.set_yscale("log")
            place.set_xlabel(f"place along {direction} (mm)")
            place.set_ylabel(f"error of {block}")
        axes[0].legend(fontsize=7)
        return {"attained": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        attained, fit = rows_of(tables["attained"]), rows_of(tables["fit"])[0]
        efficiencies = [100.0 * row.efficiency for row in attained]
        without = [max(row.without for row in attained if row.block == block) for block in BLOCKS]
        inside = sum(row.low <= row.true <= row.high for row in rows_of(tables["stiffness"]))
        return [
            Text("## Identification"),
            Text(
                f"{len(settings.plan)} loaded measurements of a hexapod whose legs are not as stiff as assumed; its "
                "deflections are those of the full equilibrium, with noise. The base model fits them (chi² "
                f"{fit.chi2:.1f} for {fit.dof:.0f} degrees of freedom, p = {fit.p_value:.2f}), and {inside} of 6 "
                "95 % intervals contain the true stiffness. The last columns: in how many repetitions the interval of "
                "a leg's compliance contains the true one."
            ),
            Shown(
                ["leg", "true (N/µm)", "identified (N/µm)", "95 % interval", "coverage", "expected"],
                [
                    [
                        str(row.leg),
                        f"{row.true:.3f}",
                        f"{row.estimate:.3f}",
                        f"{row.low:.3f} to {row.high:.3f}",
                        f"{row.coverage:.4f} ± {row.coverage_se:.4f}",
                        f"{row.coverage_predicted:.2f}",
                    ]
                    for row in rows_of(tables["stiffness"])
                ],
            ),
            Text("## Compensation"),
            Text(
                "The exact compensation with the identified stiffness, at poses along X and along Y under "
                f"26.5 kg. Against the unloaded robot the pose is wrong by up to {without[0]:.1f} µm and "
                f"{without[1]:.1f} µrad without compensation; with it, {min(efficiencies):.1f} to "
                f"{max(efficiencies):.1f} % of that is gone (1 − |with|/|without|)."
            ),
            Picture(
                "attained", "Error of the pose of one experiment against the unloaded robot, and the RMS to expect."
            ),
            Text("## Repeated"),
            Text(
                f"{settings.samples} repetitions of measurement, identification and compensation with the full "
                "equilibrium, RMS of the attained error about its mean beside √tr U:"
            ),
            deviation_table(tables["repeated"], {"along": "along", "place_mm": "place (mm)", "block": "RMS of"}, "rms"),
        ]


def _along(document: YamlDocument, places: list[float]) -> DesignProblem:
    """The problem with a copy of its first target at every place along X and along Y."""
    content: dict[str, Any] = dict(document.content)
    target = content["targets"][0]
    poses = [[*(place if i == axis else 0.0 for i in range(3)), 0.0, 0.0, 0.0] for axis in (0, 1) for place in places]
    content["targets"] = [{**target, "pose": pose} for pose in poses]
    return problem_from_document(YamlDocument(document.source, document.folder, content))


def _labels(settings: Settings) -> list[dict[str, object]]:
    return [{"along": name, "place_mm": MILLI * place} for name in ("X", "Y") for place in settings.places_m]


def _attained(true: DesignProblem, plan: Plan, estimate: FloatArray, settings: Settings) -> pd.DataFrame:
    """Errors of the loaded pose against the unloaded robot, without and with compensation."""
    plant = EquilibriumPlant(true.loaded, plan)
    rows = []
    pairs = zip(true.targets.configurations, true.target_wrenches, strict=True)
    for labels, (target, wrench) in zip(_labels(settings), pairs, strict=True):
        errors = {}
        for name, compliance in (("without", np.zeros(6)), ("with", estimate)):
            command = ExactCompensation(true.loaded, target, wrench, true.loaded.robot.compliance)
            errors[name] = plant.errors(command.attained(compliance[None]), target, wrench)[0]
        for block, part in BLOCKS.items():
            size = {name: MICRO * float(np.linalg.norm(error[part])) for name, error in errors.items()}
            rows.append({**labels, "block": block, **size, "efficiency": 1.0 - size["with"] / size["without"]})
    return pd.DataFrame(rows)


def _repeated(true: DesignProblem, plan: Plan, settings: Settings) -> tuple[pd.DataFrame, pd.DataFrame]:
    """RMS of the attained errors about their mean, and how often the intervals contain the truth."""
    result = simulate(true, plan, settings.samples, settings.seed, load_errors=False, plant=EquilibriumPlant)
    rows = []
    for index, labels in enumerate(_labels(settings)):
        errors = MICRO * (result.errors[:, index] - result.errors[:, index].mean(axis=0))
        covariance = result.predicted_covariance[index]
        for block, part in BLOCKS.items():
            found = root_mean_square(np.linalg.norm(errors[:, part], axis=1))
            rows.append(
                {
                    **labels,
                    "block": block,
                    "rms": float(found.value),
                    "rms_se": float(found.standard_error),
                    "rms_predicted": MICRO * float(np.sqrt(np.trace(covariance[part, part]))),
                }
            )
    gain = result.assessment.gain[0]
    deviation = np.sqrt(np.einsum("ipk,kl,ipl->p", gain, true.noise.covariance, gain))
    inside = np.abs(result.estimates - true.loaded.robot.compliance) <= NORMAL_95 * deviation
    coverage = inside.mean(axis=0)
    spread = np.sqrt(coverage * (1.0 - coverage) / settings.samples)
    columns = {"leg": np.arange(6) + 1, "coverage": coverage, "coverage_se": spread, "coverage_predicted": 0.95}
    return pd.DataFrame(rows), pd.DataFrame(columns)
