"""Geometry that is not as the robot file says, or does not stay as it is."""

from collections.abc import Iterator
from typing import ClassVar

import casadi as ca

from expdesign.chain.component import GEOMETRY, each_leg, on_any
from expdesign.chain.effects.legs.geometry import EQUILIBRIUM, GeometricStiffness, LegEnd
from expdesign.chain.ports.port import Entry, Names, Port, steady
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row


class Geometry(Port):
    """u: what is added to the geometric parameters of a parallel robot (coordinates of its joints, m)."""

    name = "geometry"
    at = on_any(GEOMETRY, each_leg)
    adds: ClassVar[Names] = lambda robot: [
        f"{name.replace(' ', '_')}_m" for name in getattr(robot, "geometry_names", ())
    ]

    def geometry(self, geometry: ca.SX, extra: ca.SX) -> ca.SX:
        return geometry + extra

    def entries(self, sight: Sight) -> Iterator[Entry]:
        """All joints are somewhere else, or one end of one leg is."""
        ends = [(leg, f"{end}_{leg.number}_") for leg in each_leg(self.robot) for end in LegEnd]
        for component, of in ((GEOMETRY, ""), *ends):
            moved = [index for index, name in enumerate(self.outputs) if name.startswith(of)]
            if moved:
                yield self.law(component, steady("geometry"), moved)


class LoadedGeometry(Port):
    """u: fraction of the change of geometry under load to second order (`GeometricStiffness`), at the file's stiffness.

    Whatever turns legs and lever arms while the machine yields shows in proportion to it.
    """

    name = "loaded geometry"
    at = on_any(GEOMETRY)
    adds: ClassVar[Names] = lambda robot: ("fraction",) if robot.on_legs else ()

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        effect = GeometricStiffness(self.robot, GEOMETRY, EQUILIBRIUM)
        return effect.structure(deflection, row.wrench, 1.0 / ca.SX(self.robot.stiffness), row, extra)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        yield self.law(GEOMETRY, steady("loaded geometry"), (0,))
