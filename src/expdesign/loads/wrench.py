"""A free wrench, as a force actuator or a cable applies it; it does not depend on the pose."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.coordinates import Coordinates
from expdesign.loads.load import Load


class Wrench(Load):
    """Forces and moments at the origin of P along the axes of O."""

    kind = "wrench"

    def __init__(self, coordinates: Coordinates) -> None:
        super().__init__(coordinates)
        self.columns = coordinates.wrench

    def wrench(self, parameters: ca.SX, rotation: ca.SX) -> ca.SX:
        return parameters

    def defaults(self, gravity: FloatArray) -> FloatArray:
        return np.zeros(self.coordinates.n)
