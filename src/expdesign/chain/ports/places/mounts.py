"""The platform's mount and the base's ground: extra twists under the wrench that passes through them."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.chain.component import BASE, PLATFORM, on_any
from expdesign.chain.ports.families import (
    jumps,
    kinks_over,
    memory_of,
    of_effort,
    over_time,
    since_start,
    smooth_over,
    steps_over,
    stops,
)
from expdesign.chain.ports.port import Channel, Entry, Port, Prior, channels_of, steady
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import frame_turn, twist_transfer

_LIMITS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
"""Quantiles of the load at which a mount may give way."""


class Mount(Port):
    """u: twist (m, rad) of what lies beyond the mount; laws of the wrench that passes through it.

    Attributes:
        effort: kind of the quantities that are the components of this wrench.
        place: which wrench among the efforts it is: 0 at the platform, 1 about the origin of O.
    """

    effort: ClassVar[str]
    place: ClassVar[int]

    @abstractmethod
    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        """What a twist of the mount does to the platform."""

    def _efforts(self) -> list[Quantity]:
        return [Quantity(self.effort, i) for i in range(self.width)]

    def _whole(self, axis: int) -> Quantity:
        """A component of the wrench whose history counts."""
        return Quantity("effort", len(self.robot.stiffness) + self.place * self.width + axis)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        (component,), every = self.components, self._efforts()
        sight.look(every)
        efforts = tuple(q for q in every if sight.spread(q) > 0.0)
        if not efforts:
            return
        full = [(a, q) for a in range(self.width) for q in efforts]
        own = [(a, every[a]) for a in range(self.width) if every[a] in efforts]
        changing = (*over_time(sight, "compliance"), *smooth_over(sight, "compliance", sight.pose, 8))
        for prior in (steady("compliance", efforts[0]), *changing):
            yield self.law(component, prior, full, rank=min(prior.rank, 4))
            yield self.law(component, prior, own)
        for family in (kinks_over, steps_over, smooth_over):
            for prior in family(sight, "force law", efforts, 24):
                yield self.law(component, prior, range(self.width), rank=16)
        axes = [a for a, _ in own]
        yield from self._each_axis(sight, axes)
        yield from self._every_axis(sight, axes)
        for prior in (*over_time(sight, "twist"), *jumps(sight)):
            channels = since_start(sight, channels_of(range(self.width), prior.inputs))
            yield self.law(component, prior, channels, rank=10)

    def _every_axis(self, sight: Sight, axes: list[int]) -> Iterator[Entry]:
        """In every axis a law of its own component of the wrench: springs that are not linear, clamps that slip."""
        (component,), every = self.components, self._efforts()
        largest = np.array([sight.largest(every[a]) for a in axes])
        top = float(largest.max())

        def apart(form: str, kernel: str, seen: Sequence[tuple[Quantity, ...]], power: float, rank: int) -> Entry:
            gains = (top / largest) ** power
            channels = [Channel(a, i, seen[i], gain=float(gains[i])) for i, a in enumerate(axes)]
            return self.law(component, Prior(form, kernel, seen[0], (top,) * len(seen[0]), rank), channels)

        efforts = [(every[a],) for a in axes]
        yield apart("force law", "wiener", efforts, 0.5, 14)
        yield apart("force law", "integrated_wiener", efforts, 1.5, 14)
        if sight.remembers:
            banks = [stops(sight, self._whole(a)) for a in axes]
            yield apart("friction", "linear", banks, 1.0, len(banks[0]))

    def _each_axis(self, sight: Sight, axes: list[int]) -> Iterator[Entry]:
        """Laws of one component of the wrench, which may move the mount in any direction."""
        for effort, whole in ((self._efforts()[a], self._whole(a)) for a in axes):
            remembering = [prior for prior in memory_of(sight, whole) if len(prior.inputs) > 1]
            for prior in (*of_effort(sight, effort), *remembering):
                if prior.kernel != "pinned" or prior.scales[0] > sight.spread(effort):
                    yield self.law(self.components[0], prior, range(self.width), rank=8)


class PlatformMount(Mount):
    """What the platform carries its payload with: u and the wrench along the platform's axes."""

    name, at, effort, place = "platform", on_any(PLATFORM), "carried", 0

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return deflection + row.rates @ frame_turn(row.rotation, self.robot.coordinates.n) @ extra

    def entries(self, sight: Sight) -> Iterator[Entry]:
        yield from super().entries(sight)
        yield from self._slipping(sight)

    def _slipping(self, sight: Sight) -> Iterator[Entry]:
        """A mount that gives way in the direction of a load that is large enough, and stays there."""
        d = len(self.robot.gravity)
        forces = np.column_stack([sight.values(Quantity("carried", i)) for i in range(d)])[sight.counts]
        limits = {}
        for planar in (1.0, 0.0):
            sizes = np.linalg.norm(forces[:, :2] if planar else forces, axis=1)
            limits[planar] = [round(float(np.quantile(sizes, share)), 9) for share in _LIMITS]
        sight.look(Quantity("latched", i, (limit, p)) for p, own in limits.items() for limit in own for i in range(d))
        for planar, limit in ((planar, limit) for planar, own in limits.items() for limit in own):
            way = tuple(Quantity("latched", i, (limit, planar)) for i in range(2 if planar else d))
            if limit <= 0.0 or not any(sight.spread(q) > 0.0 for q in way):
                continue
            along = [Channel(i, 0, (q,)) for i, q in enumerate(way)]
            yield self.law(PLATFORM, Prior("latch", "linear", way[:1], (1.0,), 1), along)
            yield self.law(PLATFORM, Prior("latch", "linear", way, (1.0,) * len(way), 3), range(self.width))
            for prior in smooth_over(sight, "latch", sight.pose, 12):
                yield self.law(PLATFORM, prior, list(enumerate(way)), alike=True, rank=24)


class Ground(Mount):
    """What the base stands on: it moves about the origin of O and carries all along."""

    name, at, effort, place = "base", on_any(BASE), "ground", 1

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return deflection + row.rates @ twist_transfer(row.position, self.robot.coordinates.n) @ extra
