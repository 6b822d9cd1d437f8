"""The three maps of elastostatics against finite differences of the equilibrium, for every robot of the table."""

from functools import partial

import numpy as np
import pytest

from expdesign.mechanics.elastostatics.maps import (
    actuator_forces,
    cartesian_compliance,
    cartesian_stiffness,
    geometric_stiffness,
    observation_matrix,
)
from expdesign.mechanics.robots.parallel import ParallelRobot
from tests import oracle
from tests.cases import ROBOTS, robot
from tests.oracle import Array, central_difference
from tests.robots.test_kinematics import relative, scaled

every_robot = pytest.mark.parametrize("name", ROBOTS)


def states(name: str, count: int = 10) -> tuple[ParallelRobot, Array, Array]:
    """The robot with poses (count, n) and wrenches (count, n)."""
    generator = np.random.default_rng(7)
    return robot(name), ROBOTS[name].poses(generator, count), ROBOTS[name].wrenches(generator, count)


def restoring_wrench(here: ParallelRobot, poses: Array, forces: Array, rests: Array) -> Array:
    """F = J⁻ᵀ·(τ + K·(q(X) − q_rest)): what holds the platform at `poses` against its springs (by hand)."""
    kin = oracle.kinematics(here, poses)
    springs = forces + here.stiffness * (kin.lengths - rests)
    return np.linalg.solve(kin.forward.swapaxes(-1, -2), springs[..., None])[..., 0]


def loaded_pose(here: ParallelRobot, poses: Array, wrenches: Array, compliance: Array) -> Array:
    """Equilibrium of the springs with the commands of `poses`: q(X) = q_cmd + c∘(JᵀF), by Newton's method."""
    command = oracle.kinematics(here, poses).lengths
    found = poses.copy()
    for _ in range(30):
        kin = oracle.kinematics(here, found)
        forces = np.einsum("...rj,...r->...j", kin.forward, wrenches)
        found = found + np.einsum("...ij,...j->...i", kin.pose, command + compliance * forces - kin.lengths)
    return found


@every_robot
def test_observation_matrix_is_that_of_the_sums(name: str) -> None:
    here, poses, wrenches = states(name)
    found = observation_matrix(here.jacobians(poses), wrenches)
    expected = oracle.observation(here, poses, wrenches)
    assert relative(scaled(here, found - expected), scaled(here, expected)) < 1e-10
    found = cartesian_compliance(here.jacobians(poses), here.compliance)
    expected = oracle.compliance(here, poses)
    assert relative(scaled(here, found - expected), scaled(here, expected)) < 1e-10


@every_robot
def test_compliance_is_the_derivative_of_the_loaded_pose(name: str) -> None:
    """D = ∂X/∂F of the full equilibrium at no load."""
    here, poses, _ = states(name)
    exact = cartesian_compliance(here.jacobians(poses), here.compliance)
    units = np.where(np.arange(here.coordinates.n) < here.coordinates.translations, 1.0, ROBOTS[name].lever)
    step = 1e-6 * float(here.stiffness.min())

    def pose_of(wrenches: Array) -> Array:
        return loaded_pose(here, poses, wrenches * units, here.compliance)

    found = central_difference(pose_of, np.zeros(poses.shape), step)
    assert relative(scaled(here, found - exact * units), scaled(here, exact * units)) < 1e-6


@every_robot
def test_observation_matrix_is_the_derivative_of_the_loaded_pose(name: str) -> None:
    """A = ∂X/∂c of the full equilibrium at rigid legs."""
    here, poses, wrenches = states(name)
    exact = observation_matrix(here.jacobians(poses), wrenches)
    step = 0.02 * float(here.compliance.min())

    def pose_of(compliances: Array) -> Array:
        return loaded_pose(here, poses, wrenches, compliances)

    found = central_difference(pose_of, np.zeros((len(poses), len(here.stiffness))), step)
    assert relative(scaled(here, found - exact), scaled(here, exact)) < 1e-6


@every_robot
def test_stiffness_is_the_derivative_of_the_restoring_wrench(name: str) -> None:
    """K_C at rest, K_C + K_G with forces in the legs (theory.md 2.3)."""
    here, poses, wrenches = states(name)
    jacobians = here.jacobians(poses)
    stiffness = cartesian_stiffness(jacobians, here.compliance)
    rests = here.lengths(poses)
    for forces in (np.zeros_like(rests), 100.0 * actuator_forces(jacobians, wrenches)):
        found = central_difference(partial(restoring_wrench, here, forces=forces, rests=rests), poses, 1e-5)
        exact = stiffness + geometric_stiffness(here, poses, forces)
        assert relative(found - exact, exact) < 1e-6


@every_robot
def test_geometric_stiffness_is_that_of_the_hand_formula(name: str) -> None:
    here, poses, wrenches = states(name)
    forces = actuator_forces(here.jacobians(poses), wrenches)
    exact = geometric_stiffness(here, poses, forces)
    assert relative(oracle.geometric_stiffness(here, poses, forces) - exact, exact) < 1e-10


def test_size_of_the_geometric_stiffness_of_the_default_hexapod() -> None:
    """theory.md 2.3 (C3): ‖K_C⁻¹K_G‖ is of the order of 1.8e-3 for H1 at 1200 N."""
    here, pose = robot("H1"), np.zeros(6)
    jacobians = here.jacobians(pose)
    wrench = np.array([0.0, 0.0, -1200.0, 0.0, 0.0, 0.0])
    geometric = geometric_stiffness(here, pose, actuator_forces(jacobians, wrench))
    ratio = np.linalg.norm(cartesian_compliance(jacobians, here.compliance) @ geometric, 2)
    assert 3e-4 < ratio < 6e-3
