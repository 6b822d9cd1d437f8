"""The payload and what surrounds it: an extra wrench on the platform or tip."""

from collections.abc import Iterator
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import ENVIRONMENT, PAYLOAD, on_any
from expdesign.chain.ports.families import COARSE, kinks_over, over_time, since_start, smooth_over
from expdesign.chain.ports.port import Channel, Entry, Names, Port, Prior, channels_of, steady
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row

_DIRECTIONS = 24
_DISTANCES = (1.0, 2.0, 4.0, 10.0, 40.0)
"""Of sources of force from the middle of the places, in spreads of these."""
_WEIGHTS = (0.05, 0.5)
"""Scales over the size of a load, in its spread: a single weight that is wrong, and a scale that is curved."""


def _points(middle: FloatArray, spread: FloatArray) -> FloatArray:
    """Points around a middle, evenly over directions (Fibonacci lattice) at several distances, shape (P, d)."""
    count = np.arange(_DIRECTIONS) + 0.5
    if len(middle) == 2:
        angle = 2.0 * np.pi * count / _DIRECTIONS
        directions = np.column_stack([np.cos(angle), np.sin(angle)])
    else:
        height, angle = 1.0 - 2.0 * count / _DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * count
        ring = np.sqrt(1.0 - height**2)
        directions = np.column_stack([ring * np.cos(angle), ring * np.sin(angle), height])
    size = float(np.linalg.norm(spread))
    return np.concatenate([middle + size * distance * directions for distance in _DISTANCES])


class PayloadPort(Port):
    """u: extra wrench (N, N·m) at the origin of P along the axes of O: forces of the environment, and payloads that are
    not as stated.
    """

    name = "payload"
    at = on_any(ENVIRONMENT, PAYLOAD)
    adds: ClassVar[Names] = lambda robot: robot.coordinates.wrench

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return wrench + extra

    def entries(self, sight: Sight) -> Iterator[Entry]:
        yield from self._fields(sight)
        yield from self._contacts(sight)
        yield from self._towards_points(sight, (0.5, 2.0))
        yield from self._loads(sight)

    def _fields(self, sight: Sight) -> Iterator[Entry]:
        """Forces that follow the place, the pose or time."""
        n, d = self.width, len(self.robot.gravity)
        position = tuple(Quantity("position", i) for i in range(d))
        pose, forces = sight.pose, range(d)
        priors: list[tuple[Prior, range]] = []
        for inputs in (position, pose) if n > 2 else (position,):
            priors += [(prior, forces) for prior in smooth_over(sight, "field", inputs, 20)]
            priors += [(prior, forces) for prior in kinks_over(sight, "field", inputs, 24)]
        varying = tuple(q for q in position if sight.spread(q) > 0.0)
        for factor in COARSE if varying else ():
            scales = tuple(factor * sight.spread(q) for q in varying)
            priors.append((Prior("field", "matern", varying, scales, 24), forces))
        if n > 2:
            priors += [(prior, range(n)) for prior in smooth_over(sight, "field", pose, 15)]
            priors += [(prior, range(n)) for prior in kinks_over(sight, "field", pose, 15)]
        priors += [(prior, forces) for prior in over_time(sight, "field")]
        yield from self._each(sight, priors)

    def _contacts(self, sight: Sight) -> Iterator[Entry]:
        """Forces that follow the deflection: what is touched on the way."""
        shown = tuple(Quantity("deflection", i) for i in range(self.width)) if not sight.positions else ()
        sight.look(shown)
        yield from self._each(sight, [(prior, range(self.width)) for prior in kinks_over(sight, "contact", shown, 15)])

    def _each(self, sight: Sight, priors: list[tuple[Prior, range]]) -> Iterator[Entry]:
        """Every prior with a law of its own in each of its directions."""
        for prior, outputs in priors:
            yield self.law(ENVIRONMENT, prior, self._moved(sight, channels_of(outputs, prior.inputs)))

    def _moved(self, sight: Sight, channels: tuple[Channel, ...]) -> tuple[Channel, ...]:
        """Channels as a reading shows them that is the change since the series' first row."""
        return since_start(sight, channels)

    def _towards_points(self, sight: Sight, lengths: tuple[float, ...]) -> Iterator[Entry]:
        """Forces towards or from a point: springs, cords and magnets."""
        d = len(self.robot.gravity)
        places = np.column_stack([sight.values(Quantity("position", i)) for i in range(d)])[sight.counts]
        middle, spread = places.mean(axis=0), places.std(axis=0)
        if not spread.any():
            return
        for point in _points(middle, spread):
            setting = tuple(round(float(v), 6) for v in point)
            away = Quantity("distance", 0, setting)
            if sight.spread(away) == 0.0:
                continue
            towards = [(i, Quantity("towards", i, setting)) for i in range(d)]
            for factor in lengths:
                prior = Prior("field", "squared_exponential", (away,), (factor * sight.spread(away),), 10)
                yield self.law(ENVIRONMENT, prior, towards, alike=True)

    def _loads(self, sight: Sight) -> Iterator[Entry]:
        """A share of the stated load, in any direction, that is the same always or changes."""
        count = len(self.robot.stiffness)
        every = [Quantity("effort", count + a) for a in range(self.width)]
        sight.look(every)
        efforts = [quantity for quantity in every if sight.spread(quantity) > 0.0]
        if not efforts:
            return
        pairs = [(a, q) for a in range(self.width) for q in efforts]
        same = [(a, q) for a, q in pairs if q.index == count + a]
        changing = (*over_time(sight, "load"), *smooth_over(sight, "load", sight.pose, 12))
        for prior in (steady("load", efforts[0]), *changing):
            for chosen in (pairs, same) if prior.kernel == "constant" else (same,):
                yield self.law(PAYLOAD, prior, chosen, rank=min(prior.rank, 10))
            yield self.law(PAYLOAD, prior, same, alike=True)
        size = Quantity("weight")
        for factor in _WEIGHTS if sight.varies(size) else ():
            prior = Prior("load", "squared_exponential", (size,), (factor * sight.spread(size),), 12)
            yield self.law(PAYLOAD, prior, same, alike=True)
