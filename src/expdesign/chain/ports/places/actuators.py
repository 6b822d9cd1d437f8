"""Legs and joints: each an actuator that a force passes through."""

from collections.abc import Iterator, Sequence

import casadi as ca

from expdesign.chain.component import Component, actuators_and_all
from expdesign.chain.ports.families import (
    Prior,
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
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row


class Actuators(Port):
    """u: extra elongation of every actuator (m, rad).

    Laws of one actuator; of all, alike; of all, each its own. A compliance that varies is force times a law, a force
    law depends on the force and vanishes with it, and an offset is there without load.
    """

    name = "actuators"

    def components_of_motion(self) -> int:
        return len(self.robot.stiffness)

    @property
    def outputs(self) -> Sequence[str]:
        return self.robot.actuators

    def actuator(self, elongation: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return elongation + extra

    @property
    def components(self) -> Sequence[Component]:
        return actuators_and_all(self.robot)

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
            for prior, scaled in family:
                channel = Channel(actuator, 0, prior.inputs, Quantity("effort", actuator) if scaled else None)
                channels = (channel,) if scaled else since_start(sight, (channel,))
                yield Entry(
                    self.name, self.components[actuator], prior.form, channels, prior.kernel, prior.scales, prior.rank
                )
        if len(self.components) > count and len({len(family) for family in families}) == 1:
            everything = self.components[count]
            for several in zip(*families, strict=True):
                if len({(prior.form, prior.kernel, len(prior.inputs)) for prior, _ in several}) > 1:
                    continue
                for alike in (True, False):
                    channels = tuple(
                        Channel(a, 0 if alike else a, prior.inputs, Quantity("effort", a) if scaled else None)
                        for a, (prior, scaled) in enumerate(several)
                    )
                    if not several[0][1]:
                        channels = since_start(sight, channels)
                    first = several[0][0]
                    # One law for all needs one scale for all.
                    scales = tuple(max(prior.scales[i] for prior, _ in several) for i in range(len(first.scales)))
                    rank = first.rank if alike else min(first.rank, 8)
                    yield Entry(self.name, everything, first.form, channels, first.kernel, scales, rank)

    def _friction_along(self, sight: Sight, actuator: int) -> Iterator[Entry]:
        """Friction that differs from place to place, and loops that harden, close at zero or grow with the force: a
        bank of stop operators, each times a law of the length or of the force.
        """
        effort = Quantity("effort", actuator)
        if int(sight.rows.position.max()) < 1:
            return
        varying = [stop for stop in stops(sight, effort) if sight.spread(stop) > 0.0]
        for seen in (Quantity("length", actuator), effort):
            channels = tuple(Channel(actuator, i, (seen,), stop) for i, stop in enumerate(varying))
            for factor in (0.5, 1.0, 2.0) if channels and sight.varies(seen) else ():
                scale = (factor * sight.spread(seen),)
                component = self.components[actuator]
                yield Entry(self.name, component, "friction", channels, "squared_exponential", scale, 5)

    def _hoses(self, sight: Sight) -> Iterator[Entry]:
        """What is led along an arm over two joints turns both with moments that follow both angles."""
        if not sight.positions:
            return
        for joint in range(self.width - 1):
            angles = Quantity("length", joint), Quantity("length", joint + 1)
            for prior in smooth_over(sight, "hose", angles, 8):
                channels = tuple(Channel(joint + i, i, prior.inputs) for i in range(2))
                yield Entry(self.name, self.components[joint], "hose", channels, prior.kernel, prior.scales, prior.rank)

    def _growing(self, sight: Sight) -> Iterator[Entry]:
        """Legs of one material grow with the temperature in proportion to their lengths."""
        warming = [Quantity("warming", actuator) for actuator in range(self.width)]
        if len(self.components) == self.width or sight.positions or not sight.varies(*warming):
            return
        channels = tuple(Channel(a, 0, (q,), Quantity("length", a)) for a, q in enumerate(warming))
        yield Entry(self.name, self.components[-1], "offset", channels, "linear", (sight.spread(warming[0]),), 1)

    def _on_one_bracket(self, sight: Sight, actuator: int) -> Iterator[Entry]:
        """Two legs on a bracket: the force in either moves the other (Maxwell and Betti); and one that gives way under
        what both carry, by its play or its spring that is not linear.
        """
        for other in range(actuator + 1, self.width if sight.robot.on_legs else 0):
            one, two = Quantity("effort", actuator), Quantity("effort", other)
            if sight.varies(one, two):
                crossed = Channel(actuator, 0, (two,)), Channel(other, 0, (one,))
                largest = max(sight.largest(one), sight.largest(two))
                yield Entry(self.name, self.components[actuator], "bracket", crossed, "linear", (largest,), 1)
            both, sign = (Quantity(kind, actuator, (float(other),)) for kind in ("pair", "pair_sign"))
            if not sight.varies(both):
                continue
            priors = [("wiener", both, sight.largest(both), 12)]
            if sight.varies(sign):
                priors.append(
                    ("wiener", sign, 1.0, 2)
                )  # to either side its own way: it may rest at one end of its play
            for kernel, seen, scale, rank in priors:
                channels = tuple(Channel(leg, 0, (seen,)) for leg in (actuator, other))
                yield Entry(self.name, self.components[actuator], "bracket", channels, kernel, (scale,), rank)


def _laws(sight: Sight, actuator: int) -> Iterator[tuple[Prior, bool]]:
    """Priors of one actuator, and whether they are a compliance (to be multiplied by the force)."""
    effort, length = Quantity("effort", actuator), Quantity("length", actuator)
    pose = tuple(Quantity("pose", index) for index in range(len(sight.robot.configuration)))
    for prior in smooth_over(sight, "compliance", (length,)):
        yield prior, True
    for prior in smooth_over(sight, "compliance", (effort, length), 30):
        yield prior, True
    for prior in smooth_over(sight, "compliance", pose, 30):
        yield prior, True
    for prior in over_time(sight, "compliance"):
        yield prior, True
    for form, scaled in (("compliance", True), ("offset", False)):
        yield from ((prior, scaled) for prior in over_temperature(sight, form, actuator))
    for prior in of_effort(sight, effort):
        yield prior, False
    for prior in memory_of(sight, effort):
        yield prior, False
    for prior in repeating(sight, "compliance", length):
        yield prior, True
    for prior in repeating(sight, "periodic", length):
        yield prior, False
    for prior in smooth_over(sight, "offset", (length,)):
        yield prior, False
    for prior in (*over_time(sight, "offset"), *jumps(sight)):
        yield prior, False
    for prior in jumps(sight, "compliance"):
        yield prior, True
