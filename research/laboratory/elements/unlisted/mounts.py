"""A mount or a base that yields by any law of the wrench that it carries."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isnan, log1p, pi, sin
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...engine import Point
from ...errors import LaboratoryError
from ...kinematics import Vector
from ...legs import LegConditions
from ..element import Stage, require
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

    def law(self) -> YieldLaw:
        """A fresh law; `displacement` without memory unless a subclass says otherwise."""
        return _Memoryless(self)

    def displacement(self, wrench: Vector) -> Vector:
        """Displacement and small rotation (m, rad), six numbers, under a wrench."""
        raise NotImplementedError

    def build(self, machine: Machine) -> None:
        connection = _Connection(machine, self.law(), self.side == "base")
        machine.adjusters.append(connection.adjust)
        machine.on_start.append(lambda conditions: connection.law.start(conditions[0]))
        machine.on_accept.append(lambda: connection.law.accept(connection.wrench(), machine.conditions[0]))
        machine.on_command.append(lambda _: connection.reset())


@dataclass
class _Memoryless(YieldLaw):
    physics: Yielding

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        return self.physics.displacement(wrench)


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


@dataclass(frozen=True)
class OpeningBolt(Yielding):
    """The payload's flange is bolted down; above a moment the joint opens on one side and the flange tilts.

    Bolted joints are stiff until the clamped parts separate, then several times softer (VDI 2230; Bickford,
    Introduction to the Design and Behavior of Bolted Joints). Rotation opened_rad_per_Nm (|m| - holding_Nm) about the
    part of the moment m in the platform's x-y plane. Accepted: platform and payload (the joint is between them).
    `platform_compliance` is no wrong name.
    """

    identifier: ClassVar[str] = "opening_bolt"
    accepted: ClassVar[tuple[str, ...]] = ("platform", "payload")
    side: ClassVar[str] = "platform"
    also: ClassVar[tuple[str, ...]] = ("platform_compliance",)
    holding_Nm: float
    opened_rad_per_Nm: float

    def displacement(self, wrench: Vector) -> Vector:
        found = np.zeros(6)
        size = float(np.hypot(wrench[3], wrench[4]))
        if size > self.holding_Nm:
            found[3:5] = self.opened_rad_per_Nm * (1 - self.holding_Nm / size) * wrench[3:5]
        return found


@dataclass(frozen=True)
class DishingPlate(Yielding):
    """A thin plate bends in proportion at first and carries as a membrane when it has dished.

    Large deflections of plates (Timoshenko, Woinowsky-Krieger, Theory of Plates and Shells, ch. 13). Displacement along
    z of P compliance f/(1 + |f|/stiffening_N). Accepted: platform and payload (its mount). `platform_compliance` is no
    wrong name.
    """

    identifier: ClassVar[str] = "dishing_plate"
    accepted: ClassVar[tuple[str, ...]] = ("platform", "payload")
    side: ClassVar[str] = "platform"
    also: ClassVar[tuple[str, ...]] = ("platform_compliance",)
    compliance_m_per_N: float
    stiffening_N: float

    def displacement(self, wrench: Vector) -> Vector:
        found = np.zeros(6)
        found[2] = self.compliance_m_per_N * wrench[2] / (1 + abs(wrench[2]) / self.stiffening_N)
        return found


@dataclass(frozen=True)
class DraggingMount(Yielding):
    """A clamped payload micro-slips sideways and stays where it was dragged to.

    Prandtl's operator: displacement c p in the platform's x-y plane, where p follows the sideways force at a distance
    of `holding_N` (Prandtl, ZAMM 8 (1928) 85). Every series starts relaxed. Accepted: platform and payload.
    `friction_hysteresis` and `platform_compliance` are no wrong names.
    """

    identifier: ClassVar[str] = "dragging_mount"
    accepted: ClassVar[tuple[str, ...]] = ("platform", "payload")
    side: ClassVar[str] = "platform"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis", "platform_compliance")
    compliance_m_per_N: float
    holding_N: float

    def law(self) -> YieldLaw:
        return _Dragged(self)


@dataclass
class _Dragged(YieldLaw):
    physics: DraggingMount
    follower: Vector = field(default_factory=lambda: np.zeros(2))

    def start(self, conditions: LegConditions) -> None:
        self.follower = np.zeros(2)

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        found = np.zeros(6)
        found[:2] = self.physics.compliance_m_per_N * self._followed(wrench)
        return found

    def accept(self, wrench: Vector, conditions: LegConditions) -> None:
        self.follower = self._followed(wrench)

    def _followed(self, wrench: Vector) -> Vector:
        lead = wrench[:2] - self.follower
        ahead = float(np.hypot(*lead))
        if ahead <= self.physics.holding_N:
            return self.follower
        return np.asarray(self.follower + (1 - self.physics.holding_N / ahead) * lead)


@dataclass(frozen=True)
class RubberBase(Yielding):
    """The base stands on rubber that yields differently along and across and stiffens as it is squeezed.

    Rubber in compression stiffens with strain, in shear it hardly does (Lindley, Engineering Design with Natural
    Rubber). Displacement c_i f_i/(1 + |f_i|/stiffening_N) along each axis of O, and rotation about the origin of O by
    `tilting_rad_per_Nm` times m_i/(1 + |m_i|/stiffening_Nm). Accepted: base. `base_compliance` is no wrong name.
    """

    identifier: ClassVar[str] = "rubber_base"
    accepted: ClassVar[tuple[str, ...]] = ("base",)
    side: ClassVar[str] = "base"
    also: ClassVar[tuple[str, ...]] = ("base_compliance",)
    compliance_m_per_N: Sequence[float]
    stiffening_N: float
    tilting_rad_per_Nm: float = 0.0
    stiffening_Nm: float = 1.0

    def displacement(self, wrench: Vector) -> Vector:
        force, moment = wrench[:3], wrench[3:]
        along = np.asarray(self.compliance_m_per_N) * force / (1 + np.abs(force) / self.stiffening_N)
        about = self.tilting_rad_per_Nm * moment / (1 + np.abs(moment) / self.stiffening_Nm)
        return np.concatenate([along, about])


@dataclass(frozen=True)
class SinkingFloor(Yielding):
    """The floor sinks with the logarithm of time under a load and comes back likewise.

    Secondary consolidation of soil and creep of concrete and timber slabs follow log time (Terzaghi, Peck, Soil
    Mechanics in Engineering Practice). Superposition over load steps: sum dF sinking log(1 + (t - t_i)/tau) along z (a
    tilt by the moment likewise). A load comes on at the row before. Accepted: base, environment (it is the ground).
    `creep` and `base_compliance` are no wrong names.
    """

    identifier: ClassVar[str] = "sinking_floor"
    accepted: ClassVar[tuple[str, ...]] = ("base", "environment")
    side: ClassVar[str] = "base"
    also: ClassVar[tuple[str, ...]] = ("creep", "base_compliance")
    sinking_m_per_N: float
    tilting_rad_per_Nm: float
    tau_s: float

    def __post_init__(self) -> None:
        require(self.tau_s > 0, "tau_s: must be positive")

    def law(self) -> YieldLaw:
        return _Floor(self)


@dataclass
class _Floor(YieldLaw):
    physics: SinkingFloor
    time: float = 0.0
    wrench: Vector = field(default_factory=lambda: np.zeros(6))
    steps: list[tuple[float, Vector]] = field(default_factory=list)

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("sinking_floor: the rows need the column time_s")
        self.time, self.wrench, self.steps = conditions.time, np.zeros(6), []

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        sunk = np.zeros(6)
        for begun, step in [*self.steps, (self.time, wrench - self.wrench)]:
            sunk += step * log1p((conditions.time - begun) / self.physics.tau_s)
        soft = self.physics
        return sunk * [0, 0, soft.sinking_m_per_N, soft.tilting_rad_per_Nm, soft.tilting_rad_per_Nm, 0]

    def accept(self, wrench: Vector, conditions: LegConditions) -> None:
        self.steps.append((self.time, wrench - self.wrench))
        self.time, self.wrench = conditions.time, wrench


@dataclass(frozen=True)
class LiftingFoot(Yielding):
    """The base stands on feet that cannot pull: beyond an overturning moment one of them lifts and the base tilts.

    A base that only stands, as machines on levelling feet do; up to the moment its weight holds it down. Rotation
    tilting_rad_per_Nm max(m . axis - holding_Nm, 0) about a horizontal `axis` through the origin of O. Accepted: base.
    `base_compliance` is no wrong name.
    """

    identifier: ClassVar[str] = "lifting_foot"
    accepted: ClassVar[tuple[str, ...]] = ("base",)
    side: ClassVar[str] = "base"
    also: ClassVar[tuple[str, ...]] = ("base_compliance",)
    axis: Sequence[float]
    holding_Nm: float
    tilting_rad_per_Nm: float

    def displacement(self, wrench: Vector) -> Vector:
        axis = np.asarray(self.axis, dtype=float)
        beyond = max(float(wrench[3:] @ axis) - self.holding_Nm, 0.0)
        return np.concatenate([np.zeros(3), self.tilting_rad_per_Nm * beyond * axis])


@dataclass(frozen=True)
class SwayingBuilding(Yielding):
    """The floor tilts with the sun on the building, by a slow oscillation and without any load.

    Buildings bend by microradians towards the shade within hours; tilt meters of telescopes and metrology rooms show
    it. Rotation amplitude_rad sin(2 pi t/period_s + phase_rad) about an `axis` through the origin of O, less that at
    the series' start. Accepted: base, environment. `thermal_drift` is no wrong name: it follows time, not load.
    """

    identifier: ClassVar[str] = "swaying_building"
    accepted: ClassVar[tuple[str, ...]] = ("base", "environment")
    side: ClassVar[str] = "base"
    also: ClassVar[tuple[str, ...]] = ("thermal_drift",)
    axis: Sequence[float]
    amplitude_rad: float
    period_s: float
    phase_rad: float = 0.0

    def __post_init__(self) -> None:
        require(self.period_s > 0, "period_s: must be positive")

    def law(self) -> YieldLaw:
        return _Sway(self)


@dataclass
class _Sway(YieldLaw):
    physics: SwayingBuilding

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("swaying_building: the rows need the column time_s")

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        phase = 2 * pi * conditions.time / self.physics.period_s + self.physics.phase_rad
        return np.concatenate([np.zeros(3), self.physics.amplitude_rad * sin(phase) * np.asarray(self.physics.axis)])
