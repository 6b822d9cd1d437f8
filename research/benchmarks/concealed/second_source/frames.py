"""A hexapod as a structure in OpenSees: legs of uniaxial materials, rigid or elastic platforms and supports.

Lengths are µm, forces N, times s, so that displacements and tolerances are of order one. Legs are corotational trusses
(the change of geometry under load is in them), beams have corotational or P-Delta transformations. A series is one
analysis in its own time: loads go from row to row in small steps, so that materials with memory see the path.
"""

from __future__ import annotations

import ctypes
import importlib.util
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ..campaigns import POSE, wrenches
from ..hexapods import Array, Hexapod, Posture, posture

MICRO = 1e6  # µm per m
CENTRE = 100
RIGID_SPRING = 1e6  # N/µm, far stiffer than any leg
SLACK = 1e-4  # stiffness of what is open, against that of what is closed, so that equilibrium is definite
_TOLERANCE = 1e-9  # µm and rad
_RAMP = 0.2  # share of the time between two rows in which the load changes; then it stays
_STEPS = 4


class EngineError(Exception):
    """The engine found no equilibrium."""


@cache
def engine() -> Any:
    """OpenSees; its wheel brings a BLAS that its LAPACK does not find by itself, so it is loaded first."""
    found = importlib.util.find_spec("openseespylinux")
    if found is not None and found.submodule_search_locations:
        folder = Path(found.submodule_search_locations[0]) / "lib"
        for name in ("libquadmath.so.0", "libgfortran.so.4", "libblas.so.3"):
            if (folder / name).exists():
                ctypes.CDLL(str(folder / name), mode=ctypes.RTLD_GLOBAL)
    from openseespy import opensees  # noqa: PLC0415 - an extra

    return opensees


class Structure:
    """The healthy machine; a concealed physics overrides the part in which it is.

    `steps`: steps of load from row to row; a law with memory needs more of them.
    """

    steps = _STEPS

    def __init__(self, hexapod: Hexapod) -> None:
        self.hexapod = hexapod

    def wrenches(self, rows: pd.DataFrame) -> Array:
        """Loads that really act (N, N m)."""
        return wrenches(self.hexapod, rows)

    def elongations(self, rows: pd.DataFrame) -> Array | None:
        """What the legs become longer by without force, against the series' first row (rows × 6, m)."""
        return None

    def supports(self, model: Model) -> None:
        """Ground the base joints (nodes 21 to 26)."""
        for leg in range(6):
            model.fix(21 + leg)

    def platform(self, model: Model) -> None:
        """Join the platform's joints (nodes 11 to 16) to its origin (node 100)."""
        for leg in range(6):
            model.opensees.rigidLink("beam", CENTRE, 11 + leg)

    def leg(self, model: Model, leg: int) -> None:
        """Make a leg between its joints."""
        model.truss(leg, model.elastic(model.scaled(leg)))

    def further(self, model: Model) -> None:
        """What else touches the machine."""

    def solve(self, rows: pd.DataFrame) -> Array:
        """Deflections of all rows (rows × 6: m, rad, differences of pose coordinates)."""
        return solved(self, rows)

    def readings(self, deflections: Array, rows: pd.DataFrame) -> Array:
        """What the instrument makes of the deflections (rows × 6, m, rad)."""
        return deflections


class Model:
    """One pose of a structure in the engine."""

    def __init__(self, structure: Structure, place: Posture) -> None:
        self.opensees, self.place, self.hexapod = engine(), place, structure.hexapod
        self._tag = 1000
        self.opensees.wipe()
        self.opensees.model("basic", "-ndm", 3, "-ndf", 6)
        self.node(CENTRE, place.origin)
        for leg in range(6):
            self.node(11 + leg, place.joints[leg])
            self.node(21 + leg, self.hexapod.base[leg])
        structure.supports(self)
        structure.platform(self)
        for leg in range(6):
            structure.leg(self, leg)
        structure.further(self)

    def tag(self) -> int:
        """A number that is not taken."""
        self._tag += 1
        return self._tag

    def node(self, tag: int, place: Array) -> int:
        """A node at a place in O (m)."""
        self.opensees.node(tag, *(float(value) * MICRO for value in place))
        return tag

    def fix(self, tag: int) -> None:
        """Hold a node in all six directions."""
        self.opensees.fix(tag, 1, 1, 1, 1, 1, 1)

    def scaled(self, leg: int) -> float:
        """Stiffness of a leg's bar per strain (N): k L."""
        return float(self.hexapod.stiffness[leg] * self.place.lengths[leg])

    def elastic(self, stiffness: float) -> int:
        """A linear material."""
        tag = self.tag()
        self.opensees.uniaxialMaterial("Elastic", tag, stiffness)
        return tag

    def material(self, kind: str, *parameters: float) -> int:
        """Any uniaxial material."""
        tag = self.tag()
        self.opensees.uniaxialMaterial(kind, tag, *parameters)
        return tag

    def truss(self, leg: int, material: int, kind: str = "corotTruss") -> None:
        """A leg as a bar of a material in N over strain; `truss` where it may hang loose on the way to equilibrium."""
        self.opensees.element(kind, self.tag(), 21 + leg, 11 + leg, 1.0, material)

    def bar(self, one: int, other: int, material: int) -> None:
        """A bar between two nodes."""
        self.opensees.element("corotTruss", self.tag(), one, other, 1.0, material)

    def beam(self, one: int, other: int, section: tuple[float, float, float], up: Array, kind: str = "PDelta") -> None:
        """An elastic beam: EA (N), EI (N m², both ways) and GJ (N m²)."""
        transformation = self.tag()
        self.opensees.geomTransf(kind, transformation, *(float(value) for value in up))
        axial, bending, torsion = section[0], section[1] * MICRO**2, section[2] * MICRO**2
        self.opensees.element(
            "elasticBeamColumn", self.tag(), one, other, axial, 1.0, 1.0, torsion, bending, bending, transformation
        )


