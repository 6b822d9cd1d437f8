"""One table of robots, loads, noises and load errors with which the properties of the method are crossed."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from expdesign.coordinates import Coordinates
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.errors.source import (
    CentreOfMassError,
    DirectionError,
    LoadErrorSource,
    MassError,
    WrenchError,
)
from expdesign.mechanics.loads.load import Load, Payload, Wrench
from expdesign.mechanics.robots.bipod import Bipod
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.orientation import Orientation
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.targets import Aggregate, Targets
from expdesign.planning.deflection_noise import DeflectionNoise
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.schema import OptimiserSection
from expdesign.planning.space import DesignSpace
from expdesign.planning.variables import fixed
from tests.oracle import Array


def symmetric_hexapod(
    base: float,
    platform: float,
    height: float,
    drop: float,
    stiffness: float,
    orientation: Orientation = "fixed-xyz",
) -> Hexapod:
    """The default hexapods of theory.md 2.2 (yaw 90°)."""
    base_angles = np.deg2rad(np.array([-10.0, 10.0, 110.0, 130.0, 230.0, 250.0]) + 90.0)
    platform_angles = np.deg2rad(np.array([-50.0, 50.0, 70.0, 170.0, 190.0, 290.0]) + 90.0)
    return Hexapod(
        base_joints=np.stack([base * np.cos(base_angles), base * np.sin(base_angles), np.zeros(6)], axis=1),
        platform_joints=np.stack(
            [platform * np.cos(platform_angles), platform * np.sin(platform_angles), np.full(6, -drop)], axis=1
        ),
        home=np.array([0.0, 0.0, height]),
        stiffness=np.full(6, stiffness),
        orientation=orientation,
    )


def irregular_hexapod() -> Hexapod:
    """H1 with its joints scattered by centimetres, legs of unequal stiffness and gravity that is not along z."""
    regular = symmetric_hexapod(0.24, 0.17, 0.30, 0.03, 5.24e6)
    generator = np.random.default_rng(20)
    return Hexapod(
        base_joints=regular.base_joints + generator.uniform(-0.03, 0.03, (6, 3)),
        platform_joints=regular.platform_joints + generator.uniform(-0.03, 0.03, (6, 3)),
        home=np.array([0.01, -0.02, 0.31]),
        stiffness=np.array([3.0e6, 8.0e6, 5.0e6, 1.2e7, 4.0e6, 6.5e6]),
        gravity=np.array([1.0, -2.0, -9.5]),
    )


def camera_hexapod() -> Hexapod:
    """Rubin camera hexapod: pivot 2.6 m from the joints, `moving-xyz` (lsst-ts/ts_mthexapod, constants.py, 2020).

    The stiffness is not published; it is chosen here.
    """
    base = [[0.2276, 0.6538], [-0.2276, 0.6538], [-0.68, -0.1297], [-0.4523, -0.524], [0.4523, -0.524], [0.68, -0.1297]]
    moving = [
        [0.4728, 0.5122],
        [-0.4728, 0.5122],
        [-0.68, 0.1533],
        [-0.2072, -0.6655],
        [0.2072, -0.6655],
        [0.68, 0.1533],
    ]
    pivot = -2.7584
    return Hexapod(
        base_joints=np.array([[x, y, -0.525] for x, y in base]),
        platform_joints=np.array([[x, y, -0.1214 - pivot] for x, y in moving]),
        home=np.array([0.0, 0.0, pivot]),
        stiffness=np.full(6, 1.0e8),
        orientation="moving-xyz",
    )


@dataclass(frozen=True)
class RobotCase:
    """A robot, where it is used, and loads of the size that it carries."""

    make: Callable[[], ParallelRobot]
    low: tuple[float, ...]
    high: tuple[float, ...]
    mass: float
    lever: float
    deviation: tuple[float, ...]

    def poses(self, generator: np.random.Generator, *shape: int) -> Array:
        """Poses drawn uniformly from the workspace, shape (*shape, n)."""
        low, high = np.array(self.low), np.array(self.high)
        return low + generator.random((*shape, len(low))) * (high - low)

    def wrenches(self, generator: np.random.Generator, *shape: int) -> Array:
        """Wrenches of the size that the robot carries, in every direction, shape (*shape, n)."""
        size = np.full(len(self.low), 9.81 * self.mass)
        size[3:] *= self.lever
        return generator.uniform(-1.0, 1.0, (*shape, len(size))) * size


_PUNA = (0.03, 0.03, 0.02, 0.19, 0.19, 0.35)
_CAMERA = (0.0114, 0.0114, 0.0131, 0.00628, 0.00628, 0.00175)
_MICRO = (5e-7, 6e-7, 4e-7, 2e-6, 1.5e-6, 3e-6)


def _around(half: tuple[float, ...]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return tuple(-value for value in half), half


ROBOTS: dict[str, RobotCase] = {
    "bipod": RobotCase(
        lambda: Bipod(
            base_joints=np.array([[-0.5, 0.0], [0.5, 0.0]]), home=np.zeros(2), stiffness=np.array([1.0e7, 1.3e7])
        ),
        (-0.3, 0.35),
        (0.3, 0.95),
        100.0,
        0.1,
        (1e-6, 1e-6),
    ),
    "bipod-unequal": RobotCase(
        lambda: Bipod(
            base_joints=np.array([[-0.7, 0.1], [0.4, -0.05]]), home=np.array([0.1, 0.5]), stiffness=np.array([4e6, 3e7])
        ),
        (-0.3, -0.1),
        (0.3, 0.4),
        100.0,
        0.1,
        (2e-6, 5e-7),
    ),
    "H1": RobotCase(lambda: symmetric_hexapod(0.24, 0.17, 0.30, 0.03, 5.24e6), *_around(_PUNA), 26.5, 0.1, _MICRO),
    "H-large": RobotCase(lambda: symmetric_hexapod(0.36, 0.28, 0.44, 0.04, 6e7), *_around(_PUNA), 120.0, 0.2, _MICRO),
    "irregular": RobotCase(irregular_hexapod, *_around(_PUNA), 26.5, 0.1, _MICRO),
    "moving-xyz": RobotCase(
        lambda: symmetric_hexapod(0.24, 0.17, 0.30, 0.03, 5.24e6, "moving-xyz"), *_around(_PUNA), 26.5, 0.1, _MICRO
    ),
    "camera": RobotCase(camera_hexapod, *_around(_CAMERA), 3000.0, 1.0, _MICRO),
}


@cache
def robot(name: str) -> ParallelRobot:
    """The robot of the table, made once."""
    return ROBOTS[name].make()


def content_of(here: ParallelRobot) -> dict[str, Any]:
    """What the file of a robot says."""
    assert isinstance(here, Bipod | Hexapod)
    content = {
        "kind": here.kind, "home": here.home.tolist(), "gravity_m_s2": here.gravity.tolist(),
        "base_joints": here.base_joints.tolist(), "actuator_stiffness": here.stiffness.tolist(),
    }  # fmt: skip
    if isinstance(here, Hexapod):
        content |= {"platform_joints": here.platform_joints.tolist(), "orientation": here.orientation}
    return content


def load_of(kind: str, coordinates: Coordinates) -> Load:
    """A load by its kind."""
    return Payload(coordinates) if kind == "payload" else Wrench(coordinates)


def loads(name: str, kind: str, generator: np.random.Generator, *shape: int) -> Array:
    """Load parameters (*shape, k): payloads under gravity that turns, or free wrenches."""
    case = ROBOTS[name]
    if kind == "wrench":
        return case.wrenches(generator, *shape)
    gravity = robot(name).gravity + generator.uniform(-3.0, 3.0, (*shape, len(robot(name).gravity)))
    mass = case.mass * generator.uniform(0.3, 1.0, (*shape, 1))
    centre = case.lever * generator.uniform(-1.0, 1.0, (*shape, len(robot(name).coordinates.centre_of_mass)))
    return np.concatenate([mass, centre, gravity], axis=-1)


def correlated(name: str) -> Array:
    """A full covariance with the deviations of the table and strong correlations."""
    deviation = np.array(ROBOTS[name].deviation)
    n = len(deviation)
    root = np.eye(n) + 0.4 * np.sin(np.arange(n * n)).reshape(n, n)
    covariance = root @ root.T
    scale = deviation / np.sqrt(np.diag(covariance))
    return covariance * np.outer(scale, scale)


def _independent(name: str) -> DeflectionNoise:
    deviation = np.array(ROBOTS[name].deviation)
    return DeflectionNoise.from_deviations(np.arange(len(deviation)), deviation)


def _some_axes(name: str) -> DeflectionNoise:
    deviation = np.array(ROBOTS[name].deviation)
    axes = np.array([1]) if len(deviation) == 2 else np.array([0, 2, 4])
    return DeflectionNoise.from_deviations(axes, deviation[axes])


NOISES: dict[str, Callable[[str], DeflectionNoise]] = {
    "deviations": _independent,
    "covariance": lambda name: DeflectionNoise(np.arange(len(ROBOTS[name].deviation)), correlated(name)),
    "some-axes": _some_axes,
    "shared-reference": lambda name: DeflectionNoise(
        np.arange(len(ROBOTS[name].deviation)), correlated(name), shared_reference=True
    ),
}

SOURCES: dict[str, tuple[type[LoadErrorSource], tuple[float, ...]]] = {
    "com": (CentreOfMassError, (0.001, 0.002, 0.003)),
    "mass": (MassError, (0.05,)),
    "direction": (DirectionError, (0.0005, 0.001)),
    "wrench": (WrenchError, (0.5, 0.7, 0.9, 0.05, 0.04, 0.06)),
}


def source_of(name: str, load: Load, shared: bool) -> LoadErrorSource | None:
    """A source of load error of the table, or None where it does not exist for the load."""
    kind, deviation = SOURCES[name]
    size = kind.dimension(load)
    return kind(np.array(deviation[:size]), shared) if size else None


@dataclass(frozen=True)
class Setup:
    """A robot under a kind of load with an instrument, load errors and targets."""

    name: str
    loaded: LoadedRobot
    noise: DeflectionNoise
    targets: Targets
    target_wrenches: Array
    shared: tuple[bool, ...] = field(default=())

    def designs(self, generator: np.random.Generator, count: int, measurements: int) -> tuple[Array, Array, Array]:
        """Poses (b, m, n), loads (b, m, k) and series (b, m); every other pose is measured under two loads."""
        poses = ROBOTS[self.name].poses(generator, count, measurements)
        poses[:, 1::2] = poses[:, : 2 * (measurements // 2) : 2]
        series = np.broadcast_to(1 + np.arange(measurements) // 2, (count, measurements))
        return poses, loads(self.name, self.loaded.load.kind, generator, count, measurements), series

    def assess(self, poses: Array, parameters: Array, series: Array | None = None) -> Assessment:
        """The package's assessment of b designs."""
        measured = self.loaded.measure(poses, parameters)
        return Assessment(measured, self.noise, self.shared, self.targets, series, estimator="weighted")

    def problem(self) -> DesignProblem:
        """The same as a design problem; nothing is searched in it."""
        space = DesignSpace(1, (fixed(0.0),), (), (), self.loaded.robot.coordinates, None)
        settings = OptimiserSection(population=4, generations=1, polish=False)
        return DesignProblem(
            loaded=self.loaded,
            noise=self.noise,
            targets=self.targets,
            target_wrenches=self.target_wrenches,
            target_loads=(),
            space=space,
            objectives=(),
            optimiser=settings,
            config={},
            source=self.name,
            estimator="weighted",
        )

    def plan(self, generator: np.random.Generator, measurements: int) -> Plan:
        """One design as a plan."""
        poses, parameters, series = self.designs(generator, 1, measurements)
        return Plan(poses[0], parameters[0], series[0])


