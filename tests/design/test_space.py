"""Genes of designs: what they stand for, their bounds, and the order that carries no information."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from expdesign.coordinates import PLANAR, SPATIAL
from expdesign.planning.space import DesignSpace
from expdesign.planning.variables import Choices, Interval, Quantity, fixed
from tests.design.problems import HEXAPOD, problem
from tests.oracle import Array, about

GRAVITY = np.array([0.0, 0.0, -9.80665])


def mixed_space() -> DesignSpace:
    """Continuous, chosen, fixed and single-choice quantities, with a payload and a tilting base."""
    poses: tuple[Quantity, ...] = (
        Interval(-0.1, 0.2),
        Choices((0.3, 0.1, 0.2)),
        fixed(0.05),
        Choices((0.4,)),
        Interval(-1.0, -0.5),
        fixed(0.0),
    )
    load: tuple[Quantity, ...] = (Choices((5.0, 10.0)), Interval(-0.1, 0.1), fixed(0.0), fixed(0.12))
    tilt: tuple[Quantity, ...] = (Interval(0.0, 1.2), fixed(0.3))
    return DesignSpace(3, poses, load, tilt, SPATIAL, GRAVITY)


def test_decoding_a_mixed_design() -> None:
    space = mixed_space()
    assert space.decisions == 6
    np.testing.assert_array_equal(space.discrete, [False, True, False, True, False, False])
    np.testing.assert_array_equal(space.lower, [-0.1, 0.0, -1.0, 0.0, -0.1, 0.0])
    np.testing.assert_array_equal(space.upper, [0.2, 2.0, -0.5, 1.0, 0.1, 1.2])
    poses, loads = space.decode(np.array([0.15, 1.0, -0.7, 0.0, 0.02, 0.5]))
    np.testing.assert_array_equal(poses, [0.15, 0.1, 0.05, 0.4, -0.7, 0.0])
    np.testing.assert_array_equal(loads[:4], [5.0, 0.02, 0.0, 0.12])
    np.testing.assert_allclose(loads[4:], about(1, np.array(0.3)) @ about(0, np.array(0.5)) @ GRAVITY, rtol=1e-14)


def test_indices_between_two_entries_are_rounded_and_those_beyond_are_clipped() -> None:
    space = mixed_space()
    decisions = np.array([[0.0, 1.4, -0.7, 0.6, 0.0, 0.0], [0.0, 7.0, -0.7, -3.0, 0.0, 0.0]])
    poses, loads = space.decode(decisions)
    np.testing.assert_array_equal(poses[:, 1], [0.1, 0.2])
    np.testing.assert_array_equal(loads[:, 0], [10.0, 5.0])


@pytest.mark.parametrize(("tilt_x", "tilt_y"), [(0.0, 0.0), (0.7, 0.0), (0.0, -0.4), (0.7, -0.4)])
def test_gravity_tilts_as_the_interfaces_say(tilt_x: float, tilt_y: float) -> None:
    """Ry(tilt_y)·Rx(tilt_x)·g, also for gravity that is not along z; the length stays."""
    gravity = np.array([1.0, 2.0, -9.0])
    poses = tuple(fixed(0.0) for _ in range(6))
    load = (fixed(1.0), fixed(0.0), fixed(0.0), fixed(0.0))
    space = DesignSpace(1, poses, load, (fixed(tilt_x), fixed(tilt_y)), SPATIAL, gravity)
    _, loads = space.decode(np.zeros((1, 0)))
    expected = about(1, np.array(tilt_y)) @ about(0, np.array(tilt_x)) @ gravity
    np.testing.assert_allclose(loads[0, 4:], expected, rtol=1e-14)
    assert np.linalg.norm(loads[0, 4:]) == pytest.approx(np.linalg.norm(gravity), rel=1e-14)
    assert space.tilts == (tilt_x != 0.0 or tilt_y != 0.0)


def test_gravity_of_a_tilted_bipod_turns_in_its_plane() -> None:
    space = DesignSpace(
        1,
        (fixed(0.0), fixed(0.6)),
        (fixed(2.0),),
        (fixed(np.pi / 2.0),),
        PLANAR,
        np.array([0.0, -9.8]),
    )
    _, loads = space.decode(np.zeros((1, 0)))
    np.testing.assert_allclose(loads, [[2.0, 9.8, 0.0]], atol=1e-14)


def test_candidates_are_chosen_as_rows() -> None:
    table = np.array([[0.1, 0.5], [0.2, 0.6], [0.3, 0.7]])
    space = DesignSpace(2, table, (Interval(-1.0, 1.0), fixed(-5.0)), (), PLANAR, None)
    assert space.decisions == 2
    poses, loads = space.decode(np.array([[2.0, 0.5], [0.0, -0.5]]))
    np.testing.assert_array_equal(poses, [[0.3, 0.7], [0.1, 0.5]])
    np.testing.assert_array_equal(loads, [[0.5, -5.0], [-0.5, -5.0]])


def test_samples_are_inside_the_bounds_and_reach_every_choice() -> None:
    space = mixed_space()
    decisions = space.sample(2000, np.random.default_rng(0))
    assert np.all((decisions >= space.lower) & (decisions <= space.upper))
    np.testing.assert_array_equal(decisions[:, space.discrete], np.rint(decisions[:, space.discrete]))
    poses, loads = space.decode(decisions)
    assert set(poses[:, 1]) == {0.1, 0.2, 0.3}
    assert set(loads[:, 0]) == {5.0, 10.0}
    shares = np.bincount(decisions[:, 1].astype(int)) / 2000.0
    assert np.abs(shares - 1.0 / 3.0).max() < 4.0 * np.sqrt(2.0 / 9.0 / 2000.0)
    for decision, low, high in ((0, -0.1, 0.2), (5, 0.0, 1.2)):
        mean, error = (low + high) / 2.0, (high - low) / np.sqrt(12.0 * 2000.0)
        assert abs(decisions[:, decision].mean() - mean) < 4.0 * error


@given(st.integers(0, 2**32 - 1))
def test_canonical_designs(seed: int) -> None:
    """The same measurements in any order are the same rows; nothing else is changed; doing it twice changes nothing."""
    space, generator = mixed_space(), np.random.default_rng(seed)
    decisions = space.sample(12, generator).reshape(4, 3, -1)
    decisions[0, 1] = decisions[0, 0]
    decisions[1, :, 0] = 0.1
    shuffled = decisions[:, generator.permutation(3)]
    canonical = space.canonical(decisions)
    np.testing.assert_array_equal(space.canonical(shuffled), canonical)
    np.testing.assert_array_equal(space.canonical(canonical), canonical)

    def as_sets(designs: Array) -> list[list[tuple[float, ...]]]:
        return [sorted(map(tuple, design.tolist())) for design in designs]

    assert as_sets(canonical) == as_sets(decisions)
    assert all([tuple(row) for row in design] == sorted(map(tuple, design)) for design in canonical.tolist())


def test_canonical_puts_decisions_back_into_their_bounds() -> None:
    space = mixed_space()
    wild = np.array([[[-5.0, -2.0, 5.0, 9.0, 5.0, -5.0]]])
    np.testing.assert_array_equal(space.canonical(wild)[0, 0], [-0.1, 0.0, -0.5, 1.0, 0.1, 0.0])


def test_grid_of_a_configuration() -> None:
    grid = {"x_m": [-0.03, 0.03, 7], "z_m": 0.01, "rz_rad": [0.1, 0.1, 1]}
    found = problem(HEXAPOD, {"experiment.poses": {"grid": grid}})
    poses, _ = found.space.decode(found.space.sample(300, np.random.default_rng(0)))
    np.testing.assert_allclose(np.unique(poses[:, 0]), np.linspace(-0.03, 0.03, 7), atol=1e-17)
    assert np.unique(poses[:, 0])[[0, -1]].tolist() == [-0.03, 0.03]
    np.testing.assert_array_equal(poses[:, 1:], np.tile([0.0, 0.01, 0.0, 0.0, 0.1], (300, 1)))
