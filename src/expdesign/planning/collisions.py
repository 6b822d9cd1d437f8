"""Distances between the parts of a robot and its payload (`experiment.constraints.collisions`).

Legs, or the links of an arm, are capsules around the lines of the robot's drawing; payload, platform and base are one
primitive each. Parts that are joined to each other are not compared: neighbouring links, legs with platform and base,
and the payload with platform and last link. Distances are coal's (Gilbert, Johnson & Keerthi, IEEE J. Robot. Autom. 4
(1988) 193, and the expanding polytope algorithm for depths), negative where parts overlap.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, pairwise
from types import ModuleType
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.mechanics.robots.drawing import Drawing
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class Primitive:
    """A box (edges), a cylinder about z (radius, length) or a sphere (radius), by the number of its sizes (m).

    Attributes:
        sizes: three, two or one (m).
        centre: in the frame that it is fixed to (m), shape (3,).
    """

    sizes: tuple[float, ...]
    centre: FloatArray


@dataclass(frozen=True)
class Collisions:
    """What must stay apart.

    Attributes:
        clearance: between any two parts that are compared (m).
        radius: of legs or links (m).
        payload: fixed to the platform, or None.
        platform: fixed to the platform, or None; compared with the base.
        base: fixed in O, or None.
    """

    clearance: float
    radius: float
    payload: Primitive | None = None
    platform: Primitive | None = None
    base: Primitive | None = None

    def excess(self, robot: Robot, configurations: FloatArray) -> FloatArray:
        """Clearance less the least distance (m) at configurations (..., n_q), ≤ 0 where all is well, shape (...)."""
        drawing = robot.drawing(configurations)
        if drawing is None:
            return np.full(configurations.shape[:-1], -1.0)
        library = require_library("experiment.constraints.collisions")
        segments = list(_segments(drawing))
        points = drawing.points.reshape(-1, *drawing.points.shape[-2:])
        origins = robot.position(configurations).reshape(-1, 3)
        rotations = robot.jacobians(configurations).rotation.reshape(-1, 3, 3)
        least = [self._least(library, segments, *state) for state in zip(points, origins, rotations, strict=True)]
        return self.clearance - np.array(least).reshape(configurations.shape[:-1])

    def _least(
        self,
        library: ModuleType,
        segments: list[tuple[int, int]],
        points: FloatArray,
        origin: FloatArray,
        R: FloatArray,
    ) -> float:
        capsules = [_capsule(library, points[a], points[b], self.radius) for a, b in segments]
        apart = [
            (capsules[i], capsules[j])
            for i, j in combinations(range(len(segments)), 2)
            if not set(segments[i]) & set(segments[j])
        ]
        base = None if self.base is None else _placed(library, self.base, np.zeros(3), np.eye(3))
        if self.payload is not None:
            payload = _placed(library, self.payload, origin, R)
            # A link that ends where the platform frame stands carries the payload.
            free = [
                capsule
                for capsule, ends in zip(capsules, segments, strict=True)
                if np.linalg.norm(points[list(ends)] - origin, axis=1).min() > 1e-9
            ]
            apart += [(payload, other) for other in free] + ([(payload, base)] if base is not None else [])
        if self.platform is not None and base is not None:
            apart.append((_placed(library, self.platform, origin, R), base))
        request = library.DistanceRequest()
        request.enable_signed_distance = True
        distances = [float(library.distance(*one, *two, request, library.DistanceResult())) for one, two in apart]
        return min(distances, default=np.inf)


def require_library(where: str) -> ModuleType:
    """coal, the library of distances.

    Raises:
        InputError: it is not installed.
    """
    try:
        import coal  # noqa: PLC0415 (optional)
    except ImportError:
        remedy = "Install it with `pip install 'expdesign[collisions]'`, or take the key out."
        raise InputError(
            "collisions need the library coal, which is not installed", where=where, remedy=remedy
        ) from None
    library: ModuleType = coal
    return library


def _segments(drawing: Drawing) -> Iterator[tuple[int, int]]:
    """Ends of the lines that are legs or links, without those of no length."""
    flat = drawing.points.reshape(-1, *drawing.points.shape[-2:])
    for part in drawing.parts:
        for path in part.paths if part.role == "actuator" else ():
            for start, end in pairwise(path):
                if np.linalg.norm(flat[:, start] - flat[:, end], axis=1).max(initial=0.0) > 1e-9:
                    yield start, end


def _capsule(library: ModuleType, start: FloatArray, end: FloatArray, radius: float) -> tuple[Any, Any]:
    line = end - start
    length = float(np.linalg.norm(line))
    axis = line / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    side = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    side /= np.linalg.norm(side)
    frame = np.stack([side, np.cross(axis, side), axis], axis=1)
    return library.Capsule(radius, length), library.Transform3s(frame, (start + end) / 2.0)


def _placed(library: ModuleType, primitive: Primitive, origin: FloatArray, rotation: FloatArray) -> tuple[Any, Any]:
    kind = {1: library.Sphere, 2: library.Cylinder, 3: library.Box}[len(primitive.sizes)]
    return kind(*primitive.sizes), library.Transform3s(rotation, origin + rotation @ primitive.centre)
