"""What a laboratory demands of a plan beside the robot's limits (`experiment.constraints`).

Of every measurement: nothing of the robot or its load inside a keep-out box, no actuator beyond its effort, the parts
of the robot and its payload at a distance from each other, and reflectors in sight (`visibility.py`). Of the plan as a
whole: at least so many distinct poses or masses, and poses and masses that have to occur.

Legs, or the links of an arm, are capsules around the lines of the robot's drawing; payload, platform and base are one
primitive each. Parts that are joined to each other are not compared: neighbouring links, legs with platform and base,
and the payload with platform and last link. Distances are coal's (Gilbert, Johnson & Keerthi, IEEE J. Robot. Autom. 4
(1988) 193, and the expanding polytope algorithm for depths), negative where parts overlap.
"""

from dataclasses import dataclass
from itertools import combinations, pairwise
from types import ModuleType
from typing import Any

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.errors import InputError
from expdesign.mechanics.elastostatics.maps import actuator_forces
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Load
from expdesign.mechanics.robots.drawing import Drawing
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.schema import CollisionsSection, ConstraintsSection, ExperimentSection, PrimitiveSection
from expdesign.planning.space import DesignSpace, Required
from expdesign.planning.tips import pose_of, tips_of
from expdesign.planning.visibility import Visibility, read_visibility


@dataclass(frozen=True)
class Collisions:
    """What must stay apart: legs or links, the payload and the platform, which move together, and the base."""

    stated: CollisionsSection

    def excess(self, robot: Robot, configurations: FloatArray) -> FloatArray:
        """Clearance less the least distance (m) at configurations (..., n_q), ≤ 0 where all is well, shape (...).

        Designs meet the same configurations again under other loads: each is looked at once.
        """
        batch, flat = configurations.shape[:-1], configurations.reshape(-1, configurations.shape[-1])
        distinct, index = np.unique(flat, axis=0, return_inverse=True)
        drawing = robot.drawing(distinct)
        if drawing is None:
            return np.full(batch, -1.0)
        library = require_library("experiment.constraints.collisions")
        segments = _segments(drawing)
        points = drawing.points.reshape(-1, *drawing.points.shape[-2:])
        origins = robot.position(distinct).reshape(-1, 3)
        rotations = robot.jacobians(distinct).rotation.reshape(-1, 3, 3)
        least = [self._least(library, segments, *state) for state in zip(points, origins, rotations, strict=True)]
        return self.stated.clearance_m - np.array(least)[index].reshape(batch)

    def _least(
        self,
        library: ModuleType,
        segments: list[tuple[int, int]],
        points: FloatArray,
        origin: FloatArray,
        R: FloatArray,
    ) -> float:
        capsules = [_capsule(library, points[a], points[b], self.stated.leg_radius_m) for a, b in segments]
        apart = [
            (capsules[i], capsules[j])
            for i, j in combinations(range(len(segments)), 2)
            if not set(segments[i]) & set(segments[j])
        ]
        base = None if self.stated.base is None else _placed(library, self.stated.base, np.zeros(3), np.eye(3))
        if self.stated.payload is not None:
            payload = _placed(library, self.stated.payload, origin, R)
            # A link that ends where the platform frame stands carries the payload.
            free = [
                capsule
                for capsule, ends in zip(capsules, segments, strict=True)
                if np.linalg.norm(points[list(ends)] - origin, axis=1).min() > 1e-9
            ]
            apart += [(payload, other) for other in free] + ([(payload, base)] if base is not None else [])
        if self.stated.platform is not None and base is not None:
            apart.append((_placed(library, self.stated.platform, origin, R), base))
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


def _segments(drawing: Drawing) -> list[tuple[int, int]]:
    """Ends of the lines that are legs or links, without those of no length."""
    flat = drawing.points.reshape(-1, *drawing.points.shape[-2:])
    return [
        (start, end)
        for start, end in drawing.segments("actuator")
        if np.linalg.norm(flat[:, start] - flat[:, end], axis=1).max(initial=0.0) > 1e-9
    ]


