"""Geometry that is not as the robot file says."""

from collections.abc import Iterator, Sequence

import casadi as ca

from expdesign.chain.component import GEOMETRY, Component
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight


class Geometry(Port):
    """u: what is added to the geometric parameters of a parallel robot (coordinates of its joints, m)."""

    name = "geometry"

    def components_of_motion(self) -> int:
        return int(getattr(self.robot, "geometry", ca.DM(0, 1)).shape[0])

    @property
    def outputs(self) -> Sequence[str]:
        names: Sequence[str] = getattr(self.robot, "geometry_names", ())
        return tuple(f"{name.replace(' ', '_')}_m" for name in names)

    def geometry(self, geometry: ca.SX, extra: ca.SX) -> ca.SX:
        return geometry + extra

    @property
    def components(self) -> Sequence[Component]:
        return (GEOMETRY,)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        always = Quantity("clock")
        channels = tuple(Channel(a, a, (always,)) for a in range(self.width))
        if channels:
            yield Entry(self.name, GEOMETRY, "geometry", channels, "constant", (1.0,), 1)
