"""Chapter 1: the loads at which the mappings differ by the repeatability, with hand-derived kinematics."""

import numpy as np
import pytest

from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot_file import read_robot
from research.studies.stiffness_mapping import StiffnessMapping
from research.studies.tables import rows_of
from research.studies.tests.kept import ROOT, kept
from tests import oracle

STUDY = StiffnessMapping.name()


def robot(name: str) -> ParallelRobot:
    found = read_robot(ROOT / "configs" / "robots" / f"{name}.yaml")
    assert isinstance(found, ParallelRobot)
    return found


def conservative_difference(machine: ParallelRobot, pose: np.ndarray, mass: float) -> np.ndarray:
    """(K_C + K_G)⁻¹·F − K_C⁻¹·F with K_G = ∂(J⁻ᵀτ)/∂X by central differences of hand-derived Jacobians."""
    here = oracle.kinematics(machine, pose)
    load = oracle.load_wrench("payload", np.array([mass, 0.03, 0.02, 0.15, 0.0, 0.0, -9.80665]), here.rotation)
    compliance = oracle.compliance(machine, pose)
    forces = here.forward.T @ load
    columns = []
    for axis in range(6):
        step = np.zeros(6)
        step[axis] = 1e-6
        pair = [np.linalg.inv(oracle.kinematics(machine, pose + sign * step).forward).T @ forces for sign in (1, -1)]
        columns.append((pair[0] - pair[1]) / 2e-6)
    stiffness = np.linalg.inv(compliance) + np.stack(columns, axis=1)
    return np.linalg.solve(stiffness, load) - compliance @ load


def test_differences_are_the_repeatability_at_the_loads_found() -> None:
    for row in rows_of(kept(STUDY, "reached").query("against == 'mapping'")):
        pose = np.array([float(value) for value in row.pose.split()])
        machine = robot(row.robot)
        moved = conservative_difference(machine, pose, row.translation_kg)
        turned = conservative_difference(machine, pose, row.rotation_kg)
        assert np.linalg.norm(moved[:3]) == pytest.approx(0.75e-6, rel=1e-3)
        assert np.linalg.norm(turned[3:]) == pytest.approx(3.25e-6, rel=1e-3)


def test_differences_grow_with_the_square_of_light_loads() -> None:
    rows = kept(STUDY, "differences").set_index(["robot", "pose", "mass_kg"])
    for name, pose in {(robot, pose) for robot, pose, _ in rows.index}:
        for column in rows.columns:
            light, heavier = rows.loc[(name, pose, 5.0), column], rows.loc[(name, pose, 50.0), column]
            if light > 1e-9:  # at the zero pose of a symmetric robot the rest is rounding
                assert heavier / light == pytest.approx(100.0, rel=0.03)


def test_at_the_rated_load_the_simplification_is_sound() -> None:
    """The thesis leaves the term out: far below the repeatability where the robots are used."""
    table_of = kept(STUDY, "differences")
    for name, rated in (("hexapod-h1", 26.5), ("hexapod-120kg", 120.0)):
        rows = table_of[(table_of["robot"] == name) & (table_of["mass_kg"] == rated)]
        assert len(rows) == 5
        assert rows.filter(like="translation").to_numpy().max() < 0.01 * 0.75
        assert rows.filter(like="rotation").to_numpy().max() < 0.01 * 3.25
