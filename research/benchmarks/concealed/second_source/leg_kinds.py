"""What single legs conceal: play, contacts, yielding steel, slip, creep, crookedness, clamped ends, warmth."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pandas as pd

from ..campaigns import Campaign, Wishes, base_matrices, leg_forces
from ..concealment import Concealed, Kind, chosen_leg
from ..hexapods import Array, Hexapod
from .frames import MICRO, RIGID_SPRING, SLACK, Model, Structure

LARGE = 1e12  # N, a strength that is never reached
Law = Callable[[Model, float, float], int]
"""Material of a leg (N over strain) from the model, its stiffness k L (N) and its length (m)."""


class LegsOf(Structure):
    """Some legs follow another law."""

    def __init__(self, hexapod: Hexapod, legs: tuple[int, ...], law: Law, steps: int, bar: str = "corotTruss") -> None:
        super().__init__(hexapod)
        self.legs, self.law, self.steps, self.bar = legs, law, steps, bar

    def leg(self, model: Model, leg: int) -> None:
        if leg in self.legs:
            model.truss(leg, self.law(model, model.scaled(leg), float(model.place.lengths[leg])), self.bar)
        else:
            super().leg(model, leg)


def _one(
    names: tuple[str, ...], low: float, high: float, law: Callable[..., Law], steps: int, reversing: bool = False
) -> Callable[..., Concealed[Structure]]:
    """A law of one leg; `law(size, largest force, rng)` must draw the same whatever the size."""

    def conceal(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
        leg, most = chosen_leg(leg_forces(hexapod, campaign.rows), rng, reversing)
        seed, stretch = int(rng.integers(2**31)), most / float(hexapod.stiffness[leg])

        def of_size(size: float) -> Structure:
            made = law(size, most, stretch, np.random.default_rng(seed))
            return LegsOf(hexapod, (leg,), made, steps, "truss" if law is gap else "corotTruss")

        return Concealed((f"leg {leg + 1}",), names, low, high, of_size)

    return conceal


def gap(size: float, most: float, stretch: float, rng: np.random.Generator) -> Law:
    """Play of `size` times the largest stretch, of which the rest position leaves a share to either side."""
    share = float(rng.choice([0.5, 0.0, 1.0]))

    def law(model: Model, scaled: float, length: float) -> int:
        play = size * stretch / length
        pulled = model.material("ElasticPPGap", scaled, LARGE, share * play + 1e-15)
        pushed = model.material("ElasticPPGap", scaled, -LARGE, -(1 - share) * play - 1e-15)
        return model.material("Parallel", pulled, pushed, model.elastic(SLACK * scaled))

    return law


def _curve(extra: Callable[[Array], Array], most: float) -> Law:
    """An elastic law by its points: elongation F/k + extra(F)."""
    forces = 1.6 * most * np.sign(np.linspace(-1, 1, 81)) * np.linspace(-1, 1, 81) ** 2

    def law(model: Model, scaled: float, length: float) -> int:
        strains = forces / scaled + extra(forces) / length
        tag = model.tag()
        model.opensees.uniaxialMaterial("ElasticMultiLinear", tag, 0.0, "-strain", *strains, "-stress", *forces)
        return tag

    return law


def contact(size: float, most: float, stretch: float, rng: np.random.Generator) -> Law:
    """A contact of curved faces, soft at first (Hertz: 2/3), alike both ways."""
    return _curve(lambda force: size * stretch * np.sign(force) * (np.abs(force) / most) ** (2 / 3), most)


def softening(size: float, most: float, stretch: float, rng: np.random.Generator) -> Law:
    """A member that becomes softer under load."""
    return _curve(lambda force: size * stretch * (force / most) ** 3, most)


def lost_preload(size: float, most: float, stretch: float, rng: np.random.Generator) -> Law:
    """A preloaded joint that opens at a force in one direction, and is softer beyond."""
    knee, sign = float(rng.uniform(0.1, 0.45)), float(rng.choice([-1.0, 1.0]))

    def law(model: Model, scaled: float, length: float) -> int:
        softer, at = scaled / (1.0 + size), knee * stretch / length
        if sign > 0:
            return model.material("ElasticBilin", scaled, softer, at, scaled, scaled, -1e3)
        return model.material("ElasticBilin", scaled, scaled, 1e3, scaled, softer, -at)

    return law


def steel(size: float, most: float, stretch: float, rng: np.random.Generator) -> Law:
    """Steel that yields at (1 − size) of the largest force and hardens (Giuffrè, Menegotto and Pinto)."""
    hardening, sharpness = float(rng.uniform(0.1, 0.4)), float(rng.uniform(6, 20))

    def law(model: Model, scaled: float, length: float) -> int:
        return model.material("Steel02", (1.0 - size) * most, scaled, hardening, sharpness, 0.925, 0.15)

    return law


def bouc_wen(size: float, most: float, stretch: float, rng: np.random.Generator) -> Law:
    """A clamp that slips smoothly at `size` of the largest force, beside the spring (Bouc and Wen)."""
    share, exponent = float(rng.uniform(0.4, 0.8)), float(rng.choice([1.0, 1.5, 2.0]))

    def law(model: Model, scaled: float, length: float) -> int:
        stiff = scaled / share
        slip = size * most / ((1.0 - share) * stiff)
        rate = 0.5 / slip**exponent
        return model.material("BoucWen", share, stiff, exponent, rate, rate, 1.0, 0.0, 0.0, 0.0, 1e-12 * slip)

    return law


def flag(size: float, most: float, stretch: float, rng: np.random.Generator) -> Law:
    """A self-centring joint: it opens at (1 − size) of the largest force, and closes later (flag-shaped loop)."""
    ratio, width = float(rng.uniform(0.25, 0.6)), float(rng.uniform(0.3, 0.9))

    def law(model: Model, scaled: float, length: float) -> int:
        return model.material("SelfCentering", scaled, ratio * scaled, (1.0 - size) * most, width)

    return law


def _creep(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    """A viscous member in one leg or in all: a standard linear solid whose long-term stiffness is the leg's."""
    every = rng.random() < 0.35
    leg, _ = chosen_leg(leg_forces(hexapod, campaign.rows), rng)
    spans = campaign.rows.groupby("series")["time_s"].agg(np.ptp)
    delay = float(spans.median()) / rng.uniform(1.0, 4.0)

    def of_size(size: float) -> Structure:
        def law(model: Model, scaled: float, length: float) -> int:
            quick = size * scaled
            slow = model.material("Maxwell", quick, quick * delay, 1.0, 1.0)
            return model.material("Parallel", model.elastic(scaled), slow)

        return LegsOf(hexapod, tuple(range(6)) if every else (leg,), law, steps=12)

    parts = ("all legs",) if every else (f"leg {leg + 1}",)
    return Concealed(parts, ("creep",), 3e-3, 3.0, of_size, f"time constant {delay:.0f} s")


