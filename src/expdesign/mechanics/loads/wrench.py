"""A free wrench, as a force actuator or a cable applies it; it does not depend on the pose."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.coordinates import Coordinates
from expdesign.mechanics.loads.load import Load, small_rotation


class Wrench(Load):
    """Forces and moments at the origin of P along the axes of O."""

    kind = "wrench"

    def __init__(self, coordinates: Coordinates) -> None:
        super().__init__(coordinates)
        self.columns = coordinates.wrench

    def wrench(self, parameters: ca.SX, rotation: ca.SX) -> ca.SX:
        return parameters

    def turned(self, parameters: ca.SX, rotation: ca.SX, angles: ca.SX) -> ca.SX:
        split = self.coordinates.translations
        parts = [small_rotation(parameters[:split], angles)]
        if parameters.shape[0] > split:
            # About the normal of the plane a moment stays what it is.
            parts.append(small_rotation(parameters[split:], angles) if split == 3 else parameters[split:])
        return ca.vertcat(*parts)

    def defaults(self, gravity: FloatArray) -> FloatArray:
        return np.zeros(self.coordinates.n)
