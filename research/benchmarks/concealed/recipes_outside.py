"""Concealed physics that is in no list of known effects: the right answer is that it is not known."""

from __future__ import annotations

import numpy as np

from .case import UnsuitableError
from .experiments import Experiment, Wishes
from .hidden import Hidden, Recipe, Sized, element, unit
from .linear_model import Array, maps_of, pose_columns, wrenches


def _poses(experiment: Experiment) -> Array:
    return experiment.rows[pose_columns(experiment.machine.robot)].to_numpy(dtype=float)


def _positions(experiment: Experiment) -> Array:
    """Position part of the poses, in space (m)."""
    poses = _poses(experiment)[:, :3]
    return np.column_stack([poses, np.zeros((len(poses), 3 - poses.shape[1]))])


def _region(experiment: Experiment, rng: np.random.Generator) -> tuple[Array, float]:
    """A ball that holds 35-70 % of the poses."""
    positions = _positions(experiment)
    centre = positions[int(rng.integers(len(positions)))]
    return centre.round(4), float(np.quantile(np.linalg.norm(positions - centre, axis=1), rng.uniform(0.35, 0.7)))


def _loose_mount(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    robot = experiment.machine.robot
    forces = wrenches(robot, experiment.rows)[:, :3]
    forces = np.column_stack([forces, np.zeros((len(forces), 3 - forces.shape[1]))])
    sideways = [
        float(np.hypot(*(robot.pose(pose).rotation.T @ force)[:2]))
        for pose, force in zip(_poses(experiment), forces, strict=True)
    ]
    loaded = [each for each in sideways if each > 0]
    centre, radius = _region(experiment, rng)
    holding = float(np.quantile(loaded, rng.uniform(0.2, 0.5)))

    def of_size(size: float) -> Sized:
        entry = element("loose_mount", holding_N=holding, slip_m=size, centre_m=centre, radius_m=radius)
        return Sized((entry,))

    return Hidden("loose_mount", ("platform", "payload"), 2e-7, 5e-5, of_size)


def _cable(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    robot, reach = experiment.machine.robot, experiment.machine.reach
    angle = rng.uniform(0, 2 * np.pi)
    if robot.planar:
        away = 0.7 * np.array([np.cos(angle), np.sin(angle), 0.0])
        local = np.zeros(3)
    else:
        away = reach * np.array([1.4 * np.cos(angle), 1.4 * np.sin(angle), rng.uniform(-0.6, 0.6)])
        local = reach * np.array([0.6 * np.cos(angle + 0.8), 0.6 * np.sin(angle + 0.8), 0.05])
    base = robot.home + away
    lengths = [float(np.linalg.norm(robot.pose(pose).point(local) - base)) for pose in _poses(experiment)]
    slack = float(np.quantile(lengths, rng.uniform(0.25, 0.6)))
    reachable = max(lengths) - slack
    weight = float(np.abs(wrenches(robot, experiment.rows)[:, : 2 if robot.planar else 3]).max())

    def of_size(size: float) -> Sized:
        parameters = {"base_m": base.round(4), "platform_m": local.round(4), "slack_m": slack}
        return Sized((element("cable", stiffness_N_per_m=size, **parameters),))

    return Hidden(
        "cable", ("environment", "platform", "payload"), 1e-3 * weight / reachable, weight / reachable, of_size
    )


def _attraction(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    """A magnet near the payload, so close that its force changes from pose to pose."""
    robot = experiment.machine.robot
    spread = float(np.abs(_positions(experiment)).max())
    direction = np.append(unit(rng, 2), 0.0) if robot.planar else unit(rng, 3)
    distance = spread * rng.uniform(1.8, 3.0)
    magnet = robot.home + distance * direction
    weight = float(np.abs(wrenches(robot, experiment.rows)[:, : 2 if robot.planar else 3]).max())

    def of_size(size: float) -> Sized:
        return Sized((element("attraction", magnet_m=magnet.round(4), force_N=size, distance_m=distance),))

    return Hidden("attraction", ("payload", "environment", "platform"), 1e-3 * weight, weight, of_size)


def _stop(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    robot = experiment.machine.robot
    angle = rng.uniform(0, 2 * np.pi)
    if robot.planar:
        point, normal = np.zeros(3), np.append(unit(rng, 2), 0.0)
    else:
        point = experiment.machine.reach * np.array([0.7 * np.cos(angle), 0.7 * np.sin(angle), 0.0])
        normal = np.array([0.0, 0.0, -1.0]) if rng.random() < 0.5 else np.append(unit(rng, 2), 0.0)
    compliance = 1.0 / experiment.machine.true_stiffness
    travel = []
    each = zip(maps_of(robot, experiment.rows), wrenches(robot, experiment.rows), _poses(experiment), strict=True)
    for maps, wrench, pose in each:
        twist = maps.forward @ (compliance * (maps.forward.T @ wrench))
        shift = (
            np.append(twist, 0.0)
            if robot.planar
            else twist[:3] + np.cross(twist[3:], robot.pose(pose).rotation @ point)
        )
        travel.append(float(normal @ shift))
    towards = [each for each in travel if each > 0]
    if len(towards) < 0.2 * len(travel):
        raise UnsuitableError("the platform hardly moves towards the stop")
    clearance = float(np.quantile(towards, rng.uniform(0.2, 0.6)))
    parameters = {"platform_m": point.round(4), "clearance_m": clearance, "direction": normal}
    if rng.random() < 0.4:
        centre, radius = _region(experiment, rng)
        parameters |= {"centre_m": centre, "radius_m": radius}
    own = float(experiment.machine.true_stiffness.mean())

    def of_size(size: float) -> Sized:
        return Sized((element("unilateral_stop", stiffness_N_per_m=size, **parameters),))

    return Hidden("unilateral_stop", ("environment", "platform"), 1e-3 * own, 30 * own, of_size)


def _distortion(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    """A camera whose scale changes across its field of view, looking at the middle of the workspace."""
    robot = experiment.machine.robot
    positions = _positions(experiment)
    spread = positions.std(axis=0)
    middle = robot.home + positions.mean(axis=0) + 0.5 * spread * rng.normal(size=3)
    quadratic = np.zeros(3)
    axes = [axis for axis in experiment.measured if axis < 3]
    quadratic[axes] = rng.uniform(0.5, 1.0, len(axes)) * rng.choice([-1.0, 1.0], len(axes))
    refraction = rng.uniform(-1, 1) if 2 in axes else 0.0
    limit = 0.15 / float(np.abs(positions).max())

    def of_size(size: float) -> Sized:
        parameters = {"quadratic_per_m": size * quadratic, "refraction_per_m": size * refraction}
        return Sized((element("instrument_distortion", instrument_m=middle.round(4), **parameters),))

    return Hidden("instrument_distortion", ("instrument",), 1e-3 * limit, limit, of_size)


RECIPES = (
    Recipe("loose_mount", lambda rng: Wishes(load="wrench"), _loose_mount),
    Recipe("cable", lambda rng: Wishes(), _cable),
    Recipe("attraction", lambda rng: Wishes(wide=True), _attraction),
    Recipe("unilateral_stop", lambda rng: Wishes(large=rng.random() < 0.5), _stop),
    Recipe("instrument_distortion", lambda rng: Wishes(large=True, wide=True, positions=True), _distortion),
)
