"""Legs that do more than stretch in proportion to their force."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import copysign, exp, inf, isnan, nan, pi, sin, sqrt
from typing import ClassVar

from ..errors import LaboratoryError
from ..legs import Leg, LegConditions, LegLaw
from .element import Element, OfLegs, legs_of, require

LAWS = ("hertz", "cubic", "bilinear")


@dataclass(frozen=True)
class LegNonlinearStiffness(Element):
    """A leg's force is not proportional to its elongation, by one of three laws.

    `hertz`: a pair of ball contacts in series with the spring, preloaded against each other by `preload_N`. A
    contact squeezed by s carries (s/C)^(3/2), C = `contact_m_per_N23` (K. L. Johnson, Contact Mechanics,
    1985, eq. 4.23), so N = ((s0 + e)/C)^(3/2) - ((s0 - e)/C)^(3/2), the second while s0 > e. Without preload
    e = C |N|^(2/3) sign(N).
    `cubic`: N = k d (1 + `cubic_per_m2` d^2), d the leg's whole elongation: hardening > 0, softening < 0.
    `bilinear`: stiffness k (1 + `relative_change`) in compression, k in tension.
    """

    identifier: ClassVar[str] = "leg_nonlinear_stiffness"
    component: str
    law: str = "cubic"
    contact_m_per_N23: float = 0.0
    preload_N: float = 0.0
    cubic_per_m2: float = 0.0
    relative_change: float = 0.0

    def __post_init__(self) -> None:
        require(self.law in LAWS, f"law: must be one of {', '.join(LAWS)}, not {self.law!r}")
        require(
            self.contact_m_per_N23 >= 0 and self.preload_N >= 0,
            "contact_m_per_N23 and preload_N: must be >= 0",
        )
        require(self.relative_change > -1, "relative_change: must be above -1")

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        return {index: self._law(legs[index]) for index in legs_of(self.component, len(legs))}

    def _law(self, leg: Leg) -> LegLaw:
        if self.law == "hertz":
            return _Hertz(self.contact_m_per_N23, self.preload_N)
        if self.law == "cubic":
            return _Cubic(leg, self.cubic_per_m2)
        return _Bilinear(leg, self.relative_change)


@dataclass
class _Hertz(LegLaw):
    contact: float
    preload: float

    def elongation(self, force: float, conditions: LegConditions) -> float:
        if force == 0 or self.contact == 0:
            return 0.0
        squeezed = self.contact * self.preload ** (2 / 3)

        def excess(elongation: float) -> float:
            pressed = ((squeezed + elongation) / self.contact) ** 1.5
            released = max(squeezed - elongation, 0.0) / self.contact
            return float(pressed - released**1.5 - abs(force))

        unloaded = self.contact * abs(force) ** (2 / 3)  # without preload, the most that it yields
        low, high = 0.0, unloaded
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if excess(middle) < 0 else (low, middle)
        return copysign((low + high) / 2, force)


@dataclass
class _Cubic(LegLaw):
    leg: Leg
    coefficient: float

    def elongation(self, force: float, conditions: LegConditions) -> float:
        k, b = self.leg.stiffness, self.coefficient
        linear = force / k
        if b < 0 and abs(linear) >= 2 / 3 * sqrt(-1 / (3 * b)):
            raise LaboratoryError(
                f"leg {self.leg.index + 1}: {force:.4g} N is beyond the peak of its softening law (cubic_per_m2)"
            )
        whole = linear
        for _ in range(60):
            change = (whole * (1 + b * whole**2) - linear) / (1 + 3 * b * whole**2)
            whole -= change
            if abs(change) < 1e-17:
                break
        return whole - linear


@dataclass
class _Bilinear(LegLaw):
    leg: Leg
    change: float

    def elongation(self, force: float, conditions: LegConditions) -> float:
        if force >= 0:
            return 0.0
        return force / self.leg.stiffness * (1 / (1 + self.change) - 1)


_REST = {"middle": 0.0, "short": -0.5, "long": 0.5}


@dataclass(frozen=True)
class LegBacklash(OfLegs):
    """A leg has play: between pulling and pushing it is free over `gap_m` (m).

    In tension the leg is longer by gap/2 than its nominal length, in compression shorter by gap/2. A leg that
    carries less than `seat_N` rests in the `middle` of its gap or at one end of it, `short` or `long`.
    """

    identifier: ClassVar[str] = "leg_backlash"
    gap_m: float
    rest: str = "middle"
    seat_N: float = 1e-3

    def __post_init__(self) -> None:
        require(self.gap_m >= 0, "gap_m: must be >= 0")
        require(self.rest in _REST, f"rest: must be one of {', '.join(_REST)}, not {self.rest!r}")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        if abs(force) < self.seat_N:
            return _REST[self.rest] * self.gap_m
        return copysign(self.gap_m / 2, force)


@dataclass(frozen=True)
class FrictionHysteresis(OfLegs):
    """Coulomb sliders parallel to the leg's spring (Jenkins elements; several of them: an Iwan model).

    W. D. Iwan, J. Appl. Mech. 33 (1966) 893: N = k d + sum_j clip(k_j (d - s_j), -F_j, F_j), where a slider
    that reaches its force F_j follows. `friction_N` is the sum of F_j (N); `sliders` of them share it as 1 :
    3 : 5 ... and the stiffness `contact_N_per_m` (N/m) equally; one slider with infinite stiffness is the
    rigid Coulomb element. Every series starts relaxed, all sliders at their middle.
    """

    identifier: ClassVar[str] = "friction_hysteresis"
    friction_N: float
    contact_N_per_m: float = inf
    sliders: int = 1

    def __post_init__(self) -> None:
        require(self.friction_N >= 0, "friction_N: must be >= 0")
        require(self.contact_N_per_m > 0, "contact_N_per_m: must be positive")
        require(
            self.sliders == 1 or self.contact_N_per_m < inf,
            "sliders: several of them need a finite contact_N_per_m",
        )

    def law(self, leg: Leg) -> LegLaw:
        weights = [2 * j + 1 for j in range(self.sliders)]
        limits = [self.friction_N * weight / sum(weights) for weight in weights]
        return Sliders(leg.stiffness, self.contact_N_per_m / self.sliders, limits)


@dataclass
class Sliders(LegLaw):
    """Sliders that share a force, and where they stand."""

    spring: float
    contact: float
    limits: list[float]
    middles: list[float] = field(default_factory=list)

    def start(self, conditions: LegConditions) -> None:
        self.middles = [0.0] * len(self.limits)

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self._whole(force) - force / self.spring

    def accept(self, force: float, conditions: LegConditions) -> None:
        whole = self._whole(force)
        for j, limit in enumerate(self.limits):
            reach = limit / self.contact  # 0 for a rigid slider
            self.middles[j] = min(max(self.middles[j], whole - reach), whole + reach)

    def _whole(self, force: float) -> float:
        """Elongation d at which spring and sliders together carry the force; their sum grows with d."""
        if self.contact == inf:
            stuck, limit = self.middles[0], self.limits[0]
            carried = force - self.spring * stuck
            excess = max(abs(carried) - limit, 0.0)
            return stuck + (excess if carried > 0 else -excess) / self.spring
        # Piecewise linear and monotone: walk along its corners to the piece that holds the force.
        corners = sorted(
            middle + side * limit / self.contact
            for middle, limit in zip(self.middles, self.limits, strict=True)
            for side in (-1, 1)
        )
        below = [corner for corner in corners if self._force(corner) <= force]
        above = [corner for corner in corners if self._force(corner) > force]
        start = below[-1] if below else above[0] - 1.0
        end = above[0] if above else start + 1.0
        at_start, at_end = self._force(start), self._force(end)
        return start + (force - at_start) * (end - start) / (at_end - at_start)

    def _force(self, whole: float) -> float:
        sliders = zip(self.middles, self.limits, strict=True)
        return self.spring * whole + sum(min(max(self.contact * (whole - s), -f), f) for s, f in sliders)


@dataclass(frozen=True)
class Creep(OfLegs):
    """A leg creeps like a standard linear solid: its spring k in series with a Kelvin-Voigt element.

    Elongation N/k + z with tau dz/dt + z = creep_ratio N/k: under constant load the deflection grows from N/k
    towards (1 + creep_ratio) N/k with the time constant `tau_s`. A row's load is taken to be applied at the
    fraction `applied` of the time between the row before and itself: 0 (default) right after the row before,
    1 with no time to creep.
    """

    identifier: ClassVar[str] = "creep"
    creep_ratio: float
    tau_s: float
    applied: float = 0.0

    def __post_init__(self) -> None:
        require(self.tau_s > 0, "tau_s: must be positive")
        require(self.creep_ratio > -1, "creep_ratio: must be above -1")
        require(0 <= self.applied <= 1, "applied: must be between 0 and 1")

    def law(self, leg: Leg) -> LegLaw:
        return _KelvinVoigt(self, leg)


@dataclass
class _KelvinVoigt(LegLaw):
    creep: Creep
    leg: Leg
    time: float = nan
    force: float = 0.0
    crept: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("creep: the rows need the column time_s")
        self.time, self.force, self.crept = conditions.time, 0.0, 0.0

    def elongation(self, force: float, conditions: LegConditions) -> float:
        passed = conditions.time - self.time
        if passed < 0:
            raise LaboratoryError("creep: time_s goes back within a series")
        before = self._relaxed(self.crept, self.force, self.creep.applied * passed)
        return self._relaxed(before, force, (1 - self.creep.applied) * passed)

    def accept(self, force: float, conditions: LegConditions) -> None:
        self.crept = self.elongation(force, conditions)
        self.time, self.force = conditions.time, force

    def _relaxed(self, crept: float, force: float, duration: float) -> float:
        """Exact solution of the Kelvin-Voigt element under a constant force."""
        end = self.creep.creep_ratio * force / self.leg.stiffness
        return end + (crept - end) * exp(-duration / self.creep.tau_s)


@dataclass(frozen=True)
class ThermalDrift(OfLegs):
    """A leg grows by its strain: alpha_per_K (T - T0) + rate_per_s (t - t0), times its commanded length.

    T0, t0 are those of the first row of the series. T is the leg's own temperature (`leg1_degC` ...) or else
    `temperature_degC`; with `rate_per_s` alone it is a drift with time.
    """

    identifier: ClassVar[str] = "thermal_drift"
    component: str = "all legs"
    alpha_per_K: float = 0.0
    rate_per_s: float = 0.0

    def law(self, leg: Leg) -> LegLaw:
        return _Strain(self)


@dataclass
class _Strain(LegLaw):
    drift: ThermalDrift
    origin: LegConditions | None = None

    def start(self, conditions: LegConditions) -> None:
        if self.drift.alpha_per_K and isnan(conditions.temperature):
            raise LaboratoryError("thermal_drift: the rows need temperature_degC or leg1_degC ...")
        if self.drift.rate_per_s and isnan(conditions.time):
            raise LaboratoryError("thermal_drift: the rows need time_s")
        self.origin = conditions

    def elongation(self, force: float, conditions: LegConditions) -> float:
        assert self.origin is not None
        strain = 0.0
        if self.drift.alpha_per_K:
            strain += self.drift.alpha_per_K * (conditions.temperature - self.origin.temperature)
        if self.drift.rate_per_s:
            strain += self.drift.rate_per_s * (conditions.time - self.origin.time)
        return strain * conditions.length


@dataclass(frozen=True)
class EncoderPeriodicError(OfLegs):
    """A leg is longer than commanded by amplitude_m sin(2 pi q / pitch_m + phase_rad).

    q is the commanded length (m).

    The error repeats with the screw's pitch. The reference of a series is free of it (it stands for the state
    that the command calls for), so all rows of a series, unloaded ones too, are offset by the same error. In
    the closed loop (`Laboratory.attained`) it moves the platform.
    """

    identifier: ClassVar[str] = "encoder_periodic_error"
    amplitude_m: float
    pitch_m: float
    phase_rad: float = 0.0

    def __post_init__(self) -> None:
        require(self.pitch_m > 0, "pitch_m: must be positive")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        if conditions.reference:
            return 0.0
        return self.amplitude_m * sin(2 * pi * conditions.length / self.pitch_m + self.phase_rad)
