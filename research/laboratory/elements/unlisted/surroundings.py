"""Payloads that move by themselves, and what pulls or presses on them from outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...engine import Point
from ...kinematics import Matrix, Pose, Vector
from ...loads import Load
from .law import Unlisted

if TYPE_CHECKING:
    from ...machine import Machine


@dataclass(frozen=True)
class Sloshing(Unlisted):
    """Liquid or loose parts run to the lower side: the centre of mass moves with the tilt of the platform.

    Free surface effect (ships, tank trucks): shift_m times the downhill part of gravity's direction in the platform's
    x-y plane. Accepted: payload. `payload_com_offset` is no wrong name.
    """

    identifier: ClassVar[str] = "sloshing"
    accepted: ClassVar[tuple[str, ...]] = ("payload",)
    also: ClassVar[tuple[str, ...]] = ("payload_com_offset",)
    shift_m: float

    def build(self, machine: Machine) -> None:
        downhill = [np.zeros(3)]

        def tilt(platform: Pose) -> None:
            gravity = machine.robot.gravity
            downhill[0] = platform.rotation.T @ gravity / np.linalg.norm(gravity) * [1.0, 1.0, 0.0]

        machine.on_command.append(tilt)
        machine.load_laws.append(lambda load: load.shifted(self.shift_m * downhill[0]))


@dataclass(frozen=True)
class DroopingPayload(Unlisted):
    """A slender payload bends under its own weight, and its centre of mass moves along the force that acts on it.

    A cantilever's end sags in proportion to its load, so the moment has a part that is quadratic in the load. Shift
    compliance_m_per_N times the force, in platform axes. Accepted: payload. `payload_com_offset` is no wrong name.
    """

    identifier: ClassVar[str] = "drooping_payload"
    accepted: ClassVar[tuple[str, ...]] = ("payload",)
    also: ClassVar[tuple[str, ...]] = ("payload_com_offset",)
    compliance_m_per_N: float
    axis: Sequence[float]

    def build(self, machine: Machine) -> None:
        turned: list[Matrix] = [np.eye(3)]
        axis = np.asarray(self.axis, dtype=float)

        def turn(platform: Pose) -> None:
            turned[0] = platform.rotation

        def bent(load: Load) -> Load:
            return load.shifted(self.compliance_m_per_N * float(axis @ turned[0].T @ load.force) * axis)

        machine.on_command.append(turn)
        machine.load_laws.append(bent)


@dataclass(frozen=True)
class Hose(Unlisted):
    """A hose or cable chain hangs between a post and the payload and pulls with the tension of its catenary.

    Shallow catenary of length `length_m` and weight `weight_N_per_m` (Irvine, Cable Structures, 1981): with the chord d
    the sag is sqrt(3 d (l - d)/8), the pull along the chord w d^2/(8 sag), and half of the weight hangs on the payload.
    It comes with the payload, so it is not in the unloaded reference. Accepted: payload, platform, environment.
    """

    identifier: ClassVar[str] = "hose"
    accepted: ClassVar[tuple[str, ...]] = ("payload", "platform", "environment")
    post_m: Sequence[float]
    platform_m: Sequence[float]
    length_m: float
    weight_N_per_m: float
    down: Sequence[float] = (0.0, 0.0, -1.0)

    def build(self, machine: Machine) -> None:
        down = np.asarray(self.down, dtype=float)

        def pull(chord: Vector) -> Vector:
            if not machine.loaded:
                return np.zeros(3)
            d = float(np.linalg.norm(chord))
            sag = sqrt(3 * d * max(self.length_m - d, 1e-3 * self.length_m) / 8)
            along = self.weight_N_per_m * d**2 / (8 * sag)
            return np.asarray(-along * chord / d + self.weight_N_per_m * self.length_m / 2 * down)

        point = Point(machine.mount, np.asarray(self.platform_m, dtype=float))
        machine.engine.add_field(point, np.asarray(self.post_m, dtype=float), pull)


@dataclass(frozen=True)
class Bellows(Unlisted):
    """A bellows joins the payload to a chamber: the air presses on its area and its folds are a spring.

    Edge-welded bellows are used between vacuum chambers and hexapods; pressure thrust is p A and the spring follows the
    stroke. The force along `axis` (in O) is thrust_N - rate_N_per_m (travel . axis). It comes with the payload.
    Accepted: payload, platform, environment.
    """

    identifier: ClassVar[str] = "bellows"
    accepted: ClassVar[tuple[str, ...]] = ("payload", "platform", "environment")
    axis: Sequence[float]
    thrust_N: float
    rate_N_per_m: float
    platform_m: Sequence[float] = (0.0, 0.0, 0.0)

    def build(self, machine: Machine) -> None:
        axis, point = np.asarray(self.axis, dtype=float), np.asarray(self.platform_m, dtype=float)

        def push(travel: Vector) -> Vector:
            if not machine.loaded:
                return np.zeros(3)
            return np.asarray((self.thrust_N - self.rate_N_per_m * float(travel @ axis)) * axis)

        machine.engine.add_field(Point(machine.mount, point), machine.robot.home + point, push, self.rate_N_per_m)


@dataclass(frozen=True)
class Wind(Unlisted):
    """Wind presses on a panel that the payload carries (telescopes, antennas, solar panels).

    Pressure on the panel grows with the square of the wind's component across it (Simiu, Scanlan, Wind Effects on
    Structures): force force_N |n . w| (n . w) n at a point of the platform, n the panel's normal (platform axes), w the
    wind's direction (in O). In the lee before the payload is mounted. Accepted: payload, environment, platform.
    """

    identifier: ClassVar[str] = "wind"
    accepted: ClassVar[tuple[str, ...]] = ("payload", "environment", "platform")
    force_N: float
    direction: Sequence[float]
    normal: Sequence[float]
    centre_m: Sequence[float] = (0.0, 0.0, 0.0)

    def build(self, machine: Machine) -> None:
        wind, normal = np.asarray(self.direction, dtype=float), np.asarray(self.normal, dtype=float)
        centre = np.asarray(self.centre_m, dtype=float)
        pressed = [np.zeros(3)]

        def turn(platform: Pose) -> None:
            face = platform.rotation @ normal
            across = float(face @ wind)
            pressed[0] = self.force_N * abs(across) * across * face

        def press(_: Vector) -> Vector:
            return pressed[0] if machine.loaded else np.zeros(3)

        machine.on_command.append(turn)
        machine.engine.add_field(Point(machine.mount, centre), machine.robot.home + centre, press)


@dataclass(frozen=True)
class TautWire(Unlisted):
    """A preloaded wire or spring runs from the ground to the platform all the time, and carries part of every load.

    Counterbalances and preloading springs do so (Merlet, Parallel Robots, 2006, on wire preload). Tension
    preload_N + stiffness (L - L0), L0 the length at home: the platform's stiffness has a part that no leg has.
    Accepted: environment, platform.
    """

    identifier: ClassVar[str] = "taut_wire"
    accepted: ClassVar[tuple[str, ...]] = ("environment", "platform")
    post_m: Sequence[float]
    platform_m: Sequence[float]
    stiffness_N_per_m: float
    preload_N: float = 0.0

    def build(self, machine: Machine) -> None:
        post, point = np.asarray(self.post_m, dtype=float), np.asarray(self.platform_m, dtype=float)
        commanded = [1.0]

        def set_anew(platform: Pose) -> None:  # the counterbalance follows every command with the same preload
            commanded[0] = float(np.linalg.norm(platform.point(point) - post))

        def tension(length: float) -> float:
            return self.preload_N + self.stiffness_N_per_m * (length - commanded[0])

        machine.on_command.append(set_anew)
        start, end = Point(machine.engine.ground, post), Point(machine.mount, point)
        machine.engine.add_spring(start, end, self.stiffness_N_per_m, tension)