class CrookedLeg(Structure):
    """One leg is a slender beam with a bow, pinned at both ends: it is softer the more it is pushed."""

    pieces = 6

    def __init__(self, hexapod: Hexapod, leg: int, bow: float, critical: float, sideways: float) -> None:
        super().__init__(hexapod)
        self._leg, self._bow, self._critical, self._sideways = leg, bow, critical, sideways

    def leg(self, model: Model, leg: int) -> None:
        if leg != self._leg:
            super().leg(model, leg)
            return
        start, end = model.hexapod.base[leg], model.place.joints[leg]
        length, along = float(model.place.lengths[leg]), (end - start) / model.place.lengths[leg]
        across = np.cross(along, [1.0, 0, 0])
        across /= np.linalg.norm(across)
        across = np.cos(self._sideways) * across + np.sin(self._sideways) * np.cross(along, across)
        nodes = []
        for share in np.linspace(0, 1, self.pieces + 1):
            bow = self._bow * np.sin(np.pi * share)
            nodes.append(model.node(model.tag(), start + share * length * along + bow * across))
        bending = self._critical * length**2 / np.pi**2  # Euler's load of a pinned column
        section = (model.scaled(leg), bending, bending)
        up = np.cross(along, across)
        for one, other in pairwise(nodes):
            model.beam(one, other, section, up, kind="Corotational")
        rigid, loose = model.elastic(RIGID_SPRING), model.elastic(1e4)  # 0.01 N m/rad
        for joint, node in ((21 + leg, nodes[0]), (11 + leg, nodes[-1])):
            model.opensees.element(
                "zeroLength", model.tag(), joint, node, "-mat", *[rigid] * 3, *[loose] * 3, "-dir", *range(1, 7)
            )


