"""The instrument and what surrounds it: what is read is not what happens."""

from collections.abc import Iterator, Sequence

import casadi as ca

from expdesign.chain.component import ENVIRONMENT, INSTRUMENT, Component
from expdesign.chain.ports.families import (
    Prior,
    jumps,
    over_temperature,
    over_time,
    repeating,
    since_start,
    smooth_over,
)
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row


class Instrument(Port):
    """u: added to the reading. A law over pose times the deflection is a scale or a rotation that varies."""

    name = "instrument"

    def components_of_motion(self) -> int:
        return self.robot.coordinates.n

    def reading(self, reading: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return reading + extra[: reading.shape[0]]

    @property
    def components(self) -> Sequence[Component]:
        return (INSTRUMENT,)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        n, d = self.width, len(self.robot.gravity)
        axes = [a for a in sight.axes if a < (d if sight.positions else n)]
        pose = tuple(Quantity("pose", i) for i in range(len(self.robot.configuration)))
        position = tuple(Quantity("position", i) for i in range(d))
        shown = [Quantity("deflection", i) for i in range(n)]
        if not sight.positions:
            sight.look(shown)
            blocks = [range(d), range(d, n)] if n > d else [range(d)]
            steady = Prior("scale", "constant", (shown[0],), (1.0,), 1)
            for prior in (steady, *smooth_over(sight, "scale", position, 12), *smooth_over(sight, "scale", pose, 12)):
                full = [(a, shown[b]) for block in blocks for a in block if a in axes for b in block]
                own = [(a, shown[a]) for a in axes]
                for pairs in (full, own):
                    channels = tuple(Channel(a, i, prior.inputs, q) for i, (a, q) in enumerate(pairs))
                    yield Entry(
                        self.name, INSTRUMENT, prior.form, channels, prior.kernel, prior.scales, min(prior.rank, 10)
                    )
                alike = tuple(Channel(a, 0, prior.inputs, shown[a]) for a in axes)
                yield Entry(self.name, INSTRUMENT, prior.form, alike, prior.kernel, prior.scales, prior.rank)
            for a in axes:
                if sight.varies(shown[a]):
                    for prior in (
                        *smooth_over(sight, "reading law", (shown[a],)),
                        *repeating(sight, "reading law", shown[a]),
                    ):
                        yield Entry(
                            self.name, INSTRUMENT, "reading law", (Channel(a, 0, prior.inputs),), prior.kernel,
                            prior.scales, prior.rank,
                        )  # fmt: skip
        for prior in smooth_over(sight, "offset", position if n > 2 else pose, 16):
            channels = tuple(Channel(a, i, prior.inputs) for i, a in enumerate(axes))
            yield Entry(self.name, INSTRUMENT, prior.form, channels, prior.kernel, prior.scales, prior.rank)


class Surroundings(Instrument):
    """Slow changes of whatever is read: in time, and with the temperature."""

    name = "environment"

    @property
    def components(self) -> Sequence[Component]:
        return (ENVIRONMENT,)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        n, d = self.width, len(self.robot.gravity)
        axes = [a for a in sight.axes if a < (d if sight.positions else n)]
        for prior in (*over_time(sight, "drift"), *jumps(sight), *over_temperature(sight, "drift", 0)):
            channels = since_start(sight, (Channel(a, i, prior.inputs) for i, a in enumerate(axes)))
            yield Entry(self.name, ENVIRONMENT, prior.form, channels, prior.kernel, prior.scales, prior.rank)


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
            channels = tuple(Channel(a, i, (q,), q) for i, (a, q) in enumerate(chosen))
            if channels:
                yield Entry(self.name, INSTRUMENT, "scale", channels, "constant", (1.0,), 1)
