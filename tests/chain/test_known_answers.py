"""Single effects where the answer is known without the chain."""

from collections.abc import Callable
from itertools import pairwise

import casadi as ca
import numpy as np
import pandas as pd
import pytest
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.row import row_data
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.orientation import Orientation, angles_of, rotation_matrix, rotation_vector
from expdesign.mechanics.robots.parallel import ParallelRobot
from tests.cases import ROBOTS, robot
from tests.chain.kinds import kind_for
from tests.chain.places import PAYLOAD, WRENCH, recordings, rows
from tests.identification.experiments import read
from tests.oracle import Array

ROBOT = "irregular"


def effect(physics: str, component: str, variant: str = "", name: str = ROBOT) -> Effect:
    return kind_for(robot(name), recordings(name), physics).from_text(robot(name), component, variant)


def predicted(one: Effect, parameters: list[float], frame: pd.DataFrame) -> Array:
    """Readings with an effect, compliances as approximated."""
    here = one.robot
    assert isinstance(here, ParallelRobot)
    chain = Chain(here, (one,))
    values = np.concatenate([np.ones(chain.compliances), parameters])
    return chain.predict(row_data(read(frame, here), here), values)


def base(frame: pd.DataFrame, name: str = ROBOT) -> Array:
    chain = Chain(robot(name))
    return chain.predict(row_data(read(frame, robot(name)), robot(name)), chain.start())


def forces(frame: pd.DataFrame, name: str = ROBOT) -> Array:
    """τ of every row (N, n_p)."""
    points = read(frame, robot(name))
    return np.einsum("nij,ni->nj", robot(name).jacobians(points.configurations).forward, points.wrenches)


def in_legs(deflections: Array, frame: pd.DataFrame, name: str = ROBOT) -> Array:
    """J̌⁻¹·ΔX of every row (N, n_p)."""
    points = read(frame, robot(name))
    maps = robot(name).jacobians(points.configurations).pose
    return np.linalg.solve(maps, deflections[..., None])[..., 0]


def one_series(loads: list[float], times: list[float] | None = None) -> pd.DataFrame:
    """Multiples of one wrench at one pose."""
    frame = rows(ROBOT, WRENCH, series=1, loads=len(loads))
    wrench = list(robot(ROBOT).coordinates.wrench)
    frame[wrench] = np.outer(loads, frame[wrench].iloc[0])
    frame = frame.drop(columns=[f"abs_{name}" for name in wrench])
    return frame.assign(time_s=np.arange(len(loads), dtype=float) if times is None else times)


def test_creep_approaches_one_plus_its_ratio() -> None:
    """Loaded right after the first row: 1 + ratio·(1 − exp(−t/τ)), and without load it comes back."""
    times = [0.0, 10.0, 110.0, 1e5, 1.0001e5, 2e5]
    frame = one_series([0.0, 1.0, 1.0, 1.0, 0.0, 0.0], times)
    crept = in_legs(predicted(effect("creep", "leg 3"), [0.25, 100.0, 0.0], frame), frame)[:, 2]
    linear = in_legs(base(frame), frame)[1, 2]
    expected = [0.0, 1 - np.exp(-0.1), 1 - np.exp(-1.1), 1.0, np.exp(-0.1), 0.0]
    np.testing.assert_allclose(crept, linear * (np.array([0, 1, 1, 1, 0, 0]) + 0.25 * np.array(expected)), atol=1e-15)


def test_a_load_that_was_just_put_on_has_not_crept() -> None:
    frame = one_series([0.0, 1.0], [0.0, 50.0])
    np.testing.assert_allclose(predicted(effect("creep", "all legs"), [0.5, 20.0, 1.0], frame), base(frame), atol=1e-18)


@pytest.mark.parametrize(("rest", "pulled", "pressed"), [("middle", 0.5, -0.5), ("short", 1, 0), ("long", 0, -1)])
def test_play_moves_the_platform_along_the_column_of_its_leg(rest: str, pulled: float, pressed: float) -> None:
    gap, frame = 3e-6, one_series([0.0, 1.0, -1.0])
    jump = predicted(effect("leg_backlash", "leg 4", rest), [gap], frame) - base(frame)
    points = read(frame, robot(ROBOT))
    column = robot(ROBOT).jacobians(points.configurations).pose[0, :, 3]
    force = forces(frame)[:, 3]
    expected = np.outer(np.where(force > 0, pulled, np.where(force < 0, pressed, 0.0)) * gap, column)
    np.testing.assert_allclose(jump, expected, rtol=0.0, atol=1e-17)
    np.testing.assert_allclose(np.abs(jump[1] - jump[2]), gap * np.abs(column), atol=1e-17)


