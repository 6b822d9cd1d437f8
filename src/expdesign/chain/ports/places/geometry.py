"""Geometry that is not as the robot file says, or does not stay as it is."""

from collections.abc import Iterator, Sequence

import casadi as ca

from expdesign.chain.component import GEOMETRY, Component, each_leg
from expdesign.chain.effects.legs.geometry import Correction, GeometricStiffness, LegEnd
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row


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
        return (GEOMETRY, *each_leg(self.robot))

    def entries(self, sight: Sight) -> Iterator[Entry]:
        """All joints are somewhere else, or one end of one leg is."""
        names = list(getattr(self.robot, "geometry_names", ()))
        yield from self._moved(GEOMETRY, list(range(self.width)))
        for leg in each_leg(self.robot):
            for end in LegEnd:
                own = [a for a, name in enumerate(names) if name.startswith(f"{end} {leg.number} ")]
                yield from self._moved(leg, own)

    def _moved(self, component: Component, coordinates: list[int]) -> Iterator[Entry]:
        channels = tuple(Channel(a, i, (Quantity("clock"),)) for i, a in enumerate(coordinates))
        if channels:
            yield Entry(self.name, component, "geometry", channels, "constant", (1.0,), 1)


class LoadedGeometry(Port):
    """u: fraction of the change of geometry under load to second order (`GeometricStiffness`), at the file's stiffness.

    Whatever turns legs and lever arms while the machine yields shows in proportion to it.
    """

    name = "loaded geometry"

    def components_of_motion(self) -> int:
        return int(self.robot.on_legs)

    @property
    def outputs(self) -> Sequence[str]:
        return ("fraction",)

    @property
    def components(self) -> Sequence[Component]:
        return (GEOMETRY,)

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        effect = GeometricStiffness(self.robot, GEOMETRY, Correction.EQUILIBRIUM)
        return effect.structure(deflection, row.wrench, 1.0 / ca.SX(self.robot.stiffness), row, extra)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        steady = (Channel(0, 0, (Quantity("clock"),)),)
        yield Entry(self.name, GEOMETRY, "loaded geometry", steady, "constant", (1.0,), 1)