def targets_of(name: str, count: int = 2, aggregate: Aggregate = "mean", seed: int = 5) -> tuple[Targets, Array]:
    """Targets with wrenches, weights and tolerances; the last axis of each does not matter."""
    generator = np.random.default_rng(seed)
    case, here = ROBOTS[name], robot(name)
    poses, wrenches = case.poses(generator, count), case.wrenches(generator, count)
    loaded = LoadedRobot(here, Wrench(here.coordinates))
    observation = loaded.measure(poses, wrenches).observation
    tolerance = np.array(case.deviation) * generator.uniform(1.0, 4.0, poses.shape)
    importance = 1.0 / tolerance**2
    importance[:, -1] = 0.0
    weights = generator.uniform(0.5, 2.0, count)
    return Targets(poses, observation, importance, weights, here.coordinates.translations, aggregate), wrenches


def setup(
    name: str,
    kind: str = "payload",
    noise: str = "deviations",
    errors: tuple[tuple[str, bool], ...] = (),
    aggregate: Aggregate = "mean",
) -> Setup:
    """A set-up of the table; `errors` are sources with whether they are shared, left out where they do not exist."""
    here = robot(name)
    load = load_of(kind, here.coordinates)
    sources = tuple(s for s in (source_of(source, load, shared) for source, shared in errors) if s is not None)
    targets, wrenches = targets_of(name, aggregate=aggregate)
    shared = tuple(source.shared for source in sources)
    return Setup(name, LoadedRobot(here, load, sources), NOISES[noise](name), targets, wrenches, shared)


ALL_ERRORS: tuple[tuple[str, bool], ...] = (("com", True), ("mass", False), ("direction", True), ("wrench", False))
