"""Known physics by other laws than those that were written down."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import copysign, exp, isnan, log, log1p, pi, sin, sqrt, tanh
from typing import ClassVar

from ..errors import LaboratoryError
from ..legs import Leg, LegConditions, LegLaw
from .element import require
from .unlisted.law import LegPhysics, Unlisted


@dataclass(frozen=True)
class DahlFriction(LegPhysics):
    """Friction parallel to the spring that builds up over a distance, as Dahl's solid friction and LuGre at rest do.

    dF/dd = sigma (1 - F/F_c sign(dd)) (Dahl, AIAA J. 14 (1976) 1675; LuGre without velocity: Canudas de Wit et al.,
    IEEE Trans. Autom. Control 40 (1995) 419). Every series starts relaxed. Accepted: the leg; its name is
    `friction_hysteresis`.
    """

    identifier: ClassVar[str] = "dahl_friction"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    friction_N: float
    bristle_N_per_m: float

    def law(self, leg: Leg) -> LegLaw:
        return _Bristles(self, leg)


@dataclass
class _Bristles(LegLaw):
    physics: DahlFriction
    leg: Leg
    whole: float = 0.0
    friction: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        self.whole = self.friction = 0.0

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self._found(force) - force / self.leg.stiffness

    def accept(self, force: float, conditions: LegConditions) -> None:
        whole = self._found(force)
        self.whole, self.friction = whole, self._built(whole)

    def _built(self, whole: float) -> float:
        if self.physics.friction_N == 0:
            return 0.0
        step = whole - self.whole
        towards = copysign(self.physics.friction_N, step)
        fade = exp(-self.physics.bristle_N_per_m * abs(step) / self.physics.friction_N)
        return towards + (self.friction - towards) * fade

    def _found(self, force: float) -> float:
        """Whole elongation d with k d + F(d) = force; the sum grows with d, so halving intervals finds it."""
        k, most = self.leg.stiffness, self.physics.friction_N
        low, high = (force - most) / k, (force + most) / k
        for _ in range(80):
            middle = (low + high) / 2
            low, high = (middle, high) if k * middle + self._built(middle) < force else (low, middle)
        return (low + high) / 2


CREEPS = ("stretched", "logarithmic", "power", "two_maxwell")


@dataclass(frozen=True)
class OtherCreep(LegPhysics):
    """A leg creeps by a law that a single relaxation time does not follow.

    Creep compliance ratio/k g(t/tau_s): `stretched` 1 - exp(-x^shape) (Kohlrausch, Ann. Phys. 91 (1854) 179),
    `logarithmic` log(1 + x), `power` x^shape (Andrade, shape 1/3), `two_maxwell` two elements tau and 8 tau in equal
    shares. Boltzmann's superposition over the load steps; a load comes on at the row before. Accepted: the leg; its
    name is `creep`.
    """

    identifier: ClassVar[str] = "other_creep"
    also: ClassVar[tuple[str, ...]] = ("creep",)
    kind: str
    ratio: float
    tau_s: float
    shape: float = 0.5

    def __post_init__(self) -> None:
        require(self.kind in CREEPS, f"kind: must be one of {', '.join(CREEPS)}, not {self.kind!r}")
        require(self.tau_s > 0, "tau_s: must be positive")

    def law(self, leg: Leg) -> LegLaw:
        return _Steps(self, leg)

    def grown(self, time: float) -> float:
        """g(t/tau), 0 at the load's beginning."""
        x = max(time, 0.0) / self.tau_s
        if self.kind == "stretched":
            return 1.0 - exp(-(x**self.shape))
        if self.kind == "logarithmic":
            return log1p(x)
        if self.kind == "power":
            return float(x**self.shape)
        return 1.0 - (exp(-x) + exp(-x / 8.0)) / 2.0


@dataclass
class _Steps(LegLaw):
    physics: OtherCreep
    leg: Leg
    time: float = 0.0
    force: float = 0.0
    steps: list[tuple[float, float]] = field(default_factory=list)

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("other_creep: the rows need the column time_s")
        self.time, self.force, self.steps = conditions.time, 0.0, []

    def elongation(self, force: float, conditions: LegConditions) -> float:
        steps = [*self.steps, (self.time, force - self.force)]
        crept = sum(step * self.physics.grown(conditions.time - begun) for begun, step in steps)
        return self.physics.ratio / self.leg.stiffness * crept

    def accept(self, force: float, conditions: LegConditions) -> None:
        self.steps.append((self.time, force - self.force))
        self.time, self.force = conditions.time, force


