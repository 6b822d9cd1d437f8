"""What a load is: parameters that stand in the columns of a plan, and the wrench that they make."""

from abc import ABC, abstractmethod
from typing import ClassVar

import casadi as ca

from expdesign.arrays import FloatArray
from expdesign.coordinates import Coordinates


class Load(ABC):
    """One kind of load, acting on the platform of a robot with the given coordinates.

    Attributes:
        columns: names of the parameters of one load, in order; they are columns of plans and recordings.
    """

    kind: ClassVar[str]
    columns: tuple[str, ...]

    def __init__(self, coordinates: Coordinates) -> None:
        self.coordinates = coordinates

    @abstractmethod
    def wrench(self, parameters: ca.SX, rotation: ca.SX) -> ca.SX:
        """Wrench on the platform at the origin of P, components along the axes of O (N, N·m), shape (n,).

        Args:
            parameters: values of `columns`, shape (k,).
            rotation: R of the platform, shape (d, d).
        """

    @abstractmethod
    def defaults(self, gravity: FloatArray) -> FloatArray:
        """Value of each column that a table leaves out, NaN where it must be given, shape (k,)."""


def small_rotation(vector: ca.SX, angles: ca.SX) -> ca.SX:
    """`vector` turned by small angles (rad): about x and y of O in space, about the normal in the plane.

    Exact to first order, which is all that an error propagation needs.
    """
    if vector.shape[0] == 2:
        return vector + angles[0] * ca.vertcat(-vector[1], vector[0])
    return vector + ca.cross(ca.vertcat(angles[0], angles[1], 0.0), vector)
