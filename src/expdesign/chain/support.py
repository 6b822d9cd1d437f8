"""What effects of a support (what a body stands on) have in common: drives, whole loads, and dependence on the pose.

A support's twist follows from the six components of the wrench about the origin of P. A drive is one of them (`about
x`: the moment about x and the rotation it causes), or the moment about a horizontal axis of any azimuth (`oblique`),
under which the body may turn about x and y.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Self

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, on
from expdesign.chain.declaration import rounded
from expdesign.chain.declared_effect import DeclaredEffect
from expdesign.chain.effect import Parameter
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings
from expdesign.chain.row import Row


class Drive(StrEnum):
    """The component of the load that drives, in the order of a wrench; `OBLIQUE` is about an axis that is found."""

    ALONG_X = "along x"
    ALONG_Y = "along y"
    ALONG_Z = "along z"
    ABOUT_X = "about x"
    ABOUT_Y = "about y"
    ABOUT_Z = "about z"
    OBLIQUE = "oblique"


_SINGLE = tuple(Drive)[:6]
_FORCES = _SINGLE[:3]
_VARIES = 1e-9
FARTHEST = 50.0
"""m; a centre or an axis of rotation farther away than this is a translation."""
AZIMUTHS = tuple(np.linspace(0.0, np.pi, 6, endpoint=False))


def measured_axes(points: LoadedPoints) -> set[int]:
    """Indices of the pose coordinates that were measured; all of them for points without readings."""
    return {int(axis) for axis in points.axes} if isinstance(points, Recordings) else set(range(6))


def drives(points: LoadedPoints, *, oblique: bool = False) -> list[Drive]:
    """Drives whose load varies and whose motion was measured."""
    spread = np.ptp(points.wrenches, axis=0)
    seen = measured_axes(points)
    found = [name for i, name in enumerate(_SINGLE) if i in seen and spread[i] > _VARIES * max(spread.max(), 1e-300)]
    if oblique and {Drive.ABOUT_X, Drive.ABOUT_Y} <= set(found):
        found.append(Drive.OBLIQUE)
    return found


def drive_load(drive: Drive, wrench: ca.SX, azimuth: ca.SX | float = 0.0) -> ca.SX:
    """The component of a wrench (6,) that drives; for `oblique` the moment about the axis of that azimuth."""
    if drive is Drive.OBLIQUE:
        return ca.cos(azimuth) * wrench[3] + ca.sin(azimuth) * wrench[4]
    return wrench[_SINGLE.index(drive)]


def drive_values(drive: Drive, wrenches: FloatArray, azimuth: float = 0.0) -> FloatArray:
    """`drive_load` of many wrenches (N, 6), shape (N,)."""
    if drive is Drive.OBLIQUE:
        values: FloatArray = np.cos(azimuth) * wrenches[:, 3] + np.sin(azimuth) * wrenches[:, 4]
        return values
    return wrenches[:, _SINGLE.index(drive)]


def twist_of(drive: Drive, amounts: ca.SX) -> ca.SX:
    """Twist (6,) of the body from the amounts of motion (one, or two about x and y for `oblique`)."""
    twist = ca.SX.zeros(6)
    if drive is Drive.OBLIQUE:
        twist[3:5] = amounts
    else:
        twist[_SINGLE.index(drive)] = amounts
    return twist


def whole_load(wrench: ca.SX, row: Row) -> tuple[ca.SX, ca.SX]:
    """The whole load of a row and that of its reference state (6,) each."""
    return row.absolute + (wrench - row.wrench), row.absolute - row.wrench


@dataclass(frozen=True)
class Over:
    """The range of a pose coordinate (its column) over which a quantity is a parabola; kept to six digits."""

    name: str
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.name} {self.low:.6g} to {self.high:.6g}"

    @property
    def sentence(self) -> str:
        """At which pose a value holds, for people."""
        return f"halfway between {self.name} = {self.low:.6g} and {self.high:.6g}, and it changes with {self.name}"


@dataclass(frozen=True)
class Posed:
    """A form, and the range of a pose coordinate over which its parameters are parabolas."""

    form: StrEnum
    over: Over | None = None

    def __str__(self) -> str:
        return f"{self.form}" if self.over is None else f"{self.form} over {self.over}"

    @classmethod
    def from_text(cls, form: type[StrEnum], text: str) -> Self:
        """The form that a file names; raises `ValueError`."""
        head, over, rest = text.partition(" over ")
        if not over:
            return cls(form(head))
        name, low, _, high = rest.split(" ")
        return cls(form(head), Over(name, float(low), float(high)))


def over_pose(points: LoadedPoints, names: tuple[str, ...]) -> list[Over]:
    """The ranges of the pose coordinates that vary."""
    low, high = points.configurations.min(axis=0), points.configurations.max(axis=0)
    return [
        Over(name, rounded(low[i]), rounded(high[i]))
        for i, name in enumerate(names)
        if high[i] - low[i] > 1e-2 * max(abs(high[i]), abs(low[i]), 1e-3)
    ]


def powers(over: Over | None, row: Row, names: tuple[str, ...]) -> list[ca.SX]:
    """1, u and u² of a pose coordinate (u = −1 … 1 over its range), or 1 alone where there is no dependence."""
    if over is None:
        return [ca.SX(1.0)]
    u = (2.0 * row.pose[names.index(over.name)] - (over.low + over.high)) / (over.high - over.low)
    return [ca.SX(1.0), u, u**2]


def with_powers(parameters: tuple[Parameter, ...], over: Over | None) -> tuple[Parameter, ...]:
    """Parameters of a quantity that depends on a pose coordinate: at its middle, then per u and per u²."""
    if over is None:
        return parameters
    further = [
        Parameter(f"{p.name}_{ending}", p.scale) for ending in ("slope", "curvature") for p in parameters if not p.shape
    ]
    # A sum of powers has no simple sign; what is negative somewhere shows in the intervals.
    free = [Parameter(p.name, p.scale) for p in parameters if not p.shape]
    return (*free, *further, *(p for p in parameters if p.shape))


class SupportEffect(DeclaredEffect):
    """An effect of what a body stands on, in the direction of a drive.

    Parameters of a motion are its `amount` per unit of the load that drives, or two about x and y where that is
    `oblique`; their shape is a threshold of the load and, if oblique, the azimuth of its axis.
    """

    at = on(lambda robot: robot.on_support, BASE)
    together = True

    @property
    def drive(self) -> Drive:
        """Direction of the load."""
        return Drive(getattr(self.variant, "drive", self.variant))

    @property
    def units(self) -> tuple[str, str]:
        return ("N", "m") if self.drive in _FORCES else ("Nm", "rad")

    @property
    def where(self) -> str:
        """The drive in a sentence."""
        return "about an oblique axis" if self.drive is Drive.OBLIQUE else str(self.drive)

    def driven(self, name: str, threshold: Parameter, *, low: float = float("-inf")) -> tuple[Parameter, ...]:
        """Parameters of amounts that begin with `name`, and of their shape."""
        if self.drive is not Drive.OBLIQUE:
            return self.described([Parameter(f"{name}_{{motion}}_per_{{force}}", 1e-6, low=low), threshold])
        amounts = (Parameter(f"{name}_{axis}_rad_per_Nm", 1e-6) for axis in ("rx", "ry"))
        azimuth = Parameter("azimuth_rad", 1.0, neutral=0.0, low=-10.0, high=10.0, shape=True)
        return self.described([*amounts, threshold, azimuth])

    def shapes(self, azimuths: Sequence[float]) -> list[tuple[float, ...]]:
        """The azimuths from which a search starts, () where the drive has none."""
        return [(azimuth,) for azimuth in azimuths] if self.drive is Drive.OBLIQUE else [()]

    def split(self, theta: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX | float]:
        """Amounts, threshold and azimuth."""
        if self.drive is Drive.OBLIQUE:
            return theta[:2], theta[2], theta[3]
        return theta[0], theta[1], 0.0


def taken_up(load: ca.SX, changeover: ca.SX, width: ca.SX) -> ca.SX:
    """Where in a gap a load holds the body, from −½ to ½: ½·x/√(1 + x²), x = (load − changeover)/width."""
    x = (load - changeover) / width
    return 0.5 * x / ca.sqrt(1.0 + x**2)
