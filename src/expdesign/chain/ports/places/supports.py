"""What a body stands on or is guided by: laws of the whole load, less those of the load of its reference state.

A body has no unloaded state to compare with. What a law f does to a reading is f(load) − f(load of the reference), so
that two channels of one block, with opposite signs, see the two loads. Guides of a column that is drawn out tilt in
proportion to 1/overlap by their clearance, and so does the law of a load that is taken up by them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from expdesign.chain.component import BASE, Component
from expdesign.chain.ports.families import guide_ends, time_constants
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row

_MATTERS = 0.02
"""Share of the largest spread of a force (or moment) from which another one is an input."""
_SCALES = (1.0, 2.0)
_STOPS = (0.015, 0.04, 0.1, 0.25)
"""Thresholds of friction, in ranges of the load."""
_SETTLES = (0.01, 0.03, 0.1, 0.3, 1.0)
_FEATURES = 90


class Supports(Port):
    """u: twist (m, rad) of the body at the origin of P along the axes of O."""

    name = "supports"

    def components_of_motion(self) -> int:
        return self.robot.coordinates.n if self.robot.on_support else 0

    @property
    def components(self) -> Sequence[Component]:
        return (BASE,)

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return deflection + row.rates @ extra

    def entries(self, sight: Sight) -> Iterator[Entry]:
        loads = self.loads(sight)
        if not loads:
            return
        yield from self._compliances(sight, loads)
        yield from self._force_laws(sight, loads)
        yield from self._memory(sight, loads)
        yield from self._in_time(sight)

    def loads(self, sight: Sight) -> list[int]:
        """Components of the load that vary, and by enough beside others of their unit."""
        changes = [Quantity("whole", i) for i in range(self.width)]
        sight.look(changes)
        spreads = np.array([sight.spread(q) for q in changes])
        d = len(self.robot.gravity)
        found = []
        for group in (range(d), range(d, self.width)):
            least = _MATTERS * max((spreads[i] for i in group), default=0.0)
            found += [i for i in group if spreads[i] > least]
        return found

    def _compliances(self, sight: Sight, loads: list[int]) -> Iterator[Entry]:
        """Springs about any axes, the same always, or changing with the pose; and motions that follow the pose."""
        pairs = [(a, Quantity("effort", i)) for a in sight.axes for i in loads]
        steady = tuple(Channel(a, b, (load,), load) for b, (a, load) in enumerate(pairs))
        yield Entry(self.name, BASE, "compliance", steady, "constant", (1.0,), 1)
        for pose in sight.varying("pose", len(self.robot.configuration)):
            changing = tuple(Channel(a, b, (pose,), load) for b, (a, load) in enumerate(pairs))
            yield Entry(self.name, BASE, "compliance", changing, "squared_exponential", (sight.spread(pose),), 5)

    def _force_laws(self, sight: Sight, loads: list[int]) -> Iterator[Entry]:
        """Any continuous function of the load, and the same in proportion to 1/overlap of a guide."""
        now, before = (tuple(Quantity(kind, i) for i in loads) for kind in ("whole", "rest"))
        for factor in _SCALES:
            scales = tuple(factor * sight.spread(q) for q in now)
            for a in sight.axes:
                pair = (Channel(a, 0, now), Channel(a, 0, before, gain=-1.0))
                yield Entry(self.name, BASE, "force law", pair, "matern", scales, _FEATURES)
                for overlap in self.overlaps(sight):
                    guided = tuple(replace(channel, amplitude=overlap) for channel in pair)
                    yield Entry(self.name, BASE, "guide", guided, "matern", scales, _FEATURES)

    def overlaps(self, sight: Sight) -> list[Quantity]:
        """Reciprocals of what guides overlap, for ends of the guides at several distances beyond the range."""
        poses = sight.varying("pose", len(self.robot.configuration))
        return [overlap for pose in poses for overlap in guide_ends(sight, pose)]

    def _memory(self, sight: Sight, loads: list[int]) -> Iterator[Entry]:
        """Dry friction and creep under every component of the load: banks of stop operators and of slow parts."""
        if int(sight.rows.position.max()) < 1:
            return
        stops = [
            Quantity("stop", i, (round(share * float(np.ptp(sight.values(Quantity("whole", i))[sight.counts])), 9),))
            for i in loads
            for share in _STOPS
        ]
        slow = [Quantity("lag", i, (time, 1.0)) for i in loads for time in time_constants(sight)]
        for form, bank in (("friction", stops), ("creep", slow)):
            sight.look(bank)
            inputs = tuple(q for q in bank if sight.spread(q) > 0.0)
            scales = tuple(sight.spread(q) for q in inputs)
            for a in sight.axes if inputs else ():
                yield Entry(self.name, BASE, form, (Channel(a, 0, inputs),), "linear", scales, len(inputs))
                for overlap in self.overlaps(sight) if form == "friction" else ():
                    guided = (Channel(a, 0, inputs, overlap),)
                    yield Entry(self.name, BASE, "guide friction", guided, "linear", scales, len(inputs))

    def _in_time(self, sight: Sight) -> Iterator[Entry]:
        """The body settles from the start of a series on, or drifts."""
        elapsed = Quantity("elapsed")
        if not sight.timed or not sight.varies(elapsed):
            return
        longest = sight.largest(elapsed)
        settling = tuple(Quantity("settling", 0, (round(share * longest, 6),)) for share in _SETTLES)
        priors = [("settling", settling, "linear", tuple(sight.spread(q) for q in settling), len(settling))]
        priors += [
            ("drift", (elapsed,), "pinned", (factor * sight.spread(elapsed),), 20) for factor in (0.3, 1.0)
        ]  # fmt: skip
        for form, inputs, kernel, scales, rank in priors:
            channels = tuple(Channel(a, b, inputs) for b, a in enumerate(sight.axes))
            yield Entry(self.name, BASE, form, channels, kernel, scales, rank)
