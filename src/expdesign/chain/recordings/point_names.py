"""Points that carry another's name, and points that do not lie where the drawing has them.

Between an unloaded and a loaded state points move by far less than they are apart, so that each is recognised by its
place. Against the drawing only distances count: points are registered, under their names and with any two exchanged.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from expdesign.arrays import FloatArray
from expdesign.chain.instrument.registration import registered
from expdesign.chain.recordings.point_lists import PointSet
from expdesign.errors import InputError


@dataclass(frozen=True)
class PointOptions:
    """When points are taken for mistaken.

    Attributes:
        gain: factor by which distances or residuals must fall under the other reading.
        smallest: distances and residuals (m) below which nothing is suspected.
        refused: largest residual against the drawing, in parts of the points' size, beyond which it is another object.
    """

    gain: float = 10.0
    smallest: float = 1e-3
    refused: float = 0.05


OPTIONS = PointOptions()
"""What commands use."""


@dataclass(frozen=True)
class MarkerFit:
    """How the points of a state fit the places of the robot's markers.

    Attributes:
        rms: of the distances (m) that registration leaves.
        worst: the point that is farthest from its place.
        size: how far it is (m).
        off: whether the others fit far better without it.
    """

    rms: float
    worst: str
    size: float
    off: bool


def require_own_names(before: FloatArray, after: FloatArray, names: Sequence[str], where: str) -> None:
    """Raise an `InputError` where points (N, 3) would hardly have moved under each other's names."""
    distances = cdist(after, before)
    order = linear_sum_assignment(distances**2)[1]
    stated, matched = (
        float(np.sqrt((distances[range(len(names)), o] ** 2).mean())) for o in (range(len(names)), order)
    )
    if stated < OPTIONS.smallest or matched * OPTIONS.gain >= stated:
        return
    wrong = [name for name, own in zip(names, order != np.arange(len(names)), strict=True) if own]
    what = (
        f"the points {_listed(wrong)} are swapped: each is where another was without load ({stated * 1e3:.3g} mm off)"
    )
    raise InputError(what, where=where, remedy="Correct their names in the list, or measure the state again.")


def marker_fit(points: PointSet, markers: Mapping[str, FloatArray]) -> MarkerFit | None:
    """How points fit the markers of the same names; None where fewer than three have a place.

    Raises:
        InputError: they do not lie so, with the two that would if their names were exchanged, or the one that is off.
    """
    names = [name for name in points.points if name in markers]
    if len(names) < 3:
        return None
    seen = np.array([points.points[name].position for name in names])
    places = np.array([markers[name] for name in names])
    left = _left(places, seen)
    rms, worst = _rms(left), int(np.argmax(left))
    size, off = float(left[worst]), False
    if len(names) > 3 and size > OPTIONS.smallest:
        without = [np.delete(np.arange(len(names)), i) for i in range(len(names))]
        rest = np.array([_rms(_left(places[kept], seen[kept])) for kept in without])
        worst, off = int(np.argmin(rest)), bool(rest.min() * OPTIONS.gain < rms)
        if off:
            turn, shift = registered(places[without[worst]], seen[without[worst]])
            size = float(np.linalg.norm(seen[worst] - places[worst] @ turn.T - shift))
    extent = float(np.linalg.norm(places - places.mean(axis=0), axis=1).max())
    if left.max() > OPTIONS.refused * extent:
        what = f"the points do not lie as the robot's `markers` say ({left.max() * 1e3:.3g} mm off)"
        remedy = "Check names and units of the points and of `markers`."
        pair = _exchanged(places, seen, names, rms)
        if pair is not None:
            what = f"the points {pair[0]} and {pair[1]} are swapped: exchanged, all lie as the robot's `markers` say"
            remedy = "Correct their names in the lists or in `markers`."
        elif off:
            what += f": {names[worst]} by {size * 1e3:.3g} mm, the others fit"
            remedy = f"Correct the place of {names[worst]} in the robot file, or its name."
        raise InputError(what, where=f"{points.source}, {points.name}", remedy=remedy)
    return MarkerFit(rms, names[worst], size, off)


def near_names(names: Sequence[str], known: Sequence[str]) -> str:
    """A remedy for names that differ from known ones in capitals alone, or nothing."""
    lower = {name.lower(): name for name in known}
    pairs = [(name, lower[name.lower()]) for name in names if name not in known and name.lower() in lower]
    if not pairs:
        return ""
    return f"`{pairs[0][0]}` and `{pairs[0][1]}` differ in capitals: did you mean `{pairs[0][1]}`?"


def _left(places: FloatArray, seen: FloatArray) -> FloatArray:
    """Distances (N,) that registration leaves."""
    turn, shift = registered(places, seen)
    left: FloatArray = np.linalg.norm(seen - places @ turn.T - shift, axis=1)
    return left


def _rms(left: FloatArray) -> float:
    return float(np.sqrt((left**2).mean()))


def _exchanged(places: FloatArray, seen: FloatArray, names: Sequence[str], rms: float) -> tuple[str, str] | None:
    """The two points that have each other's names, or None."""
    best: tuple[float, tuple[str, str]] | None = None
    for first, second in combinations(range(len(names)), 2):
        order = np.arange(len(names))
        order[[first, second]] = second, first
        found = _rms(_left(places[order], seen))
        if best is None or found < best[0]:
            pair = sorted((names[first], names[second]))
            best = found, (pair[0], pair[1])
    return best[1] if best is not None and best[0] * OPTIONS.gain < rms else None


def _listed(names: Sequence[str]) -> str:
    return " and ".join(names) if len(names) < 3 else f"{', '.join(names[:-1])} and {names[-1]}"