def _crooked(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    leg, most = chosen_leg(leg_forces(hexapod, campaign.rows), rng)
    critical, sideways = most * rng.uniform(2.5, 6.0), float(rng.uniform(0, 2 * np.pi))
    length = float(np.linalg.norm(hexapod.home))

    def of_size(size: float) -> Structure:
        return CrookedLeg(hexapod, leg, size * length, critical, sideways)

    names = ("leg_nonlinear_stiffness",)
    return Concealed((f"leg {leg + 1}",), names, 1e-4, 4e-2, of_size, f"Euler's load {critical:.0f} N")


_ACROSS = np.array([1.0, 0.3, 0.0])
"""Not along any leg."""


class ClampedLegs(Structure):
    """Legs without joints: flexures or seized joints that bend with the platform."""

    def __init__(self, hexapod: Hexapod, legs: tuple[int, ...], ratio: float) -> None:
        super().__init__(hexapod)
        self._legs, self._ratio = legs, ratio

    def leg(self, model: Model, leg: int) -> None:
        if leg not in self._legs:
            super().leg(model, leg)
            return
        self.bent(
            model, leg, self._ratio * float(model.hexapod.stiffness[leg]) * float(model.place.lengths[leg]) ** 3 / 12.0
        )

    def bent(self, model: Model, leg: int, bending: float) -> None:
        """The leg as a beam of a bending stiffness (N m²), clamped at both ends."""
        model.beam(21 + leg, 11 + leg, (model.scaled(leg), bending, bending), _ACROSS)


def _clamped(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    leg, _ = chosen_leg(leg_forces(hexapod, campaign.rows), rng)
    legs = tuple(range(6)) if rng.random() < 0.5 else (leg,)
    parts = ("all legs",) if len(legs) == 6 else (f"leg {leg + 1}",)
    return Concealed(parts, ("passive_joint_stiffness",), 1e-4, 1.0, lambda size: ClampedLegs(hexapod, legs, size))


class StickingEnds(ClampedLegs):
    """Joints without grease stick: a leg bends with the platform until the moment in a joint exceeds its friction.

    `ratio`: bending stiffness 12EI/l³ over the leg's own; `moment`: what friction holds (N m), about every axis.
    """

    steps = 25

    def __init__(self, hexapod: Hexapod, legs: tuple[int, ...], ratio: float, moment: float) -> None:
        super().__init__(hexapod, legs, ratio)
        self._moment = moment

    def bent(self, model: Model, leg: int, bending: float) -> None:
        ends = model.hexapod.base[leg], model.place.joints[leg]
        start, end = (model.node(model.tag(), place) for place in ends)
        model.beam(start, end, (model.scaled(leg), bending, bending), _ACROSS)
        stuck = 30.0 * 4.0 * bending / float(model.place.lengths[leg]) * MICRO  # N µm per rad
        rigid, friction = model.elastic(RIGID_SPRING), model.material("ElasticPP", stuck, self._moment * MICRO / stuck)
        dry = model.material("Parallel", friction, model.elastic(SLACK * stuck))  # so that equilibrium is definite
        for joint, node in ((21 + leg, start), (11 + leg, end)):
            model.opensees.element(
                "zeroLength", model.tag(), joint, node, "-mat", *[rigid] * 3, *[dry] * 3, "-dir", *range(1, 7)
            )


def _sticking(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    leg, _ = chosen_leg(leg_forces(hexapod, campaign.rows), rng)
    legs, part = ((leg,), f"leg {leg + 1}") if rng.random() < 0.5 else (tuple(range(6)), "all legs")
    moved = base_matrices(hexapod, campaign.rows) @ (1.0 / hexapod.stiffness)
    turned = float(np.abs(moved[:, 3:]).max())
    share, length = float(rng.uniform(0.1, 0.5)), float(np.linalg.norm(hexapod.home))

    def of_size(size: float) -> Structure:
        clamped = size * float(hexapod.stiffness[leg]) * length**2 / 2.0 * turned  # 6EI/l times the rotation
        return StickingEnds(hexapod, legs, size, share * clamped)

    return Concealed((part,), ("passive_joint_stiffness", "friction_hysteresis"), 1e-4, 3.0, of_size)


class WarmLeg(Structure):
    """One leg follows the room's temperature more than the machine does."""

    def __init__(self, hexapod: Hexapod, leg: int, expansion: float) -> None:
        super().__init__(hexapod)
        self._leg, self._expansion = leg, expansion

    def elongations(self, rows: pd.DataFrame) -> Array:
        warmer = rows["temperature_degC"] - rows.groupby("series")["temperature_degC"].transform("first")
        found = np.zeros((len(rows), 6))
        found[:, self._leg] = self._expansion * warmer * float(np.linalg.norm(self.hexapod.home))
        return found


def _warm(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    leg, sign = int(rng.integers(6)), float(rng.choice([-1.0, 1.0]))
    part, names = f"leg {leg + 1}", ("thermal_drift",)
    return Concealed((part,), names, 1e-8, 3e-4, lambda size: WarmLeg(hexapod, leg, sign * size))


_SPRING, _SLIP = ("leg_nonlinear_stiffness",), ("friction_hysteresis",)
_LOOP = (*_SLIP, *_SPRING)
KINDS: dict[str, Kind[Structure]] = {
    "leg_gap": Kind(Wishes("wrench", reversing=True), _one(("leg_backlash",), 0.01, 3.0, gap, 6, reversing=True)),
    "leg_contact": Kind(Wishes(), _one(_SPRING, 0.02, 6.0, contact, 4)),
    "leg_softening": Kind(Wishes(precise=True), _one(_SPRING, 0.01, 3.0, softening, 4)),
    "leg_lost_preload": Kind(Wishes("wrench", reversing=True), _one(_SPRING, 0.02, 5.0, lost_preload, 6, True)),
    "leg_steel": Kind(Wishes("wrench", "stairs", precise=True), _one(_LOOP, 0.02, 0.75, steel, 12)),
    "leg_bouc_wen": Kind(Wishes("wrench", "stairs", precise=True), _one(_SLIP, 0.002, 0.2, bouc_wen, 25)),
    "leg_flag": Kind(Wishes("wrench", "stairs", precise=True), _one(_LOOP, 0.02, 0.8, flag, 12)),
    "leg_creep": Kind(Wishes(path="hold", precise=True), _creep),
    "leg_crooked": Kind(Wishes(), _crooked),
    "legs_clamped": Kind(Wishes(), _clamped),
    "leg_sticking": Kind(Wishes("wrench", "stairs", precise=True), _sticking),
    "leg_warm": Kind(Wishes(temperature=True), _warm),
}