def test_play_that_the_reference_load_holds_closed_does_nothing() -> None:
    """The whole load keeps its sign while its change does not."""
    frame = one_series([1.0, -1.0])
    wrench = list(robot(ROBOT).coordinates.wrench)
    frame[[f"abs_{name}" for name in wrench]] = frame[wrench] + 3.0 * frame[wrench].iloc[0].to_numpy()
    np.testing.assert_array_equal(predicted(effect("leg_backlash", "leg 1", "middle"), [1e-6], frame), base(frame))


@pytest.mark.parametrize(("variant", "shape"), [("rigid", []), ("elastic", [1e3]), ("elastic", [2.0])])
def test_the_loop_of_friction_is_twice_the_friction_wide(variant: str, shape: list[float]) -> None:
    """At the same force on the way up and down the elongation differs by 2·F·c once the slider slips."""
    steps = [0.0, 0.5, 1.0, 2.0, 1.0, 0.0, -1.0, 0.0, 1.0]
    frame = one_series(steps)
    force = forces(frame)[:, 1]
    friction = 0.02 * np.abs(force).max()
    found = in_legs(predicted(effect("friction_hysteresis", "leg 2", variant), [friction, *shape], frame), frame)[:, 1]
    compliance = robot(ROBOT).compliance[1]
    up, down, up_again = found[2], found[4], found[8]
    assert abs(up - down) == pytest.approx(2.0 * friction * compliance, rel=1e-9)
    assert up_again == pytest.approx(up, rel=1e-9)
    # Rows of the other legs are those of the base model.
    others = [leg for leg in range(6) if leg != 1]
    moved = in_legs(predicted(effect("friction_hysteresis", "leg 2", variant), [friction, *shape], frame), frame)
    np.testing.assert_allclose(moved[:, others], in_legs(base(frame), frame)[:, others], atol=1e-18)


def test_a_slider_that_does_not_slip_is_a_second_spring() -> None:
    frame = one_series([0.0, 1.0, -2.0])
    found = in_legs(predicted(effect("friction_hysteresis", "leg 2", "elastic"), [1e5, 0.5], frame), frame)[:, 1]
    np.testing.assert_allclose(found, in_legs(base(frame), frame)[:, 1] / 1.5, rtol=1e-12)


@pytest.mark.parametrize("convention", ["fixed-xyz", "moving-xyz"])
def test_angles_are_those_of_the_rotation(convention: Orientation) -> None:
    symbol = ca.SX.sym("a", 3)
    matrix = rotation_matrix(symbol, convention)
    there = ca.Function("R", [symbol], [matrix])
    back = ca.Function("a", [symbol], [angles_of(matrix, convention)])
    for angles in np.random.default_rng(0).uniform(-1.5, 1.5, (50, 3)):
        order = "xyz" if convention == "fixed-xyz" else "XYZ"
        np.testing.assert_allclose(np.array(there(angles)), Rotation.from_euler(order, angles).as_matrix(), atol=1e-15)
        np.testing.assert_allclose(np.array(back(angles)).ravel(), angles, atol=1e-13)


def test_the_rotation_vector_is_scipys_and_smooth_at_zero() -> None:
    matrix = ca.SX.sym("R", 3, 3)
    function = ca.Function("v", [matrix], [rotation_vector(matrix), ca.jacobian(rotation_vector(matrix), matrix)])
    generator = np.random.default_rng(1)
    for angle, accuracy in ((0.0, 1e-16), (1e-6, 1e-12), (0.1, 1e-8), (0.4, 2e-6), (0.6, 2e-5)):
        axis = generator.standard_normal(3)
        vector = angle * axis / np.linalg.norm(axis)
        found, slope = function(Rotation.from_rotvec(vector).as_matrix())
        np.testing.assert_allclose(np.array(found).ravel(), vector, rtol=0.0, atol=accuracy * max(angle, 1.0))
        assert np.isfinite(np.array(slope)).all()


