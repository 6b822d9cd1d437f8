"""Chapter 1 of the thesis: from which load on the change of geometry under load exceeds the repeatability."""

from collections.abc import Callable
from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from scipy.optimize import brentq

from expdesign.arrays import FloatArray
from expdesign.io.schema import Number, Positive, Section
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.elastostatics.maps import (
    actuator_forces,
    cartesian_stiffness,
    geometric_stiffness,
    observation_matrix,
)
from expdesign.mechanics.loads.load import Payload, Wrench
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot_file import read_robot
from research.studies.drawing import COLOURS, panels
from research.studies.equilibrium import Equilibrium
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, rows_of

MAPPINGS = {"mapping": "conservative mapping", "equilibrium": "full equilibrium"}
_LEAST, _MOST = 1e-2, 1e5
"""kg; bracket of the root search for the load that reaches the repeatability."""

Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]
Pose = Annotated[list[Number], Field(min_length=6, max_length=6)]


class RobotSection(Section):
    """One robot with its load and poses."""

    robot: str = Field(description="Robot file; the path is relative to this file.")
    rated_kg: Positive = Field(description="Mass that the robot is made for (kg).")
    centre_of_mass_m: Vector = Field(description="Centre of mass in the platform frame, `[x, y, z]` (m).")
    poses: Annotated[list[Pose], Field(min_length=1)] = Field(description="Poses (m, rad).")


class Settings(StudySection):
    """Configuration of the study."""

    repeatability_m: Positive = Field(description="Repeatability of translations (m).")
    repeatability_rad: Positive = Field(description="Repeatability of rotations (rad).")
    masses_kg: Annotated[list[Positive], Field(min_length=2)] = Field(description="Masses (kg).")
    robots: Annotated[list[RobotSection], Field(min_length=1)] = Field(description="Robots with their loads and poses.")