def deflections(structure: Structure, rows: pd.DataFrame) -> Array:
    """Noise-free readings of all rows (rows × 6: m, rad)."""
    return structure.readings(structure.solve(rows), rows)


def solved(structure: Structure, rows: pd.DataFrame) -> Array:
    """Deflections of all rows by OpenSees, series by series."""
    loads, found = structure.wrenches(rows), np.zeros((len(rows), 6))
    longer = structure.elongations(rows)
    numbers = rows["series"].to_numpy()
    for number in pd.unique(numbers):
        own = np.flatnonzero(numbers == number)
        series = rows.iloc[own]
        place = posture(structure.hexapod, series[list(POSE)].to_numpy(dtype=float)[0])
        twists = _series(structure, place, series, loads[own], None if longer is None else longer[own])
        found[own] = [place.coordinates(twist) for twist in twists]
    return found


def _series(
    structure: Structure, place: Posture, rows: pd.DataFrame, loads: Array, longer: Array | None
) -> list[Array]:
    """Twists of the platform under the rows of one series (m, rad), one analysis in time."""
    model = Model(structure, place)
    opensees = model.opensees
    times = rows["time_s"].to_numpy(dtype=float) if "time_s" in rows else np.arange(len(rows), dtype=float)
    times = times - times[0] + 1.0
    instants = [0.0]
    for before, after in zip([0.0, *times[:-1]], times, strict=True):
        instants += [before + _RAMP * (after - before), after]

    instants.append(instants[-1] + 1.0)  # a path ends at its last instant, to the last digit

    def history(values: Array) -> list[float]:
        return [0.0, *(float(value) for value in np.repeat(values, 2)), float(values[-1])]

    applied: list[tuple[int, int, Array]] = [
        (CENTRE, axis, loads[:, axis] * (1.0 if axis < 3 else MICRO)) for axis in range(6)
    ]
    if longer is not None:  # a bar that grows: a pair of forces k·e along it
        direction = (place.joints - structure.hexapod.base) / place.lengths[:, None]
        for leg in np.flatnonzero(np.abs(longer).max(axis=0) > 0):
            for axis in range(3):
                push = structure.hexapod.stiffness[leg] * longer[:, leg] * direction[leg, axis]
                applied += [(11 + int(leg), axis, push), (21 + int(leg), axis, -push)]
    for number, (node, axis, values) in enumerate(applied, start=1):
        opensees.timeSeries("Path", number, "-time", *instants, "-values", *history(values))
        opensees.pattern("Plain", number, number)
        opensees.load(node, *(1.0 if each == axis else 0.0 for each in range(6)))
    _analysis(opensees)
    found, now = [], 0.0
    for at in times:
        ramp = now + _RAMP * (at - now)
        _advance(opensees, ramp - now, structure.steps)
        _advance(opensees, at - ramp, structure.steps)
        now = float(at)
        moved = np.array(opensees.nodeDisp(CENTRE))
        found.append(np.concatenate([moved[:3] / MICRO, moved[3:]]))
    opensees.wipe()
    return found


def _analysis(opensees: Any) -> None:
    opensees.constraints("Transformation")
    opensees.numberer("Plain")
    opensees.system("FullGeneral")
    opensees.test("NormDispIncr", _TOLERANCE, 60, 0)
    opensees.algorithm("Newton")
    opensees.integrator("LoadControl", 1.0)
    opensees.analysis("Static", "-noWarnings")


def _advance(opensees: Any, duration: float, steps: int) -> None:
    """Go on in time; where Newton's method cycles at a kink, with a line search, then in smaller steps."""
    for _ in range(steps):
        if not _step(opensees, duration / steps, depth=0):
            raise EngineError("no equilibrium")


def _step(opensees: Any, duration: float, depth: int) -> bool:
    opensees.integrator("LoadControl", duration)
    for algorithm in (("Newton",), ("NewtonLineSearch",), ("KrylovNewton",)):
        opensees.algorithm(*algorithm)
        if opensees.analyze(1) == 0:
            return True
    return depth < 3 and all(_step(opensees, duration / 4, depth + 1) for _ in range(4))
