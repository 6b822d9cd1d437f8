"""Distances between legs, platform, base and payload, by hand and as constraints of a search."""

import sys
from typing import Any

import numpy as np
import pytest

import expdesign
from expdesign.errors import InputError
from expdesign.planning.constraints import Collisions
from expdesign.planning.result import plan_of
from expdesign.planning.schema import CollisionsSection, PrimitiveSection
from expdesign.planning.search import search
from tests.design.problems import HEXAPOD, problem

pytest.importorskip("coal")

HOME = np.zeros(6)
FEW = {"population": 8, "generations": 2, "seed": 1, "polish": False}


def apart(clearance: float, radius: float, **parts: PrimitiveSection) -> Collisions:
    return Collisions(CollisionsSection(clearance_m=clearance, leg_radius_m=radius, **parts))


def segment_distance(one: np.ndarray, two: np.ndarray) -> float:
    """Least distance of two segments (2, 3) by sampling both."""
    along = np.linspace(0.0, 1.0, 401)[:, None]
    first, second = (ends[0] + along * (ends[1] - ends[0]) for ends in (one, two))
    return float(np.linalg.norm(first[:, None] - second[None], axis=-1).min())


def test_legs_are_as_far_apart_as_their_axes_less_two_radii() -> None:
    robot = problem(HEXAPOD).loaded.robot
    pose = np.array([0.02, -0.01, 0.01, 0.1, -0.05, 0.0])
    drawing = robot.drawing(pose)
    legs = [drawing.points[[leg, leg + 6]] for leg in range(6)]
    expected = min(segment_distance(legs[i], legs[j]) for i in range(6) for j in range(i))
    radius, clearance = 0.004, 0.001
    excess = float(apart(clearance, radius).excess(robot, pose))
    assert clearance - excess == pytest.approx(expected - 2.0 * radius, abs=1e-6)


def test_a_sphere_below_the_platform_overlaps_the_base_by_a_known_depth() -> None:
    robot = problem(HEXAPOD).loaded.robot
    base = PrimitiveSection(box_m=[2.0, 2.0, 0.1], at_m=[0.0, 0.0, -0.05])  # its top is z = 0
    for radius, low in ((0.01, 0.15), (0.05, 0.29)):
        sphere = PrimitiveSection(sphere_m=radius, at_m=[0.0, 0.0, -low])
        # Legs so thin that they are nowhere nearer than the base; the platform frame stands 0.3 m above O.
        collisions = apart(0.0, 1e-4, platform=sphere, base=base)
        depth = -float(collisions.excess(robot, HOME))
        legs = -float(apart(0.0, 1e-4).excess(robot, HOME))
        assert depth == pytest.approx(min(0.3 - low - radius, legs), abs=1e-6)


def test_a_payload_turns_with_the_platform() -> None:
    """A long box in x reaches the legs where the platform is turned about z and not before, or the other way round."""
    robot = problem(HEXAPOD).loaded.robot
    box = PrimitiveSection(box_m=[0.5, 0.02, 0.02], at_m=[0.0, 0.0, -0.15])
    collisions = apart(0.0, 0.005, payload=box)
    angles = np.linspace(0.0, np.pi / 3.0, 7)
    poses = np.zeros((7, 6))
    poses[:, 5] = angles
    excess = collisions.excess(robot, poses)
    single = [float(collisions.excess(robot, pose)) for pose in poses]
    np.testing.assert_allclose(excess, single, atol=1e-12)
    assert np.ptp(excess) > 1e-3


def collisions(**changes: Any) -> dict[str, Any]:
    return {"clearance_m": 0.002, "leg_radius_m": 0.005} | changes


def test_no_design_collides_and_a_colliding_plan_is_refused() -> None:
    # A plate below the platform that tilted poses bring to the legs.
    stated = collisions(payload={"cylinder_m": [0.162, 0.01], "at_m": [0.0, 0.0, -0.05]})
    poses = problem(HEXAPOD).space.decode(problem(HEXAPOD).space.sample(30, np.random.default_rng(0)))[0]
    few = {"optimiser": FEW, "experiment.poses": {"candidates": poses.tolist()}}
    free = problem(HEXAPOD, few)
    bound = problem(HEXAPOD, few | {"experiment.constraints": {"collisions": stated}})
    hits = bound.constraints.collisions.excess(bound.loaded.robot, poses) > 0.0
    assert 0.02 < hits.mean() < 0.98
    front = search(bound)
    assert (
        bound.constraints.collisions.excess(bound.loaded.robot, bound.space.decode(front.decisions)[0]) <= 0.0
    ).all()
    plan = plan_of(free, front.decisions[0])
    plan["series"] = np.arange(1, len(plan) + 1)  # rows of one series have one command
    for name, value in zip(bound.loaded.robot.configuration, poses[hits][0], strict=True):
        plan.loc[1, name] = value
    with pytest.raises(InputError, match=r"experiment\.constraints\.collisions"):
        expdesign.evaluate(bound, plan)


def test_without_the_library_one_message_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "coal", None)
    with pytest.raises(InputError, match="not installed") as raised:
        problem(HEXAPOD, {"experiment.constraints": {"collisions": collisions()}})
    assert "pip install" in raised.value.remedy


@pytest.mark.parametrize("part", [{}, {"sphere_m": 0.1, "box_m": [1, 1, 1]}, {"box_m": [1, 1]}])
def test_bad_primitives(part: dict[str, Any]) -> None:
    with pytest.raises(InputError):
        problem(HEXAPOD, {"experiment.constraints": {"collisions": collisions(payload=part)}})
