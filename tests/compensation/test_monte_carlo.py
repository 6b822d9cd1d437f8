"""Monte-Carlo of the whole method against an independent implementation, its own equations, and known limits."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from expdesign.assurance.validation.compensation import TOLERANCE, ExactCompensation
from expdesign.assurance.validation.repeated import repeat, root_mean_square, standard_deviation
from expdesign.assurance.validation.simulation import simulate
from expdesign.mechanics.elastostatics.maps import actuator_forces, cartesian_stiffness, geometric_stiffness
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Payload, Wrench
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.deflection_noise import DeflectionNoise
from expdesign.planning.plan import Plan
from research.laboratory import Laboratory
from research.laboratory import Robot as LaboratoryRobot
from research.studies.equilibrium import Equilibrium
from tests import oracle
from tests.cases import ALL_ERRORS, ROBOTS, Setup, content_of, robot, setup
from tests.oracle import Array
from tests.robots.arms import ARMS, serial_robot

SAMPLES = 500


def oracle_errors(here: Setup, estimates: Array, target: int) -> Array:
    """X̂_A − X_D (s, n) by a plain fixed point on hand-derived Jacobians."""
    machine, wanted = robot(here.name), here.targets.configurations[target]
    load = here.target_wrenches[target]
    command = np.broadcast_to(wanted, (len(estimates), len(wanted)))
    for _ in range(8):
        predicted = np.einsum("sij,sj->si", oracle.observation(machine, command, load), estimates)
        command = wanted - predicted
    return command + oracle.observation(machine, command, load) @ machine.compliance - wanted


def oracle_estimates(here: Setup, plan: Plan, deflections: Array) -> Array:
    """ĉ (s, n_p) by generalised least squares, assuming the nominal wrenches."""
    machine = robot(here.name)
    turned = oracle.kinematics(machine, plan.configurations).rotation
    assumed = oracle.load_wrench(here.loaded.load.kind, plan.loads, turned)
    a = oracle.observation(machine, plan.configurations, assumed)
    weight = np.linalg.inv(here.noise.covariance)
    information = np.einsum("mip,ij,mjq->pq", a, weight, a)
    scale = 1.0 / np.sqrt(np.diag(information))
    right = np.einsum("mip,ij,smj->sp", a, weight, deflections) * scale
    return np.linalg.solve(information * np.outer(scale, scale), right.T).T * scale


@pytest.mark.parametrize("kind", ["payload", "wrench"])
@pytest.mark.parametrize("name", ["bipod", "irregular", "moving-xyz", "camera"])
def test_against_an_independent_implementation(name: str, kind: str) -> None:
    """Estimates and attained errors, repetition by repetition, from the same draws."""
    here = setup(name, kind, "covariance", tuple(e for e in ALL_ERRORS if e[0] != "com" or kind == "payload"))
    plan = here.plan(np.random.default_rng(1), 4)
    result = simulate(here.problem(), plan, SAMPLES, 5, noise=False)
    generator = np.random.default_rng([5, 0, 1])
    added = here.loaded.drawn_errors(plan.configurations, plan.loads, SAMPLES, generator)
    turned = oracle.kinematics(robot(name), plan.configurations).rotation
    wrenches = oracle.load_wrench(kind, plan.loads, turned) + added
    deflections = np.einsum("mij,smj->smi", oracle.compliance(robot(name), plan.configurations), wrenches)
    estimates = oracle_estimates(here, plan, deflections)
    np.testing.assert_allclose(result.estimates, estimates, rtol=1e-8)
    for target in range(len(here.targets.configurations)):
        expected = oracle_errors(here, result.estimates, target)
        np.testing.assert_allclose(result.errors[:, target], expected, atol=3e-13)


@pytest.mark.parametrize("name", list(ROBOTS))
def test_commands_solve_the_fixed_point_however_wrong_the_estimates(name: str) -> None:
    here = setup(name, "wrench")
    machine, target, load = robot(name), here.targets.configurations[0], here.target_wrenches[0]
    scatter = 1.0 + 0.3 * np.random.default_rng(2).standard_normal((SAMPLES, len(machine.stiffness)))
    estimates = machine.compliance * scatter
    attained = ExactCompensation(here.loaded, target, load, machine.compliance).attained(estimates)
    maps = oracle.observation(machine, attained.commands, load)
    off = attained.commands + np.einsum("sij,sj->si", maps, estimates) - target
    assert attained.residual <= TOLERANCE
    assert np.abs(off).max() < 3e-13
    errors = np.einsum("sij,sj->si", maps, machine.compliance - estimates)
    np.testing.assert_allclose(attained.errors, errors, atol=3e-13)  # the exact identity of theory.md 4.1


def test_equilibrium_is_that_of_the_virtual_laboratory() -> None:
    """An independent engine at tens of times the rated load, the payload's moment turning with the platform."""
    machine = robot("H1")
    poses = ROBOTS["H1"].poses(np.random.default_rng(14), 4)
    payload = np.array([500.0, 0.03, 0.02, 0.15])
    rows = pd.DataFrame(poses, columns=list(machine.configuration)).assign(
        **dict(zip(("mass_kg", "com_x_m", "com_y_m", "com_z_m"), payload.tolist()))
    )
    laboratory = Laboratory(LaboratoryRobot.from_mapping(content_of(machine)), true_stiffness=list(machine.stiffness))
    loads = np.tile([*payload, *machine.gravity], (4, 1))
    solver = Equilibrium(machine, Payload(machine.coordinates), machine.compliance)
    found = solver.poses(poses, machine.lengths(poses), loads, np.zeros_like(poses))
    np.testing.assert_allclose(found, laboratory.attained(rows).to_numpy(), atol=1e-12)


