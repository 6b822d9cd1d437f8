"""Legs that yield by another law of place, temperature or direction, without memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import acos, atan2, cos, exp, isnan, pi, sin
from typing import ClassVar

import numpy as np

from ...errors import LaboratoryError
from ...legs import Leg, LegConditions
from ..element import require
from .law import LegPhysics


@dataclass(frozen=True)
class ScrewLength(LegPhysics):
    """The free screw between bearing and nut is longer in an extended leg, so the leg is softer there.

    A screw fixed at one end is a rod whose compliance l/(E A) grows with its free length l (Slocum, Precision Machine
    Design, 1992, ch. 10; catalogues of ball screws state it as the axial rigidity of the shaft). Elongation
    N/k slope_per_m (q - middle_m). Accepted: the leg.
    """

    identifier: ClassVar[str] = "screw_length"
    abscissa: ClassVar[str] = "length"
    slope_per_m: float
    middle_m: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return force / leg.stiffness * self.slope_per_m * (conditions.length - self.middle_m)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.slope_per_m * (at - self.middle_m)) / leg.stiffness


@dataclass(frozen=True)
class ScrewWear(LegPhysics):
    """The thread has lost its preload over the stretch on which the machine works most, and is softer there.

    Wear of ball screws follows the sliding distance (Archard), so it is local; what is lost first is preload and with
    it contact stiffness. Elongation N/k softening exp(-((q - centre)/width)^2 / 2). Accepted: the leg.
    """

    identifier: ClassVar[str] = "screw_wear"
    abscissa: ClassVar[str] = "length"
    softening: float
    centre_m: float
    width_m: float

    def __post_init__(self) -> None:
        require(self.width_m > 0, "width_m: must be positive")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return force * (self.curve(conditions.length, leg) - 1.0 / leg.stiffness)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.softening * exp(-(((at - self.centre_m) / self.width_m) ** 2) / 2)) / leg.stiffness


@dataclass(frozen=True)
class WarmLeg(LegPhysics):
    """The compliance of a leg with a polymer member (coupling, damped strut) changes with temperature.

    Near their glass transition polymers lose several per cent of modulus per kelvin (Ferry, Viscoelastic Properties of
    Polymers, 1980). Elongation N/k slope_per_K (T - reference_degC). Accepted: the leg.
    """

    identifier: ClassVar[str] = "warm_leg"
    abscissa: ClassVar[str] = "temperature"
    slope_per_K: float
    reference_degC: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        if isnan(conditions.temperature):
            raise LaboratoryError("warm_leg: the rows need temperature_degC or leg1_degC ...")
        return force / leg.stiffness * self.slope_per_K * (conditions.temperature - self.reference_degC)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.slope_per_K * (at - self.reference_degC)) / leg.stiffness


@dataclass(frozen=True)
class SaggingLeg(LegPhysics):
    """A leg that is not upright sags under its own weight, and a bowed strut is axially softer than a straight one.

    Bow and with it the loss of axial stiffness grow with the square of the weight across the leg (Ernst's modulus of
    inclined members, Der Bauingenieur 40 (1965) 52). Elongation N/k ratio (1 - (u . vertical)^2). Accepted: the leg.
    """

    identifier: ClassVar[str] = "sagging_leg"
    ratio: float
    vertical: Sequence[float] = (0.0, 0.0, 1.0)

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        upright = float(conditions.direction @ np.asarray(self.vertical, dtype=float))
        return force / leg.stiffness * self.ratio * (1.0 - upright**2)


@dataclass(frozen=True)
class NeedleBearing(LegPhysics):
    """The fork of a universal joint runs on few needles, and is softer when the load falls between two of them.

    Variable compliance of rolling bearings (Sunnersjo, J. Sound Vib. 58 (1978) 363). Elongation
    N/k ratio (1 + cos(2 pi swivel/pitch_rad + phase_rad))/2, the swivel being the leg's angle from its home direction
    about the fork's axis, which lies at `fork_rad` about the leg. Accepted: the leg (a passive joint is its leg's).
    """

    identifier: ClassVar[str] = "needle_bearing"
    abscissa: ClassVar[str] = "swivel"
    ratio: float
    pitch_rad: float
    phase_rad: float = 0.0
    fork_rad: float = 0.0

    def __post_init__(self) -> None:
        require(self.pitch_rad > 0, "pitch_rad: must be positive")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        home = conditions.home_direction
        across = np.cross(home, [0.0, 0.0, 1.0])
        across = across / np.linalg.norm(across)
        side = cos(self.fork_rad) * across + sin(self.fork_rad) * np.cross(home, across)
        swivel = atan2(float(conditions.direction @ side), float(conditions.direction @ home))
        return force * (self.curve(swivel, leg) - 1.0 / leg.stiffness)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.ratio * (1 + cos(2 * pi * at / self.pitch_rad + self.phase_rad)) / 2) / leg.stiffness


@dataclass(frozen=True)
class WornSocket(LegPhysics):
    """A worn ball joint carries on a full seat near home and on the socket's rim at large swivel angles.

    Contact compliance grows as the conformal seat is lost (Johnson, Contact Mechanics, 1985, sec. 5.3). Elongation
    N/k ratio max(swivel - seat_rad, 0)/span_rad, with the angle from the home direction. Accepted: the leg.
    """

    identifier: ClassVar[str] = "worn_socket"
    abscissa: ClassVar[str] = "swivel"
    ratio: float
    seat_rad: float
    span_rad: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        swivel = acos(min(max(float(conditions.direction @ conditions.home_direction), -1.0), 1.0))
        return force * (self.curve(swivel, leg) - 1.0 / leg.stiffness)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.ratio * max(at - self.seat_rad, 0.0) / self.span_rad) / leg.stiffness


@dataclass(frozen=True)
class LoadFeedForward(LegPhysics):
    """The controller corrects for load by a gain that it takes from a wrong map of the workspace.

    Gain-scheduled feed-forward with an error that is linear in the platform's place. Elongation
    -N/k gain_per_m (travel . direction). Accepted: the leg, or for all legs `all legs` and `geometry`, since it is a
    property of the pose there.
    """

    identifier: ClassVar[str] = "load_feed_forward"
    gain_per_m: float
    direction: Sequence[float]

    @property
    def parts(self) -> tuple[str, ...]:
        return ("all legs", "geometry") if self.component == "all legs" else (self.component,)

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        away = float(conditions.travel @ np.asarray(self.direction, dtype=float))
        return -force / leg.stiffness * self.gain_per_m * away


@dataclass(frozen=True)
class LengthScale(LegPhysics):
    """A leg moves farther than commanded: the controller holds another lead or gear ratio than is built in.

    A screw of 5 mm lead entered as one of 4 mm moves a quarter too far; small lead errors are stated per travel (ISO
    3408-3: v300). The true pose is another one, and with it the directions of all legs. Longer by scale (q - zero_m),
    loaded or not. Accepted: the leg, `geometry`. `joint_position_error` is no wrong name, as the true pose is not the
    commanded one.
    """

    identifier: ClassVar[str] = "length_scale"
    also: ClassVar[tuple[str, ...]] = ("joint_position_error",)
    scale: float
    zero_m: float

    @property
    def parts(self) -> tuple[str, ...]:
        return (self.component, "geometry")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return self.scale * (conditions.length - self.zero_m)


@dataclass(frozen=True)
class EncoderDefect(LegPhysics):
    """A scratch or dirt on the scale: near one length the leg is not as long as its encoder says.

    Scales with local contamination show errors over a few signal periods to millimetres (makers state contamination
    tests). As with periodic errors, the reference of a series stands for the state that the command calls for:
    all rows of a series are offset by height_m exp(-((q - place_m)/width_m)^2 / 2). Accepted: the leg.
    """

    identifier: ClassVar[str] = "encoder_defect"
    height_m: float
    place_m: float
    width_m: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        if conditions.reference:
            return 0.0
        return self.height_m * exp(-(((conditions.length - self.place_m) / self.width_m) ** 2) / 2)
