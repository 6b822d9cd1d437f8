"""Singular configurations are recognised by the scaled condition number, which knows neither units nor frames."""

import numpy as np
import pytest

from expdesign.mechanics.robots.bipod import Bipod
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.robot import CONDITION_LIMIT
from tests import oracle
from tests.cases import ROBOTS, robot, symmetric_hexapod
from tests.oracle import Array

HEXAPODS = [name for name in ROBOTS if not name.startswith("bipod")]


def flat_hexapod(height: float = 0.0) -> Hexapod:
    """All joints in one plane at height 0: no leg can push upwards, and whole columns of J⁻¹ are exactly zero."""
    return symmetric_hexapod(0.24, 0.17, height, 0.0, 5e6)


def similar_hexapod() -> Hexapod:
    """Similar base and platform polygons: architecturally singular, at every pose."""
    regular = symmetric_hexapod(0.24, 0.17, 0.3, 0.0, 5e6)
    return Hexapod(
        base_joints=regular.base_joints,
        platform_joints=0.6 * regular.base_joints,
        home=regular.home,
        stiffness=regular.stiffness,
    )


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot_of_the_table_is_regular_in_its_workspace(name: str) -> None:
    condition = robot(name).jacobians(ROBOTS[name].poses(np.random.default_rng(0), 500)).condition
    assert np.all(condition >= 1.0 - 1e-12)
    assert np.all(condition < CONDITION_LIMIT)


def test_condition_of_an_isotropic_mechanism_is_one() -> None:
    here = Bipod(base_joints=np.array([[-0.5, 0.0], [0.5, 0.0]]), home=np.zeros(2), stiffness=np.ones(2))
    assert float(here.jacobians(np.array([0.0, 0.5])).condition) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("pose", [[0.1, 0.0], [0.0, 0.0], [0.5, 0.0], [-0.5, 0.0], [2.0, 0.0]])
def test_bipod_with_its_legs_in_line_is_singular(pose: list[float]) -> None:
    """Also with a leg of no length, whose direction does not exist."""
    here = robot("bipod")
    assert float(here.jacobians(np.array(pose)).condition) == np.inf
    assert not here.usable(np.array(pose))


@pytest.mark.parametrize(
    ("here", "pose"),
    [
        (flat_hexapod(), np.zeros(6)),
        (flat_hexapod(), np.array([0.01, 0.02, 0.0, 0.0, 0.0, 0.1])),
        (similar_hexapod(), np.zeros(6)),
        (similar_hexapod(), np.array([0.01, 0.02, 0.03, 0.1, -0.05, 0.1])),
        (symmetric_hexapod(0.24, 0.17, 0.3, 0.03, 5e6), np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.pi / 2.0])),
    ],
    ids=["flat", "flat-moved", "similar", "similar-moved", "turned-by-90-degrees"],
)
def test_singular_hexapods_are_far_beyond_the_limit(here: Hexapod, pose: Array) -> None:
    assert float(here.jacobians(pose).condition) > 1e6 * CONDITION_LIMIT
    assert not here.usable(pose)


def test_condition_grows_as_the_inverse_distance_to_a_singularity() -> None:
    distance = np.array([1e-2, 1e-4, 1e-6, 1e-8])
    poses = np.stack([np.full(4, 0.1), distance], axis=1)
    condition = robot("bipod").jacobians(poses).condition
    np.testing.assert_allclose(condition[1:] * distance[1:], condition[3] * distance[3], rtol=1e-3)
    turned = np.zeros((4, 6))
    turned[:, 5] = np.pi / 2.0 - distance
    condition = robot("H1").jacobians(turned).condition
    np.testing.assert_allclose(condition[1:] * distance[1:], condition[3] * distance[3], rtol=1e-2)
    assert np.all(condition[1:] > CONDITION_LIMIT)


def test_an_exactly_singular_member_leaves_the_rest_of_a_batch_alone() -> None:
    here = flat_hexapod()
    poses = np.zeros((5, 6))
    poses[:, 2] = [0.3, 0.25, 0.0, 0.28, 0.31]
    jacobians = here.jacobians(poses)
    assert jacobians.condition[2] == np.inf
    assert np.isnan(jacobians.forward[2]).all()
    for index in (0, 1, 3, 4):
        alone = here.jacobians(poses[index])
        np.testing.assert_allclose(jacobians.forward[index], alone.forward, rtol=1e-12, atol=1e-13)
        assert jacobians.condition[index] == pytest.approx(float(alone.condition), rel=1e-12)
        assert jacobians.condition[index] < CONDITION_LIMIT


@pytest.mark.parametrize("name", HEXAPODS)
def test_condition_does_not_depend_on_the_unit_of_length(name: str) -> None:
    here, poses = robot(name), ROBOTS[name].poses(np.random.default_rng(1), 20)
    assert isinstance(here, Hexapod)
    millimetres = Hexapod(
        base_joints=1e3 * here.base_joints,
        platform_joints=1e3 * here.platform_joints,
        home=1e3 * here.home,
        stiffness=here.stiffness,
        orientation=here.orientation,
    )
    scaled = poses * [1e3, 1e3, 1e3, 1.0, 1.0, 1.0]
    np.testing.assert_allclose(millimetres.jacobians(scaled).condition, here.jacobians(poses).condition, rtol=1e-9)


@pytest.mark.parametrize("name", HEXAPODS)
def test_condition_does_not_depend_on_the_origin_of_the_platform_frame(name: str) -> None:
    """The same platform in the same place, its frame moved by d: home − d, joints + d, and positions follow R."""
    here, poses = robot(name), ROBOTS[name].poses(np.random.default_rng(2), 20)
    assert isinstance(here, Hexapod)
    offset = np.array([0.4, -0.7, 3.0])
    moved = Hexapod(
        base_joints=here.base_joints,
        platform_joints=here.platform_joints + offset,
        home=here.home - offset,
        stiffness=here.stiffness,
        orientation=here.orientation,
    )
    turned = oracle.rotation(poses[:, 3:], here.orientation)
    same = poses.copy()
    same[:, :3] += offset - np.einsum("aij,j->ai", turned, offset)
    np.testing.assert_allclose(moved.lengths(same), here.lengths(poses), rtol=1e-12)
    np.testing.assert_allclose(moved.jacobians(same).condition, here.jacobians(poses).condition, rtol=1e-9)


@pytest.mark.parametrize("name", HEXAPODS)
def test_condition_is_that_of_the_hand_written_scaling(name: str) -> None:
    """κ = ‖J⁻¹S‖_F·‖S⁻¹J‖_F/n with the twist taken at the mean platform joint and lengths in units of its spread."""
    here, poses = robot(name), ROBOTS[name].poses(np.random.default_rng(4), 20)
    assert isinstance(here, Hexapod)
    kin = oracle.kinematics(here, poses)
    arms = kin.arms - kin.arms.mean(axis=1, keepdims=True)
    spread = np.sqrt((arms**2).sum(axis=-1).mean(axis=-1))[:, None, None]
    centred = np.concatenate([kin.directions, np.cross(arms, kin.directions) / spread], axis=-1)
    norms = np.linalg.norm(centred, axis=(1, 2)) * np.linalg.norm(np.linalg.inv(centred), axis=(1, 2))
    np.testing.assert_allclose(here.jacobians(poses).condition, norms / 6.0, rtol=1e-9)