DRIFTS = ("saturating", "quadratic", "oscillating")


@dataclass(frozen=True)
class OtherDrift(LegPhysics):
    """A leg grows with time or temperature, but not in proportion.

    `saturating`: growth_m (1 - exp(-t/scale)) with t (s) since the start of the recordings (a drive that warms up; ISO
    230-3), `oscillating`: growth_m sin(2 pi t/scale) (an air conditioner), `quadratic`: growth_m ((T - T0)/scale)^2
    with T in degC (a compensated material, Invar). What shows is the change since the series' start. Accepted: the leg,
    environment; its name is `thermal_drift`.
    """

    identifier: ClassVar[str] = "other_drift"
    also: ClassVar[tuple[str, ...]] = ("thermal_drift",)
    kind: str
    growth_m: float
    scale: float
    origin: float = 0.0

    def __post_init__(self) -> None:
        require(self.kind in DRIFTS, f"kind: must be one of {', '.join(DRIFTS)}, not {self.kind!r}")
        require(self.scale > 0, "scale: must be positive")

    @property
    def parts(self) -> tuple[str, ...]:
        return (self.component, "environment")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        at = conditions.temperature if self.kind == "quadratic" else conditions.time
        if isnan(at):
            raise LaboratoryError("other_drift: the rows need time_s or temperature_degC")
        x = (at - self.origin) / self.scale
        if self.kind == "saturating":
            return self.growth_m * (1.0 - exp(-x))
        return self.growth_m * (x**2 if self.kind == "quadratic" else sin(2 * pi * x))


SHAPES = ("preload_loss", "smeared_bilinear", "exponential", "root")


@dataclass(frozen=True)
class OtherSpring(LegPhysics):
    """A leg's stiffness changes with its force by a shape that is neither cubic nor Hertz nor two straight lines.

    Elongations beyond N/k, each times size/k and with F = scale_N: `preload_loss` sign(N) max(|N| - F, 0) (a preloaded
    nut that separates; ISO 3408-4), `smeared_bilinear` the softer side of tension and compression with a rounded
    transition F log(1 + exp(N/F)) - F log 2, `exponential` F (1 - exp(-|N|/F)) sign(N) (a foam or gasket that
    hardens), `root` F sign(N) (sqrt(1 + |N|/F) - 1) (rough surfaces pressed together). Accepted: the leg; its name is
    `leg_nonlinear_stiffness`.
    """

    identifier: ClassVar[str] = "other_spring"
    also: ClassVar[tuple[str, ...]] = ("leg_nonlinear_stiffness",)
    abscissa: ClassVar[str] = "force"
    shape: str
    size: float
    scale_N: float

    def __post_init__(self) -> None:
        require(self.shape in SHAPES, f"shape: must be one of {', '.join(SHAPES)}, not {self.shape!r}")
        require(self.scale_N > 0, "scale_N: must be positive")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return self.curve(force, leg)

    def curve(self, at: float, leg: Leg) -> float:
        x = abs(at) / self.scale_N
        if self.shape == "preload_loss":
            form = copysign(max(x - 1.0, 0.0), at)
        elif self.shape == "smeared_bilinear":
            form = log1p(exp(-x)) + (x if at > 0 else 0.0) - log(2.0)
        elif self.shape == "exponential":
            form = copysign(1.0 - exp(-x), at)
        else:
            form = copysign(sqrt(1.0 + x) - 1.0, at)
        return self.size * self.scale_N / leg.stiffness * form


@dataclass(frozen=True)
class SmearedBacklash(LegPhysics):
    """Play whose flanks meet one after another: gap_m/2 tanh(N/seat_N) in place of a jump.

    Many teeth, balls or threads with unequal gaps add up to a rounded transition. Accepted: the leg; its name is
    `leg_backlash`, and `leg_nonlinear_stiffness` where it is taken up over much of the load.
    """

    identifier: ClassVar[str] = "smeared_backlash"
    also: ClassVar[tuple[str, ...]] = ("leg_backlash", "leg_nonlinear_stiffness")
    abscissa: ClassVar[str] = "force"
    gap_m: float
    seat_N: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return self.curve(force, leg)

    def curve(self, at: float, leg: Leg) -> float:
        return self.gap_m / 2 * tanh(at / self.seat_N)


FORMS: dict[str, type[Unlisted]] = {
    element.identifier: element for element in (DahlFriction, OtherCreep, OtherDrift, OtherSpring, SmearedBacklash)
}
"""By identifier."""
