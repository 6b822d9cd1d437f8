"""A mount or a base that yields by any law of the wrench that it carries."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...engine import Point
from ...kinematics import Vector
from ...legs import LegConditions
from ..element import Stage
from .law import Unlisted

if TYPE_CHECKING:
    from ...machine import Machine

_CARRIER = 1e8  # N/m and N m/rad of the connection; what it yields itself is taken off the law's displacement


class YieldLaw(ABC):
    """Displacement and small rotation (m, rad) of a connection under a wrench (N, N m)."""

    def start(self, conditions: LegConditions) -> None:
        """Begin a series, relaxed."""
        del conditions

    @abstractmethod
    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        """Six numbers, without changing the law's memory."""

    def accept(self, wrench: Vector, conditions: LegConditions) -> None:
        """Remember the state that has been reached."""
        del wrench, conditions


@dataclass(frozen=True)
class Yielding(Unlisted):
    """A body on a connection whose displacement follows a law.

    `side` platform: the payload's mount on the joints' plate, wrench about the origin of P in platform axes. `side`
    base: the base on the ground, wrench about the origin of O. The wrench is that of the load (and of the pose where
    it acts): the law is exact as long as no hose or stop takes part of it away from the mount.
    """

    stage: ClassVar[Stage] = Stage.BODIES
    side: ClassVar[str]

    @abstractmethod
    def law(self) -> YieldLaw:
        """A fresh law."""

    def build(self, machine: Machine) -> None:
        connection = _Connection(machine, self.law(), self.side == "base")
        machine.adjusters.append(connection.adjust)
        machine.on_start.append(lambda conditions: connection.law.start(conditions[0]))
        machine.on_accept.append(lambda: connection.law.accept(connection.wrench(), machine.conditions[0]))
        machine.on_command.append(lambda _: connection.reset())


@dataclass
class _Connection:
    machine: Machine
    law: YieldLaw
    base: bool
    given: Vector = field(default_factory=lambda: np.zeros(6))

    def __post_init__(self) -> None:
        engine, zero = self.machine.engine, np.zeros(3)
        stiffness = _CARRIER * np.eye(6)
        if self.base:
            self.below = self.machine.base
            body = engine.add_body(zero, engine.ground.placement)
            self.machine.base = body
        else:
            self.below = self.machine.mount
            body = engine.add_body(self.machine.robot.home, lambda platform: platform)
            self.machine.mount = body
        self.bushing = engine.add_bushing(Point(self.below, zero), Point(body, zero), stiffness)

    def reset(self) -> None:
        self.given = np.zeros(6)
        self.machine.engine.set_bushing_offset(self.bushing, self.given)

    def wrench(self) -> Vector:
        """Wrench that the connection carries, about its own point and in its axes."""
        mount, load = self.machine.engine.pose(self.machine.mount), self.machine.load
        below = self.machine.engine.pose(self.below)
        arm = mount.point(load.point) - below.position
        moment = load.moment + np.cross(arm, load.force)
        return np.concatenate([below.rotation.T @ load.force, below.rotation.T @ moment])

    def adjust(self) -> float:
        """Follow the law; how far that moved (m, rad)."""
        wrench = self.wrench()
        wanted = self.law.offset(wrench, self.machine.conditions[0]) - wrench / _CARRIER
        moved = float(np.abs(wanted - self.given).max())
        if moved < 1e-13:
            return 0.0
        self.given = wanted
        self.machine.engine.set_bushing_offset(self.bushing, wanted)
        return moved