@pytest.mark.parametrize("name", ["bipod", "irregular"])
def test_equilibrium_yields_by_the_conservative_stiffness(name: str) -> None:
    """dX/dF of the equilibrium under load is (K_C + K_G)⁻¹ at the loaded pose (theory.md 2.3)."""
    machine = robot(name)
    generator = np.random.default_rng(5)
    pose, load = ROBOTS[name].poses(generator), 20.0 * ROBOTS[name].wrenches(generator)
    solver = Equilibrium(machine, Wrench(machine.coordinates), machine.compliance)
    step = np.diag(np.maximum(np.abs(load), 1.0) * 1e-3)
    loads = np.concatenate([load[None], load + step, load - step])
    start = np.broadcast_to(pose, loads.shape)
    lengths = np.broadcast_to(machine.lengths(pose), (len(loads), len(machine.stiffness)))
    loaded, *moved = solver.poses(start, lengths, loads, np.zeros_like(loads))
    n = len(pose)
    slope = (np.array(moved[:n]) - np.array(moved[n:])).T / (2.0 * np.diag(step))
    stiffness = machine.jacobians(loaded)
    forces = actuator_forces(stiffness, load)
    total = cartesian_stiffness(stiffness, machine.compliance) + geometric_stiffness(machine, loaded, forces)
    scale = np.sqrt(np.abs(np.diag(slope)))
    np.testing.assert_allclose(slope / np.outer(scale, scale), np.linalg.inv(total) / np.outer(scale, scale), atol=1e-6)


def test_batches_and_causes_have_streams_of_their_own() -> None:
    here = setup("bipod", "payload", errors=ALL_ERRORS)
    plan = here.plan(np.random.default_rng(7), 3)
    many = simulate(here.problem(), plan, 10_200, 8)
    few = simulate(here.problem(), plan, 10_000, 8)
    np.testing.assert_array_equal(many.estimates[:10_000], few.estimates)
    noise = simulate(here.problem(), plan, 10_000, 8, load_errors=False)
    loads = simulate(here.problem(), plan, 10_000, 8, noise=False)
    true = robot("bipod").compliance
    np.testing.assert_allclose(noise.estimates + loads.estimates - true, few.estimates, rtol=1e-12)
    assert np.abs(many.estimates[10_000] / many.estimates[0] - 1.0).min() > 1e-6


