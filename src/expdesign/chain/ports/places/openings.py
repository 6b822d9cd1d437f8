"""Joints of the platform and of the base that open: what is clamped face to face lifts off at an edge under load.

A bolted joint or a foot transmits pressure alone. It stays closed until the moment about an in-plane axis, together
with the force along its normal, lifts one edge; from then on it opens about the other one. Of the six components of the
wrench three (or two) matter, in which the law is a sum of half-planes.
"""

from collections.abc import Iterator

from expdesign.chain.ports.families import kinks_over
from expdesign.chain.ports.places.mounts import Ground, Mount, PlatformMount
from expdesign.chain.ports.port import Entry
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight

_RANK = 24


class _Opening(Mount):
    """u as of a mount; laws of the force along a normal and of the moments about the axes of its plane."""

    def entries(self, sight: Sight) -> Iterator[Entry]:
        d = len(self.robot.gravity)
        if self.width == d:
            return
        for normal in range(d):
            about = [axis for axis in range(d) if axis != normal] if d == 3 else [0]
            for axes in (*((axis,) for axis in about), *((tuple(about),) if len(about) > 1 else ())):
                moved = (normal, *(d + axis for axis in axes))
                efforts = tuple(Quantity(self.effort, component) for component in moved)
                for prior in kinks_over(sight, "force law", efforts, _RANK):
                    yield self.law(self.components[0], prior, moved)


class PlatformOpening(_Opening, PlatformMount):
    """Where the payload is clamped to the platform."""

    name = "platform opening"


class GroundOpening(_Opening, Ground):
    """Where the base stands on the floor."""

    name = "base opening"
