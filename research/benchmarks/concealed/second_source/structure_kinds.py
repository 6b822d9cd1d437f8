"""What supports, platforms, loads, surroundings and instruments of a hexapod conceal."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ..campaigns import PAYLOAD, POSE, Campaign, Wishes, leg_forces, wrenches
from ..concealment import Concealed, Kind, chosen_leg
from ..hexapods import Array, Hexapod, posture
from . import pynite_frames
from .frames import SLACK, Model, Structure
from .leg_kinds import LARGE


class BeamPlatform(Structure):
    """A platform of spokes and a ring of beams; the payload and the target of the instrument are at the hub."""

    def __init__(self, hexapod: Hexapod, softness: float, ring: float) -> None:
        super().__init__(hexapod)
        self._softness, self._ring = softness, ring

    def platform(self, model: Model) -> None:
        radius = float(np.linalg.norm(self.hexapod.platform[0]))
        bending = float(self.hexapod.stiffness.mean()) * radius**3 / (3.0 * self._softness)
        section = (60.0 * bending / radius**2, bending, 0.7 * bending)
        up = model.place.rotation @ np.array([0.0, 0.0, 1.0])
        for leg in range(6):
            model.beam(100, 11 + leg, section, up)
            rim = (section[0], self._ring * bending, 0.7 * self._ring * bending)
            model.beam(11 + leg, 11 + (leg + 1) % 6, rim, up)


def _beam_platform(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    ring = float(rng.uniform(0.2, 1.5))
    return Concealed(
        ("platform",), ("platform_compliance",), 3e-3, 10.0, lambda size: BeamPlatform(hexapod, size, ring)
    )


class LooseBracket(Structure):
    """Two legs stand on one bracket whose bolt is loose: it lifts by a play before the bolt holds it."""

    def __init__(self, hexapod: Hexapod, foot: int, play: float, stiffness: float) -> None:
        super().__init__(hexapod)
        self._foot, self._play, self._stiffness = foot, play, stiffness

    def supports(self, model: Model) -> None:
        legs = (2 * self._foot, 2 * self._foot + 1)
        for leg in set(range(6)) - set(legs):
            model.fix(21 + leg)
        middle = self.hexapod.base[list(legs)].mean(axis=0)
        ground, bracket = model.node(model.tag(), middle), model.node(model.tag(), middle)
        model.fix(ground)
        play, stiffness = self._play * 1e6, self._stiffness * 1e-6  # µm, N/µm
        apart = 1e6 * float(np.linalg.norm(np.diff(self.hexapod.base[list(legs)], axis=0)))
        held, kept = model.elastic(40.0 * stiffness), model.elastic(40.0 * stiffness * apart**2)
        down = model.material("ElasticPPGap", stiffness, -LARGE, -1e-9)
        up = model.material("ElasticPPGap", stiffness, LARGE, play)
        both = model.material("Parallel", down, up, model.elastic(SLACK * stiffness))
        materials = (held, held, both, kept, kept, kept)
        model.opensees.element("zeroLength", model.tag(), ground, bracket, "-mat", *materials, "-dir", *range(1, 7))
        for leg in legs:
            model.opensees.rigidLink("beam", bracket, 21 + leg)


def _loose_bracket(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    foot, stiff = int(rng.integers(3)), 25.0 * float(hexapod.stiffness.mean())
    stretch = np.abs(leg_forces(hexapod, campaign.rows)).max() / hexapod.stiffness.mean()
    parts = ("base", f"leg {2 * foot + 1}", f"leg {2 * foot + 2}")
    names = ("leg_backlash", "joint_backlash", "base_compliance", "leg_coupling")
    return Concealed(parts, names, 0.01, 3.0, lambda size: LooseBracket(hexapod, foot, size * float(stretch), stiff))


class WarmColumn(Structure):
    """A column of the base frame warms with the room: the foot on it rises and leans, and two legs with it."""

    def __init__(self, hexapod: Hexapod, foot: int, way: Array, expansion: float) -> None:
        super().__init__(hexapod)
        self._foot, self._way, self._expansion = foot, way, expansion

    def elongations(self, rows: pd.DataFrame) -> Array:
        warmer = rows["temperature_degC"] - rows.groupby("series")["temperature_degC"].transform("first")
        shift = self._expansion * float(np.linalg.norm(self.hexapod.home)) * self._way
        found = np.zeros((len(rows), 6))
        for index, (pose, kelvin) in enumerate(zip(rows[list(POSE)].to_numpy(dtype=float), warmer, strict=True)):
            place = posture(self.hexapod, pose)
            # A foot that moves along a leg pushes as a longer leg does.
            for leg in (2 * self._foot, 2 * self._foot + 1):
                direction = (place.joints[leg] - self.hexapod.base[leg]) / place.lengths[leg]
                found[index, leg] = kelvin * float(direction @ shift)
        return found


def _warm_column(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    foot, way = int(rng.integers(3)), np.array([*(0.3 * rng.normal(size=2)), 1.0])
    parts, names = ("base", "environment"), ("thermal_drift",)
    return Concealed(parts, names, 1e-8, 3e-4, lambda size: WarmColumn(hexapod, foot, way, size))


class TautCable(Structure):
    """A hose or cable between the ground and the platform, which holds when it is pulled and has some slack."""

    def __init__(self, hexapod: Hexapod, anchor: Array, eye: Array, stiffness: float, slack: float) -> None:
        super().__init__(hexapod)
        self._anchor, self._eye, self._stiffness, self._slack = anchor, eye, stiffness, slack

    def further(self, model: Model) -> None:
        eye = model.place.origin + model.place.rotation @ self._eye
        ground, held = model.node(model.tag(), self._anchor), model.node(model.tag(), eye)
        model.fix(ground)
        model.opensees.rigidLink("beam", 100, held)
        length = float(np.linalg.norm(eye - self._anchor))
        scaled = self._stiffness * length
        pulled = model.material("ElasticPPGap", scaled, LARGE, self._slack / length + 1e-15)
        model.bar(ground, held, model.material("Parallel", pulled, model.elastic(SLACK * scaled)))


def _taut_cable(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    _, most = chosen_leg(leg_forces(hexapod, campaign.rows), rng)
    reach, angle = float(np.hypot(*hexapod.base[0, :2])), float(rng.uniform(0, 2 * np.pi))
    anchor = np.array([1.5 * reach * np.cos(angle), 1.5 * reach * np.sin(angle), hexapod.home[2] * rng.uniform(0, 0.7)])
    eye = np.array([0.5 * reach * np.cos(angle + 0.6), 0.5 * reach * np.sin(angle + 0.6), 0.0])
    own = float(hexapod.stiffness.mean())
    slack = most / own * float(rng.choice([0.0, 0.2]))
    parts = ("environment", "platform", "payload")
    return Concealed(parts, (), 1e-3, 5.0, lambda size: TautCable(hexapod, anchor, eye, size * own, slack))


class WrongLoad(Structure):
    """The load that acts is another than was written down."""

    def __init__(self, hexapod: Hexapod, shift: Array, mass: float | None) -> None:
        super().__init__(hexapod)
        self._shift, self._mass = shift, mass

    def wrenches(self, rows: pd.DataFrame) -> Array:
        true = rows.copy()
        concerned = true["mass_kg"] > 0 if self._mass is None else np.isclose(true["mass_kg"], self._mass, rtol=1e-3)
        for axis, name in enumerate(PAYLOAD[1:]):
            true[name] = true[name] + np.where(concerned, self._shift[axis], 0.0)
        return wrenches(self.hexapod, true)


def _wrong_centre(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    masses = campaign.rows["mass_kg"]
    one = float(rng.choice(masses[masses > 0].unique())) if rng.random() < 0.5 else None
    way = rng.normal(size=3) * [1.0, 1.0, 0.3]
    way /= np.linalg.norm(way)
    remark = "of every payload" if one is None else f"of the payload of {one:g} kg"
    names = ("payload_com_offset",)
    return Concealed(("payload",), names, 1e-4, 0.1, lambda size: WrongLoad(hexapod, size * way, one), remark)


class LoadCell(Structure):
    """The load cell is wrong: by a factor on one axis, or more the larger its load."""

    def __init__(self, hexapod: Hexapod, axis: int, error: float, largest: float | None) -> None:
        super().__init__(hexapod)
        self._axis, self._error, self._largest = axis, error, largest

    def wrenches(self, rows: pd.DataFrame) -> Array:
        true = wrenches(self.hexapod, rows)
        own = true[:, self._axis]
        share = 1.0 if self._largest is None else np.abs(own) / self._largest
        true[:, self._axis] = own * (1.0 + self._error * share)
        return true


def _load_cell(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    axis, sign = int(rng.choice([0, 1, 2])), float(rng.choice([-1.0, 1.0]))
    largest = float(np.abs(wrenches(hexapod, campaign.rows)[:, axis]).max()) if rng.random() < 0.5 else None
    what = "constant" if largest is None else "grows with the load"
    return Concealed(
        ("payload", "environment"),
        ("payload_mass_error",),
        0.005,
        0.9,
        lambda size: LoadCell(hexapod, axis, sign * size, largest),
        f"axis {axis + 1}, {what}",
    )


class CurvedGauge(Structure):
    """A gauge that reads more than it should, the more the farther it is pushed."""

    def __init__(self, hexapod: Hexapod, axis: int, error: float, largest: float) -> None:
        super().__init__(hexapod)
        self._axis, self._error, self._largest = axis, error, largest

    def readings(self, deflections: Array, rows: pd.DataFrame) -> Array:
        read, own = deflections.copy(), deflections[:, self._axis]
        read[:, self._axis] = own * (1.0 + self._error * own / self._largest)
        return read


def _curved_gauge(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    axis = int(rng.integers(3))
    largest = 50.0 * float(campaign.std[axis])
    return Concealed(
        ("instrument",), ("instrument_scale",), 0.01, 0.9, lambda size: CurvedGauge(hexapod, axis, size, largest)
    )


def _base_frame(hexapod: Hexapod, campaign: Campaign, rng: np.random.Generator) -> Concealed[Structure]:
    frame = pynite_frames.draw_frame(hexapod, rng)
    return Concealed(
        ("base",), ("base_compliance",), 3e-3, 10.0, lambda size: pynite_frames.OnFrame(hexapod, frame, size)
    )


KINDS: dict[str, Kind[Structure]] = {
    "base_frame": Kind(Wishes(), _base_frame),
    "platform_of_beams": Kind(Wishes(), _beam_platform),
    "loose_bracket": Kind(Wishes("wrench", reversing=True), _loose_bracket),
    "warm_column": Kind(Wishes(temperature=True), _warm_column),
    "taut_cable": Kind(Wishes("wrench"), _taut_cable),
    "wrong_centre_of_mass": Kind(Wishes("payload"), _wrong_centre),
    "load_cell": Kind(Wishes("wrench"), _load_cell),
    "curved_gauge": Kind(Wishes(), _curved_gauge),
}
