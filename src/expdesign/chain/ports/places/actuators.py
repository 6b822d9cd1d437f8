"""Legs and joints: each an actuator that a force passes through."""

from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar

import casadi as ca

from expdesign.chain.component import actuators_and_all
from expdesign.chain.ports.families import (
    by_approach,
    jumps,
    memory_of,
    of_effort,
    over_temperature,
    over_time,
    repeating,
    since_start,
    smooth_over,
    stops,
)
from expdesign.chain.ports.port import Channel, Entry, Names, Port, Prior
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row


class Actuators(Port):
    """u: extra elongation of every actuator (m, rad).

    Laws of one actuator; of all, alike; of all, each its own. A compliance that varies is force times a law, a force
    law depends on the force and vanishes with it, and an offset is there without load.
    """

    name = "actuators"
    at = actuators_and_all
    adds: ClassVar[Names] = lambda robot: robot.actuators

    def actuator(self, elongation: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return elongation + extra

    def entries(self, sight: Sight) -> Iterator[Entry]:
        count = self.width
        sight.look(
            Quantity(kind, one, (float(other),))
            for kind in ("pair", "pair_sign")
            for one in range(count)
            for other in range(one + 1, count)
        )
        for actuator in range(count):
            yield from self._friction_along(sight, actuator)
            yield from self._on_one_bracket(sight, actuator)
        yield from self._growing(sight)
        if not sight.robot.on_legs:
            yield from self._hoses(sight)
        families = [list(_laws(sight, actuator)) for actuator in range(count)]
        for actuator, family in enumerate(families):
            for prior in family:
                yield self.law(self.components[actuator], prior, _channels(sight, {actuator: prior}))
        if len(self.components) == count or len({len(family) for family in families}) > 1:
            return
        for several in zip(*families, strict=True):
            if len({(prior.form, prior.kernel, len(prior.inputs)) for prior in several}) > 1:
                continue
            # One law for all needs one scale for all.
            first = several[0]
            common = replace(first, scales=tuple(map(max, zip(*(prior.scales for prior in several), strict=True))))
            own = _channels(sight, dict(enumerate(several)))
            yield self.law(self.components[count], common, tuple(replace(channel, block=0) for channel in own))
            yield self.law(self.components[count], common, own, rank=min(first.rank, 8))

    def _friction_along(self, sight: Sight, actuator: int) -> Iterator[Entry]:
        """Friction that differs from place to place, and loops that harden, close at zero or grow with the force: a
        bank of stop operators, each times a law of the length or of the force.
        """
        effort = Quantity("effort", actuator)
        if not sight.remembers:
            return
        bank = [(actuator, stop) for stop in stops(sight, effort) if sight.spread(stop) > 0.0]
        for seen in (Quantity("length", actuator), effort):
            for factor in (0.5, 1.0, 2.0) if bank and sight.varies(seen) else ():
                prior = Prior("friction", "squared_exponential", (seen,), (factor * sight.spread(seen),), 5)
                yield self.law(self.components[actuator], prior, bank)

    def _hoses(self, sight: Sight) -> Iterator[Entry]:
        """What is led along an arm over two joints turns both with moments that follow both angles."""
        for joint in range(self.width - 1) if sight.positions else ():
            angles = Quantity("length", joint), Quantity("length", joint + 1)
            for prior in smooth_over(sight, "hose", angles, 8):
                yield self.law(self.components[joint], prior, (joint, joint + 1))

    def _growing(self, sight: Sight) -> Iterator[Entry]:
        """Legs of one material grow with the temperature in proportion to their lengths."""
        warming = [Quantity("warming", actuator) for actuator in range(self.width)]
        if len(self.components) == self.width or sight.positions or not sight.varies(*warming):
            return
        channels = tuple(Channel(a, 0, (q,), Quantity("length", a)) for a, q in enumerate(warming))
        prior = Prior("offset", "linear", (warming[0],), (sight.spread(warming[0]),), 1)
        yield self.law(self.components[-1], prior, channels)

    def _on_one_bracket(self, sight: Sight, actuator: int) -> Iterator[Entry]:
        """Two legs on a bracket: the force in either moves the other (Maxwell and Betti); and one that gives way under
        what both carry, by its play or its spring that is not linear.
        """
        here = self.components[actuator]
        for other in range(actuator + 1, self.width if sight.robot.on_legs else 0):
            one, two = Quantity("effort", actuator), Quantity("effort", other)
            if sight.varies(one, two):
                crossed = Channel(actuator, 0, (two,)), Channel(other, 0, (one,))
                largest = max(sight.largest(one), sight.largest(two))
                yield self.law(here, Prior("bracket", "linear", (two,), (largest,), 1), crossed)
            both, sign = (Quantity(kind, actuator, (float(other),)) for kind in ("pair", "pair_sign"))
            if not sight.varies(both):
                continue
            priors = [Prior("bracket", "wiener", (both,), (sight.largest(both),), 12)]
            if sight.varies(sign):
                # To either side its own way: it may rest at one end of its play.
                priors.append(Prior("bracket", "wiener", (sign,), (1.0,), 2))
            for prior in priors:
                yield self.law(here, prior, (actuator, other), alike=True)


def _channels(sight: Sight, priors: dict[int, Prior]) -> tuple[Channel, ...]:
    """A law of its own in each actuator; a compliance is multiplied by its force."""
    compliance = next(iter(priors.values())).form == "compliance"
    channels = tuple(
        Channel(actuator, block, prior.inputs, Quantity("effort", actuator) if compliance else None)
        for block, (actuator, prior) in enumerate(priors.items())
    )
    return channels if compliance else since_start(sight, channels)


def _laws(sight: Sight, actuator: int) -> Iterator[Prior]:
    """Priors of one actuator."""
    effort, length = Quantity("effort", actuator), Quantity("length", actuator)
    yield from smooth_over(sight, "compliance", (length,))
    yield from smooth_over(sight, "compliance", (effort, length), 30)
    yield from smooth_over(sight, "compliance", sight.pose, 30)
    yield from over_time(sight, "compliance")
    yield from over_temperature(sight, "compliance", actuator)
    yield from over_temperature(sight, "offset", actuator)
    yield from of_effort(sight, effort)
    yield from memory_of(sight, effort)
    yield from by_approach(sight, actuator)
    yield from repeating(sight, "compliance", length)
    yield from repeating(sight, "periodic", length)
    yield from smooth_over(sight, "offset", (length,))
    yield from over_time(sight, "offset")
    yield from jumps(sight)
    yield from jumps(sight, "compliance")
