"""The numbers on docs/theory.md are those of the program."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.mechanics.elastostatics.maps import (
    actuator_forces,
    cartesian_compliance,
    cartesian_stiffness,
    geometric_stiffness,
    observation_matrix,
)
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Wrench
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.deflection_noise import DeflectionNoise
from tests.cases import robot

PAGE = (Path(__file__).parents[2] / "docs/theory.md").read_text(encoding="utf-8")


def vectors(name: str) -> dict[str, Any]:
    found = re.search(rf'```json title="{name}"\n(.*?)```', PAGE, flags=re.DOTALL)
    content: dict[str, Any] = json.loads(found[1])
    return content


def test_bipod() -> None:
    here, printed = robot("bipod"), vectors("bipod")
    target, target_load = np.array([0.10, 0.60]), np.array([0.0, -1000.0])
    pose, load = np.array([-0.20, 0.55]), np.array([200.0, -900.0])
    at_target, measured = here.jacobians(target), here.jacobians(pose)
    loaded = LoadedRobot(here, Wrench(here.coordinates))
    observation = loaded.measure(target[None], target_load[None]).observation
    targets = Targets(target[None], observation, np.ones((1, 2)), np.ones(1), 2)
    noise = DeflectionNoise.from_deviations(np.arange(2), np.ones(2))
    assessment = Assessment(loaded.measure(pose[None, None], load[None, None]), noise, (), targets)
    forces = actuator_forces(at_target, target_load)
    root = assessment.noise_root[0, 0]
    computed = {
        "J_D": at_target.pose,
        "tau_D": forces,
        "A_D": observation[0],
        "deflection_D_um": 1e6 * observation[0] @ here.compliance,
        "D_D_um_per_N": 1e6 * cartesian_compliance(at_target, here.compliance),
        "K_C": cartesian_stiffness(at_target, here.compliance),
        "tau_M": actuator_forces(measured, load),
        "A_M": observation_matrix(measured, load),
        "U": root @ root.T,
        "Z_um_per_N": 1e6 * assessment.force_sensitivity()[0, 0],
        "K_G": geometric_stiffness(here, target, forces),
        "o1_to_o5": [float(known_criteria()[f"o{i}"].values(assessment)[0]) for i in range(1, 6)],
    }
    assert set(printed) == {*computed, "q_D", "X_C"}
    for name, values in computed.items():
        digits = 2e-6 if name in ("K_G", "o1_to_o5") else 1e-9  # as many as are printed
        np.testing.assert_allclose(values, printed[name], rtol=digits, atol=1e-9 * np.abs(printed[name]).max())
    np.testing.assert_allclose(assessment.noise_variance[0, 0], np.diag(computed["U"]), rtol=1e-14)
    np.testing.assert_allclose(known_criteria()["o_tp"].values(assessment), np.trace(computed["U"]), rtol=1e-10)
    np.testing.assert_allclose(here.lengths(target), printed["q_D"], rtol=0.0, atol=5e-11)  # type: ignore[attr-defined]
    np.testing.assert_array_equal(at_target.pose, at_target.forward)
    command = target.copy()
    for _ in range(20):
        deflection = observation_matrix(here.jacobians(command), target_load) @ here.compliance
        command = target - deflection
    np.testing.assert_allclose(command, printed["X_C"], atol=1e-12)


def test_hexapod() -> None:
    here, printed = robot("H1"), vectors("hexapod")
    pose, load = np.array([0.02, -0.01, 0.005, 0.05, -0.08, 0.1]), np.array([20.0, -30.0, -300.0, 10.0, 5.0, -2.0])
    jacobians = here.jacobians(pose)
    np.testing.assert_allclose(here.lengths(pose), printed["q"], rtol=0.0, atol=5e-11)  # type: ignore[attr-defined]
    np.testing.assert_allclose(actuator_forces(jacobians, load), printed["tau"], rtol=1e-8)
    deflection = observation_matrix(jacobians, load).sum(axis=-1) / 5e6
    np.testing.assert_allclose(deflection, printed["deflection_at_5_N_per_um"], rtol=1e-8)


def test_what_is_said_of_the_convention_and_of_the_stiffness() -> None:
    """2.2: T differs from the identity by 0.10 at ry = 0.1 rad, and not at all by rx alone; Σu_iz² = 4.514 (C2), which
    calibrates 23.64 N/µm to 5.24 N/µm per leg.
    """
    here = robot("H1")
    for pose, expected in ((np.array([0, 0, 0, 0, 0.1, 0.0]), 0.10), (np.array([0, 0, 0, 0.1, 0, 0.0]), 0.0)):
        jacobians = here.jacobians(pose)
        rates = jacobians.pose @ np.linalg.inv(jacobians.forward)
        assert abs(np.linalg.norm(rates - np.eye(6)) - expected) < 1e-3
    directions = np.linalg.inv(here.jacobians(np.zeros(6)).forward)[:, 2]
    assert abs((directions**2).sum() - 4.514) < 5e-4
    assert abs(260.0 / 11e-6 / (directions**2).sum() - 5.24e6) < 5e3
