"""What a laboratory demands of a plan beside the robot's limits (`experiment.constraints`).

Of every measurement: nothing of the robot or its load inside a keep-out box, and no actuator beyond its effort. Of the
plan as a whole: at least so many distinct poses or masses, and poses and masses that have to occur.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.mechanics.elastostatics.maps import actuator_forces
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.planning.collisions import Collisions

_ALONG = np.linspace(0.0, 1.0, 9)
"""Places along a line of the robot that are kept out of boxes."""


@dataclass(frozen=True)
class Constraints:
    """Demands on designs.

    Attributes:
        boxes: lowest and highest corners in O (m), shape (k, 2, d).
        effort: largest force or moment of every actuator (N or N·m), infinite where none is known, shape (n_p,); or
            None.
        distinct_poses: at least.
        distinct_masses: at least.
        collisions: what must stay apart, or None.
    """

    boxes: FloatArray
    effort: FloatArray | None = None
    distinct_poses: int = 1
    distinct_masses: int = 1
    collisions: Collisions | None = None

    def measurements(self, loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> FloatArray:
        """How far measurements are beyond what is allowed, ≤ 0 within: boxes (m), effort (parts of it),
        collisions (m).

        Args:
            loaded: the robot.
            configurations: shape (..., n_q).
            loads: shape (..., k).

        Returns:
            Shape (..., 3).
        """
        beyond = np.full((*configurations.shape[:-1], 3), -1.0)
        if len(self.boxes):
            beyond[..., 0] = self._penetration(loaded, configurations, loads)
        if self.effort is not None:
            beyond[..., 1] = self._overload(loaded, self.effort, configurations, loads)
        if self.collisions is not None:
            beyond[..., 2] = self.collisions.excess(loaded.robot, configurations)
        return beyond

    def violations(self, loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> FloatArray:
        """Constraints (≤ 0) of b designs: boxes, effort, collisions, missing poses, masses; (b, 5)."""
        each = self.measurements(loaded, configurations, loads).max(axis=1)
        poses = _distinct(configurations)
        masses = _distinct(loads[..., :1]) if loaded.load.has_mass else np.full(len(loads), self.distinct_masses)
        missing = np.stack([self.distinct_poses - poses, self.distinct_masses - masses], axis=1).astype(float)
        return np.concatenate([each, missing], axis=1)

    def allowed(self, loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> BoolArray:
        """Which measurements are within boxes and effort and free of collisions, shape (...)."""
        allowed: BoolArray = np.logical_and.reduce(self.measurements(loaded, configurations, loads) <= 0.0, axis=-1)
        return allowed

    def _penetration(self, loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> FloatArray:
        points = _points(loaded, configurations, loads)[..., None, :]
        depth = np.minimum(points - self.boxes[:, 0], self.boxes[:, 1] - points).min(axis=-1)
        deepest: FloatArray = depth.max(axis=(-2, -1))
        return deepest

    @staticmethod
    def _overload(loaded: LoadedRobot, effort: FloatArray, configurations: FloatArray, loads: FloatArray) -> FloatArray:
        robot = loaded.robot
        jacobians = robot.jacobians(configurations)
        wrenches = loaded.wrenches(jacobians.rotation, loads)[0]
        gravity = loaded.load.gravities(loads, robot.gravity)
        forces = actuator_forces(jacobians, wrenches) + robot.own_weight(configurations, gravity)
        overload: FloatArray = (np.abs(forces) / effort).max(axis=-1) - 1.0
        return overload


def _points(loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> FloatArray:
    """Points of the robot and the payload's centre of mass in O (m), shape (..., p, d)."""
    robot = loaded.robot
    points = [robot.position(configurations)[..., None, :]]
    drawing = robot.drawing(configurations)
    if drawing is not None:
        for part in drawing.parts:
            for path in part.paths:
                for start, end in pairwise(path):
                    here, there = drawing.points[..., start, None, :], drawing.points[..., end, None, :]
                    points.append(here + _ALONG[:, None] * (there - here))
    centres = loaded.load.centres(loads)
    if centres.shape[-1]:
        rotation = robot.jacobians(configurations).rotation
        lever = (rotation @ centres[..., None])[..., 0]
        points.append((points[0][..., 0, :] + lever)[..., None, :])
    return np.concatenate(points, axis=-2)


def _distinct(values: FloatArray) -> FloatArray:
    """Number of distinct rows of each design, values (b, m, n), shape (b,)."""
    return np.array([len(np.unique(design, axis=0)) for design in values], dtype=float)
