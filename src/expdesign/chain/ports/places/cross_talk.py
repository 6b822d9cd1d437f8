"""Cross talk of the instrument's axes: what one axis reads shows in another one."""

from collections.abc import Iterator

from expdesign.chain.component import INSTRUMENT
from expdesign.chain.ports.places.instrument import Instrument
from expdesign.chain.ports.port import Channel, Entry
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight


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
