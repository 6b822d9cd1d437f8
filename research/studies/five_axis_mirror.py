"""Appendix C: a mirror, whose rotation about its own axis does not matter."""

from dataclasses import replace
from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.simulation import simulate
from expdesign.io.schema import Count, Number
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.deflection_noise import series_by_pose
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.sampling import starting_designs
from research.studies.drawing import draw_map, panels
from research.studies.pose_errors import deviation_frame, deviation_table
from research.studies.study import Picture, Piece, Shown, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, rows_of


class Settings(StudySection):
    """Configuration of the study."""

    problem: dict[str, object] = Field(description="Run configuration of the study.")
    plans: Count = Field(description="Number of random plans from which the best is taken.")
    plans_seed: Annotated[int, Field(strict=True, ge=0)] = Field(description="Seed of the random plans.")
    largest_angle_rad: Number = Field(description="Largest rotation of the target in the map (rad).")
    map_points: Count = Field(description="Points of the map per axis.")


class FiveAxisMirror(Study):
    """What selected angles leak, and what it costs to choose a plan by them."""

    title = "Appendix C: a mirror with five axes that matter"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        problem = problem_from_document(document.where("problem"))
        selected = replace(problem, targets=_selected(problem))
        best, plans = [], _plans(problem, settings)
        values = {name: _criterion(here, plans) for name, here in (("body", problem), ("angles", selected))}
        for name, found in values.items():
            index = int(np.argmin(found))
            best.append({"chosen_by": name, "plan": index + 1, **{key: each[index] for key, each in values.items()}})
        chosen = int(np.argmin(values["body"]))
        plan = Plan(plans[0][chosen], plans[1][chosen], series_by_pose(plans[0][chosen]))
        frames = []
        result = simulate(problem, plan, settings.samples, settings.seed)
        for target in range(len(problem.targets.weights)):
            labels = {"target": target + 1}
            frames.append(deviation_frame(labels, result.errors[:, target], result.predicted_covariance[target]))
        return {
            "leak": StudyTable(_leak(problem, settings), digits=5),
            "target": StudyTable(_axes_of_targets(problem), digits=5),
            "choice": StudyTable(pd.DataFrame(best)),
            "attained": StudyTable(pd.concat(frames, ignore_index=True)),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        leak = tables["leak"]
        figure, axes = panels(1, 2, 3.4, 2.8)
        angles = column(leak, "rx_rad"), column(leak, "ry_rad")
        for axis, name in zip(axes, ("x", "y")):
            draw_map(axis, *angles, column(leak, f"leak_{name}"), f"angle rz in the body's {name}")
            axis.set_xlabel("rx (rad)")
            axis.set_ylabel("ry (rad)")
        return {"leak": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        rows = {row.chosen_by: row for row in rows_of(tables["choice"])}
        worse = 100.0 * (rows["angles"].body / rows["body"].body - 1.0)
        missed = 100.0 * (rows["angles"].angles / rows["angles"].body - 1.0)
        same = rows["angles"].plan == rows["body"].plan
        target = rows_of(tables["target"])[0]
        return [
            Text("## What leaks"),
            Text(
                "A mirror of revolution may turn about its own axis. With R = Rz·Ry·Rx, leaving out the angle rz "
                "is not that: away from zero rotation an error of rz turns the mirror about its own x and y too. "
                f"At rx = {target.rx_rad:g}, ry = {target.ry_rad:g} rad it does by {target.leak_x:+.3f} and "
                f"{target.leak_y:+.3f} of itself (the reconstruction: −0.15 and +0.10)."
            ),
            Picture("leak", "How much of an error of the angle rz is a rotation about the body's own x and y."),
            Text("## What it changes"),
            Text(
                "`tolerance_axes: body` at a target means rotations about the axes of the platform, W = SᵀBS with "
                f"S = blkdiag(I, RᵀE). Of {settings.plans} random plans, the best by selected angles "
                + ("is the best by the axes of the body too" if same else f"has {worse:.1f} % more DUIR than the best")
                + f"; what selected angles say of it is {missed:+.1f} % off."
            ),
            Shown(
                ["best of the random plans by", "no.", "DUIR, axes of the body", "DUIR, selected angles"],
                [[name, str(row.plan), f"{row.body:.4f}", f"{row.angles:.4f}"] for name, row in rows.items()],
            ),
            Text("## Attained"),
            Text(
                f"{settings.samples} repetitions with the plan that is best by the axes of the body, load errors "
                "included; rotations are about the mirror's own axes. rz does not matter, and is predicted "
                "all the same."
            ),
            deviation_table(tables["attained"], {"target": "target", "axis": "axis"}),
        ]


def _selected(problem: DesignProblem) -> Targets:
    """The same targets with the tolerances on the angles themselves."""
    targets = problem.targets
    assert targets.axes is not None
    return replace(targets, observation=np.linalg.solve(targets.axes, targets.observation), axes=None)


def _plans(problem: DesignProblem, settings: Settings) -> tuple[FloatArray, FloatArray]:
    space = problem.space
    decisions = starting_designs(problem, settings.plans, np.random.default_rng(settings.plans_seed))
    return space.decode(decisions)


def _criterion(problem: DesignProblem, plans: tuple[FloatArray, FloatArray]) -> FloatArray:
    return known_criteria()["duir"].values(problem.assess(*plans))


def _leak(problem: DesignProblem, settings: Settings) -> pd.DataFrame:
    """Third column of RᵀE over rx and ry."""
    values = np.linspace(-settings.largest_angle_rad, settings.largest_angle_rad, settings.map_points)
    rows = [_leak_at(problem, float(rx), float(ry)) for rx in values for ry in values]
    return pd.DataFrame(rows)


def _leak_at(problem: DesignProblem, rx: float, ry: float) -> dict[str, float]:
    jacobians = problem.loaded.robot.jacobians(np.array([0.0, 0.0, 0.0, rx, ry, 0.0]))
    turned = jacobians.rotation.T @ (jacobians.forward @ np.linalg.inv(jacobians.pose))[3:, 3:]
    return {"rx_rad": rx, "ry_rad": ry, "leak_x": float(turned[0, 2]), "leak_y": float(turned[1, 2])}


def _axes_of_targets(problem: DesignProblem) -> pd.DataFrame:
    poses = problem.targets.configurations
    return pd.DataFrame([_leak_at(problem, float(pose[3]), float(pose[4])) for pose in poses])
