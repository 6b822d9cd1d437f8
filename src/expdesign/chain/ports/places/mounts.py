"""The platform's mount and the base's ground: extra twists under the wrench that passes through them."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence

import casadi as ca
import numpy as np

from expdesign.chain.component import BASE, PLATFORM, Component
from expdesign.chain.ports.families import (
    Prior,
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
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import frame_turn, twist_transfer

_LIMITS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
"""Quantiles of the load at which a mount may give way."""


class Mount(Port):
    """u: twist (m, rad) of what lies beyond the mount; laws of the wrench that passes through it."""

    component: Component
    effort: str

    def components_of_motion(self) -> int:
        return self.robot.coordinates.n

    @abstractmethod
    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        """What a twist of the mount does to the platform."""

    def _efforts(self) -> list[Quantity]:
        return [Quantity(self.effort, i) for i in range(self.width)]

    @property
    def components(self) -> Sequence[Component]:
        return (self.component,)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        every = self._efforts()
        sight.look(every)
        efforts = [q for q in every if sight.spread(q) > 0.0]
        if not efforts:
            return
        pose = tuple(Quantity("pose", i) for i in range(len(self.robot.configuration)))
        steady = Prior("compliance", "constant", (efforts[0],), (1.0,), 1)
        full = [(a, q) for a in range(self.width) for q in efforts]
        own = [(a, every[a]) for a in range(self.width) if every[a] in efforts]
        for prior in (steady, *over_time(sight, "compliance"), *smooth_over(sight, "compliance", pose, 8)):
            for pairs in (full, own):
                channels = tuple(Channel(a, i, prior.inputs, q) for i, (a, q) in enumerate(pairs))
                rank = prior.rank if pairs is own else min(prior.rank, 4)
                yield Entry(self.name, self.component, prior.form, channels, prior.kernel, prior.scales, rank)
        laws: list[Prior] = [*kinks_over(sight, "force law", tuple(efforts), 24)]
        laws += steps_over(sight, "force law", tuple(efforts), 24)
        laws += smooth_over(sight, "force law", tuple(efforts), 24)
        for prior in laws:
            channels = tuple(Channel(a, a, prior.inputs) for a in range(self.width))
            yield Entry(self.name, self.component, prior.form, channels, prior.kernel, prior.scales, 16)
        yield from self._each_axis(sight, [a for a, _ in own])
        yield from self._every_axis(sight, [a for a, _ in own])
        for prior in (*over_time(sight, "twist"), *jumps(sight)):
            channels = since_start(sight, (Channel(a, a, prior.inputs) for a in range(self.width)))
            yield Entry(self.name, self.component, prior.form, channels, prior.kernel, prior.scales, 10)

    def _every_axis(self, sight: Sight, axes: list[int]) -> Iterator[Entry]:
        """In every axis a law of its own component of the wrench: springs that are not linear, clamps that slip."""
        every = self._efforts()
        largest = np.array([sight.largest(every[a]) for a in axes])
        top = float(largest.max())
        for kernel, power in (("wiener", 0.5), ("integrated_wiener", 1.5)):
            gains = (top / largest) ** power
            channels = tuple(Channel(a, i, (every[a],), gain=float(gains[i])) for i, a in enumerate(axes))
            yield Entry(self.name, self.component, "force law", channels, kernel, (top,), 14)
        if int(sight.rows.position.max()) < 1:
            return
        first = len(self.robot.stiffness) + (0 if self.effort == "carried" else self.width)
        banks = [stops(sight, Quantity("effort", first + a)) for a in axes]
        gains = top / largest
        channels = tuple(Channel(a, i, banks[i], gain=float(gains[i])) for i, a in enumerate(axes))
        yield Entry(self.name, self.component, "friction", channels, "linear", (top,) * len(banks[0]), len(banks[0]))

    def _each_axis(self, sight: Sight, axes: list[int]) -> Iterator[Entry]:
        """Laws of one component of the wrench, which may move the mount in any direction."""
        every = self._efforts()
        for a in axes:
            priors = list(of_effort(sight, every[a]))
            first = len(self.robot.stiffness) + (0 if self.effort == "carried" else self.width)
            for whole in (Quantity("effort", first + a),):
                priors += [prior for prior in memory_of(sight, whole) if len(prior.inputs) > 1]
            for prior in priors:
                channels = tuple(Channel(b, b, prior.inputs) for b in range(self.width))
                if prior.kernel != "pinned" or prior.scales[0] > sight.spread(every[a]):
                    yield Entry(self.name, self.component, prior.form, channels, prior.kernel, prior.scales, 8)


class PlatformMount(Mount):
    """What the platform carries its payload with: u and the wrench along the platform's axes."""

    name, component, effort = "platform", PLATFORM, "carried"

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return deflection + row.rates @ frame_turn(row.rotation, self.robot.coordinates.n) @ extra

    def entries(self, sight: Sight) -> Iterator[Entry]:
        yield from super().entries(sight)
        yield from self._slipping(sight)

    def _slipping(self, sight: Sight) -> Iterator[Entry]:
        """A mount that gives way in the direction of a load that is large enough, and stays there."""
        d = len(self.robot.gravity)
        forces = np.column_stack([sight.values(Quantity("carried", i)) for i in range(d)])[sight.counts]
        pose = tuple(Quantity("pose", i) for i in range(len(self.robot.configuration)))
        limits = {}
        for planar in (1.0, 0.0):
            sizes = np.linalg.norm(forces[:, :2] if planar else forces, axis=1)
            limits[planar] = [round(float(np.quantile(sizes, share)), 9) for share in _LIMITS]
        sight.look(Quantity("latched", i, (limit, p)) for p, own in limits.items() for limit in own for i in range(d))
        for planar, own in limits.items():
            for limit in own:
                way = tuple(Quantity("latched", i, (limit, planar)) for i in range(2 if planar else d))
                if limit <= 0.0 or not any(sight.spread(q) > 0.0 for q in way):
                    continue
                alike = tuple(Channel(i, 0, (q,)) for i, q in enumerate(way))
                yield Entry(self.name, self.component, "latch", alike, "linear", (1.0,), 1)
                each = tuple(Channel(a, a, way) for a in range(self.width))
                yield Entry(self.name, self.component, "latch", each, "linear", (1.0,) * len(way), 3)
                for prior in smooth_over(sight, "latch", pose, 12):
                    where = tuple(Channel(i, 0, prior.inputs, q) for i, q in enumerate(way))
                    yield Entry(self.name, self.component, "latch", where, prior.kernel, prior.scales, 24)


class Ground(Mount):
    """What the base stands on: it moves about the origin of O and carries all along."""

    name, component, effort = "base", BASE, "ground"

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return deflection + row.rates @ twist_transfer(row.position, self.robot.coordinates.n) @ extra