@pytest.mark.parametrize("distribution", ["normal", "uniform"])
def test_load_errors_of_any_distribution_have_the_predicted_deviation(distribution: Any) -> None:
    here = setup("irregular", "payload", errors=ALL_ERRORS)
    plan = here.plan(np.random.default_rng(9), 4)
    repeated = repeat(here.problem(), plan, 40_000, 10, distribution=distribution)
    assert set(repeated.causes) == {"duir", "feir", "total"}
    assert np.abs(repeated.scores()).max() < 3.0
    estimate, predicted = repeated.deviations["feir"]
    assert np.abs(estimate.value / predicted - 1.0).max() < 0.03


@pytest.mark.parametrize("name", ["ur5", "tiago"])
def test_arms_are_compensated_in_their_joints(name: str) -> None:
    """The prediction holds for arms, and the tip is where the true deflection of the joints leaves it."""
    arm = serial_robot(ARMS[name])
    generator = np.random.default_rng(12)
    lower = arm.reference_configuration()
    joints = lower + generator.uniform(-0.4, 0.4, (3, len(lower)))
    wrenches = generator.uniform(-1.0, 1.0, (3, 6)) * np.array([80.0, 80.0, 80.0, 20.0, 20.0, 20.0])
    loaded = LoadedRobot(arm, Wrench(arm.coordinates))
    noise = DeflectionNoise.from_deviations(np.arange(6), np.array([2e-5] * 3 + [4e-5] * 3))
    observation = loaded.measure(joints[:1], wrenches[:1]).observation
    targets = Targets(joints[:1], observation, np.full((1, 6), 1e8), np.ones(1), 3)
    here = Setup(name, loaded, noise, targets, wrenches[:1])
    plan = Plan(np.repeat(joints, 2, axis=0), generator.uniform(-80.0, 80.0, (6, 6)), np.arange(6))
    assert np.abs(repeat(here.problem(), plan, 20_000, 13).scores()).max() < 3.5  # 14 comparisons
    estimates = simulate(here.problem(), plan, 50, 13).estimates
    attained = ExactCompensation(loaded, joints[0], wrenches[0], arm.compliance).attained(estimates)
    forces = wrenches[0] @ arm.jacobians(attained.commands).forward
    np.testing.assert_allclose(attained.commands + estimates * forces, np.tile(joints[0], (50, 1)), atol=3e-13)
    reached = arm.position(attained.commands + arm.compliance * forces) - arm.position(joints[0])
    np.testing.assert_allclose(attained.errors[:, :3], reached, atol=1e-9 * np.abs(reached).max() + 1e-15)


def test_rounding_beside_a_prediction_of_nothing_is_no_difference() -> None:
    """Load errors of 1e-30 N leave only the rounding of the compensation."""
    here = setup("bipod", "payload", errors=(("wrench", True),))
    here.loaded.sources[0].deviation[:] = 1e-30
    repeated = repeat(here.problem(), here.plan(np.random.default_rng(15), 3), 1000, 16)
    assert repeated.criteria["feir"][1] < 1e-20
    assert repeated.criterion_score("feir") == 0.0
    assert not repeated.deviation_score("feir").any()
    assert repeated.deviation_score("duir").all()


def test_standard_errors_are_those_of_the_estimates() -> None:
    """Their own Monte-Carlo: 400 simulations of 500 samples of two distributions."""
    generator = np.random.default_rng(11)
    for samples in (generator.standard_normal((500, 400)), generator.uniform(-1.0, 1.0, (500, 400))):
        for function in (standard_deviation, root_mean_square):
            estimate = function(samples)
            assert estimate.standard_error.mean() == pytest.approx(estimate.value.std(ddof=1), rel=0.12)