def equilibrium(here: ParallelRobot, pose: Array, compliance: Array, wrench_at: Callable[[Array], Array]) -> Array:
    """ΔX that satisfies q(X + ΔX) = q(X) + c∘(J(X + ΔX)ᵀ·F(X + ΔX)), by a root finder (theory.md 2.3, P2)."""
    start = here.jacobians(pose)
    scale = np.abs(start.pose @ (compliance * (start.forward.T @ wrench_at(pose)))).max()

    def error(scaled: Array) -> Array:
        loaded = pose + scale * scaled
        force = here.jacobians(loaded).forward.T @ wrench_at(loaded)
        return (here.lengths(loaded) - here.lengths(pose) - compliance * force) / scale

    result, _, status, message = fsolve(error, np.zeros(len(pose)), xtol=1e-8, full_output=True)
    assert status == 1, message
    return np.asarray(scale * result)


@pytest.mark.parametrize(("name", "load"), [("irregular", PAYLOAD), ("moving-xyz", PAYLOAD), ("irregular", WRENCH)])
def test_one_whole_geometric_stiffness_is_the_full_equilibrium(name: str, load: str) -> None:
    """What the second order leaves is of the third: at most 2 % of the whole correction."""
    here, case = robot(name), ROBOTS[name]
    assert isinstance(here, Hexapod)
    frame = rows(name, load)
    if load == PAYLOAD:
        frame["mass_kg"] *= 5.0
    else:
        frame = frame.drop(columns=[f"abs_{column}" for column in here.coordinates.wrench])
    points = read(frame, here)
    found = predicted(effect("geometric_stiffness", "geometry", name=name), [1.0], frame)
    linear = base(frame, name)
    exact = np.zeros_like(found)
    for row in map(int, np.flatnonzero(np.abs(points.wrenches).max(axis=1) > 0.0)):
        pose, wrench = points.configurations[row], points.wrenches[row]

        def at(loaded: Array, row: int = row, wrench: Array = wrench) -> Array:
            if points.payload is None:
                return wrench
            lever = here.jacobians(loaded).rotation @ points.payload[row, 1:]
            return np.concatenate([wrench[:3], np.cross(lever, wrench[:3])])

        exact[row] = equilibrium(here, pose, here.compliance, at)
    deviation = np.array(case.deviation)
    before, after = (np.linalg.norm((value - exact) / deviation) for value in (linear, found))
    assert after < 0.02 * before


@pytest.mark.parametrize("end", ["base", "platform"])
def test_a_displaced_joint_is_another_robot_at_another_pose(end: str) -> None:
    """The robot with its true joints, at the pose to which the commanded lengths lead."""
    here = robot(ROBOT)
    assert isinstance(here, Hexapod)
    offset, frame = np.array([2e-3, -1e-3, 1.5e-3]), rows(ROBOT)
    joints = {"base": here.base_joints.copy(), "platform": here.platform_joints.copy()}
    joints[end][4] += offset
    true = Hexapod(
        base_joints=joints["base"],
        platform_joints=joints["platform"],
        home=here.home,
        stiffness=here.stiffness,
        gravity=here.gravity,
    )
    points = read(frame, here)
    displaced = frame.copy()
    for row, pose in enumerate(points.configurations):
        wanted = here.lengths(pose)
        reached = fsolve(lambda x, wanted=wanted: true.lengths(x) - wanted, pose, xtol=1e-12)  # type: ignore[misc]
        displaced.loc[row, list(here.configuration)] = reached
    chain = Chain(true)
    expected = chain.predict(row_data(read(displaced, true), true), chain.start())
    found = predicted(effect("joint_position_error", "leg 5", end), list(offset), frame)
    change = np.abs(expected - base(frame)).max(axis=0)
    assert (np.abs(found - expected).max(axis=0) < 1e-4 * change).all()


def test_an_offset_of_the_centre_of_mass_is_another_centre_of_mass() -> None:
    frame, offset = rows(ROBOT), np.array([0.004, -0.002, 0.01])
    moved = frame.copy()
    moved[["com_x_m", "com_y_m", "com_z_m"]] += offset
    found = predicted(effect("payload_com_offset", "payload"), list(offset), frame)
    np.testing.assert_allclose(found, base(moved), rtol=0.0, atol=1e-12 * np.abs(found).max())