class StiffnessMapping(Study):
    """Non-conservative mapping against the conservative one and against the exact equilibrium."""

    title = "Chapter 1: what the change of geometry under load does"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        differences, reached = [], []
        for section in settings.robots:
            robot = read_robot(document.folder / section.robot)
            if not robot.on_legs:
                raise section.where("robot").fault("the study is of hexapods", "Name a hexapod's file.")
            legs = robot.inverse_kinematics
            differences += _differences(legs, section, settings)
            reached += _reached(legs, section, settings)
        return {"differences": StudyTable(pd.DataFrame(differences)), "reached": StudyTable(pd.DataFrame(reached))}

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        table = tables["differences"]
        figure, axes = panels(1, 2, 4.4, 3.3)
        limits = (settings.repeatability_m, settings.repeatability_rad)
        kinds = (("translation_um", limits[0], "µm"), ("rotation_urad", limits[1], "µrad"))
        for axis, (kind, repeatability, unit) in zip(axes, kinds):
            for index, name in enumerate(table["robot"].unique()):
                rows = table[table["robot"] == name]
                worst = rows.groupby("mass_kg", as_index=False).max(numeric_only=True)
                for mapping, style in (("mapping", (0, (3, 2))), ("equilibrium", "-")):
                    axis.loglog(
                        column(worst, "mass_kg"),
                        column(worst, f"{mapping}_{kind}"),
                        linestyle=style,
                        color=COLOURS[index],
                        label=f"{name}, {MAPPINGS[mapping]}",
                    )
            axis.axhline(1e6 * repeatability, color="#475569", linewidth=0.8)
            axis.text(column(table, "mass_kg").min(), 1.1e6 * repeatability, "repeatability", fontsize=7)
            axis.set_xlabel("mass of the payload (kg)")
            axis.set_ylabel(f"difference, {kind.split('_')[0]} ({unit})")
        axes[1].legend(fontsize=7, loc="lower right")
        return {"differences": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        reached, differences = tables["reached"], tables["differences"]
        pieces: list[Piece] = [
            Text("## The three mappings"),
            Text(
                "Non-conservative: ΔX = J̌K⁻¹JᵀΔF, which the thesis uses. Conservative: (K_C + K_G)ΔX = ΔF with the "
                "geometric stiffness K_G of the loaded legs. Full equilibrium: the pose at which the legs' forces "
                "balance the load, without any linearisation. The differences grow with the square of the load."
            ),
            Picture("differences", "Largest difference from the non-conservative mapping over the poses."),
        ]
        for name in reached["robot"].unique():
            rows = reached[reached["robot"] == name]
            least = {mapping: rows[rows["against"] == mapping]["mass_kg"].min() for mapping in MAPPINGS}
            rated = float(rows["rated_kg"].iloc[0])
            at_rated = differences[(differences["robot"] == name) & (differences["mass_kg"] == rated)]
            micro = at_rated[["equilibrium_translation_um", "equilibrium_rotation_urad"]].max()
            pieces.append(
                Text(
                    f"**{name}**: with its {rated:g} kg the non-conservative mapping is off by at most "
                    f"{1e3 * micro.iloc[0]:.2g} nm and {1e3 * micro.iloc[1]:.2g} nrad from the full equilibrium. The "
                    f"difference reaches the repeatability at {_mass(least['equilibrium'])} kg (full equilibrium; "
                    f"{_mass(least['mapping'])} kg against the conservative mapping) at the worst of the poses."
                )
            )
        rows = [
            [
                row.robot,
                f"({row.pose.replace(' ', ', ')})",
                MAPPINGS[row.against],
                _mass(row.translation_kg),
                _mass(row.rotation_kg),
                _mass(row.mass_kg),
            ]
            for row in rows_of(reached)
        ]
        columns = ["robot", "pose (m, rad)", "against", "translation reaches it at (kg)", "rotation (kg)", "first (kg)"]
        text = "Where the difference reaches the repeatability; – where it does not below 100 t."
        return [*pieces, Text("## Loads that reach the repeatability"), Text(text), Shown(columns, rows)]


def _differences_of(robot: ParallelRobot, pose: FloatArray, centre: FloatArray) -> Callable[[float], dict[str, float]]:
    """A function of the mass (kg) that gives the differences in micrometres and microradians at a pose."""
    load = Payload(robot.coordinates)
    equilibrium = Equilibrium(robot, Wrench(robot.coordinates), robot.compliance)
    jacobians = robot.jacobians(pose)
    lengths = robot.lengths(pose)

    def differences(mass: float) -> dict[str, float]:
        wrench = load.wrenches(jacobians.rotation, np.array([mass, *centre, *robot.gravity]))
        plain = observation_matrix(jacobians, wrench) @ robot.compliance
        geometric = geometric_stiffness(robot, pose, actuator_forces(jacobians, wrench))
        conservative = np.linalg.solve(cartesian_stiffness(jacobians, robot.compliance) + geometric, wrench)
        start = (pose + plain)[None]
        exact = equilibrium.poses(start, lengths[None], wrench[None], np.zeros((1, 6)))[0] - pose
        result = {}
        for name, other in (("mapping", conservative), ("equilibrium", exact)):
            off = 1e6 * (other - plain)
            result[f"{name}_translation_um"] = float(np.linalg.norm(off[:3]))
            result[f"{name}_rotation_urad"] = float(np.linalg.norm(off[3:]))
        return result

    return differences


def _differences(robot: ParallelRobot, section: RobotSection, settings: Settings) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    for pose in section.poses:
        differences = _differences_of(robot, np.array(pose), np.array(section.centre_of_mass_m))
        for mass in sorted({*settings.masses_kg, section.rated_kg}):
            rows.append({"robot": robot.name, "pose": _text(pose), "mass_kg": mass} | differences(mass))
    return rows


def _reached(robot: ParallelRobot, section: RobotSection, settings: Settings) -> list[dict[str, object]]:
    """Mass at which each difference reaches the repeatability."""
    limits = {"translation_um": 1e6 * settings.repeatability_m, "rotation_urad": 1e6 * settings.repeatability_rad}
    rows: list[dict[str, object]] = []
    for pose in section.poses:
        differences = _differences_of(robot, np.array(pose), np.array(section.centre_of_mass_m))
        for mapping in MAPPINGS:
            masses = [_crossing(differences, f"{mapping}_{kind}", limit) for kind, limit in limits.items()]
            row: dict[str, object] = {"robot": robot.name, "pose": _text(pose), "against": mapping}
            row |= {"translation_kg": masses[0], "rotation_kg": masses[1], "mass_kg": np.nanmin(masses)}
            rows.append(row | {"rated_kg": section.rated_kg})
    return rows


def _crossing(differences: Callable[[float], dict[str, float]], name: str, limit: float) -> float:
    """Least mass (kg) at which a difference reaches a limit, NaN where it does not."""

    def excess(logarithm: float) -> float:
        return float(np.log(max(differences(float(np.exp(logarithm)))[name], 1e-300) / limit))

    low = float(np.log(_LEAST))
    steps = np.log(np.geomspace(_LEAST, _MOST, 29)[1:])
    for high in steps.tolist():
        if excess(high) >= 0.0:
            return float(np.exp(brentq(excess, low, high, xtol=1e-10)))
        low = high
    return float("nan")


def _text(pose: list[float]) -> str:
    return " ".join(f"{value:g}" for value in pose)


def _mass(value: float) -> str:
    """A mass (kg) to three digits."""
    return "–" if np.isnan(value) else f"{float(f'{value:.2e}'):.10g}"