def _capsule(library: ModuleType, start: FloatArray, end: FloatArray, radius: float) -> tuple[Any, Any]:
    line = end - start
    length = float(np.linalg.norm(line))
    axis = line / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    side = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    side /= np.linalg.norm(side)
    frame = np.stack([side, np.cross(axis, side), axis], axis=1)
    return library.Capsule(radius, length), library.Transform3s(frame, (start + end) / 2.0)


def _placed(
    library: ModuleType, primitive: PrimitiveSection, origin: FloatArray, rotation: FloatArray
) -> tuple[Any, Any]:
    kind = {1: library.Sphere, 2: library.Cylinder, 3: library.Box}[len(primitive.sizes)]
    return kind(*primitive.sizes), library.Transform3s(rotation, origin + rotation @ np.array(primitive.at_m))


_ALONG = np.linspace(0.0, 1.0, 9)
"""Places along a line of the robot that are kept out of boxes."""


LIMITS = ("keep_out", "effort", "collisions", "visibility")
"""Keys of what is demanded of every measurement."""


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
        visibility: what the instrument has to see, or None.
    """

    boxes: FloatArray
    effort: FloatArray | None = None
    distinct_poses: int = 1
    distinct_masses: int = 1
    collisions: Collisions | None = None
    visibility: Visibility | None = None

    def measurements(self, loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> FloatArray:
        """How far measurements are beyond what is allowed, ≤ 0 within: boxes (m), effort (parts of it), collisions
        (m), visibility (rad or m).

        Args:
            loaded: the robot.
            configurations: shape (..., n_q).
            loads: shape (..., k).

        Returns:
            Shape (..., 4), in the order of `LIMITS`.
        """
        beyond = np.full((*configurations.shape[:-1], len(LIMITS)), -1.0)
        if len(self.boxes):
            beyond[..., 0] = self._penetration(loaded, configurations, loads)
        if self.effort is not None:
            beyond[..., 1] = self._overload(loaded, self.effort, configurations, loads)
        if self.collisions is not None:
            beyond[..., 2] = self.collisions.excess(loaded.robot, configurations)
        if self.visibility is not None:
            beyond[..., 3] = self.visibility.excess(loaded.robot, configurations).max(axis=-1)
        return beyond

    def binding(self, loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> str:
        """Which limits measurements (N, n_q), (N, k) break, the most frequent first, in words; empty where none is."""
        broken = (self.measurements(loaded, configurations, loads) > 0.0).mean(axis=0)
        names = [f"`{LIMITS[i]}` at {100.0 * broken[i]:.3g} %" for i in np.argsort(-broken) if broken[i] > 0.0]
        text = " and ".join(names)
        if self.visibility is None or not broken[3]:
            return text
        excess = self.visibility.excess(loaded.robot, configurations)
        nearest = excess[int(np.argmin(excess.max(axis=-1)))]
        return f"{text} (at the pose that is nearest to being seen {self.visibility.sentence(nearest)})"

    def violations(self, loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> FloatArray:
        """Constraints (≤ 0) of b designs: those of `LIMITS`, missing poses, masses; (b, 6)."""
        each = self.measurements(loaded, configurations, loads).max(axis=1)
        poses = _distinct(configurations)
        masses = _distinct(loads[..., :1]) if loaded.load.has_mass else np.full(len(loads), self.distinct_masses)
        missing = np.stack([self.distinct_poses - poses, self.distinct_masses - masses], axis=1).astype(float)
        return np.concatenate([each, missing], axis=1)

    def allowed(self, loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> BoolArray:
        """Which measurements are within boxes and effort, free of collisions and seen, shape (...)."""
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
        wrenches = loaded.load.wrenches(jacobians.rotation, loads)
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


def read_constraints(experiment: ExperimentSection, robot: Robot, load: Load) -> Constraints | None:
    """The constraints, or None where there are none.

    Raises:
        InputError: they contradict each other, the robot or the number of measurements.
    """
    section = experiment.constraints
    if section is None:
        return None
    if (section.distinct_masses > 1 or section.masses_kg) and not load.has_mass:
        remedy = "Take it out, or use `load: {kind: payload}`."
        raise section.where("masses_kg").fault("a wrench has no mass", remedy)
    dimension = len(robot.gravity)
    boxes = np.zeros((len(section.keep_out), 2, dimension))
    for index, box in enumerate(section.keep_out):
        if len(box.low_m) != dimension or len(box.high_m) != dimension:
            raise box.where().fault(f"{dimension} coordinates are needed for each corner", "In m, in O.")
        boxes[index] = box.low_m, box.high_m
        if (boxes[index, 0] >= boxes[index, 1]).any():
            raise box.where().fault("the corners are the wrong way round", "low_m is the lower one.")
    effort = robot.effort if section.effort else None
    if section.effort and (effort is None or not np.isfinite(effort).any()):
        remedy = "Add `effort=` to the <limit> of its joints, or take the key out."
        raise section.where("effort").fault("the robot states no effort of its actuators", remedy)
    collisions = _collisions(section, robot)
    seen = read_visibility(section.visibility, robot)
    return Constraints(boxes, effort, section.distinct_poses, section.distinct_masses, collisions, seen)


def _collisions(section: ConstraintsSection, robot: Robot) -> Collisions | None:
    stated = section.collisions
    if stated is None:
        return None
    if len(robot.gravity) != 3 or robot.drawing(np.zeros((1, len(robot.configuration)))) is None:
        what = f"collisions of a {robot.kind} are not known, which has no legs or links in space"
        raise section.where("collisions").fault(what, "Take the key out; `keep_out` boxes may do.")
    require_library(str(section.where("collisions")))
    return Collisions(stated)


def required(section: ConstraintsSection | None, space: DesignSpace, robot: Robot) -> Required:
    """Poses and masses that have to occur, as decisions.

    Raises:
        InputError: one of them cannot be chosen, or more different ones are demanded than there are.
    """
    if section is None:
        return Required()
    _require_as_many(section, space)
    poses = []
    for index, stated in enumerate(section.poses):
        place, tips = section.where("poses", index), bool(tips_of(robot))  # whichever is measured there
        poses.append(pose_of(stated, robot, place))
        if not bool(robot.usable(np.array([*poses[-1], *[1.0] * tips]))):
            raise place.fault("the pose is beyond the limits, or singular", "Choose another pose.")
    masses = [np.array([mass]) for mass in section.masses_kg]
    found: list[list[FloatArray]] = [[], []]
    wanted = (("poses", 0, poses), ("masses_kg", space.n_pose, masses))
    for decisions, (key, first, values) in zip(found, wanted, strict=True):
        for index, value in enumerate(values):
            decision = space.decisions_of(value, first)
            if decision is None:
                remedy = "Only what `experiment.poses` and `experiment.load` allow can occur."
                raise section.where(key, index).fault("this cannot be chosen", remedy)
            decisions.append(decision)
    return Required(*map(tuple, found))


def _require_as_many(section: ConstraintsSection, space: DesignSpace) -> None:
    """Raise an `InputError` where more different poses or masses are demanded than the experiment offers."""
    poses, masses = range(space.n_pose), range(space.n_pose, space.n_pose + 1)
    for key, demanded, source, quantities in (
        ("distinct_poses", section.distinct_poses, "poses", poses),
        ("poses", len(section.poses), "poses", poses),
        ("distinct_masses", section.distinct_masses, "load.mass_kg", masses),
        ("masses_kg", len(section.masses_kg), "load.mass_kg", masses),
    ):
        for name, offered in (("measurements", space.measurements), (source, space.different(quantities))):
            if demanded > offered:
                noun = "poses" if source == "poses" else "masses"
                what = f"{demanded} different {noun} are demanded, and `experiment.{name}` offers {offered:.0f}"
                raise section.where(key).fault(what, "Demand fewer, or offer more.")
