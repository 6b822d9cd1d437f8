"""What a file of recordings measured, by its columns: deflections of the platform, its poses, or markers on it."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.coordinates import Coordinates

POSITION = ("px_m", "py_m", "pz_m")
POSITION_DEVIATION = ("spx_m", "spy_m", "spz_m")


@dataclass(frozen=True)
class Measurand:
    """One kind of measured quantity.

    Attributes:
        name: in words.
        absolute: whether it says where something is, so that geometry, own weight and the instrument's place show, or
            by how much a load moved it, in which they cancel.
    """

    name: str
    absolute: bool

    def columns(self, coordinates: Coordinates) -> tuple[str, ...]:
        """Columns of what the instrument reads."""
        if self.name == "poses":
            return measured_names(coordinates)
        return POSITION if self.absolute else coordinates.deflection

    def deviation_columns(self, coordinates: Coordinates) -> tuple[str, ...]:
        """Columns of their standard deviations."""
        return POSITION_DEVIATION if self.columns(coordinates) == POSITION else coordinates.deviation

    def reference(self, weight: FloatArray) -> FloatArray:
        """What own weight does in the reference state: that of a position is the weightless robot."""
        return np.zeros_like(weight) if self.absolute else weight

    def shown(self, weight: FloatArray) -> FloatArray:
        """What own weight adds to what is read."""
        return weight if self.absolute else np.zeros_like(weight)


DEFLECTIONS = Measurand("deflections", absolute=False)
POSITIONS = Measurand("positions of markers", absolute=True)
POSES = Measurand("poses", absolute=True)


def measured_names(coordinates: Coordinates) -> tuple[str, ...]:
    """Columns of a pose as it was measured, in the coordinates of the commanded one."""
    return tuple(f"measured_{name}" for name in coordinates.pose)
