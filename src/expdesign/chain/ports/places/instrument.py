"""The instrument and what surrounds it: what is read is not what happens."""

from collections.abc import Iterator

import casadi as ca

from expdesign.chain.component import ENVIRONMENT, INSTRUMENT, on_any
from expdesign.chain.ports.families import (
    jumps,
    over_temperature,
    over_time,
    repeating,
    since_start,
    smooth_over,
)
from expdesign.chain.ports.port import Channel, Entry, Port, channels_of, steady
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row


class Instrument(Port):
    """u: added to the reading. A law over pose times the deflection is a scale or a rotation that varies."""

    name = "instrument"
    at = on_any(INSTRUMENT)

    def reading(self, reading: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return reading + extra[: reading.shape[0]]

    def _axes(self, sight: Sight) -> list[int]:
        """What is read of the components of u."""
        return [a for a in sight.axes if a < (len(self.robot.gravity) if sight.positions else self.width)]

    def entries(self, sight: Sight) -> Iterator[Entry]:
        n, d, axes = self.width, len(self.robot.gravity), self._axes(sight)
        position = tuple(Quantity("position", i) for i in range(d))
        if not sight.positions:
            shown = [Quantity("deflection", i) for i in range(n)]
            sight.look(shown)
            blocks = [range(d), range(d, n)] if n > d else [range(d)]
            full = [(a, shown[b]) for block in blocks for a in block if a in axes for b in block]
            own = [(a, shown[a]) for a in axes]
            varying = [prior for seen in (position, sight.pose) for prior in smooth_over(sight, "scale", seen, 12)]
            for prior in (steady("scale", shown[0]), *varying):
                for pairs in (full, own):
                    yield self.law(INSTRUMENT, prior, pairs, rank=min(prior.rank, 10))
                yield self.law(INSTRUMENT, prior, own, alike=True)
            for a in axes:
                curves = [*smooth_over(sight, "reading law", (shown[a],)), *repeating(sight, "reading law", shown[a])]
                for prior in curves if sight.varies(shown[a]) else ():
                    yield self.law(INSTRUMENT, prior, (a,))
        for prior in smooth_over(sight, "offset", position if n > 2 else sight.pose, 16):
            yield self.law(INSTRUMENT, prior, axes)


class Surroundings(Instrument):
    """Slow changes of whatever is read: in time, and with the temperature."""

    name = "environment"
    at = on_any(ENVIRONMENT)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        for prior in (*over_time(sight, "drift"), *jumps(sight), *over_temperature(sight, "drift", 0)):
            channels = since_start(sight, channels_of(self._axes(sight), prior.inputs))
            yield self.law(ENVIRONMENT, prior, channels)


class CrossTalk(Instrument):
    """u as of the instrument: a linear mixing of the deflections along all axes, translations and rotations alike.

    A rotation of the instrument mixes within translations and within rotations only, and all of them at once; sensors
    that are mounted or balanced badly mix any two axes.
    """

    name = "cross talk"

    def entries(self, sight: Sight) -> Iterator[Entry]:
        if sight.positions:
            return
        shown = [Quantity("deflection", axis) for axis in range(self.width)]
        sight.look(shown)
        pairs = [(a, q) for a in sight.axes for q in shown if q.index != a and sight.spread(q) > 0.0]
        rows = [[pair for pair in pairs if pair[0] == a] for a in sight.axes]
        for chosen in (pairs, *rows, *([pair] for pair in pairs)):
            if chosen:
                channels = [Channel(a, block, (q,), q) for block, (a, q) in enumerate(chosen)]
                yield self.law(INSTRUMENT, steady("scale"), channels)