def test_an_error_of_the_mass_is_another_mass() -> None:
    frame = rows(ROBOT)
    points = recordings(ROBOT)
    size = float(np.linalg.norm(points.wrenches[:, :3], axis=1).max())
    heaviest = frame["mass_kg"] == frame["mass_kg"].max()
    heavier = frame.assign(mass_kg=frame["mass_kg"] * np.where(heaviest, 1.03, 1.0))
    found = predicted(effect("payload_mass_error", "payload", f"{size:.6g} newton"), [0.03], frame)
    np.testing.assert_allclose(found, base(heavier), rtol=0.0, atol=1e-12 * np.abs(found).max())
    gravity = float(np.linalg.norm(robot(ROBOT).gravity))
    forgotten = frame.assign(mass_kg=frame["mass_kg"] + np.where(frame["mass_kg"] > 0.0, 0.5, 0.0))
    found = predicted(effect("payload_mass_error", "payload", "forgotten"), [0.5 * gravity], frame)
    np.testing.assert_allclose(found, base(forgotten), rtol=0.0, atol=1e-12 * np.abs(found).max())


@pytest.mark.parametrize("load", [PAYLOAD, WRENCH])
def test_a_tilt_turns_gravity_for_a_payload_and_force_and_moment_of_a_wrench(load: str) -> None:
    """Against the finite rotation, to second order in the angle."""
    frame, angles = rows(ROBOT, load), np.array([1e-4, -2e-4])
    turn = Rotation.from_rotvec([*angles, 0.0]).as_matrix()
    tilted, here = frame.copy(), robot(ROBOT)
    if load == PAYLOAD:
        tilted[["gx_m_s2", "gy_m_s2", "gz_m_s2"]] = turn @ here.gravity
    else:
        wrench = list(here.coordinates.wrench)
        for half in (wrench[:3], wrench[3:]):
            tilted[half] = frame[half].to_numpy() @ turn.T
    found = predicted(effect("load_direction_tilt", "payload"), list(angles), frame)
    change = np.abs(base(tilted) - base(frame)).max()
    assert np.abs(found - base(tilted)).max() < 1e-3 * change


def test_an_instrument_reads_poses_in_its_own_axes() -> None:
    """Differences of Qᵀ·p and of the angles of Qᵀ·R·Q between the loaded and the unloaded platform."""
    frame, angles = rows(ROBOT), [0.03, -0.05, 0.08]
    turn = Rotation.from_euler("xyz", angles).as_matrix()
    points = recordings(ROBOT)
    deflection = 1e-4 * base(frame)  # small, so that the second order of the difference does not show

    def read_at(pose: Array) -> Array:
        rotation = turn.T @ Rotation.from_euler("xyz", pose[3:]).as_matrix() @ turn
        return np.concatenate([turn.T @ pose[:3], Rotation.from_matrix(rotation).as_euler("xyz")])

    expected = [
        (read_at(pose + 5e3 * d) - read_at(pose - 5e3 * d)) / 1e4
        for pose, d in zip(points.configurations, deflection, strict=True)
    ]
    found = 1e-4 * predicted(effect("instrument_misalignment", "instrument"), angles, frame)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-7 * np.abs(found).max())
    turned = 1e-4 * predicted(effect("instrument_misalignment", "instrument", "differences"), angles, frame)
    np.testing.assert_allclose(turned, np.hstack([deflection[:, :3] @ turn, deflection[:, 3:] @ turn]), atol=1e-18)


def test_warm_legs_are_longer() -> None:
    """All legs by α·ΔT of their length: the platform goes where the lengths do."""
    frame, alpha = rows(ROBOT), 1e-5
    here = robot(ROBOT)
    temperature = frame[[f"leg{i}_degC" for i in range(1, 7)]].to_numpy()
    first = np.repeat(temperature[::4], 4, axis=0)
    gained = in_legs(predicted(effect("thermal_drift", "all legs"), [alpha], frame) - base(frame), frame)
    lengths = here.lengths(recordings(ROBOT).configurations)
    np.testing.assert_allclose(gained, alpha * lengths * (temperature - first), rtol=0.0, atol=1e-15)


