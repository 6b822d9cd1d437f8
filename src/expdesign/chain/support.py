"""What effects of a support (what a body stands on) have in common: drives, whole loads, and dependence on the pose.

A support's twist follows from the six components of the wrench about the origin of P. A drive is one of them (`about
x`: the moment about x and the rotation it causes), or the moment about a horizontal axis of any azimuth (`oblique`),
under which the body may turn about x and y.
"""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.effect import Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints, Recordings

_DRIVES = ("along x", "along y", "along z", "about x", "about y", "about z")
OBLIQUE = "oblique"
_VARIES = 1e-9
AZIMUTHS = tuple(np.linspace(0.0, np.pi, 6, endpoint=False))


def measured_axes(points: LoadedPoints) -> set[int]:
    """Indices of the pose coordinates that were measured; all of them for points without readings."""
    return {int(axis) for axis in points.axes} if isinstance(points, Recordings) else set(range(6))


def drives(points: LoadedPoints, *, oblique: bool = False) -> list[str]:
    """Drives whose load varies and whose motion was measured."""
    spread = np.ptp(points.wrenches, axis=0)
    seen = measured_axes(points)
    found = [name for i, name in enumerate(_DRIVES) if i in seen and spread[i] > _VARIES * max(spread.max(), 1e-300)]
    if oblique and {"about x", "about y"} <= set(found):
        found.append(OBLIQUE)
    return found


def unit_of(drive: str) -> tuple[str, str]:
    """Units of the load and of the motion of a drive."""
    return ("N", "m") if drive.startswith("along") else ("Nm", "rad")


def drive_load(drive: str, wrench: ca.SX, azimuth: ca.SX | float = 0.0) -> ca.SX:
    """The component of a wrench (6,) that drives; for `oblique` the moment about the axis of that azimuth."""
    if drive == OBLIQUE:
        return ca.cos(azimuth) * wrench[3] + ca.sin(azimuth) * wrench[4]
    return wrench[_DRIVES.index(drive)]


def drive_values(drive: str, wrenches: FloatArray, azimuth: float = 0.0) -> FloatArray:
    """`drive_load` of many wrenches (N, 6), shape (N,)."""
    if drive == OBLIQUE:
        values: FloatArray = np.cos(azimuth) * wrenches[:, 3] + np.sin(azimuth) * wrenches[:, 4]
        return values
    return wrenches[:, _DRIVES.index(drive)]


def twist_of(drive: str, amounts: ca.SX) -> ca.SX:
    """Twist (6,) of the body from the amounts of motion (one, or two about x and y for `oblique`)."""
    twist = ca.SX.zeros(6)
    if drive == OBLIQUE:
        twist[3:5] = amounts
    else:
        twist[_DRIVES.index(drive)] = amounts
    return twist


def whole_load(wrench: ca.SX, row: Row) -> tuple[ca.SX, ca.SX]:
    """The whole load of a row and that of its reference state (6,) each."""
    return row.absolute + (wrench - row.wrench), row.absolute - row.wrench


def over_pose(points: LoadedPoints, names: tuple[str, ...]) -> list[str]:
    """Endings of variants for the pose coordinates that vary: ` over z_m 1.98 to 3.87`."""
    low, high = points.configurations.min(axis=0), points.configurations.max(axis=0)
    return [
        f" over {name} {low[i]:.6g} to {high[i]:.6g}"
        for i, name in enumerate(names)
        if high[i] - low[i] > 1e-2 * max(abs(high[i]), abs(low[i]), 1e-3)
    ]


def powers(variant: str, row: Row, names: tuple[str, ...]) -> list[ca.SX]:
    """1, u and u² where the variant depends on a pose coordinate (u = −1 … 1 over its range), else 1 alone."""
    if " over " not in variant:
        return [ca.SX(1.0)]
    name, low, _, high = variant.split(" over ")[1].split()
    u = (2.0 * row.pose[names.index(name)] - (float(low) + float(high))) / (float(high) - float(low))
    return [ca.SX(1.0), u, u**2]


def with_powers(parameters: tuple[Parameter, ...], variant: str) -> tuple[Parameter, ...]:
    """Parameters of a quantity that depends on a pose coordinate: at its middle, then per u and per u²."""
    if " over " not in variant:
        return parameters
    further = [
        Parameter(f"{p.name}_{ending}", p.scale) for ending in ("slope", "curvature") for p in parameters if not p.shape
    ]
    # A sum of powers has no simple sign; what is negative somewhere shows in the intervals.
    free = [Parameter(p.name, p.scale) for p in parameters if not p.shape]
    return (*free, *further, *(p for p in parameters if p.shape))
