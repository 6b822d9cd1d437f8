"""The robot in the engine: platform, base and legs, plus what the elements add, and its equilibria.

Without elements it is a platform on axial springs between ideal spherical joints. Elements put bodies in
between (`Machine.base`, `Machine.mount`, `Machine.base_ends`, `Machine.platform_ends`), add members to legs
(`LegLaw`) and act on the platform from outside.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .elements.element import Element, Stage
from .engine import Body, Engine, Point
from .errors import LaboratoryError
from .kinematics import Matrix, Pose, Vector, leg_directions, leg_lengths
from .legs import Leg, LegConditions, LegLaw
from .loads import Load
from .robot import Robot

_TOLERANCE = 1e-13  # m, on the elongation of every leg
_ITERATIONS = 150
_UNDAMPED = 12


class Machine:
    """A robot with elements, ready to be commanded and loaded."""

    def __init__(self, robot: Robot, stiffness: Vector, elements: Sequence[Element]) -> None:
        self.engine = Engine()
        self.nominal = robot
        for element in elements:
            robot = element.true_geometry(robot)
        self.robot = robot
        self.legs = [Leg(index, float(k)) for index, k in enumerate(stiffness)]
        self.base: Body = self.engine.ground
        self.plate: Body = self.engine.add_body(robot.home, lambda platform: platform)
        self.mount: Body = self.plate
        self.loaded = False
        self.on_command: list[Callable[[Pose], None]] = []  # told the commanded pose of every series
        self.adjusters: list[Callable[[], float]] = []  # parts that move between equilibria: how far (m)
        self.load_laws: list[Callable[[Load], Load]] = []  # what makes another load of the stated one at this command
        self.on_start: list[Callable[[Sequence[LegConditions]], None]] = []  # parts with a memory: a series begins
        self.on_accept: list[Callable[[], None]] = []  # parts with a memory: this equilibrium has been reached
        self.load = Load.none()
        self.conditions: Sequence[LegConditions] = ()
        self.travel: Vector = np.zeros(3)
        home = robot.pose(np.zeros(2 if robot.planar else 6))
        self.home_directions: Matrix = leg_directions(self.nominal.base_joints, self.nominal.platform_joints, home)
        self.directions: Matrix = self.home_directions
        self._build(sorted(elements, key=lambda element: element.stage))
        self._laws: list[list[LegLaw]] = [[] for _ in self.legs]
        for element in elements:
            for index, law in element.leg_laws(self.legs).items():
                self._laws[index].append(law)
        self._stiffness = np.asarray(stiffness, dtype=float)
        self._lengths: Vector = np.ones(len(self.legs))
        self._further = np.zeros(len(self.legs))

    def _build(self, elements: Sequence[Element]) -> None:
        for element in elements:
            if element.stage == Stage.BODIES:
                element.build(self)
        self.base_ends = [Point(self.base, joint) for joint in self.robot.base_joints]
        self.platform_ends = [Point(self.plate, joint) for joint in self.robot.platform_joints]
        for element in elements:
            if element.stage > Stage.BODIES:
                element.build(self)
        if self.robot.planar:
            self._hold_in_plane()
        ends = zip(self.base_ends, self.platform_ends, self.legs, strict=True)
        self._springs = [self.engine.add_spring(base, top, leg.stiffness) for base, top, leg in ends]
        self._load = self.engine.add_load(self.mount)
        self.engine.assemble()

    def _hold_in_plane(self) -> None:
        # Nothing loads a bipod out of its plane or turns its tool point, so any stiffness there holds without
        # error.
        across = np.diag([0.0, 0.0, 1e7, 1e6, 1e6, 1e6])
        ground = Point(self.engine.ground, self.robot.home)
        self.engine.add_bushing(ground, Point(self.plate, np.zeros(3)), across)

    def command(self, coordinates: Vector, lengths: Vector | None = None) -> None:
        """Set the actuators for a pose, by the controller's nominal geometry or to given lengths (m)."""
        platform = self.nominal.pose(coordinates)
        if lengths is None:
            lengths = leg_lengths(self.nominal.base_joints, self.nominal.platform_joints, platform)
        self._lengths = lengths
        self.travel = platform.position - self.nominal.home
        self.directions = leg_directions(self.nominal.base_joints, self.nominal.platform_joints, platform)
        self._further = np.zeros(len(self.legs))
        self.engine.place(platform)
        for prepare in self.on_command:
            prepare(platform)

    @property
    def lengths(self) -> Vector:
        """Commanded actuator lengths (m)."""
        return self._lengths

    def start(self, conditions: Sequence[LegConditions]) -> None:
        """Begin a series: every member of every leg is relaxed."""
        for laws, each in zip(self._laws, conditions, strict=True):
            for law in laws:
                law.start(each)
        for begin in self.on_start:
            begin(conditions)

    def equilibrium(self, load: Load, conditions: Sequence[LegConditions]) -> Pose:
        """Load the mount, find the equilibrium and return the mount's pose.

        The engine's springs are linear. Whatever else a leg does is an elongation that depends on its force
        and is iterated until both agree to 1e-13 m: N_i = k_i (q_i - q_command,i - e_i(N_i)). Leg forces
        hardly depend on elongations (the legs are nearly statically determinate), so this converges in two or
        three passes. A leg that floats within its play has no law e(N); steps that shrink find the elongation
        at which N = 0.
        """
        self.loaded = not load.is_zero
        if self.loaded:
            for law_of_load in self.load_laws:
                load = law_of_load(load)
        self.load, self.conditions = load, conditions
        self._load.set(load.force, load.moment, load.point)
        fraction = 1.0
        for iteration in range(_ITERATIONS):
            for spring, length in zip(self._springs, self._lengths + self._further, strict=True):
                self.engine.set_spring_length(spring, length)
            self.engine.solve()
            forces = self.leg_forces()
            wanted = [
                sum(law.elongation(force, each) for law in laws)
                for laws, force, each in zip(self._laws, forces, conditions, strict=True)
            ]
            if iteration >= _UNDAMPED:
                fraction *= 0.7
            step = fraction * (np.array(wanted) - self._further)
            moved = sum(adjust() for adjust in self.adjusters)
            if np.abs(step).max() < _TOLERANCE and moved < _TOLERANCE:
                break
            self._further = self._further + step
        else:
            raise LaboratoryError(f"the legs' laws and the equilibrium do not agree after {_ITERATIONS} iterations")
        for laws, force, each in zip(self._laws, forces, conditions, strict=True):
            for law in laws:
                law.accept(float(force), each)
        for remember in self.on_accept:
            remember()
        return self.engine.pose(self.mount)

    def leg_forces(self) -> Vector:
        """Tension of every leg (N) in the last equilibrium."""
        stretched = np.array([self.engine.spring_length(spring) for spring in self._springs])
        return self._stiffness * (stretched - self._lengths - self._further)
