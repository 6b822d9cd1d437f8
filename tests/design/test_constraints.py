"""Demands of a laboratory on plans: distinct poses and masses, what has to occur, boxes to keep out of, effort."""

from typing import Any

import numpy as np
import pytest

from expdesign.errors import ExpdesignError, InfeasibleError, InputError
from expdesign.planning.constraints import Constraints
from expdesign.planning.search import search
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.plausibility.sound import content_of, problem_from

FEW: dict[str, Any] = {"population": 8, "generations": 3, "seed": 1, "polish": True}


def found(base: dict[str, Any], constraints: dict[str, Any], **changes: Any) -> Any:
    case = problem(base, {"experiment.constraints": constraints, "optimiser": FEW} | changes)
    front = search(case)
    return case, *case.space.decode(front.decisions)


def test_at_least_so_many_distinct_poses_and_masses() -> None:
    changes = {
        "experiment.deflection_noise.shared_reference": True,
        "experiment.measurements": 5,
        "optimiser": {**FEW, "population": 12},
    }
    _, poses, loads = found(HEXAPOD, {"distinct_poses": 4, "distinct_masses": 3}, **changes)
    assert len(poses) > 0
    for design in range(len(poses)):
        assert len(np.unique(poses[design], axis=0)) >= 4
        assert len(np.unique(loads[design, :, 0])) >= 3


def test_masses_and_poses_that_have_to_occur() -> None:
    pose = [0.0123456, 0.0, 0.0, 0.05, 0.0, 0.0]
    _, poses, loads = found(HEXAPOD, {"poses": [pose], "masses_kg": [5.0, 10.0]})
    for design in range(len(poses)):
        assert (np.abs(poses[design] - pose).max(axis=1) < 1e-12).sum() >= 1
        assert {5.0, 10.0} <= set(loads[design, :, 0].tolist())


def test_nothing_is_in_a_box() -> None:
    """The payload's centre of mass may not be where y > 0."""
    box = {"low_m": [-1.0, 0.02, 0.35], "high_m": [1.0, 1.0, 1.0]}
    case, poses, loads = found(HEXAPOD, {"keep_out": [box]})
    rotation = case.loaded.robot.jacobians(poses).rotation
    centres = case.loaded.robot.position(poses) + (rotation @ loads[..., 1:4, None])[..., 0]
    inside = (centres > box["low_m"]) & (centres < box["high_m"])
    assert not inside.all(axis=-1).any()
    free = search(problem(HEXAPOD, {"optimiser": {**FEW, "polish": False}}))
    unbound = problem(HEXAPOD).space.decode(free.decisions)
    rotation = case.loaded.robot.jacobians(unbound[0]).rotation
    centres = case.loaded.robot.position(unbound[0]) + (rotation @ unbound[1][..., 1:4, None])[..., 0]
    assert ((centres > box["low_m"]) & (centres < box["high_m"])).all(axis=-1).any()


def test_depth_in_a_box_is_a_distance() -> None:
    case = problem(BIPOD)
    boxes = np.array([[[-10.0, 0.59], [10.0, 0.61]]])
    depth = Constraints(boxes).measurements(case.loaded, np.array([[0.1, 0.6]]), np.array([[0.0, -700.0]]))
    assert depth[0, 0] == pytest.approx(0.01, abs=1e-9)


def test_joints_stay_within_their_effort() -> None:
    content = content_of("ur5")
    content["experiment"]["constraints"] = {"effort": True}
    content["optimiser"] = FEW
    case = problem_from(content)
    effort = case.loaded.robot.effort
    assert effort is not None
    assert np.isfinite(effort).all()
    # Own weight and payload by hand, at one configuration.
    decisions = case.space.sample(40, np.random.default_rng(0))
    poses, loads = case.space.decode(decisions)
    jacobians = case.loaded.robot.jacobians(poses)
    wrenches = case.loaded.load.wrenches(jacobians.rotation, loads)
    forces = np.einsum("ijk,ij->ik", jacobians.forward, wrenches) + case.loaded.robot.own_weight(poses, loads[:, -3:])
    expected = (np.abs(forces) / effort).max(axis=1) - 1.0
    np.testing.assert_allclose(case.constraints.measurements(case.loaded, poses, loads)[:, 1], expected, rtol=1e-9)
    front = search(case)
    assert (case.constraints.violations(case.loaded, *case.space.decode(front.decisions)) <= 0.0).all()


@pytest.mark.parametrize(
    ("constraints", "words"),
    [
        ({"distinct_poses": 9}, "`experiment.measurements` offers 3"),
        ({"poses": [[0.0, 0.0]]}, "6 numbers are needed"),
        ({"poses": [[0.5, 0, 0, 0, 0, 0]]}, "beyond the limits"),
        ({"masses_kg": [7.0]}, "cannot be chosen"),
        ({"masses_kg": [5, 10, 26.5, 5]}, "`experiment.measurements` offers 3"),
        ({"keep_out": [{"low_m": [0, 0], "high_m": [1, 1]}]}, "3 coordinates"),
        ({"keep_out": [{"low_m": [0, 0, 1], "high_m": [1, 1, 0]}]}, "wrong way round"),
        ({"effort": True}, "states no effort"),
        ({"distinct_pose": 2}, "Did you mean `distinct_poses`"),
    ],
)
def test_bad_constraints(constraints: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        problem(HEXAPOD, {"experiment.constraints": constraints})


def test_what_cannot_be_is_said() -> None:
    everything = {"keep_out": [{"low_m": [-9, -9, -9], "high_m": [9, 9, 9]}]}
    with pytest.raises(InfeasibleError, match=r"experiment\.constraints"):
        search(problem(HEXAPOD, {"experiment.constraints": everything, "optimiser": FEW}))
    with pytest.raises(ExpdesignError):
        search(problem(BIPOD, {"experiment.constraints": {"masses_kg": [1.0]}}))
