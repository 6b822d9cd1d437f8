"""Supports that are elastic frames, solved by Pynite with P-Delta."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pandas as pd

from ..campaigns import POSE
from ..hexapods import Array, Hexapod, Posture, posture
from .frames import Structure

MICRO = 1e6  # µm per m: lengths in µm, forces in N, as in `frames`
_AXES = ("FX", "FY", "FZ", "MX", "MY", "MZ")
_RIGID = 1e4  # stiffness of the platform's beams against that of legs


@cache
def engine() -> Any:
    """Pynite's frame model."""
    from Pynite import FEModel3D  # noqa: PLC0415 - an extra

    return FEModel3D


@dataclass(frozen=True)
class Frame:
    """Three columns under the feet, joined by a ring; `weaker` are factors on the columns' bending stiffness."""

    height: float
    ring: float
    weaker: tuple[float, float, float]


def draw_frame(hexapod: Hexapod, rng: np.random.Generator) -> Frame:
    """A frame of about the machine's height, one column possibly weaker than the others."""
    height = float(np.linalg.norm(hexapod.home)) * float(rng.uniform(0.7, 1.6))
    one, two, three = (float(value) for value in rng.lognormal(0.0, 0.5, 3))
    return Frame(height, float(rng.uniform(0.5, 2.0)), (one, two, three))


class OnFrame(Structure):
    """A hexapod on an elastic frame; a column yields sideways `softness` as much as a leg does."""

    def __init__(self, hexapod: Hexapod, frame: Frame, softness: float) -> None:
        super().__init__(hexapod)
        self.frame, self.softness = frame, softness

    def solve(self, rows: pd.DataFrame) -> Array:
        """Deflections of all rows: one model a pose, one combination a load."""
        loads, numbers, found = self.wrenches(rows), rows["series"].to_numpy(), np.zeros((len(rows), 6))
        for number in pd.unique(numbers):
            own = np.flatnonzero(numbers == number)
            place = posture(self.hexapod, rows.iloc[own[0]][list(POSE)].to_numpy(dtype=float))
            found[own] = [place.coordinates(twist) for twist in twists(self, place, loads[own])]
        return found


def twists(structure: OnFrame, place: Posture, loads: Array) -> Array:
    """Motions of the platform (loads × 6; m, rad) at one pose."""
    model = engine()()
    hexapod, frame = structure.hexapod, structure.frame

    def node(name: str, where: Array) -> str:
        return str(model.add_node(name, *(float(value) * MICRO for value in where)))

    def beam(name: str, one: str, other: str, axial: float, bending: float) -> None:
        """EA (N) and EI (N m²)."""
        material = model.add_material(f"m {name}", 1.0, 0.4, 0.25, 0.0)
        inertia = bending * MICRO**2
        section = model.add_section(f"s {name}", axial, inertia, inertia, 2.0 * inertia)
        model.add_member(name, one, other, material, section)

    k, radius = float(hexapod.stiffness.mean()), float(np.linalg.norm(hexapod.platform[0]))
    hub = node("hub", place.origin)
    column = k * frame.height**3 / 12.0 / structure.softness
    for leg in range(6):
        top, foot = node(f"top {leg}", place.joints[leg]), node(f"foot {leg}", hexapod.base[leg])
        beam(f"spoke {leg}", hub, top, _RIGID * k * radius, _RIGID * k * radius**3)
        beam(f"leg {leg}", foot, top, float(hexapod.stiffness[leg] * place.lengths[leg]), k * place.lengths[leg] ** 3)
        model.def_releases(f"leg {leg}", Ryi=True, Rzi=True, Rxj=True, Ryj=True, Rzj=True)
    for corner in range(3):
        middle = hexapod.base[[2 * corner, 2 * corner + 1]].mean(axis=0)
        head, ground = node(f"head {corner}", middle), node(f"ground {corner}", middle - [0, 0, frame.height])
        model.def_support(ground, True, True, True, True, True, True)
        own = column / frame.weaker[corner]
        beam(f"column {corner}", ground, head, 60.0 * own / frame.height**2, own)
        for leg in (2 * corner, 2 * corner + 1):
            beam(f"bracket {leg}", head, f"foot {leg}", 60.0 * column / frame.height**2, 5.0 * column)
        beam(f"ring {corner}", f"foot {2 * corner + 1}", f"foot {(2 * corner + 2) % 6}",
             60.0 * column / frame.height**2, frame.ring * column)  # fmt: skip
    for number, load in enumerate(loads):
        for axis, value in zip(_AXES, load * [1.0, 1.0, 1.0, MICRO, MICRO, MICRO], strict=True):
            model.add_node_load(hub, axis, float(value), f"load {number}")
        model.add_load_combo(f"row {number}", {f"load {number}": 1.0})
    model.analyze_PDelta(check_stability=False)
    moved = model.nodes["hub"]
    parts = (moved.DX, moved.DY, moved.DZ, moved.RX, moved.RY, moved.RZ)
    found = [[float(part[f"row {number}"]) for part in parts] for number in range(len(loads))]
    return np.array(found) / [MICRO, MICRO, MICRO, 1.0, 1.0, 1.0]
