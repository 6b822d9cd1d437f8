"""Legs whose elongation depends on what was before, or on what others carry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import atanh, exp, isnan, tanh
from typing import ClassVar

import numpy as np

from ...errors import LaboratoryError
from ...kinematics import Vector
from ...legs import Leg, LegConditions, LegLaw
from ..element import require
from ..leg_laws import Sliders
from .law import LegPhysics, Unlisted

_STUCK, _CLOSE = 0.3, 1.0 - 1e-12  # share of the stiffness that is left when all slips; z/z0 at most


@dataclass(frozen=True)
class BoucWen(LegPhysics):
    """A joint in series with the leg micro-slips: force over elongation follows a rounded loop.

    Wen, J. Eng. Mech. Div. 102 (1976) 249, with exponent 2 and beta = gamma: the joint's stiffness is k_j = k/ratio,
    N = a k_j e + (1 - a) k_j z with a = 0.3, dz = (1 - (z/z0)^2) de while |z| grows and dz = de while it shrinks. Its
    slipping part carries `saturation_N` at most. Bolted and riveted joints do so (Ibrahim, Pettit, J. Sound Vib. 279
    (2005) 857). Accepted: the leg. `friction_hysteresis` is no wrong name.
    """

    identifier: ClassVar[str] = "bouc_wen"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    ratio: float
    saturation_N: float

    def __post_init__(self) -> None:
        require(self.ratio >= 0, "ratio: must be >= 0")
        require(self.saturation_N > 0, "saturation_N: must be positive")

    def law(self, leg: Leg) -> LegLaw:
        return _Loop(self, leg)


@dataclass
class _Loop(LegLaw):
    physics: BoucWen
    leg: Leg
    yielded: float = 0.0  # e of the state that was reached
    slipping: float = 0.0  # force of the slipping part, (1 - a) k_j z (N)

    def start(self, conditions: LegConditions) -> None:
        self.yielded = self.slipping = 0.0

    def elongation(self, force: float, conditions: LegConditions) -> float:
        if self.physics.ratio == 0:
            return 0.0
        stuck = _STUCK * self.leg.stiffness / self.physics.ratio
        low, high = (force - self.physics.saturation_N) / stuck, (force + self.physics.saturation_N) / stuck
        for _ in range(80):  # the force grows with the elongation
            middle = (low + high) / 2
            low, high = (middle, high) if stuck * middle + self._slipped(middle) < force else (low, middle)
        return (low + high) / 2

    def accept(self, force: float, conditions: LegConditions) -> None:
        reached = self.elongation(force, conditions)
        if self.physics.ratio:
            self.yielded, self.slipping = reached, self._slipped(reached)

    def _slipped(self, yielded: float) -> float:
        """Force of the slipping part after a monotonic way to an elongation."""
        most, step = self.physics.saturation_N, yielded - self.yielded
        push, held = (1 - _STUCK) * self.leg.stiffness / self.physics.ratio * step, self.slipping
        if held * push < 0:  # back to zero in proportion
            if abs(push) <= abs(held):
                return held + push
            push, held = push + held, 0.0
        return most * tanh(atanh(min(max(held / most, -_CLOSE), _CLOSE)) + push / most)


@dataclass(frozen=True)
class HoldingDroop(LegPhysics):
    """The drive lowers its holding current some time after a move, and its position stiffness with it.

    Stepper drives reduce the current at standstill after a set delay; servo drives do by their I2t limit. Elongation
    N/k ratio / (1 + exp(-(t - after_s)/width_s)), t the time since the series' start. Accepted: the leg. `creep` is no
    wrong name: deflection grows with time under load.
    """

    identifier: ClassVar[str] = "holding_droop"
    also: ClassVar[tuple[str, ...]] = ("creep",)
    ratio: float
    after_s: float
    width_s: float

    def law(self, leg: Leg) -> LegLaw:
        return _Droop(self, leg)


@dataclass
class _Droop(LegLaw):
    physics: HoldingDroop
    leg: Leg
    begun: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("holding_droop: the rows need the column time_s")
        self.begun = conditions.time

    def elongation(self, force: float, conditions: LegConditions) -> float:
        late = (conditions.time - self.begun - self.physics.after_s) / self.physics.width_s
        return force / self.leg.stiffness * self.physics.ratio * (1 + tanh(late / 2)) / 2


@dataclass(frozen=True)
class PlaceBacklash(LegPhysics):
    """A screw or rack that is worn in the middle has play there and none at its ends.

    Rebuilt machine tools show it as lost motion that varies along the axis (ISO 230-2 reports reversal per position).
    Gap gap_m exp(-((q - worn_m)/width_m)^2 / 2), taken up over a force of `seat_N`. Accepted: the leg. `leg_backlash`
    is no wrong name.
    """

    identifier: ClassVar[str] = "place_backlash"
    also: ClassVar[tuple[str, ...]] = ("leg_backlash",)
    gap_m: float
    worn_m: float
    width_m: float
    seat_N: float = 1.0

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        gap = self.gap_m * exp(-(((conditions.length - self.worn_m) / self.width_m) ** 2) / 2)
        return gap / 2 * tanh(force / self.seat_N)


@dataclass(frozen=True)
class PlaceFriction(LegPhysics):
    """A guide that is tight at one end: the breakaway force changes along the travel.

    Misaligned or bent screws bind where the offset is largest; makers state drag torque as a band along the travel (ISO
    3408-3). A rigid Coulomb slider of breakaway_N exp(-(q - tight_m)^2 / (2 width_m^2)) parallel to the spring.
    Accepted: the leg. `friction_hysteresis` is no wrong name.
    """

    identifier: ClassVar[str] = "place_friction"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    breakaway_N: float
    tight_m: float
    width_m: float

    def law(self, leg: Leg) -> LegLaw:
        return _Slider(self, leg)


@dataclass
class _Slider(LegLaw):
    physics: PlaceFriction
    leg: Leg
    slider: Sliders | None = None

    def start(self, conditions: LegConditions) -> None:
        physics = self.physics
        limit = physics.breakaway_N * exp(-(((conditions.length - physics.tight_m) / physics.width_m) ** 2) / 2)
        self.slider = Sliders(self.leg.stiffness, np.inf, [limit])
        self.slider.start(conditions)

    def elongation(self, force: float, conditions: LegConditions) -> float:
        assert self.slider is not None
        return self.slider.elongation(force, conditions)

    def accept(self, force: float, conditions: LegConditions) -> None:
        assert self.slider is not None
        self.slider.accept(force, conditions)


@dataclass(frozen=True)
class Seating(LegPhysics):
    """Seats and threads that were set anew settle under the largest load so far and keep the set.

    Embedding of bolted and threaded contacts (VDI 2230) flattens asperities up to the load reached and does not come
    back; each new command starts on fresh flanks. Elongation set_ratio times the extreme tension and compression of the
    series, over k. Accepted: the leg. `friction_hysteresis` (loading and unloading differ) is no wrong name.
    """

    identifier: ClassVar[str] = "seating"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    set_ratio: float

    def law(self, leg: Leg) -> LegLaw:
        return _Set(self, leg)


@dataclass
class _Set(LegLaw):
    physics: Seating
    leg: Leg
    low: float = 0.0
    high: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        self.low = self.high = 0.0

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self.physics.set_ratio * (min(self.low, force) + max(self.high, force)) / self.leg.stiffness

    def accept(self, force: float, conditions: LegConditions) -> None:
        self.low, self.high = min(self.low, force), max(self.high, force)


@dataclass(frozen=True)
class SharedSupply(Unlisted):
    """All drives hang on one supply (hydraulic pressure, DC link) which sags with what all of them carry.

    The stiffness of each leg falls with the sum of all forces: elongation N/k sag (sum |N|)/typical_N. Accepted:
    `all legs`. `leg_nonlinear_stiffness` and `leg_coupling` are no wrong names.
    """

    identifier: ClassVar[str] = "shared_supply"
    accepted: ClassVar[tuple[str, ...]] = ("all legs",)
    also: ClassVar[tuple[str, ...]] = ("leg_nonlinear_stiffness", "leg_coupling")
    sag: float
    typical_N: float

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        carried = np.zeros(len(legs))
        return {leg.index: _Fed(self, leg, carried) for leg in legs}


@dataclass
class _Fed(LegLaw):
    physics: SharedSupply
    leg: Leg
    carried: Vector  # what every leg carried in the pass before; one array for all

    def elongation(self, force: float, conditions: LegConditions) -> float:
        self.carried[self.leg.index] = abs(force)
        total = float(self.carried.sum()) / self.physics.typical_N
        return force / self.leg.stiffness * self.physics.sag * total


@dataclass(frozen=True)
class BaseGradient(Unlisted):
    """The sunny side of the base grows more than the other: base joints move along one direction over the day.

    Homogeneous strain with a gradient: joint i moves by strain_per_K (T - T0) times its coordinate along `direction`,
    along `direction`; T0 is that of the series' start. Its part along the leg shortens the leg (a leg that is held
    farther away). ISO 230-3 tests machines for such distortions. Accepted: base, environment, geometry.
    `thermal_drift` is no wrong name.
    """

    identifier: ClassVar[str] = "base_gradient"
    accepted: ClassVar[tuple[str, ...]] = ("base", "environment", "geometry")
    also: ClassVar[tuple[str, ...]] = ("thermal_drift",)
    strain_per_K: float
    direction: Sequence[float]
    base_m: Sequence[Sequence[float]]

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        along = np.asarray(self.base_m, dtype=float) @ np.asarray(self.direction, dtype=float)
        return {leg.index: _Grown(self, float(along[leg.index])) for leg in legs}


@dataclass
class _Grown(LegLaw):
    physics: BaseGradient
    place: float
    origin: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.temperature):
            raise LaboratoryError("base_gradient: the rows need temperature_degC")
        self.origin = conditions.temperature

    def elongation(self, force: float, conditions: LegConditions) -> float:
        moved = self.physics.strain_per_K * (conditions.temperature - self.origin) * self.place
        return moved * float(conditions.direction @ np.asarray(self.physics.direction, dtype=float))