RECIPROCAL = [
    ("platform_compliance", "platform", "full"),
    ("base_compliance", "base", "full"),
    ("leg_coupling", "leg 1", "shared with leg 4"),
    ("passive_joint_compliance", "leg 2", "base"),
    ("passive_joint_compliance", "leg 2", "platform"),
    ("passive_joint_stiffness", "all legs", ""),
    ("passive_joint_stiffness", "leg 3", "bending"),
    ("passive_joint_stiffness", "all legs", "flexures"),
]


@pytest.mark.parametrize(("physics", "component", "variant"), RECIPROCAL)
def test_elastic_parts_are_reciprocal(physics: str, component: str, variant: str) -> None:
    """Maxwell and Betti: one load works as much on the motion by another as that on the motion by the one.

    Flexures turn the unloaded platform by up to 1e-5 per N·m/rad, about which the motion is symmetric.
    """
    frame, one = one_series([1.0] * 6), effect(physics, component, variant)
    wrench = list(robot(ROBOT).coordinates.wrench)
    frame[wrench] = 100.0 * np.eye(6)
    bent = variant == "flexures"
    scales = [1.0] if bent else [parameter.scale * (1.0 + 0.3 * i) for i, parameter in enumerate(one.parameters)]
    found = predicted(one, scales, frame)
    points = read(frame, robot(ROBOT))
    jacobians = robot(ROBOT).jacobians(points.configurations)
    rates = jacobians.pose[0] @ np.linalg.inv(jacobians.forward[0])
    twists = np.linalg.solve(rates, found.T)
    assert np.abs(twists - twists.T).max() < (3e-5 if bent else 1e-9) * np.abs(twists).max()
    added = twists - np.linalg.solve(rates, base(frame).T)
    assert np.abs(added).max() > 1e-6 * np.abs(twists).max()


@pytest.mark.parametrize(("physics", "component"), [("platform_compliance", "platform"), ("base_compliance", "base")])
def test_a_compliant_part_in_the_place_of_the_origin(physics: str, component: str) -> None:
    """A soft spring along z of its frame, at zero pose: the platform shifts by C·f in that direction."""
    frame = one_series([1.0])
    frame[list(robot(ROBOT).configuration)] = 0.0
    moved = predicted(effect(physics, component, "diagonal"), [0.0, 0.0, 2e-8, 0.0, 0.0, 0.0], frame) - base(frame)
    expected = np.zeros((1, 6))
    expected[0, 2] = 2e-8 * frame["fz_N"].iloc[0]
    np.testing.assert_allclose(moved, expected, rtol=0.0, atol=1e-18)


@pytest.mark.parametrize("force", ["quadratic", "asymmetric", "hertz", "cubic"])
def test_a_nonlinear_leg_follows_its_law(force: str) -> None:
    frame = one_series([0.0, 0.5, 1.0, -1.0, 2.0])
    tau, compliance = forces(frame)[:, 2], robot(ROBOT).compliance[2]
    one = effect("leg_nonlinear_stiffness", "leg 3", force)
    parameter = 0.3 if force == "cubic" else 2e-6
    found = in_legs(predicted(one, [parameter], frame), frame)[:, 2]
    relative = tau / 100.0
    if force == "cubic":
        # τ = k·(x + b·x³) with b in units of the square of the elongation at 100 N.
        x = found / (compliance * 100.0)
        np.testing.assert_allclose(x + parameter * x**3, relative, atol=1e-9)
        return
    beyond = {
        "quadratic": relative * np.abs(relative),
        "asymmetric": np.abs(relative),
        "hertz": np.sign(relative) * np.abs(relative) ** (2 / 3),
    }[force]
    np.testing.assert_allclose(found - compliance * tau, parameter * beyond, rtol=1e-9, atol=1e-17)


def test_a_screw_error_is_common_to_a_series() -> None:
    frame = rows(ROBOT)
    offset = predicted(effect("encoder_periodic_error", "leg 6"), [1e-6, 2e-6, 1e-3], frame) - base(frame)
    lengths = robot(ROBOT).lengths(recordings(ROBOT).configurations)[:, 5]
    angle = 2.0 * np.pi * lengths / 1e-3
    gained = in_legs(offset, frame)[:, 5]
    np.testing.assert_allclose(gained, 1e-6 * np.sin(angle) + 2e-6 * np.cos(angle), atol=1e-15)
    for start, end in pairwise(range(0, 17, 4)):
        np.testing.assert_allclose(offset[start:end], offset[[start] * 4], rtol=0.0, atol=1e-17)
