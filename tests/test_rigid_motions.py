"""Twists and wrenches of a rigid body at two points and along two frames: the same power."""

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from expdesign.mechanics.robots.orientation import frame_turn, twist_transfer


def _rotation(d: int, generator: np.random.Generator) -> ca.DM:
    if d == 3:
        return ca.DM(Rotation.random(random_state=generator).as_matrix())
    angle = generator.uniform(-np.pi, np.pi)
    return ca.DM([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize(("d", "n"), [(3, 6), (2, 3), (2, 2)])
def test_the_power_of_a_wrench_does_not_depend_on_the_point(d: int, n: int) -> None:
    generator = np.random.default_rng(4)
    arm, twist, wrench = generator.normal(size=d), generator.normal(size=n), generator.normal(size=n)
    transfer = np.array(ca.DM(twist_transfer(ca.SX(arm), n)))
    assert (transfer @ twist) @ wrench == pytest.approx(twist @ (transfer.T @ wrench))
    if n == 6:
        assert transfer @ twist == pytest.approx(np.concatenate([twist[:3] + np.cross(twist[3:], arm), twist[3:]]))
    elif n == 3:
        assert transfer @ twist == pytest.approx([twist[0] - twist[2] * arm[1], twist[1] + twist[2] * arm[0], twist[2]])


@pytest.mark.parametrize(("d", "n"), [(3, 6), (2, 3), (2, 2)])
def test_axes_turn_without_changing_sizes(d: int, n: int) -> None:
    rotation = _rotation(d, np.random.default_rng(5))
    turn = np.array(ca.DM(frame_turn(ca.SX(rotation), n)))
    assert turn @ turn.T == pytest.approx(np.eye(n))
    assert turn[:d, :d] == pytest.approx(np.array(rotation))
    if n == 3:
        assert turn[2] == pytest.approx([0.0, 0.0, 1.0])
