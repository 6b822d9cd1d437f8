"""What must hold for every effect of an arm, and what mechanics says of each."""

from functools import cache

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from expdesign.chain.chain import Chain
from expdesign.chain.component import Component, Part, link_span
from expdesign.chain.effect import Effect
from expdesign.chain.effects.joints.backlash import JointBacklash
from expdesign.chain.effects.joints.bearings import JointCompliance, across
from expdesign.chain.effects.joints.geometry import ArmGeometricStiffness, ArmGeometryError
from expdesign.chain.effects.joints.readings import LoggedBeforeSettled
from expdesign.chain.effects.links.links import LinkCompliance
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from tests.chain.arm_rows import arm_rows, six_axis
from tests.chain.kinds import KINDS
from tests.identification.experiments import read
from tests.oracle import Array

ARM = six_axis()


@cache
def points() -> Recordings:
    """Loads of every direction at every joint, gravity that changes."""
    return read(arm_rows(ARM, series=5, loads=3, sideways=True), ARM)


def predicted(effects: tuple[Effect, ...], parameters: list[float], rows: Recordings | None = None) -> Array:
    chain = Chain(ARM, effects)
    values = chain.start()
    values[chain.compliances :] = parameters
    return chain.predict(row_data(points() if rows is None else rows, ARM), values)


def test_effects_of_arms_refuse_other_robots() -> None:
    from tests.cases import robot  # noqa: PLC0415

    kinds = [kind for kind in KINDS if kind.__module__.split(".")[-2] in ("joints", "links")]
    assert len(kinds) >= 8
    for kind in kinds:
        with pytest.raises(ValueError, match="has no `joint 1`"):
            kind(robot("H1"), Component(Part.JOINT, 1))


def _frames(configuration: Array) -> list[tuple[Array, Array]]:
    """Place and orientation of every joint's frame, by numbers."""
    q = ca.SX.sym("q", 6)
    frames = [part for joint in range(6) for part in ARM.tree.joint_frame(q, joint)]
    values = ca.Function("frames", [q], frames).call([configuration])
    return [(np.array(p).ravel(), np.array(r)) for p, r in zip(values[::2], values[1::2], strict=True)]


def _through(point: Array, axis: Array, tip: Array) -> Array:
    """Twist of the tip per turn about an axis through a point (6,)."""
    return np.concatenate([np.cross(axis, tip - point), axis])


@pytest.mark.parametrize("joint", [0, 2, 4])
def test_a_tilting_bearing_is_two_more_springs_across_the_joint(joint: int) -> None:
    effect = JointCompliance.from_text(ARM, f"joint {joint + 1}", "two directions")
    found = predicted((effect,), [2e-5, 5e-5]) - predicted((), [])
    tips = ARM.position(points().configurations)
    for row, configuration in enumerate(points().configurations):
        point, frame = _frames(configuration)[joint]
        expected = np.zeros(6)
        for axis, compliance in zip(across(ARM.tree.joints[joint].axis), (2e-5, 5e-5), strict=True):
            twist = _through(point, frame @ axis, tips[row])
            expected += compliance * twist * (twist @ points().wrenches[row])
        np.testing.assert_allclose(found[row], expected, rtol=0.0, atol=1e-12)


def test_a_bending_link_is_many_hinges_along_it() -> None:
    """1000 hinges, each with its share of the compliance, bend as the beam does (midpoint rule: error 1e-7)."""
    link, bending, torsion, parts = 1, 6e-6, 4e-6, 1000
    found = predicted((LinkCompliance.from_text(ARM, f"link {link + 1}"),), [bending, torsion]) - predicted((), [])
    q = ca.SX.sym("q", 6)
    ends = ca.Function("ends", [q], list(link_span(ARM, q, link)))
    tips = ARM.position(points().configurations)
    for row, configuration in enumerate(points().configurations):
        start, end = (np.array(v).ravel() for v in ends.call([configuration]))
        along = (end - start) / np.linalg.norm(end - start)
        expected = np.zeros(6)
        for share in (np.arange(parts) + 0.5) / parts:
            point = start + share * (end - start)
            for axis, compliance in (*((v, bending) for v in across(along)), (along, torsion)):
                twist = _through(point, axis, tips[row])
                expected += compliance / parts * twist * (twist @ points().wrenches[row])
        np.testing.assert_allclose(found[row], expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())


def test_the_change_of_geometry_is_that_of_the_equilibrium() -> None:
    """Joint springs in full equilibrium with own weight and payload; what remains is of third order."""
    found = predicted((ArmGeometricStiffness.from_text(ARM, "geometry"),), [1.0])
    base = predicted((), [])
    payload = points().payload
    for row in range(0, len(points()), 4):
        q, gravity, (mass, *centre) = points().configurations[row], points().gravity[row], payload[row]

        def torques(at: Array, mass: float) -> Array:
            jacobians = ARM.jacobians(at)
            moment = np.cross(jacobians.rotation @ np.array(centre), mass * gravity)  # noqa: B023
            wrench = np.concatenate([mass * gravity, moment])  # noqa: B023
            return ARM.own_weight(at, gravity) + jacobians.forward.T @ wrench  # noqa: B023

        def rest(mass: float) -> tuple[Array, Rotation]:
            at = q  # noqa: B023
            for _ in range(30):  # contracts by torque gradient over stiffness, below 1e-2
                at = q + ARM.compliance * torques(at, mass)  # noqa: B023
            return ARM.position(at), Rotation.from_matrix(ARM.jacobians(at).rotation)

        (before, turned_before), (after, turned_after) = rest(0.0), rest(mass)
        expected = np.concatenate([after - before, (turned_after * turned_before.inv()).as_rotvec()])
        second_order = np.abs(expected - base[row]).max()
        assert second_order > 1e-7
        np.testing.assert_allclose(found[row], expected, rtol=0.0, atol=0.05 * second_order)


def test_a_wrong_zero_is_a_command_that_is_off() -> None:
    """The payload hangs on the tip as before: the same load at another command."""
    found = predicted((ArmGeometryError.from_text(ARM, "joint 3", "offset"),), [0.03])
    frame = arm_rows(ARM, series=5, loads=3, sideways=True)
    frame["q3_rad"] += 0.03
    np.testing.assert_allclose(found, predicted((), [], read(frame, ARM)), rtol=0.0, atol=1e-12)


def test_play_shows_where_the_payload_turns_the_whole_torque_round() -> None:
    joint = 3
    found = predicted((JointBacklash.from_text(ARM, f"joint {joint + 1}", "middle"),), [1e-3]) - predicted((), [])
    jacobians = ARM.jacobians(points().configurations)
    own = ARM.own_weight(points().configurations, points().gravity)[:, joint]
    whole = own + np.einsum("nij,ni->nj", jacobians.forward, points().wrenches)[:, joint]
    jump = 0.5 * (np.sign(whole) - np.sign(own))
    assert {0.0, 1.0} <= set(np.abs(jump))
    np.testing.assert_allclose(found, 1e-3 * jump[:, None] * jacobians.forward[..., joint], atol=1e-15)


def test_an_unsettled_row_lacks_part_of_the_step_from_the_row_before() -> None:
    rho = 0.2
    found = predicted((LoggedBeforeSettled.from_text(ARM, "all joints", "logged before settled"),), [rho])
    base = predicted((), [])
    reached = np.zeros(6)
    for row in range(3):  # one series, one command: steps of the tip are those of the joints
        reached = reached + (1.0 - rho) * (base[row] - reached)
        np.testing.assert_allclose(found[row], reached, rtol=0.0, atol=1e-14)
