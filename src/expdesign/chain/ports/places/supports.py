"""What a body stands on or is guided by: laws of the whole load, less those of the load of its reference state.

A body has no unloaded state to compare with. What a law f does to a reading is f(load) − f(load of the reference), so
that two channels of one block, with opposite signs, see the two loads. Guides of a column that is drawn out tilt in
proportion to 1/overlap by their clearance, and so does the law of a load that is taken up by them.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.chain.component import BASE, on_any
from expdesign.chain.ports.families import guide_ends, time_constants
from expdesign.chain.ports.port import Channel, Entry, Names, Port, Prior, steady
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
    at = on_any(BASE)
    adds: ClassVar[Names] = lambda robot: robot.coordinates.deflection if robot.on_support else ()

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
        # The same always in proportion to each load, which also stands in the place of an input.
        same = [Channel(a, b, (load,), load) for b, (a, load) in enumerate(pairs)]
        yield self.law(BASE, steady("compliance"), same)
        for pose in sight.varying("pose", len(self.robot.configuration)):
            changing = Prior("compliance", "squared_exponential", (pose,), (sight.spread(pose),), 5)
            yield self.law(BASE, changing, pairs)

    def _force_laws(self, sight: Sight, loads: list[int]) -> Iterator[Entry]:
        """Any continuous function of the load, and the same in proportion to 1/overlap of a guide."""
        now, before = (tuple(Quantity(kind, i) for i in loads) for kind in ("whole", "rest"))
        for factor in _SCALES:
            law = Prior("force law", "matern", now, tuple(factor * sight.spread(q) for q in now), _FEATURES)
            for a in sight.axes:
                pair = (Channel(a, 0, now), Channel(a, 0, before, gain=-1.0))
                yield self.law(BASE, law, pair)
                for overlap in self.overlaps(sight):
                    guided = [replace(channel, amplitude=overlap) for channel in pair]
                    yield self.law(BASE, replace(law, form="guide"), guided)

    def overlaps(self, sight: Sight) -> list[Quantity]:
        """Reciprocals of what guides overlap, for ends of the guides at several distances beyond the range."""
        poses = sight.varying("pose", len(self.robot.configuration))
        return [overlap for pose in poses for overlap in guide_ends(sight, pose)]

    def _memory(self, sight: Sight, loads: list[int]) -> Iterator[Entry]:
        """Dry friction and creep under every component of the load: banks of stop operators and of slow parts."""
        if not sight.remembers:
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
            law = Prior(form, "linear", inputs, tuple(sight.spread(q) for q in inputs), len(inputs))
            for a in sight.axes if inputs else ():
                yield self.law(BASE, law, (a,))
                for overlap in self.overlaps(sight) if form == "friction" else ():
                    yield self.law(BASE, replace(law, form="guide friction"), [(a, overlap)])

    def _in_time(self, sight: Sight) -> Iterator[Entry]:
        """The body settles from the start of a series on, or drifts."""
        elapsed = Quantity("elapsed")
        if not sight.timed or not sight.varies(elapsed):
            return
        longest = sight.largest(elapsed)
        parts = tuple(Quantity("settling", 0, (round(share * longest, 6),)) for share in _SETTLES)
        priors = [Prior("settling", "linear", parts, tuple(sight.spread(q) for q in parts), len(parts))]
        priors += [Prior("drift", "pinned", (elapsed,), (f * sight.spread(elapsed),), 20) for f in (0.3, 1.0)]
        for prior in priors:
            yield self.law(BASE, prior, sight.axes)
